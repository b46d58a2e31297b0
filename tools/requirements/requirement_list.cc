#include "tools/requirements/requirement_list.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <string_view>

#include "hil/scenario/language/record.h"
#include "hil/scenario/text/suggestion.h"
#include "hil/scenario/text/utf8.h"
#include "hil/scenario/yaml/yaml_reader.h"
#include "tools/common/text.h"

namespace unlatch::tools {

const std::vector<std::string> kUsualIds{"ReqIF.ForeignID", "ID", "Identifier", "Object Identifier", "ForeignID"};
const std::vector<std::string> kUsualTexts{"ReqIF.Text", "Text", "Object Text", "Primary Text", "Description"};
const std::vector<std::string> kUsualParents{"Parent", "Parent ID", "Derived from"};
const std::vector<std::string> kUsualRationales{"Rationale", "ReqIF.Rationale"};

std::string describe_limit(const hil::Requirement& requirement) {
  const std::string unit = requirement.unit.empty() ? "" : " " + requirement.unit;
  if (std::isinf(requirement.most)) return "at least " + to_short_text(requirement.least) + unit;
  if (std::isinf(requirement.least)) return "at most " + to_short_text(requirement.most) + unit;
  return "between " + to_short_text(requirement.least) + " and " + to_short_text(requirement.most) + unit;
}

std::vector<ListedRequirement> list_requirements(const hil::Scenario& scenario) {
  std::vector<ListedRequirement> list;
  const hil::ScenarioRecord record = hil::load_record(scenario);
  for (std::size_t i = 0; i < scenario.requirements.size(); ++i) {
    const hil::Requirement& one = scenario.requirements[i];
    list.push_back({one.id, one.text, record.requirements[i].parent, record.requirements[i].rationale,
                    hil::describe_quantity(one, scenario.model) + ": " + describe_limit(one)});
  }
  return list;
}

std::string to_line(std::string_view text) {
  std::string out;
  bool space = false;
  for (std::size_t i = 0; i < text.size();) {
    const std::size_t length = hil::get_utf8_length(text, i);
    if (length == 0) throw RequirementError("it is not UTF-8: save it as such");
    const auto byte = static_cast<unsigned char>(text[i]);
    const bool c1 = byte == 0xc2 && static_cast<unsigned char>(text[i + 1]) < 0xa0;
    if (byte <= 0x20 || byte == 0x7f || c1) {
      space = !out.empty();
    } else {
      if (space) out += ' ';
      space = false;
      out += text.substr(i, length);
    }
    i += length;
  }
  return out;
}

std::size_t find_attribute(const std::vector<std::string>& known, const std::string& given,
                           const std::vector<std::string>& usual) {
  const std::vector<std::string>& wanted = given.empty() ? usual : std::vector<std::string>{given};
  for (const std::string& name : wanted)
    for (std::size_t i = 0; i < known.size(); ++i)
      if (hil::to_lower(known[i]) == hil::to_lower(name)) return i;
  return known.size();
}

namespace {

// A line between quotation marks, as YAML reads it.
std::string quote(const std::string& line) {
  std::string out = "\"";
  for (const char c : line) {
    if (c == '"' || c == '\\') out += '\\';
    out += c;
  }
  return out + "\"";
}

}  // namespace

ImportedPart write_part(const std::vector<ListedRequirement>& list, const hil::Scenario& scenario,
                        const std::string& file) {
  ImportedPart part;
  part.text = "# Written by `unlatch requirements import` from " + quote(to_line(file)) +
              ": texts of requirements of " + scenario.name + ". The scenario has `include:` with this file's name.\n" +
              "unlatch_part: 1\n";
  std::string sets, others;
  std::set<std::string_view> seen;
  for (const ListedRequirement& one : list) {
    if (!seen.insert(one.id).second)
      throw RequirementError("requirement '" + one.id + "' stands there more than once; give each its own identifier");
    const bool known = std::ranges::any_of(scenario.requirements, [&](const auto& own) { return own.id == one.id; });
    if (!known) {
      part.missing.push_back(one.id);
      others += "#   - id: " + (hil::is_name(one.id) ? one.id : "NAME  # " + quote(one.id) + " is no name") +
                "\n#     text: " + quote(one.text) + "\n";
      if (!one.parent.empty()) others += "#     parent: " + quote(one.parent) + "\n";
      if (!one.rationale.empty()) others += "#     rationale: " + quote(one.rationale) + "\n";
      continue;
    }
    ++part.set;
    const auto add = [&](const char* key, const std::string& value) {
      if (!value.empty()) sets += "  requirements." + one.id + "." + key + ": " + quote(value) + "\n";
    };
    add("text", one.text);
    add("parent", one.parent);
    add("rationale", one.rationale);
  }
  for (const hil::Requirement& own : scenario.requirements)
    if (std::ranges::none_of(list, [&](const auto& one) { return one.id == own.id; })) part.unknown.push_back(own.id);
  if (!sets.empty()) part.text += "set:\n" + sets;
  if (!others.empty())
    part.text +=
        "\n# The scenario does not judge these. To add one to its `requirements`, give it a quantity and a limit:\n" +
        others;
  return part;
}

}  // namespace unlatch::tools
