// Pushers, stops, cords, friction in joints, and impulses.
#include <algorithm>
#include <cmath>

#include "kernel/model/validate.h"

namespace unlatch {
namespace {

struct Check {
  const Model& model;
  std::string where;
  ModelErrors& errors;

  void report(const std::string& what, const std::string& mend, const std::string& key) {
    errors.push_back({where, what, mend, key});
  }
  void check_finite(const char* key, bool finite) {
    if (!finite) report(std::string(key) + " is not finite", "give a finite value", key);
  }
  void check_not_negative(const char* key, double value) {
    if (!(value >= 0) || !std::isfinite(value))
      report(std::string(key) + " is " + show(value), "0 or more, and finite", key);
  }
  void check_positive(const char* key, double value) {
    if (!(value > 0) || !std::isfinite(value))
      report(std::string(key) + " is " + show(value), "greater than 0, and finite", key);
  }
  bool check_body(int body, const char* key) {
    if (!is_index(body, model.bodies.size())) {
      report("it acts on no body", "a body's index", key);
      return false;
    }
    const Body& named = model.bodies[static_cast<std::size_t>(body)];
    if (named.flexible)
      report("it acts on the flexible body '" + named.name + "' itself", "name one of its markers", key);
    return true;
  }
};

void check_table(Check& check, const OneSided& f) {
  if (f.travels.empty() || f.travels.size() != f.forces.size())
    return check.report("its table has " + std::to_string(f.travels.size()) + " travels and " +
                            std::to_string(f.forces.size()) + " forces",
                        "as many of each, at least one", "table");
  for (std::size_t i = 0; i < f.travels.size(); ++i) {
    if (!std::isfinite(f.travels[i]) || !(f.forces[i] >= 0) || !std::isfinite(f.forces[i]))
      return check.report("its table has the force " + show(f.forces[i]) + " at " + show(f.travels[i]),
                          "finite travels, and forces of 0 or more", "table");
    if (i > 0 && !(f.travels[i] > f.travels[i - 1]))
      return check.report("its table's travels do not increase: " + show(f.travels[i - 1]) + ", " + show(f.travels[i]),
                          "each is greater than the one before", "table");
  }
}

void check_law(Check& check, const OneSided& f) {
  check.check_not_negative("stroke", f.stroke);
  if (f.kind == OneSided::Kind::kPusher && f.stroke == 0)
    check.report("its stroke is 0", "the length over which it pushes", "stroke");
  check.check_not_negative("preload", f.preload);
  check.check_not_negative("stiffness", f.stiffness);
  check.check_not_negative("damping", f.damping);
  check.check_not_negative("friction", f.friction);
  check.check_positive("friction_speed", f.friction_speed);
  if (f.law == OneSided::Law::kTable) check_table(check, f);
  if (f.law == OneSided::Law::kGas) {
    check.check_positive("gas_length", f.gas_length);
    if (!(f.exponent >= 1) || !std::isfinite(f.exponent))
      check.report("its exponent is " + show(f.exponent), "1 (isothermal) or more", "exponent");
  }
  // what is left at the end of the stroke, but for the rounding of what was typed
  constexpr double kRounding = 1e-9;
  const double end = f.preload - f.stiffness * f.stroke;
  if (f.law == OneSided::Law::kLinear && end < -kRounding * f.preload)
    check.report("its force comes to " + show(end) + " at the end of its stroke, and 0 after " +
                     show(f.preload / f.stiffness) + " of " + show(f.stroke),
                 "a stroke that ends where the force does, or before", "stroke");
}

void check_one_sided(const Model& model, const OneSided& f, ModelErrors& errors) {
  Check check{model, quoted("element", f.name), errors};
  check_law(check, f);
  check.check_finite("limit", !f.limit || std::isfinite(*f.limit));
  if (f.joint != kNone) {
    if (!is_index(f.joint, model.joints.size())) check.report("it is on no joint", "a joint's index", "joint");
    if (!is_index(f.axis, kRows)) check.report("it has no axis", "x … rot_z", "axis");
    return;
  }
  check.check_finite("point", f.point_base.allFinite());
  check.check_finite("follower_point", f.point_follower.allFinite());
  if (f.base != kGround) check.check_body(f.base, "between");
  if (check.check_body(f.follower, "between") && f.base == f.follower)
    check.report("it connects a body with itself", "name two bodies", "between");
  if (f.guide && !(std::abs(f.guide->norm() - 1) < 1e-9))
    check.report("guide has the length " + show(f.guide->norm()), "a vector that is not zero", "guide");
}

void check_friction(const Model& model, const JointFriction& f, ModelErrors& errors) {
  Check check{model, quoted("element", f.name), errors};
  check.check_not_negative("coefficient", f.coefficient);
  check.check_positive("speed", f.speed);
  if (!is_index(f.axis, kRows)) return check.report("it has no axis", "x … rot_z", "axis");
  if (f.axis >= kRotX) check.check_positive("radius", f.radius);
  if (!is_index(f.joint, model.joints.size())) return check.report("it is on no joint", "a joint's index", "joint");
  const Joint& joint = model.joints[static_cast<std::size_t>(f.joint)];
  const bool rubs = std::any_of(joint.modes.begin(), joint.modes.end(), [&](const JointMode& mode) {
    return !has_row(mode.rows, f.axis) && (mode.rows & kPointRows) != 0;
  });
  if (!rubs)
    check.report("no mode of joint '" + joint.name + "' leaves " + kRowNames[f.axis] + " free and holds a point",
                 "an axis along which or about which the joint moves", "axis");
}

void check_impulse(const Model& model, const Impulse& impulse, std::size_t number, ModelErrors& errors) {
  Check check{model, "impulse " + std::to_string(number + 1), errors};
  check.check_body(impulse.body, "body");
  check.check_finite("point", impulse.point.allFinite());
  check.check_finite("linear", impulse.linear.allFinite());
  check.check_finite("angular", impulse.angular.allFinite());
  if (impulse.channel != kNone && !is_index(impulse.channel, model.channels.size()))
    check.report("its channel does not exist", "a channel's index, or kNone", "channel");
}

}  // namespace

void validate_one_sided(const Model& model, ModelErrors& errors) {
  for (const OneSided& force : model.one_sided) check_one_sided(model, force, errors);
  for (const JointFriction& friction : model.frictions) check_friction(model, friction, errors);
  for (std::size_t i = 0; i < model.impulses.size(); ++i) check_impulse(model, model.impulses[i], i, errors);
}

}  // namespace unlatch
