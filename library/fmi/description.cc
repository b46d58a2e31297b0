#include "library/fmi/description.h"

#include <algorithm>
#include <exception>
#include <set>
#include <string_view>

#include "hil/scenario/text/number_text.h"
#include "hil/scenario/text/quantity.h"
#include "hil/scenario/text/xml_text.h"

namespace unlatch::fmi {
namespace {

using hil::escape_xml;

// <BaseUnit .../> of a unit, by its exponents; "" for a unit that the scenario's author invented.
std::string describe_base(const std::string& unit) {
  hil::Dimension dimension;
  try {
    if (unit != "1") dimension = hil::dimension_of(unit);
  } catch (const std::exception&) {
    return "";
  }
  constexpr const char* kNames[] = {"m", "kg", "s", "rad", "", "K"};  // in the order of Dimension::Base
  std::string xml = "<BaseUnit";
  for (const std::size_t i : {1u, 0u, 2u, 5u, 3u})
    if (dimension.exponents[i] != 0)
      xml += std::string(" ") + kNames[i] + "=\"" + std::to_string(dimension.exponents[i]) + "\"";
  return xml + "/>";
}

std::string describe_units(const std::vector<Variable>& variables) {
  std::set<std::string> used;
  for (const Variable& variable : variables) used.insert(variable.unit);
  used.erase("");
  std::string xml = "  <UnitDefinitions>\n";
  for (const std::string& unit : used)
    xml += "    <Unit name=\"" + escape_xml(unit) + "\">" + describe_base(unit) + "</Unit>\n";
  return xml + "  </UnitDefinitions>\n";
}

std::string describe_variable(const Variable& variable, std::size_t reference, int version) {
  using enum Variable::Causality;
  static constexpr const char* kNames[] = {"independent", "input", "parameter", "output"};  // in the order of Causality
  const std::string common = " name=\"" + escape_xml(variable.name) + "\" valueReference=\"" +
                             std::to_string(reference) + "\" description=\"" + escape_xml(variable.description) +
                             "\" causality=\"" + kNames[static_cast<std::size_t>(variable.causality)] +
                             "\" variability=\"" + (variable.causality == kParameter ? "fixed" : "continuous") + "\"";
  std::string real = variable.unit.empty() ? "" : " unit=\"" + escape_xml(variable.unit) + "\"";
  if (variable.causality == kInput)
    real += " min=\"" + hil::write_number(variable.minimum) + "\" max=\"" + hil::write_number(variable.maximum) + "\"";
  if (variable.causality == kInput || variable.causality == kParameter)
    real += " start=\"" + hil::write_number(variable.start) + "\"";
  if (version == 3) return "    <Float64" + common + real + "/>\n";
  return "    <ScalarVariable" + common + "><Real" + real + "/></ScalarVariable>\n";
}

// FMI 2.0.4, 2.2.9, and 3.0, 2.4.7.5.1: identifiers of letters, digits and _ with points between them, each with array
// indices in one pair of brackets. Quoted names and derivatives, which are legal too, do not occur here.
bool is_structured(std::string_view name) {
  const auto is_digit = [](char c) { return c >= '0' && c <= '9'; };
  const auto is_letter = [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; };
  std::size_t i = 0;
  const auto skip = [&](const auto& belongs) {
    const std::size_t before = i;
    while (i < name.size() && belongs(name[i])) ++i;
    return i > before;
  };
  while (true) {
    if (i == name.size() || !is_letter(name[i])) return false;
    (void)skip([&](char c) { return is_letter(c) || is_digit(c); });
    if (i < name.size() && name[i] == '[') {
      do {
        ++i;
        if (!skip(is_digit)) return false;
      } while (i < name.size() && name[i] == ',');
      if (i == name.size() || name[i++] != ']') return false;
    }
    if (i == name.size()) return true;
    if (name[i++] != '.') return false;
  }
}

// "structured" is a promise for all names of a description: paths such as attitude.rotate[0][1] and names with a hyphen
// do not keep it. "flat" takes any text.
bool are_structured(const std::vector<Variable>& variables) {
  return std::all_of(variables.begin(), variables.end(), [](const Variable& v) { return is_structured(v.name); });
}

}  // namespace

std::string describe(const Description& model, const std::vector<Variable>& variables, int version) {
  const std::string v3 =
      "hasEventMode=\"true\" canReturnEarlyAfterIntermediateUpdate=\"true\" fixedInternalStepSize=\"" +
      hil::write_number(model.dt) + "\" canGetAndSetFMUState=\"true\" canSerializeFMUState=\"true\"";
  const std::string v2 = "canGetAndSetFMUstate=\"true\" canSerializeFMUstate=\"true\"";
  std::string xml = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<fmiModelDescription fmiVersion=\"" +
                    std::string(version == 3 ? "3.0" : "2.0") + "\" modelName=\"" + escape_xml(model.name) + "\" " +
                    (version == 3 ? "instantiationToken" : "guid") + "=\"" + model.token +
                    "\" generationTool=\"unlatch\"" + " variableNamingConvention=\"" +
                    (are_structured(variables) ? "structured" : "flat") + "\">\n";
  xml += "  <CoSimulation modelIdentifier=\"" + model.identifier +
         "\" canHandleVariableCommunicationStepSize=\"true\" " + (version == 3 ? v3 : v2);
  if (version == 2 && !model.sources.empty()) {
    xml += ">\n    <SourceFiles>\n";
    for (const std::string& file : model.sources) xml += "      <File name=\"" + escape_xml(file) + "\"/>\n";
    xml += "    </SourceFiles>\n  </CoSimulation>\n";
  } else {
    xml += "/>\n";
  }
  xml += describe_units(variables);
  xml += "  <DefaultExperiment startTime=\"0\" stopTime=\"" + hil::write_number(model.until) + "\" stepSize=\"" +
         hil::write_number(model.dt) + "\"/>\n";
  xml += "  <ModelVariables>\n";
  for (std::size_t i = 0; i < variables.size(); ++i) xml += describe_variable(variables[i], i, version);
  xml += "  </ModelVariables>\n  <ModelStructure>\n";
  // All outputs, and the unknowns of initialization mode, which are the same.
  for (const char* const list : {"Output", "InitialUnknown"}) {
    if (version == 2) xml += std::string("    <") + list + "s>\n";
    for (std::size_t i = 1; i < variables.size(); ++i) {
      if (variables[i].causality != Variable::Causality::kOutput) continue;
      xml += version == 3 ? std::string("    <") + list + " valueReference=\"" + std::to_string(i) + "\"/>\n"
                          : "      <Unknown index=\"" + std::to_string(i + 1) + "\"/>\n";
    }
    if (version == 2) xml += std::string("    </") + list + "s>\n";
  }
  return xml + "  </ModelStructure>\n</fmiModelDescription>\n";
}

}  // namespace unlatch::fmi
