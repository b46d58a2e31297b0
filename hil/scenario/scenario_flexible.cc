// Flexible bodies, whose modes come from a file beside the scenario (MODES.md), and the markers that they carry.
#include <cmath>
#include <stdexcept>

#include "hil/flexible/flexible_body.h"
#include "hil/scenario/scenario_reader.h"

namespace unlatch::hil {

// {modes: FILE, select: [1, 4, 5], damping: 0.01 or one for each}
void ScenarioReader::read_flexible(const YamlNode& node, Body& body) {
  YamlMap map(node, "a flexible body", mistakes_);
  const YamlNode* file = map.require("modes");
  ModeSelection selection;
  if (const YamlNode* select = map.find("select"))
    for (const double number : read_numbers(*select, 0, "", mistakes_)) {
      constexpr double kMost = 1e6;
      const bool counts = number == std::floor(number) && std::abs(number) < kMost;
      if (!counts) mistakes_.add(select->mark, "the number of a mode is a whole one", "1 is the first in the file");
      selection.numbers.push_back(counts ? static_cast<int>(number) : 1);
    }
  if (const YamlNode* damping = map.find("damping"))
    selection.damping = damping->is_sequence() ? read_numbers(*damping, 0, "", mistakes_)
                                               : std::vector<double>{read_number(*damping, "", 0.0, mistakes_)};
  map.finish();
  if (file == nullptr) return;
  const std::string name = read_text(*file, mistakes_);
  try {
    FlexibleReport report;
    const std::string path = resolve_include("", name);
    const FlexibleStructure structure =
        build_flexible_body(read_modes_text(sources_.read(path), path), selection, report);
    body.mass = structure.mass;
    body.inertia = structure.inertia;
    body.flexible = structure.flexible;
    structures_[body.name] = structure;
  } catch (const ScenarioError& error) {
    mistakes_.add(file->mark, "its modes cannot be read: " + std::string(error.what()), "see hil/MODES.md");
  } catch (const std::invalid_argument& error) {
    mistakes_.add(node.mark, name + ": " + error.what(), "unlatch modes show says what the file has");
  } catch (const std::runtime_error& error) {
    mistakes_.add(file->mark, "its modes cannot be read: " + std::string(error.what()), "a file beside the scenario");
  }
}

// {of: BODY, at: NAME}: a frame of the modes file. The flexible body stands above it.
void ScenarioReader::read_marker(const YamlNode& node, Body& body) {
  YamlMap map(node, "a marker", mistakes_);
  const int of = map.choice("of", "body", bodies_);
  std::vector<std::string> names;
  if (of >= 0)
    for (const auto& marker : structures_[bodies_[static_cast<std::size_t>(of)]].markers) names.push_back(marker.name);
  const int at = map.choice("at", "marker", names);
  map.finish();
  if (of < 0 || at < 0) return;
  body.marker = structures_[bodies_[static_cast<std::size_t>(of)]].markers[static_cast<std::size_t>(at)].marker;
  body.marker->body = of;
}

}  // namespace unlatch::hil
