#include "library/fmi/write_fmu.h"

#include <dlfcn.h>

#include <fstream>
#include <map>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "library/fmi/description.h"
#include "library/fmi/instance.h"
#include "library/fmi/sources.h"
#include "library/fmi/variables.h"
#include "library/fmi/zip.h"

namespace {

using unlatch::fmi::describe_build;
using unlatch::fmi::Description;
using unlatch::fmi::list_compiled;
using unlatch::fmi::read_sources;
using unlatch::fmi::Variable;
using unlatch::fmi::Zip;

std::string read_file(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream bytes;
  bytes << file.rdbuf();
  if (!file) throw std::runtime_error(path + ": cannot be read");
  return bytes.str();
}

// Makes a C identifier of a name.
std::string make_identifier(const std::string& name) {
  std::string made = "unlatch_";
  for (const char c : name) made += std::isalnum(static_cast<unsigned char>(c)) != 0 ? c : '_';
  return made;
}

void write_fmu(const std::string& text, const std::string& overrides, const std::string& name, int version,
               const std::string& path) {
  std::vector<std::string> lines;
  std::istringstream stream(overrides);
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  std::vector<const char*> pointers;
  for (const std::string& line : lines) pointers.push_back(line.c_str());
  unlatch_options options{};
  options.size = sizeof options;
  options.overrides = pointers.data();
  options.override_count = pointers.size();
  options.flags = UNLATCH_JUDGE;
  unlatch_simulation* simulation = nullptr;
  if (unlatch_load_text(text.data(), text.size(), name.c_str(), &options, &simulation) != UNLATCH_OK)
    throw std::runtime_error(unlatch_get_error(0)->text);
  Dl_info own{};
  if (dladdr(reinterpret_cast<const void*>(&unlatch_write_fmu), &own) == 0) throw std::runtime_error("no own binary");
  const std::string binary = own.dli_fname, folder = binary.substr(0, binary.rfind('/') + 1);
  const std::map<std::string, std::string> sources = read_sources(folder + "unlatch-fmu-sources.tar");
  Description model{name, make_identifier(name), unlatch::fmi::calc_token(text, lines), 0, 0, list_compiled(sources)};
  (void)unlatch_get_scenario(simulation, nullptr, &model.dt, &model.until);
  const std::vector<Variable> variables = unlatch::fmi::list_variables(simulation);
  const std::string xml = describe(model, variables, version);
  (void)unlatch_close(simulation);
  if (variables.empty()) throw std::runtime_error(name + ": its variables cannot be listed");

#if defined(__aarch64__)
  const std::string platform = version == 3 ? "aarch64-linux" : "linux-aarch64";
#else
  const std::string platform = version == 3 ? "x86_64-linux" : "linux64";
#endif
  Zip zip;
  zip.add("modelDescription.xml", xml);
  zip.add("resources/scenario.yaml", text);
  zip.add("resources/overrides.txt", overrides);
  zip.add("binaries/" + platform + "/" + model.identifier + ".so", read_file(binary));
  if (!sources.empty()) zip.add("sources/buildDescription.xml", describe_build(sources, model.identifier));
  for (const auto& [file, content] : sources) zip.add("sources/" + file, content);
  std::ofstream file(path, std::ios::binary);
  file << zip.finish();
  if (!file.flush()) throw std::runtime_error(path + ": cannot be written");
}

}  // namespace

const char* unlatch_write_fmu(const char* text, const char* overrides, const char* name, int version,
                              const char* path) {
  static std::string failure;
  try {
    write_fmu(text, overrides, name, version, path);
    return nullptr;
  } catch (const std::exception& error) {
    failure = error.what();
    return failure.c_str();
  }
}
