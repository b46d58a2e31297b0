// Flexible bodies, whose modes come from a file beside the scenario (MODES.md), and their markers.
#include <cmath>
#include <cstdio>
#include <stdexcept>

#include "hil/scenario/flexible/flexible_body.h"
#include "hil/scenario/sections/scenario_reader.h"

namespace unlatch::hil {

namespace {

// Larger changes than those caused by lumped masses and printed digits.
constexpr double kChanged = 1e-3;

// Description of the changes that conditioning made to the modes; empty if there are none.
std::string describe_changes(const FlexibleReport& report) {
  char line[200];
  const bool is_off = report.found_gram > kChanged || report.found_momentum > kChanged;
  if (!is_off) return "";
  std::snprintf(line, sizeof line,
                "its modes were changed when the file was read: they were off orthogonality by %.2g and off zero "
                "momentum by %.2g",
                report.found_gram, report.found_momentum);
  std::string text = line;
  for (const ModeFinding& mode : report.modes) {
    if (!mode.selected || std::abs(mode.hz - mode.file_hz) <= kChanged * mode.file_hz) continue;
    std::snprintf(line, sizeof line, "; mode %d from %.6g to %.6g Hz, with its damping ratio", mode.number,
                  mode.file_hz, mode.hz);
    text += line;
  }
  return text;
}

}  // namespace

// Reads {modes: FILE, select: [1, 4, 5], damping: 0.01 or one for each}.
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
    const KnownStructure& known = read_structure(resolve_include("", name), selection.numbers);
    FlexibleStructure structure = known.structure;
    set_damping(selection.damping, structure);
    if (const std::string changes = describe_changes(known.report); !changes.empty())
      scenario_.remarks.push_back({"body '" + body.name + "'", changes});
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

// A file's structure without damping: read and conditioned, unless this or a reading with other values has it.
const KnownStructure& ScenarioReader::read_structure(const std::string& path, const std::vector<int>& numbers) {
  const std::string& text = sources_.read(path);
  for (const std::shared_ptr<const KnownStructure>& known : known_structures_)
    if (known->path == path && known->numbers == numbers) return *known;
  const auto made = std::make_shared<KnownStructure>();
  made->path = path;
  made->numbers = numbers;
  made->structure = build_flexible_body(read_modes_text(text, path), {numbers, {0}}, made->report);
  return *known_structures_.emplace_back(made);
}

// Reads {of: BODY, at: NAME}: a frame of the modes file. The flexible body precedes it in the scenario.
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
