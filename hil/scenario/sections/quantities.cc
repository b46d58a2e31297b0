// Quantities: those that the scenario names, and those that conditions and requirements write down in their place. Keys
// follow from the kernel's table (unlatch/quantities.h).
#include "hil/scenario/quantities.h"

#include <algorithm>

#include "hil/scenario/sections/scenario_reader.h"

namespace unlatch::hil {

namespace {

// Keys of quantities, and that of an expression.
const std::vector<std::string>& list_all_keys() {
  static const std::vector<std::string> keys = [] {
    std::vector<std::string> list = list_quantity_keys();
    list.emplace_back("expression");
    return list;
  }();
  return keys;
}

}  // namespace

std::string get_si(const Model& model, const unlatch::Quantity& quantity) {
  if (quantity.kind == unlatch::Quantity::Kind::kCommand)
    return get_si(model.channels[static_cast<std::size_t>(quantity.subject)]);
  const std::string unit = get_unit(model, quantity);
  return unit == "1" ? "" : unit;
}

void ScenarioReader::read_quantities(YamlMap& top) {
  std::vector<std::pair<int, const YamlNode*>> expressions;  // once all others are known
  for_each_named(top, "quantities", "quantity", [&](const std::string& name, const YamlNode& node) {
    if (!check_name(name, node, "quantity", Minus::kAllowed)) return;
    YamlMap map(node, "quantity '" + name + "'", mistakes_);
    // `scale` is also the key of a quantity.
    const bool is_expression = map.find("expression") != nullptr;
    const std::string kind = is_expression ? "expression" : map.only_one_of(list_all_keys(), "to say what it is");
    if (is_expression)
      for (const char* const key : {"unit", "scale", "offset", "scale_channel", "offset_channel"}) map.find(key);
    map.finish();
    if (kind.empty()) return;
    unlatch::Quantity quantity;
    if (is_expression) {
      quantity.kind = unlatch::Quantity::Kind::kLaw;
      quantity.subject = add_law(name, node);
      expressions.emplace_back(quantity.subject, &node);
    } else {
      quantity = read_model_quantity(kind, *map.find(kind));
    }
    quantity.name = name;
    model_.quantities.push_back(std::move(quantity));
  });
  scenario_.named_quantities = model_.quantities.size();
  for (const auto& [law, node] : expressions) {
    const std::string where = "quantity '" + model_.laws[static_cast<std::size_t>(law)].name + "'";
    read_item_at(where, *node, [&, number = law, at = node] {
      YamlMap map(*at, where, mistakes_);
      read_expression_quantity(map, number);
    });
  }
}

// Index of the quantity that `kind` says: `quantity`, the name of one, or the key of its kind.
int ScenarioReader::read_quantity_index(const std::string& kind, const YamlNode& node) {
  if (kind == "quantity" && node.is_scalar()) {
    std::vector<std::string> names;
    for (std::size_t i = 0; i < scenario_.named_quantities; ++i) names.push_back(model_.quantities[i].name);
    return std::max(0, read_choice(node, "quantity", names, mistakes_));
  }
  std::string own = kind;
  const YamlNode* value = &node;
  if (kind == "quantity") {
    YamlMap map(node, "a quantity", mistakes_);
    own = map.only_one_of(list_all_keys(), "to say what it is");
    map.finish();
    if (own.empty()) return 0;
    value = node.find(own);
  }
  if (own == "expression") {
    unlatch::Quantity quantity;
    quantity.kind = unlatch::Quantity::Kind::kLaw;
    quantity.name = "expression#" + std::to_string(model_.laws.size() + 1);
    quantity.subject = add_law(quantity.name, *value);
    compile_law(quantity.subject, *value, std::nullopt, "");
    model_.quantities.push_back(std::move(quantity));
    return static_cast<int>(model_.quantities.size()) - 1;
  }
  const std::string name = own + "#" + std::to_string(model_.quantities.size() - scenario_.named_quantities + 1);
  read_item_at("quantity '" + name + "'", *value, [&] {
    unlatch::Quantity quantity = read_model_quantity(own, *value);
    quantity.name = name;
    model_.quantities.push_back(std::move(quantity));
  });
  return static_cast<int>(model_.quantities.size()) - 1;
}

unlatch::Quantity ScenarioReader::read_model_quantity(const std::string& kind, const YamlNode& node) {
  const QuantityTraits& traits = *find_quantity_traits(kind);
  unlatch::Quantity quantity;
  quantity.kind = traits.kind;
  if (node.is_scalar() && traits.of != SubjectOf::kSurface) {
    quantity.subject = read_quantity_subject(node, traits.of);
    if (needs_more(traits))
      mistakes_.add(node.mark, kind + " needs more than a name", "write " + kind + ": " + write_pattern(traits));
    return quantity;
  }
  YamlMap map(node, kind, mistakes_);
  if (const YamlNode* const subject = map.require(get_subject_key(traits.of))) {
    if (traits.of != SubjectOf::kSurface) {
      quantity.subject = read_quantity_subject(*subject, traits.of);
    } else if (const std::optional<ClearancePair> pair = read_surface_pair(*subject)) {
      quantity.subject = find_surface(pair->a);
      quantity.other = find_surface(pair->b);
    }
  }
  if (traits.other == SubjectOf::kBody) quantity.other = read_relative_to(map, quantity.subject, traits.has_axes);
  read_quantity_part(map, traits, quantity);
  if (traits.has_point) quantity.point = map.vector("point", "m", Eigen::Vector3d::Zero());
  if (traits.has_axes) {
    quantity.direction = read_direction(map, "axis", true);
    quantity.other_direction = read_direction(map, "other", true);
  }
  map.finish();
  return quantity;
}

int ScenarioReader::read_quantity_subject(const YamlNode& node, SubjectOf of) {
  if (of == SubjectOf::kCord) return read_wound_cord(node);
  if (of == SubjectOf::kEvent) {  // events are read later: see find_quantity_events()
    awaited_events_.emplace_back(model_.quantities.size(), &node);
    return 0;
  }
  std::vector<std::string> names;
  for (std::size_t i = 0; i < count_subjects(model_, of); ++i)
    names.push_back(get_subject_name(model_, of, static_cast<int>(i)));
  return std::max(0, read_choice(node, get_subject_key(of), names, mistakes_));
}

// Body that a motion is relative to; kGround by default.
int ScenarioReader::read_relative_to(YamlMap& map, int body, bool may_be_itself) {
  std::vector<std::string> frames = bodies_;
  frames.push_back("ground");
  const int ground = static_cast<int>(bodies_.size());
  const int frame = map.choice("relative_to", "body", frames, ground);
  if (body >= 0 && frame == body && !may_be_itself && map.find("relative_to"))
    mistakes_.add(map.node().find("relative_to")->mark, "a body relative to itself", "name another body, or ground");
  return frame == ground ? kGround : frame;
}

// A unit vector; zero if it is absent.
Eigen::Vector3d ScenarioReader::read_direction(YamlMap& map, const char* key, bool needed) {
  const Eigen::Vector3d none = Eigen::Vector3d::Zero();
  if (!needed && !map.find(key)) return none;
  const Eigen::Vector3d given = map.vector(key, "");
  if (given.norm() > 0) return given.normalized();
  if (const YamlNode* at = map.find(key); at && at->is_sequence() && at->items.size() == 3)
    mistakes_.add(at->mark, "a direction of length 0", "write a vector, [1, 0, 0]");
  return none;
}

void ScenarioReader::read_quantity_part(YamlMap& map, const QuantityTraits& traits, unlatch::Quantity& to) {
  using Values = QuantityValues;
  static const std::vector<std::string> kTurns{"rot_x", "rot_y", "rot_z", "x", "y", "z"}, kNumbers{"w", "x", "y", "z"};
  switch (traits.values) {
    case Values::kOne:
      return;
    case Values::kOfMode:
      to.part = read_mode_of(map, "is", to.subject);
      return;
    case Values::kOfPointRow:
      to.part = std::max(0, map.choice("axis", "axis", axis_names()));
      return;
    case Values::kOfTurnRow:
      to.part = kRotX + std::max(0, map.choice("axis", "axis", kTurns)) % 3;
      return;
    case Values::kOfRow:
    case Values::kRowValues:
      to.part = std::max(0, map.choice(traits.values == Values::kOfRow ? "axis" : "row", "row", row_names()));
      return;
    case Values::kVector:
      to.direction = read_direction(map, get_direction_key(traits), false);
      if (map.find("component")) {
        std::vector<std::string> names;
        for (int part = 0; part < 3; ++part) names.emplace_back(get_component_name(traits, part));
        to.part = std::max(0, map.choice("component", "component", names));
      }
      if (map.find("component") && !to.direction.isZero(0))
        mistakes_.add(map.node().find("component")->mark, "a component and a direction", "write one of them");
      return;
    case Values::kQuaternion:
      if (map.find("component")) to.part = std::max(0, map.choice("component", "component", kNumbers));
      return;
  }
}

// Events that quantities are the time since.
void ScenarioReader::find_quantity_events() {
  for (const auto& [number, node] : awaited_events_) {
    const EventName name = read_event_name(*node);
    if (name.is_named() && name.event == kNone && number < model_.quantities.size())
      for (const auto& [whole, index] : event_names_)
        if (whole == name.text && index == kNone)
          mistakes_.add(node->mark, "event '" + name.text + "' is left out", "enable it, or leave out the quantity");
    if (number < model_.quantities.size()) model_.quantities[number].subject = std::max(0, name.event);
  }
  awaited_events_.clear();
}

}  // namespace unlatch::hil
