// Outputs: names of the quantities that a run writes, and their rates.
#include "hil/scenario/outputs.h"

#include "hil/scenario/sections/scenario_reader.h"

namespace unlatch::hil {

void ScenarioReader::read_outputs(YamlMap& top) {
  const YamlNode* node = top.find("outputs");
  if (!node) return;
  if (!node->is_sequence())
    return mistakes_.add(node->mark, "outputs is not a list", "write `- {select: [core.*, \"*.force\"], every: 10}`");
  const std::vector<Output> known = list_outputs(scenario_);
  for (const YamlNode& item : node->items) read_output_group(item, known);
}

void ScenarioReader::read_output_group(const YamlNode& node, const std::vector<Output>& known) {
  OutputGroup group;
  YamlMap map(node, "a group of outputs", mistakes_);
  const std::string where = "outputs " + std::to_string(scenario_.outputs.size() + 1);
  scenario_.marks[where] = node.mark;
  if (const YamlNode* select = map.require("select")) {
    if (!select->is_sequence()) mistakes_.add(select->mark, "select is not a list", "write [core.*, \"*.force\"]");
    for (const YamlNode& item : select->items) read_output_pattern(item, known, where, group);
  }
  if (const YamlNode* rate = map.find("rate")) {
    const double hertz = map.number("rate", "Hz");
    group.rate.every = scenario_.dt > 0 && hertz > 0 ? calc_every(hertz, scenario_.dt) : 0;
    if (group.rate.every < 1) {
      group.rate.every = 1;
      mistakes_.add(rate->mark, "a period of this rate is not a whole number of steps",
                    "a rate that divides 1/step.dt");
    }
    for (const char* other : {"every", "period"})
      if (const YamlNode* second = map.find(other))
        mistakes_.add(second->mark, std::string(other) + " beside rate", "one of rate, every, period");
  } else if (map.find("every") || map.find("period")) {
    group.rate = read_rate(map);
  }
  if (const YamlNode* phase = map.find("phase"); phase && !map.find("every") && !map.find("period"))
    mistakes_.add(phase->mark, "phase without every or period",
                  "a phase counts ticks of one of them: {every: 10, phase: 5}");
  map.finish();
  scenario_.outputs.push_back(std::move(group));
}

// Reads a pattern. A wrong name is a mistake; a pattern with * that selects nothing here is a remark, since templates
// may contain it.
void ScenarioReader::read_output_pattern(const YamlNode& node, const std::vector<Output>& known,
                                         const std::string& where, OutputGroup& group) {
  const std::string pattern = read_text(node, mistakes_);
  const std::string fault = find_fault(pattern, known);
  if (!fault.empty() && pattern.find('*') == std::string::npos)
    mistakes_.add(node.mark, "'" + pattern + "' is no output", fault);
  else if (!fault.empty())
    scenario_.remarks.push_back({where, "'" + pattern + "' selects nothing: " + fault, "outputs"});
  group.patterns.push_back(pattern);
}

}  // namespace unlatch::hil
