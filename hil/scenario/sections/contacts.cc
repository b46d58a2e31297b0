// Contacts: pairs of shapes that push each other, and the model's surfaces that contacts, conditions and sensors name.
#include <algorithm>

#include "hil/scenario/sections/scenario_reader.h"

namespace unlatch::hil {

// Reads a pair of shapes for which the step computes distances.
std::optional<ClearancePair> ScenarioReader::read_surface_pair(const YamlNode& node) {
  std::optional<ClearancePair> pair = read_shape_pair(node);
  if (!pair) return pair;
  for (const ShapeSet* set : {&pair->a, &pair->b})
    for (const int shape : set->shapes) {
      const BodyShape& own = get_shapes(scenario_, set->body)[static_cast<std::size_t>(shape)];
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
    surface.shapes.push_back(get_shapes(scenario_, set.body)[static_cast<std::size_t>(shape)].shape);
  surfaces.push_back(std::move(surface));
  return static_cast<int>(surfaces.size()) - 1;
}

void ScenarioReader::read_contacts(YamlMap& top) {
  for_each_named(top, "contacts", "contact",
                 [&](const std::string& name, const YamlNode& node) { read_contact(name, node); });
}

void ScenarioReader::read_contact(const std::string& name, const YamlNode& node) {
  YamlMap map(node, "contact '" + name + "'", mistakes_);
  Contact contact;
  contact.name = name;
  const YamlNode* const between = map.require("between");
  const std::optional<ClearancePair> pair = between ? read_surface_pair(*between) : std::nullopt;
  const YamlNode* const except = map.find("except");
  std::vector<ClearancePair> pairs;
  if (pair) {
    pairs = {*pair};
    if (except) read_exceptions(*except, pairs);
    const auto find_place = [](const ShapeSet& set, int shape) {
      return static_cast<int>(std::find(set.shapes.begin(), set.shapes.end(), shape) - set.shapes.begin());
    };
    for (const auto& [a, b] : pairs[0].except)
      contact.except.emplace_back(find_place(pair->a, a), find_place(pair->b, b));
    contact.base = find_surface(pair->a);
    contact.follower = find_surface(pair->b);
    if (is_of_lines(pairs[0]))
      mistakes_.add(between->mark, "two lines: capsules of the radius 0 never overlap, and do not touch",
                    "give one of them a radius, 1 mm say");
  }
  const std::string law = map.only_one_of({"stiffness", "hertz_stiffness", "rigid"}, "a stiffness, or `rigid: true`");
  if (law == "stiffness") contact.stiffness = map.number(law, "N/m");
  if (law == "hertz_stiffness") {
    contact.stiffness = map.number(law, "");
    contact.exponent = 1.5;
  }
  if (law == "rigid" && !(contact.rigid = map.boolean(law, true)))
    mistakes_.add(node.mark, "contact '" + name + "' has `rigid: false` and no stiffness", "`stiffness` instead");
  contact.damping = map.number("damping", "s/m", 0.0);
  read_restitution(map, contact);
  contact.friction = map.number("friction", "", 0.0);
  if (const YamlNode* slip = map.find("slip_speed"); slip && contact.rigid)
    mistakes_.add(slip->mark, "a rigid contact has no `slip_speed`: it sticks", "leave it out");
  contact.slip_speed = map.number("slip_speed", "m/s", contact.slip_speed);
  contact.on = map.boolean("enabled", true);
  map.finish();
  if (pair && contact.on) {
    report_shared_pairs(pairs[0], *between);
    pushing_.emplace_back(name, pairs[0]);
  }
  model_.contacts.push_back(std::move(contact));
}

// Of a rigid contact a number, of any other the ratio for a blow of one speed.
void ScenarioReader::read_restitution(YamlMap& map, Contact& contact) {
  const YamlNode* const settle = map.find("settle");
  if (settle && contact.rigid) contact.settle = map.number("settle", "s");
  if (settle && !contact.rigid)
    mistakes_.add(settle->mark, "a contact with a stiffness has no `settle`",
                  "leave it out: its bounces end by its law");
  const YamlNode* const restitution = map.find("restitution");
  if (restitution == nullptr) return;
  if (contact.rigid && restitution->is_mapping())
    return mistakes_.add(restitution->mark, "the restitution of a rigid contact is one number, for every speed",
                         "`restitution: 0.5`");
  if (contact.rigid) {
    contact.restitution = map.number("restitution", "");
    return;
  }
  if (!restitution->is_mapping())
    return mistakes_.add(restitution->mark, "the restitution of a contact with a stiffness is that of one speed",
                         "`restitution: {coefficient: 0.5, speed: 1 m/s}`");
  YamlMap inner(*restitution, "restitution", mistakes_);
  contact.restitution = inner.number("coefficient", "");
  contact.speed = inner.number("speed", "m/s");
  inner.finish();
  if (const YamlNode* damping = map.find("damping"))
    mistakes_.add(damping->mark, "a contact with a damping and a restitution",
                  "one of them: each follows from the other");
}

// True if no pair of shapes has any thickness, so that none can overlap.
bool ScenarioReader::is_of_lines(const ClearancePair& pair) const {
  const auto is_line = [&](int body, int shape) {
    const geometry::Shape& own = get_shapes(scenario_, body)[static_cast<std::size_t>(shape)].shape;
    return own.kind == geometry::ShapeKind::kCapsule && own.radius == 0;
  };
  for (const int i : pair.a.shapes)
    for (const int k : pair.b.shapes)
      if (!pair.is_excepted(i, k) && !(is_line(pair.a.body, i) && is_line(pair.b.body, k))) return false;
  return true;
}

// Reports a pair of shapes on which a contact before this one acts as well: both would push.
void ScenarioReader::report_shared_pairs(const ClearancePair& pair, const YamlNode& node) {
  const auto get_name = [&](int body, int shape) {
    const BodyShape& own = get_shapes(scenario_, body)[static_cast<std::size_t>(shape)];
    return get_body_name(body) + "." + (own.name.empty() ? "shape[" + std::to_string(shape) + "]" : own.name);
  };
  const auto has = [](const ClearancePair& of, int a, int i, int b, int k) {
    const auto holds = [](const ShapeSet& set, int body, int shape) {
      return set.body == body && std::ranges::find(set.shapes, shape) != set.shapes.end();
    };
    return holds(of.a, a, i) && holds(of.b, b, k) && !of.is_excepted(i, k);
  };
  for (const auto& [name, other] : pushing_)
    for (const int i : pair.a.shapes)
      for (const int k : pair.b.shapes) {
        const int a = pair.a.body, b = pair.b.body;
        if (pair.is_excepted(i, k) || !(has(other, a, i, b, k) || has(other, b, k, a, i))) continue;
        return mistakes_.add(
            node.mark, "contact '" + name + "' acts between " + get_name(a, i) + " and " + get_name(b, k) + " too",
            "leave the pair out of one of the two with `except`; `enabled: false` if one follows the other");
      }
}

// Adds touch and lift of each contact as ordinary events, after those of the scenario.
void ScenarioReader::add_touches() {
  const std::size_t first = model_.events.size();
  add_contact_events(model_);
  for (std::size_t e = first; e < model_.events.size(); ++e)
    event_names_.emplace_back(model_.events[e].name + ":" + model_.events[e].subject, static_cast<int>(e));
}

}  // namespace unlatch::hil
