#include "library/fmi/write_fmu.h"

#include <dlfcn.h>

#include <array>
#include <cstdint>
#include <cstdio>
#include <fstream>
#include <map>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "library/fmi/instance.h"
#include "library/fmi/variables.h"

namespace {

using unlatch::fmi::Variable;

// --- A zip file of stored members (PKWARE's APPNOTE, 4.3)

std::uint32_t calc_crc32(const std::string& bytes) {
  static const std::array<std::uint32_t, 256> table = [] {
    std::array<std::uint32_t, 256> made{};
    for (std::uint32_t i = 0; i < 256; ++i) {
      made[i] = i;
      for (int k = 0; k < 8; ++k) made[i] = (made[i] & 1u) != 0 ? 0xEDB88320u ^ (made[i] >> 1) : made[i] >> 1;
    }
    return made;
  }();
  std::uint32_t crc = ~0u;
  for (const char c : bytes) crc = table[(crc ^ static_cast<unsigned char>(c)) & 0xFFu] ^ (crc >> 8);
  return ~crc;
}

class Zip {
 public:
  void add(const std::string& name, const std::string& bytes) {
    std::string header;
    put(header, {20, 0, 0, 0, 0x21}, 2);  // version, flags, stored, time, 1 January 1980
    put(header, {calc_crc32(bytes), bytes.size(), bytes.size()}, 4);
    put(header, {name.size(), 0}, 2);
    put(directory_, {0x02014b50}, 4);
    put(directory_, {(3u << 8) | 20}, 2);  // made on Unix
    directory_ += header;
    put(directory_, {0, 0, 0}, 2);
    put(directory_, {0100644ull << 16, file_.size()}, 4);
    directory_ += name;
    put(file_, {0x04034b50}, 4);
    file_ += header + name + bytes;
    ++count_;
  }
  std::string finish() {
    std::string end;
    put(end, {0x06054b50}, 4);
    put(end, {0, 0, count_, count_}, 2);
    put(end, {directory_.size(), file_.size()}, 4);
    put(end, {0}, 2);
    return file_ + directory_ + end;
  }

 private:
  static void put(std::string& to, std::initializer_list<std::uint64_t> numbers, int bytes) {
    for (const std::uint64_t number : numbers)
      for (int i = 0; i < bytes; ++i) to += static_cast<char>(number >> (8 * i) & 0xFFu);
  }
  std::string file_, directory_;
  std::uint64_t count_ = 0;
};

// --- modelDescription.xml

std::string escape(const std::string& text) {
  std::string out;
  for (const char c : text) {
    switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      default:
        out += c;
    }
  }
  return out;
}

std::string write(double number) {
  char text[32];
  std::snprintf(text, sizeof text, "%.17g", number);
  return text;
}

// Exponents of kg, m, s, rad.
const std::map<std::string, std::array<int, 4>>& get_units() {
  static const std::map<std::string, std::array<int, 4>> units{{"1", {}},
                                                               {"s", {0, 0, 1, 0}},
                                                               {"m", {0, 1, 0, 0}},
                                                               {"m/s", {0, 1, -1, 0}},
                                                               {"m/s^2", {0, 1, -2, 0}},
                                                               {"rad", {0, 0, 0, 1}},
                                                               {"rad/s", {0, 0, -1, 1}},
                                                               {"N", {1, 1, -2, 0}},
                                                               {"N m", {1, 2, -2, 0}},
                                                               {"kg", {1, 0, 0, 0}}};
  return units;
}

std::string describe_units(const std::vector<Variable>& variables) {
  std::map<std::string, bool> used;
  for (const Variable& variable : variables) used[variable.unit] = true;
  std::string xml = "  <UnitDefinitions>\n";
  for (const auto& [unit, is_used] : used) {
    if (unit.empty()) continue;
    xml += "    <Unit name=\"" + escape(unit) + "\">";
    const auto known = get_units().find(unit);
    if (known != get_units().end()) {
      xml += "<BaseUnit";
      constexpr const char* kNames[] = {"kg", "m", "s", "rad"};
      for (std::size_t i = 0; i < 4; ++i)
        if (known->second[i] != 0)
          xml += std::string(" ") + kNames[i] + "=\"" + std::to_string(known->second[i]) + "\"";
      xml += "/>";
    }
    xml += "</Unit>\n";
  }
  return xml + "  </UnitDefinitions>\n";
}

