// Checks of a model's numbers and indices, each mistake with its place and its remedy. For validate() and for the kinds
// of elements (kernel/elements/kinds).
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <string>
#include <vector>

#include "kernel/math/number_text.h"
#include "unlatch/model.h"

namespace unlatch {

using ModelErrors = std::vector<ModelError>;

inline bool is_index(int index, std::size_t size) { return index >= 0 && static_cast<std::size_t>(index) < size; }

inline std::string quoted(const std::string& kind, const std::string& name) { return kind + " '" + name + "'"; }

inline std::string show(const Eigen::Vector3d& v) {
  return "[" + show(v.x()) + ", " + show(v.y()) + ", " + show(v.z()) + "]";
}

// Collects the mistakes of one part of a model, for example of one element. `where` names the part, as "element 'x'".
struct Check {
  const Model& model;
  std::string where;
  ModelErrors& errors;

  void report(const std::string& what, const std::string& mend, const std::string& key) const {
    errors.push_back({where, what, mend, key});
  }
  void check_finite(const std::string& key, bool finite) const {
    if (!finite) report(key + " is not finite", "give a finite value", key);
  }
  void check_not_negative(const std::string& key, double value) const {
    if (!(value >= 0) || !std::isfinite(value)) report(key + " is " + show(value), "0 or more, and finite", key);
  }
  void check_positive(const std::string& key, double value) const {
    if (!(value > 0) || !std::isfinite(value)) report(key + " is " + show(value), "greater than 0, and finite", key);
  }
  void check_unit(const std::string& key, const Eigen::Vector3d& axis) const {
    constexpr double kRounding = 1e-9;  // of what was typed
    if (!(std::abs(axis.norm() - 1) < kRounding))
      report(key + " has the length " + show(axis.norm()), "a vector that is not zero", key);
  }
  // The body exists, and is no flexible one: loads and ends of elements are on its markers. False if it does not exist.
  bool check_body(int body, const std::string& key) const {
    if (!is_index(body, model.bodies.size())) {
      report("it acts on no body", "a body's index", key);
      return false;
    }
    const Body& named = model.bodies[static_cast<std::size_t>(body)];
    if (named.flexible)
      report("it acts on the flexible body '" + named.name + "' itself", "name one of its markers", key);
    return true;
  }
  // Two different bodies, of which the base may be the ground. False if one does not exist.
  bool check_ends(int base, int follower) const {
    const bool held = base == kGround || check_body(base, "between"), ends = check_body(follower, "between");
    if (ends && base == follower) report("it connects a body with itself", "name two bodies", "between");
    return held && ends;
  }
  // The joint and the axis exist.
  bool check_joint_axis(int joint, int axis) const {
    const bool has_joint = is_index(joint, model.joints.size()), has_axis = is_index(axis, kRows);
    if (!has_joint) report("it is on no joint", "a joint's index", "joint");
    if (!has_axis) report("it has no axis", "x … rot_z", "axis");
    return has_joint && has_axis;
  }
  void check_channel(int channel) const {
    if (channel != kNone && !is_index(channel, model.channels.size()))
      report("its channel does not exist", "a channel's index, or kNone", "channel");
  }
};

}  // namespace unlatch
