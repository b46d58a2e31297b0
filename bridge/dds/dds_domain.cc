#include "bridge/dds/dds_domain.h"

#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <map>
#include <mutex>

#include "bridge/dds/dds_byte_order.h"
#include "bridge/dds/dds_log.h"

namespace unlatch::bridge {
namespace {

constexpr int kLastDomain = 230;  // the last whose ports fit into 16 bits

// Loopback has no multicast: without a peer and automatic participant indices the processes of one machine never meet.
// Every index up to the largest is greeted at start. A port that closes waits for its readers itself, for all writers
// together (dds_port.cc): that they linger besides, one after the other, is for nothing.
// A refusal by the security plugins is explained nowhere but in the trace.
std::string write_configuration(const DdsOptions& options) {
  const std::string& interface = options.interface;
  const bool loopback = interface == "lo";
  const std::string network = loopback ? "<NetworkInterface name=\"lo\" multicast=\"false\"/>"
                                       : "<NetworkInterface name=\"" + interface + "\"/>";
  return "<CycloneDDS><Domain Id=\"any\"><General><Interfaces>" + network + "</Interfaces>" +
         (loopback ? "<AllowMulticast>false</AllowMulticast>" : "") +
         "<MaxMessageSize>65500B</MaxMessageSize></General>" +
         (loopback ? "<Discovery><ParticipantIndex>auto</ParticipantIndex><MaxAutoParticipantIndex>99"
                     "</MaxAutoParticipantIndex><Peers><Peer Address=\"127.0.0.1\"/></Peers></Discovery>"
                   : "") +
         "<Internal><WriterLingerDuration>0s</WriterLingerDuration><WriteBatch>true</WriteBatch></Internal>" +
         (options.security.empty()
              ? ""
              : "<Tracing><Verbosity>warning</Verbosity><OutputFile>stderr</OutputFile></Tracing>") +
         "</Domain></CycloneDDS>";
}

bool is_interface_name(const std::string& name) {
  return !name.empty() && name.size() < 16 && std::all_of(name.begin(), name.end(), [](unsigned char c) {
    return std::isalnum(c) != 0 || c == '_' || c == '-' || c == '.' || c == ':';
  });
}

struct OpenDomain {
  std::weak_ptr<const DdsEntity> entity;
  std::string interface;
};

// Held while a domain is created or deleted, so that the two never overlap.
std::mutex g_mutex;
std::map<int, OpenDomain> g_domains;

void close(const DdsEntity* domain) {
  const std::lock_guard lock(g_mutex);
  delete domain;
}

// The user's own configuration of Cyclone DDS. An empty variable is none: Cyclone itself would take it as one, without
// anything in it, and choose a network interface by itself.
bool is_configured_outside() {
  const char* const uri = std::getenv("CYCLONEDDS_URI");
  return uri != nullptr && *uri != 0;
}

}  // namespace

std::string describe(const DdsOptions& options) {
  const std::string text = "DDS, domain " + std::to_string(options.domain) + ", ";
  const std::string who = options.security.empty() ? "every process there may listen and command"
                                                   : "only whom the authority of " + options.security +
                                                         " has signed may listen or command, encrypted";
  if (is_configured_outside()) return text + "as CYCLONEDDS_URI configures it: " + who;
  return text + "on the interface '" + options.interface +
         "': " + (options.interface == "lo" ? "this machine only; " : "") + who;
}

PortError make_dds_error(const DdsOptions& options, const char* what, dds_return_t code) {
  const std::string where = is_configured_outside()
                                ? "with the configuration of CYCLONEDDS_URI; is that right?"
                                : "on the interface '" + options.interface + "'; is it there and up (`ip link show " +
                                      options.interface + "`), and are fewer than 100 participants running?";
  const std::string security =
      options.security.empty() ? "" : ", or does the identity in " + options.security + " not permit it (see above)?";
  return PortError("Cyclone DDS: " + std::string(what) + " failed (" + dds_strretcode(code) + ") in domain " +
                   std::to_string(options.domain) + " " + where + security);
}

std::shared_ptr<const DdsEntity> open_dds_domain(const DdsOptions& options) {
  if (options.domain < 0 || options.domain > kLastDomain) {
    throw PortError("Cyclone DDS: there is no domain " + std::to_string(options.domain) + "; choose one from 0 to " +
                    std::to_string(kLastDomain));
  }
  take_dds_log();
  if (!is_byte_order_checked())
    throw PortError(
        "Cyclone DDS: this program was linked so that samples of the other byte order are not refused, and 0.10.2 "
        "writes outside its memory for them; link it with -Wl,--export-dynamic-symbol=dds_stream_normalize");
  if (is_configured_outside()) return nullptr;
  if (!is_interface_name(options.interface)) {
    throw PortError("Cyclone DDS: '" + options.interface + "' is no name of a network interface; `ip link` lists them");
  }
  const std::lock_guard lock(g_mutex);
  OpenDomain& known = g_domains[options.domain];
  if (auto open = known.entity.lock()) {
    if (known.interface == options.interface) return open;
    throw PortError("Cyclone DDS: domain " + std::to_string(options.domain) +
                    " is open in this process on the interface '" + known.interface +
                    "'; a process uses one interface per domain, so use that or another domain");
  }
  const auto domain =
      dds_create_domain(static_cast<dds_domainid_t>(options.domain), write_configuration(options).c_str());
  if (domain < 0) throw make_dds_error(options, "opening the network", domain);
  std::shared_ptr<const DdsEntity> entity(new DdsEntity(domain), close);
  known = {entity, options.interface};
  return entity;
}

}  // namespace unlatch::bridge
