#include "bridge/dds/dds_security.h"

#include <array>
#include <filesystem>
#include <fstream>

#include "bridge/core/port.h"

namespace unlatch::bridge {
namespace {

struct Plugin {
  const char* property;
  const char* library;
  const char* functions;
};
constexpr std::array<Plugin, 3> kPlugins{{{"auth", "dds_security_auth", "authentication"},
                                          {"access", "dds_security_ac", "access_control"},
                                          {"crypto", "dds_security_crypto", "crypto"}}};

struct File {
  const char* property;
  const char* name;
};
constexpr std::array<File, 6> kFiles{{{"auth.identity_ca", "ca.pem"},
                                      {"auth.identity_certificate", "identity.pem"},
                                      {"auth.private_key", "key.pem"},
                                      {"access.permissions_ca", "ca.pem"},
                                      {"access.governance", "governance.p7s"},
                                      {"access.permissions", "permissions.p7s"}}};

void set(dds_qos_t* qos, const std::string& property, const std::string& value) {
  dds_qset_prop(qos, ("dds.sec." + property).c_str(), value.c_str());
}

}  // namespace

void set_dds_security(dds_qos_t* qos, const std::string& folder) {
  for (const Plugin& plugin : kPlugins) {
    const std::string library = std::string(plugin.property) + ".library.";
    set(qos, library + "path", plugin.library);
    set(qos, library + "init", std::string("init_") + plugin.functions);
    set(qos, library + "finalize", std::string("finalize_") + plugin.functions);
  }
  for (const File& file : kFiles) {
    const std::filesystem::path path = std::filesystem::absolute(folder) / file.name;
    if (!std::ifstream(path)) {
      throw PortError("DDS Security: cannot read " + path.string() +
                      "; `bridge/security/make-keys` makes such folders");
    }
    set(qos, file.property, "file:" + path.string());
  }
}

}  // namespace unlatch::bridge
