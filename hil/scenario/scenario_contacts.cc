// Contacts: pairs of shapes that push each other, and the model's surfaces that contacts, conditions and sensors name.
#include <algorithm>

#include "hil/scenario/scenario_reader.h"

namespace unlatch::hil {

// Reads a pair of shapes for which the step computes distances.
std::optional<ClearancePair> ScenarioReader::read_surface_pair(const YamlNode& node) {
  std::optional<ClearancePair> pair = read_shape_pair(node);
  if (!pair) return pair;
  for (const ShapeSet* set : {&pair->a, &pair->b})
    for (const int shape : set->shapes) {
      const BodyShape& own = scenario_.shapes[static_cast<std::size_t>(set->body)][static_cast<std::size_t>(shape)];
      if (!own.mesh) continue;
      mistakes_.add(
          node.mark,
          set->name + " has a mesh, " + own.mesh->get_place().file +
              ": contacts, conditions and sensors are between other shapes",
          "name a shape or a group without meshes, as core.skirt; meshes are for clearances and requirements");
      return {};
    }
  return pair;
}

// Number of the model's surface of these shapes; all users of the same set share one surface.
int ScenarioReader::find_surface(const ShapeSet& set) {
  std::vector<Surface>& surfaces = model_.surfaces;
  const auto found =
      std::find_if(surfaces.begin(), surfaces.end(), [&](const Surface& known) { return known.name == set.name; });
  if (found != surfaces.end()) return static_cast<int>(found - surfaces.begin());
  Surface surface{set.name, set.body, {}};
  for (const int shape : set.shapes)
    surface.shapes.push_back(
        scenario_.shapes[static_cast<std::size_t>(set.body)][static_cast<std::size_t>(shape)].shape);
  surfaces.push_back(std::move(surface));
  return static_cast<int>(surfaces.size()) - 1;
}

void ScenarioReader::read_contacts(YamlMap& top) {
  for_each_named(top, "contacts", "contact",
                 [&](const std::string& name, const YamlNode& node) { read_contact(name, node); });
  for (const Contact& contact : model_.contacts) elements_.push_back(contact.name);
}

void ScenarioReader::read_contact(const std::string& name, const YamlNode& node) {
  YamlMap map(node, "contact '" + name + "'", mistakes_);
  Contact contact;
  contact.name = name;
  const YamlNode* const between = map.require("between");
  const std::optional<ClearancePair> pair = between ? read_surface_pair(*between) : std::nullopt;
  const YamlNode* const except = map.find("except");
  if (pair) {
    std::vector<ClearancePair> pairs{*pair};
    if (except) read_exceptions(*except, pairs);
    const auto find_place = [](const ShapeSet& set, int shape) {
      return static_cast<int>(std::find(set.shapes.begin(), set.shapes.end(), shape) - set.shapes.begin());
    };
    for (const auto& [a, b] : pairs[0].except)
      contact.except.emplace_back(find_place(pair->a, a), find_place(pair->b, b));
    contact.base = find_surface(pair->a);
    contact.follower = find_surface(pair->b);
  }
  const std::string law = map.only_one_of({"stiffness", "hertz_stiffness"}, "a stiffness");
  if (law == "stiffness") contact.stiffness = map.number(law, "N/m");
  if (law == "hertz_stiffness") {
    contact.stiffness = map.number(law, "");
    contact.exponent = 1.5;
  }
  contact.damping = map.number("damping", "s/m", 0.0);
  if (const YamlNode* restitution = map.find("restitution")) {
    YamlMap inner(*restitution, "restitution", mistakes_);
    contact.restitution = inner.number("coefficient", "");
    contact.speed = inner.number("speed", "m/s");
    inner.finish();
  }
  contact.friction = map.number("friction", "", 0.0);
  contact.slip_speed = map.number("slip_speed", "m/s", contact.slip_speed);
  contact.on = map.boolean("enabled", true);
  map.finish();
  model_.contacts.push_back(std::move(contact));
}

// Adds touch and lift of each contact as ordinary events, after those of the scenario.
void ScenarioReader::add_touches() {
  const std::size_t first = model_.events.size();
  add_contact_events(model_);
  for (std::size_t e = first; e < model_.events.size(); ++e)
    event_names_.emplace_back(model_.events[e].name + ":" + model_.events[e].subject, static_cast<int>(e));
}

}  // namespace unlatch::hil
