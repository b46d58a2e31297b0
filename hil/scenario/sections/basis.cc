// The basis of values: which ones an entry covers, and its uncertainty.
#include <algorithm>

#include "hil/scenario/language/record.h"
#include "hil/scenario/sections/scenario_reader.h"
#include "hil/scenario/text/suggestion.h"

namespace unlatch::hil {

// Only where numbers are kept: scenarios that differ in some values have one basis, which was read with the first.
void ScenarioReader::read_basis(YamlMap& top, const YamlNode& root) {
  const YamlNode* const node = top.find("basis");
  if (mistakes_.numbers().empty()) return;
  if (node != nullptr) {
    if (!node->is_sequence())
      mistakes_.add(node->mark, "basis is not a list", "write `- {of: bodies.*.mass, is: measured}` for each entry");
    for (const YamlNode& item : node->items) read_basis_entry(item, root);
  }
  record_.values = list_data(root, record_.basis, mistakes_);
  check_uncertainties();
}

void ScenarioReader::read_basis_entry(const YamlNode& node, const YamlNode& root) {
  Basis basis;
  basis.mark = node.mark;
  YamlMap map(node, "an entry of basis", mistakes_);
  const std::string where = "basis " + std::to_string(record_.basis.size() + 1);
  scenario_.marks[where] = node.mark;
  if (const YamlNode* const of = map.require("of")) {
    if (of->is_sequence() && !of->items.empty())
      for (const YamlNode& item : of->items) read_basis_pattern(item, root, where, basis);
    else
      read_basis_pattern(*of, root, where, basis);
  }
  basis.kind = static_cast<Basis::Kind>(std::max(0, map.choice("is", "basis", kBasisNames)));
  if (const YamlNode* const source = map.find("source")) basis.source = read_text(*source, mistakes_);
  if (const YamlNode* const uncertainty = map.find("uncertainty")) {
    basis.uncertainty_text = read_text(*uncertainty, mistakes_);
    if (uncertainty->is_scalar()) basis.uncertainty = read_quantity(*uncertainty, mistakes_);
    if (basis.uncertainty && !(basis.uncertainty->value >= 0))
      mistakes_.add(uncertainty->mark, "an uncertainty below 0", "one standard deviation, at least 0: 0.5 %, 2 mm");
  }
  map.finish();
  record_.basis.push_back(std::move(basis));
}

// A path that does not exist is a mistake; a pattern with * that covers nothing here is a remark, since files that
// several scenarios include may contain it.
void ScenarioReader::read_basis_pattern(const YamlNode& node, const YamlNode& root, const std::string& where,
                                        Basis& basis) {
  const std::size_t before = mistakes_.count();
  const std::string text = read_text(node, mistakes_);
  if (mistakes_.count() != before) return;
  try {
    PathPattern pattern = parse_pattern(text, node.mark);
    const std::string& section = pattern.parts.front();
    const std::vector<std::string>& sections = list_data_sections();
    if (std::ranges::find(sections, section) == sections.end())
      return mistakes_.add(node.mark, "'" + section + "' is no section with data", suggest(section, sections));
    if (find_matches(pattern, root).empty()) {
      const std::string mend = correct_pattern(pattern, root);
      if (!pattern.has_wildcard()) return mistakes_.add(node.mark, "nothing is at '" + text + "'", mend);
      scenario_.remarks.push_back({where, "'" + text + "' covers nothing: " + mend, "basis"});
    }
    basis.of.push_back(std::move(pattern));
  } catch (const YamlError& error) {
    mistakes_.add(error.mark, error.what(), error.mend);
  }
}

// An uncertainty with a unit is one of values in that unit.
void ScenarioReader::check_uncertainties() {
  std::vector<bool> reported(record_.basis.size());
  for (const DataValue& value : record_.values) {
    if (value.basis < 0) continue;
    const auto entry = static_cast<std::size_t>(value.basis);
    const Basis& basis = record_.basis[entry];
    if (reported[entry] || !basis.uncertainty || basis.uncertainty->dimension.is_plain() || value.numbers.empty())
      continue;
    const Dimension dimension = dimension_of(value.unit);
    if (!dimension.is_plain() && dimension.takes(basis.uncertainty->dimension)) continue;
    reported[entry] = true;
    mistakes_.add(basis.mark,
                  "an uncertainty of '" + basis.uncertainty_text + "' for " + value.path + ", which is " +
                      describe_dimension(dimension),
                  "a part of the value, such as 0.5 %, or an entry for each unit");
  }
}

}  // namespace unlatch::hil
