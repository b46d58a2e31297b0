// Joints: their bodies, their frames, and the rows that each mode holds.
#include "hil/scenario/sections/scenario_reader.h"

namespace unlatch::hil {

const std::vector<std::string>& axis_names() {
  static const std::vector<std::string> names{"x", "y", "z"};
  return names;
}

const std::vector<std::string>& row_names() {
  static const std::vector<std::string> names(kRowNames, kRowNames + kRows);
  return names;
}

void ScenarioReader::read_joints(YamlMap& top) {
  for_each_named(top, "joints", "joint",
                 [&](const std::string& name, const YamlNode& node) { read_joint(name, node); });
}

void ScenarioReader::read_joint(const std::string& name, const YamlNode& node) {
  Joint joint;
  joint.name = name;
  YamlMap map(node, "joint '" + name + "'", mistakes_);
  read_between(map, joint.base, joint.follower);
  joint.point_base = map.vector("point", "m", Eigen::Vector3d::Zero());
  joint.point_follower = map.vector("follower_point", "m", Eigen::Vector3d::Zero());
  if (const YamlNode* axes = map.find("axes")) joint.axes = read_frame(*axes);
  if (const YamlNode* axes = map.find("rotation_axes")) joint.rotation_axes = read_frame(*axes);
  if (const YamlNode* axes = map.find("follower_axes")) joint.follower_axes = read_frame(*axes);
  joint.share = map.number("share", "", 1);
  if (map.find("share_length") != nullptr) joint.share_length = map.number("share_length", "m");
  if (const YamlNode* modes = map.require("modes")) read_modes(*modes, joint);
  std::vector<std::string> names;
  for (const JointMode& mode : joint.modes) names.push_back(mode.name);
  joint.mode = names.size() == 1 ? map.choice("mode", "mode", names, 0) : map.choice("mode", "mode", names);
  if (const YamlNode* parts = map.find("parts")) read_parting(*parts, joint, static_cast<int>(model_.joints.size()));
  map.finish();
  joints_.push_back(name);
  model_.joints.push_back(std::move(joint));
}

// Reads `between: [base, follower]`; the base may be the ground.
void ScenarioReader::read_between(YamlMap& map, int& base, int& follower) {
  base = follower = kNone;
  const YamlNode* between = map.require("between");
  if (!between) return;
  if (!between->is_sequence() || between->items.size() != 2) {
    mistakes_.add(between->mark, "not a pair of bodies", "write between: [base, follower]");
    return;
  }
  std::vector<std::string> bases{"ground"};
  bases.insert(bases.end(), bodies_.begin(), bodies_.end());
  base = read_choice(between->items[0], "body", bases, mistakes_) - 1;
  if (between->items[1].is_scalar() && between->items[1].text == "ground")
    mistakes_.add(between->items[1].mark, "the ground cannot follow", "swap them: between: [ground, body]");
  else
    follower = read_choice(between->items[1], "body", bodies_, mistakes_);
}

void ScenarioReader::read_modes(const YamlNode& node, Joint& joint) {
  YamlMap map(node, "modes", mistakes_);
  for (std::size_t i = 0; i < node.keys.size(); ++i) {
    const YamlKey& key = node.keys[i];
    if (node.find(key.text) != &node.items[i]) continue;  // duplicate: finish() reports it
    map.find(key.text);
    if (!is_name(key.text))
      mistakes_.add(key.mark, "'" + key.text + "' cannot be the name of a mode", describe_name_rule(key.text));
    YamlMap mode(node.items[i], "mode '" + key.text + "'", mistakes_);
    JointMode read{key.text, 0};
    const std::string by = mode.only_one_of({"rows", "kind"}, "its rows");
    if (by == "rows") read.rows = read_rows(*mode.find("rows"));
    if (by == "kind") read.rows = read_joint_kind(mode, joint);
    mode.finish();
    joint.modes.push_back(std::move(read));
  }
  map.finish();
}

RowSet ScenarioReader::read_rows(const YamlNode& node) {
  RowSet rows = 0;
  if (!node.is_sequence()) mistakes_.add(node.mark, "rows is not a list", "write rows: [x, y, z]; [] for none");
  for (const YamlNode& item : node.items) {
    const int row = read_choice(item, "row", row_names(), mistakes_);
    if (row < 0) continue;
    if (has_row(rows, row)) mistakes_.add(item.mark, "the row '" + item.text + "' twice", "name each row once");
    rows = static_cast<RowSet>(rows | row_bit(row));
  }
  return rows;
}

// Rows of the common joints, by name. `axis`: axis of rotation or sliding, or the normal of a plane.
RowSet ScenarioReader::read_joint_kind(YamlMap& mode, Joint& joint) {
  static const std::vector<std::string> kKinds{"free",        "ball",   "weld",      "revolute",       "prismatic",
                                               "cylindrical", "planar", "universal", "revolute_slider"};
  constexpr RowSet kAll = kPointRows | kRotationRows;
  const int choice = mode.choice("kind", "joint kind", kKinds);
  if (choice < 0) return 0;
  const std::string& kind = kKinds[static_cast<std::size_t>(choice)];
  if (kind == "free") return 0;
  if (kind == "ball") return kPointRows;
  if (kind == "weld") return kAll;
  if (kind == "universal") {
    joint.universal = true;
    return kPointRows | row_bit(kRotZ);
  }
  const int axis = mode.choice("axis", "axis", axis_names());
  if (axis < 0) return 0;
  const auto without = [](int rows, int row) { return static_cast<RowSet>(rows & ~row_bit(row)); };
  if (kind == "revolute") return without(kAll, kRotX + axis);
  if (kind == "prismatic") return without(kAll, axis);
  if (kind == "cylindrical") return without(without(kAll, axis), kRotX + axis);
  if (kind == "planar") return static_cast<RowSet>(without(kRotationRows, kRotX + axis) | row_bit(axis));
  const int slide = mode.choice("slide", "axis", axis_names());
  return slide < 0 ? RowSet{0} : without(without(kAll, kRotX + axis), slide);
}

}  // namespace unlatch::hil
