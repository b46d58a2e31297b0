#include "hil/scenario/scenario.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <set>

#include "hil/scenario/language/bounded_number.h"
#include "hil/scenario/language/scenario_parts.h"
#include "hil/scenario/scenario_tree.h"
#include "hil/scenario/sections/scenario_reader.h"
#include "hil/scenario/text/number_text.h"
#include "hil/scenario/yaml/yaml_override.h"
#include "unlatch/model/contact_substeps.h"

namespace unlatch::hil {
namespace {

constexpr double kMaxTicks = 1e12;

}  // namespace

const std::vector<std::string> kPolicyNames{"hold", "zero", "safe", "pause", "abort", "evict"};

namespace {

Scenario read_tree(const YamlNode& root, ScenarioSources& sources, const std::string& file,
                   std::vector<std::string> overrides, Mistakes& mistakes, KnownStructures* structures = nullptr,
                   const Scenario* like = nullptr, ScenarioRecord* record = nullptr) {
  Scenario scenario;
  scenario.file = file;
  scenario.overrides = std::move(overrides);
  KnownStructures own;
  ScenarioReader reader(scenario, sources, mistakes, structures != nullptr ? *structures : own, like);
  for (const YamlError& unread : list_unread_overrides(root)) mistakes.add(unread.mark, unread.what(), unread.mend);
  reader.read(root);
  if (record != nullptr) *record = reader.take_record();
  mistakes.throw_if_any();
  scenario.text = sources.join();
  scenario.files = mistakes.files();
  return scenario;
}

// Files of a scenario, read and joined once, for readings that differ in their overrides.
struct Files {
  Files(ScenarioSources sources_in, const std::string& file_in)
      : file(file_in), sources(std::move(sources_in)), mistakes(file, {}), root(build_tree(sources, file, mistakes)) {}

