#include "tools/fmu/description.h"

#include <expat.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <map>
#include <memory>
#include <string_view>

#include "tools/fmu/zip_file.h"

namespace unlatch::fmu {
namespace {

using Attributes = const XML_Char**;

std::string find(Attributes attributes, std::string_view name) {
  for (; *attributes != nullptr; attributes += 2)
    if (name == attributes[0]) return attributes[1];
  return {};
}

class Reader {
 public:
  Description description;
  bool is_fmi = false, is_co_simulation = false;
  std::string failure;

  static void begin(void* self, const XML_Char* element, Attributes attributes) {
    static_cast<Reader*>(self)->begin(std::string_view(element), attributes);
  }
  static void end(void* self, const XML_Char* element) {
    auto& reader = *static_cast<Reader*>(self);
    if (std::string_view(element) == "ModelVariables") reader.in_variables_ = false;
    --reader.depth_;
  }

 private:
  void begin(std::string_view element, Attributes attributes) {
    ++depth_;
    if (depth_ == 1) {
      is_fmi = element == "fmiModelDescription";
      const std::string version = find(attributes, "fmiVersion");
      description.version = version.starts_with("2.") ? 2 : version.starts_with("3.") ? 3 : 0;
      if (is_fmi && description.version == 0) failure = "fmiVersion is '" + version + "'; 2.0 and 3.0 are known";
      description.token = find(attributes, description.version == 3 ? "instantiationToken" : "guid");
    } else if (depth_ == 2 && element == "CoSimulation") {
      is_co_simulation = true;
      description.identifier = find(attributes, "modelIdentifier");
    } else if (depth_ == 3 && element == "Unit") {
      unit_ = find(attributes, "name");
    } else if (depth_ == 4 && element == "BaseUnit") {
      const std::string factor = find(attributes, "factor"), offset = find(attributes, "offset");
      const bool is_si = (factor.empty() || read_number(factor) == 1) && (offset.empty() || read_number(offset) == 0);
      if (!is_si) description.scaled_units.push_back(unit_);
    } else if ((depth_ == 3 && element == "SimpleType") || (depth_ == 3 && element.ends_with("Type"))) {
      type_ = find(attributes, "name");
      if (const std::string unit = find(attributes, "unit"); !unit.empty()) types_[type_] = unit;
    } else if (depth_ == 4 && !in_variables_ && element == "Real") {
      if (const std::string unit = find(attributes, "unit"); !unit.empty()) types_[type_] = unit;
    } else if (depth_ == 2 && element == "ModelVariables") {
      in_variables_ = true;
    } else if (in_variables_ && depth_ == 3) {
      add_variable(element, attributes);
    } else if (in_variables_ && depth_ == 4 && !description.variables.empty()) {
      Variable& variable = description.variables.back();
      if (description.version == 2 && variable.kind == Variable::Kind::kOther) variable.kind = get_kind(element);
      if (element == "Dimension") variable.array = true;
      if (description.version == 2) read_unit(attributes, variable);
    }
  }
  void add_variable(std::string_view element, Attributes attributes) {
    Variable variable;
    variable.name = find(attributes, "name");
    if (description.version == 3) variable.kind = get_kind(element);
    if (description.version == 3) read_unit(attributes, variable);
    const std::string causality = find(attributes, "causality");
    if (causality == "input") variable.causality = Variable::Causality::kInput;
    if (causality == "output") variable.causality = Variable::Causality::kOutput;
    const std::string reference = find(attributes, "valueReference");
    const char* const last = reference.data() + reference.size();
    const auto read = std::from_chars(reference.data(), last, variable.reference);
    if (variable.name.empty() || read.ec != std::errc{} || read.ptr != last)
      failure = "variable '" + variable.name + "' has no name, or no valueReference that is a number";
    description.variables.push_back(std::move(variable));
  }
  // Its own unit, or that of its declared type; types stand before variables.
  void read_unit(Attributes attributes, Variable& variable) const {
    variable.unit = find(attributes, "unit");
    const auto type = types_.find(find(attributes, "declaredType"));
    if (variable.unit.empty() && type != types_.end()) variable.unit = type->second;
  }
  static double read_number(const std::string& text) {
    double value = std::nan("");
    std::from_chars(text.data(), text.data() + text.size(), value);
    return value;
  }
  static Variable::Kind get_kind(std::string_view element) {
    if (element == "Real" || element == "Float64") return Variable::Kind::kReal;
    return element == "Boolean" ? Variable::Kind::kBoolean : Variable::Kind::kOther;
  }

  int depth_ = 0;
  bool in_variables_ = false;
  std::string unit_, type_;                   // the latest
  std::map<std::string, std::string> types_;  // units of types
};

}  // namespace

Description read_description(const std::string& xml) {
  const std::string place = "modelDescription.xml: ";
  const std::unique_ptr<XML_ParserStruct, void (*)(XML_Parser)> parser(XML_ParserCreate(nullptr), XML_ParserFree);
  if (!parser) throw FmuError(place + "no memory to read it");
  Reader reader;
  XML_SetUserData(parser.get(), &reader);
  XML_SetElementHandler(parser.get(), &Reader::begin, &Reader::end);
  if (XML_Parse(parser.get(), xml.data(), static_cast<int>(xml.size()), 1) != XML_STATUS_OK) {
    throw FmuError(place + "line " + std::to_string(XML_GetCurrentLineNumber(parser.get())) + ": " +
                   XML_ErrorString(XML_GetErrorCode(parser.get())));
  }
  if (!reader.is_fmi) throw FmuError(place + "its root is not fmiModelDescription");
  if (!reader.failure.empty()) throw FmuError(place + reader.failure);
  if (!reader.is_co_simulation) throw FmuError(place + "it offers no co-simulation, which is needed here");
  const std::string& identifier = reader.description.identifier;
  const bool is_identifier = !identifier.empty() && std::ranges::all_of(identifier, [](unsigned char c) {
    return std::isalnum(c) != 0 || c == '_';
  });
  if (!is_identifier) throw FmuError(place + "modelIdentifier '" + identifier + "' is no C identifier");
  return std::move(reader.description);
}

}  // namespace unlatch::fmu
