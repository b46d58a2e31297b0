// Watched pairs of bodies, groups and shapes.
#include <algorithm>

#include "hil/scenario/sections/scenario_reader.h"
#include "hil/scenario/text/count.h"
#include "hil/scenario/text/suggestion.h"

namespace unlatch::hil {
namespace {

bool is_same_pair(const ClearancePair& x, const ClearancePair& y) {
  return (x.a.name == y.a.name && x.b.name == y.b.name) || (x.a.name == y.b.name && x.b.name == y.a.name);
}

// Returns true if the kernel or a mesh gives a distance; meshes have one from every shape.
bool has_distance(const BodyShape& a, const BodyShape& b) {
  return a.mesh || b.mesh || geometry::has_distance(a.shape.kind, b.shape.kind);
}

bool has(const ShapeSet& set, int shape) { return std::binary_search(set.shapes.begin(), set.shapes.end(), shape); }

// Excepts shapes from a pair that are in both sets. False: there are none.
bool leave_out(ClearancePair& pair, const ShapeSet& a, const ShapeSet& b) {
  bool found = false;
  const auto add = [&](const ShapeSet& first, const ShapeSet& second) {
    if (first.body != pair.a.body || second.body != pair.b.body) return;
    for (const int i : first.shapes)
      for (const int k : second.shapes)
        if (has(pair.a, i) && has(pair.b, k)) {
          found = true;
          if (!pair.is_excepted(i, k)) pair.except.emplace_back(i, k);
        }
  };
  add(a, b);
  add(b, a);
  return found;
}

}  // namespace

std::string ScenarioReader::get_body_name(int body) const {
  return body == kGround ? kGroundName : bodies_[static_cast<std::size_t>(body)];
}

ShapeSet ScenarioReader::get_shapes_of(int body) const {
  ShapeSet set{.body = body, .name = get_body_name(body), .shapes = {}};
  for (std::size_t i = 0; i < get_shapes(scenario_, body).size(); ++i) set.shapes.push_back(static_cast<int>(i));
  return set;
}

// Reads "core", "core.skirt".
std::optional<ShapeSet> ScenarioReader::read_shape_set(const YamlNode& node) {
  if (!node.is_scalar()) {
    mistakes_.add(node.mark, "not a body or a shape", "write core, or core.skirt: a body, or its shape or group");
    return {};
  }
  const std::size_t dot = node.text.find('.');
  YamlNode body_node = node;
  body_node.text = node.text.substr(0, dot);
  const bool of_ground = body_node.text == kGroundName;
  const int body = of_ground ? kGround : read_choice(body_node, "body", bodies_, mistakes_);
  if (body < 0 && !of_ground) return {};
  ShapeSet set = get_shapes_of(body);
  if (set.shapes.empty()) {
    if (of_ground)
      mistakes_.add(node.mark, "the ground has no shape", "write `ground: {shape: [{name: floor, box: …}]}`");
    else
      mistakes_.add(node.mark, "body '" + get_body_name(body) + "' has no shape",
                    "give it one; a clearance is between shapes");
    return {};
  }
  if (dot == std::string::npos) return set;
  const std::string part = node.text.substr(dot + 1);
  std::vector<std::string> known;
  set.name = node.text;
  set.shapes.clear();
  const std::vector<BodyShape>& shapes = get_shapes(scenario_, body);
  for (std::size_t i = 0; i < shapes.size(); ++i) {
    for (const std::string& name : {shapes[i].name, shapes[i].group})
      if (!name.empty() && std::find(known.begin(), known.end(), name) == known.end()) known.push_back(name);
    if (!part.empty() && (shapes[i].name == part || shapes[i].group == part)) set.shapes.push_back(static_cast<int>(i));
  }
  if (!set.shapes.empty()) return set;
  mistakes_.add(node.mark,
                "unknown shape '" + part + "' of " + (of_ground ? "the ground" : "body '" + get_body_name(body) + "'"),
                known.empty() ? "its shapes have no `name` and no `group`" : suggest(part, known));
  return {};
}

std::optional<ClearancePair> ScenarioReader::read_two_sets(const YamlNode& node) {
  if (!node.is_sequence() || node.items.size() != 2) {
    mistakes_.add(node.mark, "not a pair of bodies", "write [core, booster1], or [core.skirt, booster1.nozzle]");
    return {};
  }
  const std::optional<ShapeSet> a = read_shape_set(node.items[0]), b = read_shape_set(node.items[1]);
  if (!a || !b) return {};
  if (a->body == b->body) {
    mistakes_.add(node.mark, "a body and itself", "name two bodies, or shapes of two bodies");
    return {};
  }
  return ClearancePair{.a = *a, .b = *b, .except = {}};
}

std::optional<ClearancePair> ScenarioReader::read_shape_pair(const YamlNode& node) {
  std::optional<ClearancePair> pair = read_two_sets(node);
  if (!pair || count_distances(*pair) > 0) return pair;
  mistakes_.add(node.mark, "no distance is defined between " + pair->a.name + " and " + pair->b.name,
                "two hollow shapes and two half-spaces have none: make one of the two hollow ones solid, as a "
                "cylinder or a frustum, or leave the pair out");
  return {};
}

// Number of pairs of shapes that have a distance and are not excepted.
std::size_t ScenarioReader::count_distances(const ClearancePair& pair) const {
  const auto get_shape = [&](int body, int shape) -> const BodyShape& {
    return get_shapes(scenario_, body)[static_cast<std::size_t>(shape)];
  };
  std::size_t count = 0;
  for (const int i : pair.a.shapes)
    for (const int k : pair.b.shapes)
      if (!pair.is_excepted(i, k) && has_distance(get_shape(pair.a.body, i), get_shape(pair.b.body, k))) ++count;
  return count;
}

void ScenarioReader::report_undefined(const ClearancePair& pair) {
  const std::size_t all = pair.a.shapes.size() * pair.b.shapes.size() - pair.except.size();
  const std::size_t count = all - count_distances(pair);
  if (count == 0) return;
  scenario_.remarks.push_back({"clearance",
                               pair.a.name + " – " + pair.b.name + ": " + std::to_string(count) + " of " +
                                   hil::count(all, "pair") + " of shapes " + (count == 1 ? "does" : "do") +
                                   " not count: two hollow shapes and two half-spaces have no distance; make one of "
                                   "the hollow ones solid, or leave the pair out with `except`",
                               "clearance"});
}

// Adds a pair, or returns the same pair if it was named before with the same exceptions.
int ScenarioReader::watch(const ClearancePair& pair) {
  std::vector<ClearancePair>& pairs = scenario_.clearance;
  const auto found = std::find_if(pairs.begin(), pairs.end(), [&](const auto& p) { return is_same_pair(p, pair); });
  if (found != pairs.end()) return static_cast<int>(found - pairs.begin());
  pairs.push_back(pair);
  report_undefined(pair);
  return static_cast<int>(pairs.size()) - 1;
}

// Lists pairs of bodies with shapes; reports those without a distance.
std::vector<ClearancePair> ScenarioReader::list_all_pairs() {
  std::vector<ClearancePair> pairs;
  const int count = static_cast<int>(bodies_.size());
  const auto has_shape = [&](int body) { return !get_shapes(scenario_, body).empty(); };
  for (int a = 0; a < count; ++a)
    for (int k = a + 1; k <= count; ++k) {
      const int b = k < count ? k : kGround;  // the ground is the last
      if (!has_shape(a) || !has_shape(b)) continue;
      const ClearancePair pair{.a = get_shapes_of(a), .b = get_shapes_of(b), .except = {}};
      if (count_distances(pair) > 0)
        pairs.push_back(pair);
      else
        report_undefined(pair);
    }
  return pairs;
}

// Reads `{between: [core, booster1], except: [[core.socket, booster1.nose]]}`; between may be `all`.
std::vector<ClearancePair> ScenarioReader::read_watched_pairs(const YamlNode& node) {
  std::vector<ClearancePair> pairs;
  const auto read_between = [&](const YamlNode& between) {
    if (between.is_scalar() && between.text == "all")
      pairs = list_all_pairs();
    else if (const std::optional<ClearancePair> pair = read_shape_pair(between))
      pairs.push_back(*pair);
  };
  if (!node.is_mapping()) {
    read_between(node);
    return pairs;
  }
  YamlMap map(node, "a watched pair", mistakes_);
  if (const YamlNode* between = map.require("between")) read_between(*between);
  if (const YamlNode* except = map.find("except")) read_exceptions(*except, pairs);
  map.finish();
  return pairs;
}

// Reads the pairs of shapes or groups that `pairs` leave out.
void ScenarioReader::read_exceptions(const YamlNode& node, std::vector<ClearancePair>& pairs) {
  if (!node.is_sequence())
    mistakes_.add(node.mark, "except is not a list of pairs", "write [[core.socket, booster1.nose]]");
  for (const YamlNode& item : node.items) {
    const std::optional<ClearancePair> out = read_two_sets(item);
    if (!out || pairs.empty()) continue;
    bool found = false;
    for (ClearancePair& pair : pairs)
      if (leave_out(pair, out->a, out->b)) found = true;
    if (!found) mistakes_.add(item.mark, "no watched pair has these shapes", "name shapes of the bodies in `between`");
  }
  for (const ClearancePair& pair : pairs)
    if (count_distances(pair) == 0)
      mistakes_.add(node.mark, "nothing is left of " + pair.a.name + " – " + pair.b.name,
                    "leave out single shapes, by their names, and not all");
}

void ScenarioReader::read_clearance(YamlMap& top) {
  const YamlNode* node = top.find("clearance");
  if (!node) return;
  scenario_.marks["clearance"] = node->mark;
  if (node->is_scalar() && node->text == "all") {
    for (const ClearancePair& pair : list_all_pairs()) watch(pair);
    return;
  }
  if (!node->is_sequence()) mistakes_.add(node->mark, "not a list of pairs", "write [[core, booster1], …], or all");
  for (const YamlNode& item : node->items) {
    if (item.is_scalar() && item.text == "all") {
      mistakes_.add(item.mark, "not a pair of bodies", "write clearance: all, or {between: all, except: […]}");
      continue;
    }
    for (const ClearancePair& pair : read_watched_pairs(item)) {
      const std::size_t count = scenario_.clearance.size();
      const auto at = static_cast<std::size_t>(watch(pair));
      if (at < count && scenario_.clearance[at].except != pair.except)
        mistakes_.add(item.mark, pair.a.name + " – " + pair.b.name + " is watched twice, with different exceptions",
                      "watch it once, or name a group of its shapes");
    }
  }
}

}  // namespace unlatch::hil