  std::string file;
  ScenarioSources sources;
  Mistakes mistakes;
  YamlNode root;
};

void apply_overrides(const std::vector<std::string>& overrides, YamlNode& root, Mistakes& mistakes) {
  accept_read_overrides(root);
  for (const std::string& text : overrides) {
    const int index = mistakes.add_override(text);
    try {
      apply_override(text, index, root);
      accept_read_overrides(root);
    } catch (const YamlError& e) {
      mistakes.add(e.mark, e.what(), e.mend);
    }
  }
}

Scenario read_files(Files files, const std::vector<std::string>& overrides, KnownStructures* structures = nullptr) {
  apply_overrides(overrides, files.root, files.mistakes);
  files.mistakes.keep_numbers();
  Scenario scenario = read_tree(files.root, files.sources, files.file, overrides, files.mistakes, structures);
  scenario.numbers = list_written_numbers(files.root, files.mistakes);
  for (const std::string& name : list_unread_constants(files.root))
    scenario.remarks.push_back({"constant '" + name + "'", "nothing reads it: its value changes nothing", "unread"});
  return scenario;
}

std::set<std::string> list_mistakes(const Files& files, const std::vector<std::string>& overrides) {
  std::set<std::string> found;
  try {
    read_files(files, overrides);
  } catch (const ScenarioError& error) {
    for (const ScenarioMistake& mistake : error.mistakes) found.insert(mistake.to_string());
  }
  return found;
}

// Attributes mistakes to overrides. An override may make a line wrong that is correct without it: constants.gap=-0.2,
// and a length that uses gap. Such a mistake belongs to the first override without which it disappears.
void blame_overrides(const Files& files, const std::vector<std::string>& overrides,
                     std::vector<ScenarioMistake>& mistakes) {
  constexpr std::size_t kTried = 64;  // overrides: each costs one more reading
  const auto is_blamed = [](const ScenarioMistake& mistake) { return !mistake.override_text.empty(); };
  for (std::size_t i = 0; i < std::min(kTried, overrides.size()); ++i) {
    if (std::ranges::all_of(mistakes, is_blamed)) return;
    std::vector<std::string> others = overrides;
    others.erase(others.begin() + static_cast<std::ptrdiff_t>(i));
    const std::set<std::string> remaining = list_mistakes(files, others);
    for (ScenarioMistake& mistake : mistakes)
      if (!is_blamed(mistake) && remaining.count(mistake.to_string()) == 0) mistake.override_text = overrides[i];
  }
}

Scenario load_sources(const ScenarioSources& sources, const std::string& file,
                      const std::vector<std::string>& overrides, KnownStructures* structures = nullptr) {
  const Files files(sources, file);
  try {
    return read_files(files, overrides, structures);
  } catch (const ScenarioError& error) {
    std::vector<ScenarioMistake> mistakes = error.mistakes;
    blame_overrides(files, overrides, mistakes);
    throw ScenarioError(std::move(mistakes));
  }
}

ScenarioSources open_sources(const std::string& path) {
  const std::string folder = is_standard_input(path) ? "" : std::filesystem::path(path).parent_path().string();
  return {read_text_file(path, "scenario"), folder.empty() ? "." : folder};
}

std::string get_shown_name(const std::string& path) { return path == "-" ? "<stdin>" : path; }

}  // namespace

std::string name_surface_shape(const Scenario& scenario, int surface, int shape) {
  const Surface& own = scenario.model.surfaces[static_cast<std::size_t>(surface)];
  const std::string body =
      own.body == kGround ? "ground" : scenario.model.bodies[static_cast<std::size_t>(own.body)].name;
  const std::size_t dot = own.name.find('.');
  const std::string part = dot == std::string::npos ? "" : own.name.substr(dot + 1);
  const std::vector<BodyShape>& shapes = get_shapes(scenario, own.body);
  int number = 0;
  for (std::size_t i = 0; i < shapes.size(); ++i) {
    if (!part.empty() && shapes[i].name != part && shapes[i].group != part) continue;
    if (number++ != shape) continue;
    return body + "." + (shapes[i].name.empty() ? "shape[" + std::to_string(i) + "]" : shapes[i].name);
  }
  return own.name;
}

std::string describe_absence(const FlightSoftware& flight_software, const std::string& something) {
  std::string names;
  for (const std::string& name : flight_software.required) names += (names.empty() ? "" : ", ") + name;
  if (names.empty()) return "";
  return "the scenario requires flight software (" + names + "), which takes no part in " + something +
         ": its channels keep their initial values";
}

ScenarioRecord load_record(const Scenario& scenario) {
  Files files(ScenarioSources(scenario.text, ""), scenario.file);
  apply_overrides(scenario.overrides, files.root, files.mistakes);
  files.mistakes.keep_numbers();
  ScenarioRecord record;
  read_tree(files.root, files.sources, files.file, scenario.overrides, files.mistakes, nullptr, nullptr, &record);
  return record;
}

Scenario load_scenario(const std::string& path, const std::vector<std::string>& overrides) {
  return load_sources(open_sources(path), get_shown_name(path), overrides);
}

Scenario load_scenario_text(const std::string& text, const std::string& file,
                            const std::vector<std::string>& overrides) {
  return load_sources(ScenarioSources(text, ""), file, overrides);
}

ScenarioTree::ScenarioTree(const std::string& path, const std::vector<std::string>& overrides)
    : ScenarioTree(open_sources(path), get_shown_name(path), overrides) {}

// The first reading reports all mistakes, and reads all files of the scenario into memory.
ScenarioTree::ScenarioTree(const ScenarioSources& sources, const std::string& file,
                           const std::vector<std::string>& overrides)
    : nominal_(load_sources(sources, file, overrides, &structures_)),
      sources_(nominal_.text, ""),
      mistakes_(file, {}),
      root_(build_tree(sources_, nominal_.file, mistakes_)) {
  apply_overrides(overrides, root_, mistakes_);
}

Scenario ScenarioTree::read(std::span<const Setting> settings) const {
  ScenarioSources sources = sources_;
  Mistakes mistakes = mistakes_;
  YamlNode root = root_;
  std::vector<std::string> overrides = nominal_.overrides;
  for (const Setting& setting : settings) {
    overrides.push_back(to_text(setting));
    const int index = mistakes.add_override(overrides.back());
    try {
      apply_setting(setting, index, root);
    } catch (const YamlError& e) {
      mistakes.add(e.mark, e.what(), e.mend);
    }
  }
  KnownStructures structures = structures_;  // one that is new belongs to these settings
  return read_tree(root, sources, nominal_.file, std::move(overrides), mistakes, &structures, &nominal_);
}

// --- The reader's top level -----------------------------------------------------------------------------------------

ScenarioReader::ScenarioReader(Scenario& scenario, ScenarioSources& sources, Mistakes& mistakes,
                               KnownStructures& structures, const Scenario* like)
    : scenario_(scenario),
      model_(scenario.model),
      sources_(sources),
      mistakes_(mistakes),
      known_structures_(structures) {
  if (like == nullptr) return;
  for (const std::vector<BodyShape>& shapes : like->shapes)
    for (const BodyShape& shape : shapes)
      if (shape.mesh) known_meshes_.push_back(shape.mesh);
}

void ScenarioReader::read(const YamlNode& root) {
  if (root.kind == YamlNode::Kind::kNull)
    return mistakes_.add({}, "there is nothing in it",
                         "a scenario begins with `unlatch: 1`; `unlatch init NAME` writes one to start from");
  YamlMap top(root, "the scenario", mistakes_);
  if (!root.is_mapping()) return;
  top.read_header("unlatch");
  if (const YamlNode* name = top.require("name")) scenario_.name = read_name(*name, mistakes_);
  if (const YamlNode* title = top.find("title")) scenario_.title = read_text(*title, mistakes_);
  model_.name = scenario_.name;
  read_constants(top);
  read_step(top);
  read_gravity(top);
  read_environment(top);
  read_bodies(top);
  read_start(top);
  read_ground(top);
  read_channels(top);
  read_signals(top);
  read_joints(top);
  read_elements(top);
  read_contacts(top);
  // Contacts stand among the elements: their numbers are known once all of them are read.
  for (int i = 0; i < model_.element_count(); ++i) elements_.push_back(model_.element_name(i));
  read_tables(top);
  read_quantities(top);
  compile_element_laws();
  read_sensors(top);
  read_events(top);
  add_touches();
  append_events();
  read_clearance(top);
  read_points(top);
  read_requirements(top);
  find_quantity_events();
  read_outputs(top);
  read_flight_software(top);
  read_timing(top);
  read_sensor_delays();
  for (const char* worked_out : {"include", "set", "templates", "instances"}) top.find(worked_out);
  read_basis(top, root);
  top.finish();
  report_physics();
}

// False, and noted, if an expression would read the name as something else.
bool ScenarioReader::check_name(const std::string& name, const YamlNode& node, const std::string& kind, Minus minus) {
  const bool is_difference = minus == Minus::kRefused && name.find('-') != std::string::npos;
  if (!is_difference && !is_reserved_name(name)) return true;
  mistakes_.add(
      node.mark, "'" + name + "' cannot be the name of a " + kind,
      is_difference ? "in an expression - is minus: use _" : "it is a unit, function or constant of the language");
  return false;
}

// Each constant may use those before it.
void ScenarioReader::read_constants(YamlMap& top) {
  for_each_named(top, "constants", "constant", [&](const std::string& name, const YamlNode& node) {
    if (!check_name(name, node, "constant", Minus::kRefused)) return;
    const auto value = read_quantity(node, mistakes_);
    if (!value) return;
    mistakes_.add_constant(name, *value);
    scenario_.constants.push_back({name, *value});
  });
}

void ScenarioReader::read_step(YamlMap& top) {
  const YamlNode* node = top.require("step");
  if (!node) return;
  const std::size_t before = mistakes_.count();
  YamlMap map(*node, "step", mistakes_);
  const double dt = scenario_.dt = map.number("dt", "s");
  const double until = scenario_.until = map.number("until", "s");
  if (const YamlNode* parts = map.find("contact_substeps"); parts && !(parts->is_scalar() && parts->text == "auto"))
    model_.contact_substeps =
        static_cast<int>(read_bounded(map, get_number_key("scenario.step.contact_substeps"), 1.0, mistakes_));
  const int refinement =
      static_cast<int>(read_bounded(map, get_number_key("scenario.step.contact_refinement"), 1.0, mistakes_));
  if (has_automatic_parts(model_.contact_substeps))
    model_.contact_substeps = make_automatic_substeps(refinement);
  else if (refinement != 1)
    mistakes_.add(map.find("contact_refinement")->mark,
                  "this refinement is of automatic parts, and their number is given",
                  "leave out contact_substeps, or this");
  map.finish();
  if (mistakes_.count() != before) return;
  const auto mark = [&](const char* key) { return node->find(key)->mark; };
  // Messages carry the step as a whole number of nanoseconds.
  const double dt_ns = dt * 1e9;
  constexpr double kRounding = 1e-12;  // of dt: that of a double and of an expression, not that of a typed decimal
  if (!(dt >= 1e-6 && dt <= 1.0))
    mistakes_.add(mark("dt"), "this step is not usable",
                  "dt is 1 us to 1 s, in whole nanoseconds; 0.001 is a good start");
  else if (std::abs(dt_ns - std::round(dt_ns)) > kRounding * dt_ns)
    mistakes_.add(mark("dt"), "this step is no whole number of nanoseconds, so that two clocks would differ",
                  "the nearest two are " + std::to_string(static_cast<std::int64_t>(std::floor(dt_ns))) + " and " +
                      std::to_string(static_cast<std::int64_t>(std::ceil(dt_ns))) +
                      " ns: dt: " + write_number(std::round(dt_ns) / 1e9));
  else if (!(until > 0) || until / dt > kMaxTicks)
    mistakes_.add(mark("until"), "this end is not usable", "until is beyond 0 and within 1e12 steps");
}

void ScenarioReader::read_gravity(YamlMap& top) {
  const YamlNode* node = top.find("gravity");
  if (!node) return;
  read_item_at("gravity", *node, [&] {
    YamlMap map(*node, "gravity", mistakes_);
    model_.gravity.uniform = map.vector("uniform", "m/s2", Eigen::Vector3d::Zero());
    model_.gravity.mu = map.number("mu", "m3/s2", 0.0);
    model_.gravity.centre = map.vector("centre", "m", Eigen::Vector3d::Zero());
    map.finish();
  });
}

void ScenarioReader::read_flight_software(YamlMap& top) {
  const YamlNode* node = top.find("flight_software");
  if (!node) return;
  FlightSoftware& software = scenario_.flight_software;
  YamlMap map(*node, "flight_software", mistakes_);
  if (const YamlNode* required = map.find("required")) {
    if (!required->is_sequence())
      mistakes_.add(required->mark, "required is not a list", "write the participants' names: [fsw]");
    for (const YamlNode& item : required->items) {
      const std::string name = read_name(item, mistakes_);
      for (const std::string& other : software.required)
        if (other == name) mistakes_.add(item.mark, "'" + name + "' is required twice", "name each once");
      software.required.push_back(name);
    }
  }
  const auto read = [&](const NumberKey& key, double fallback) { return read_bounded(map, key, fallback, mistakes_); };
  software.timeout = read(get_number_key("scenario.flight_software.timeout"), software.timeout);
  software.pause_limit = read(get_number_key("scenario.flight_software.pause_limit"), software.pause_limit);
  software.cutoff = read(get_number_key("scenario.flight_software.cutoff"), software.cutoff);
  software.delay = static_cast<int>(read(get_number_key("scenario.flight_software.delay"), software.delay));
  software.horizon = read(get_number_key("scenario.flight_software.horizon"), software.horizon);
  software.queue = static_cast<int>(read(get_number_key("scenario.flight_software.queue"), software.queue));
  const int policy = map.choice("policy", "policy", kPolicyNames, static_cast<int>(software.policy));
  if (policy >= 0) software.policy = static_cast<Policy>(policy);
  if (const YamlNode* limits = map.find("require")) read_session_limits(*limits);
  map.finish();
}

void ScenarioReader::read_session_limits(const YamlNode& node) {
  FlightSoftware::Limits& limits = scenario_.flight_software.limits;
  YamlMap map(node, "require", mistakes_);
  const auto read = [&](const NumberKey& key, double fallback) { return read_bounded(map, key, fallback, mistakes_); };
  limits.lost = static_cast<int>(read(get_number_key("scenario.session_limits.lost"), limits.lost));
  limits.late = read(get_number_key("scenario.session_limits.late"), limits.late);
  limits.refused = static_cast<int>(read(get_number_key("scenario.session_limits.refused"), limits.refused));
  const auto read_optional = [&](const char* key, const NumberKey& number, std::optional<int>& limit) {
    if (map.find(key) != nullptr) limit = static_cast<int>(read(number, 0));
  };
  read_optional("malformed", get_number_key("scenario.session_limits.malformed"), limits.malformed);
  read_optional("unused", get_number_key("scenario.session_limits.unused"), limits.unused);
  read_optional("overruns", get_number_key("scenario.session_limits.overruns"), limits.overruns);
  map.finish();
}

// Reports mistakes that the kernel finds in the physics, with their places in the text.
void ScenarioReader::report_physics() {
  for (const Joint& joint : model_.joints)
    for (const int body : {joint.base, joint.follower})
      if (body >= 0 && is_flawed("body '" + bodies_.at(static_cast<std::size_t>(body)) + "'"))
        flawed_.insert("joint '" + joint.name + "'");
  for (const ModelError& error : validate(model_)) {
    if (is_flawed(error.where)) continue;
    const auto at = nodes_.find(error.where);
    SourceMark mark;
    if (at != nodes_.end()) mark = at->second->mark;
    if (const YamlNode* value = at == nodes_.end() ? nullptr : at->second->find(error.key)) mark = value->mark;
    mistakes_.add(mark, error.where + ": " + error.what, error.mend);
  }
}

void ScenarioReader::for_each_named(YamlMap& top, const std::string& section, const std::string& kind,
                                    const std::function<void(const std::string&, const YamlNode&)>& read_item) {
  const YamlNode* node = top.find(section);
  if (!node) return;
  YamlMap map(*node, section, mistakes_);
  for (std::size_t i = 0; i < node->keys.size(); ++i) {
    const YamlKey& key = node->keys[i];
    if (node->find(key.text) != &node->items[i]) continue;  // duplicate: finish() reports it
    map.find(key.text);
    if (!is_name(key.text) || key.text == "ground")
      mistakes_.add(key.mark, "'" + key.text + "' cannot be the name of a " + kind,
                    key.text == "ground" ? "ground is the inertial frame" : describe_name_rule(key.text));
    const std::string where = kind + " '" + key.text + "'";
    read_item_at(where, node->items[i], [&] { read_item(key.text, node->items[i]); });
    scenario_.marks[where] = key.mark;
  }
  map.finish();
}

void ScenarioReader::read_item_at(const std::string& where, const YamlNode& node,
                                  const std::function<void()>& read_item) {
  const std::size_t before = mistakes_.count();
  nodes_[where] = &node;
  scenario_.marks[where] = node.mark;
  read_item();
  if (mistakes_.count() != before) flawed_.insert(where);
}

}  // namespace unlatch::hil