std::string describe_variable(const Variable& variable, std::size_t reference, int version) {
  const bool time = reference == 0;
  std::string common = " name=\"" + escape(variable.name) + "\" valueReference=\"" + std::to_string(reference) +
                       "\" description=\"" + escape(variable.description) + "\" causality=\"" +
                       (time             ? "independent"
                        : variable.input ? "input"
                                         : "output") +
                       "\" variability=\"continuous\"";
  std::string real = variable.unit.empty() ? "" : " unit=\"" + escape(variable.unit) + "\"";
  if (variable.input)
    real += " min=\"" + write(variable.minimum) + "\" max=\"" + write(variable.maximum) + "\" start=\"" +
            write(variable.start) + "\"";
  if (version == 3) return "    <Float64" + common + real + "/>\n";
  return "    <ScalarVariable" + common + "><Real" + real + "/></ScalarVariable>\n";
}

struct Description {
  std::string name, identifier, token;
  double dt, until;
};

std::string describe(const Description& model, const std::vector<Variable>& variables, int version) {
  const std::string v3 =
      "hasEventMode=\"true\" canReturnEarlyAfterIntermediateUpdate=\"true\" fixedInternalStepSize=\"" +
      write(model.dt) + "\" canGetAndSetFMUState=\"true\" canSerializeFMUState=\"true\"";
  const std::string v2 = "canGetAndSetFMUstate=\"true\" canSerializeFMUstate=\"true\"";
  std::string xml = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<fmiModelDescription fmiVersion=\"" +
                    std::string(version == 3 ? "3.0" : "2.0") + "\" modelName=\"" + escape(model.name) + "\" " +
                    (version == 3 ? "instantiationToken" : "guid") + "=\"" + model.token +
                    "\" generationTool=\"unlatch\"" + (version == 3 ? "" : " variableNamingConvention=\"structured\"") +
                    ">\n";
  const std::string simulation = "  <CoSimulation modelIdentifier=\"" + model.identifier +
                                 "\" canHandleVariableCommunicationStepSize=\"true\" " + (version == 3 ? v3 : v2) +
                                 "/>\n";
  xml += simulation + describe_units(variables);
  xml += "  <DefaultExperiment startTime=\"0\" stopTime=\"" + write(model.until) + "\" stepSize=\"" + write(model.dt) +
         "\"/>\n";
  xml += "  <ModelVariables>\n";
  for (std::size_t i = 0; i < variables.size(); ++i) xml += describe_variable(variables[i], i, version);
  xml += "  </ModelVariables>\n  <ModelStructure>\n";
  // All outputs; and the same as what initialization mode computes.
  for (const char* const list : {"Output", "InitialUnknown"}) {
    if (version == 2) xml += std::string("    <") + list + "s>\n";
    for (std::size_t i = 1; i < variables.size(); ++i) {
      if (variables[i].input) continue;
      xml += version == 3 ? std::string("    <") + list + " valueReference=\"" + std::to_string(i) + "\"/>\n"
                          : "      <Unknown index=\"" + std::to_string(i + 1) + "\"/>\n";
    }
    if (version == 2) xml += std::string("    </") + list + "s>\n";
  }
  return xml + "  </ModelStructure>\n</fmiModelDescription>\n";
}

std::string read_file(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream bytes;
  bytes << file.rdbuf();
  if (!file) throw std::runtime_error(path + ": cannot be read");
  return bytes.str();
}

// A C identifier.
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
  Description model{name, make_identifier(name), unlatch::fmi::calc_token(text, lines), 0, 0};
  (void)unlatch_get_scenario(simulation, nullptr, &model.dt, &model.until);
  const std::vector<Variable> variables = unlatch::fmi::list_variables(simulation);
  const std::string xml = describe(model, variables, version);
  (void)unlatch_close(simulation);
  if (variables.empty()) throw std::runtime_error(name + ": its variables cannot be listed");

  Dl_info own{};
  if (dladdr(reinterpret_cast<const void*>(&unlatch_write_fmu), &own) == 0) throw std::runtime_error("no own binary");
#if defined(__aarch64__)
  const std::string platform = version == 3 ? "aarch64-linux" : "linux-aarch64";
#else
  const std::string platform = version == 3 ? "x86_64-linux" : "linux64";
#endif
  const std::string binary = own.dli_fname, folder = binary.substr(0, binary.rfind('/') + 1);
  Zip zip;
  zip.add("modelDescription.xml", xml);
  zip.add("resources/scenario.yaml", text);
  zip.add("resources/overrides.txt", overrides);
  zip.add("binaries/" + platform + "/" + model.identifier + ".so", read_file(binary));
  // The distances of shapes are in a module beside it (hil/modules).
  if (std::ifstream(folder + "libunlatch-fcl.so"))
    zip.add("binaries/" + platform + "/libunlatch-fcl.so", read_file(folder + "libunlatch-fcl.so"));
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
