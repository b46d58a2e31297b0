// Pushers, stops, cords, friction in joints, and impulses.
#include <algorithm>
#include <cmath>

#include "kernel/model/from_eigen.h"
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
    return check.report("its table has travels (" + std::to_string(f.travels.size()) + ") and forces (" +
                            std::to_string(f.forces.size()) + ")",
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
  if (f.kind == OneSided::Kind::kStop && f.stiffness == 0)
    check.report("its stiffness is 0, so that it stops nothing", "greater than 0, and finite", "stiffness");
  if (f.kind == OneSided::Kind::kCord && f.stiffness == 0)
    check.report("its stiffness is 0, so that nothing tells where it is taut",
                 "greater than 0: a cord that is to do nothing may have 1e-6 N/m", "stiffness");
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

// Checks of a cord's drum alone; true if the cord's end can be placed on it.
bool check_drum(Check& check, const OneSided& f) {
  const Drum& drum = *f.drum;
  const std::size_t before = check.errors.size();
  if (f.kind != OneSided::Kind::kCord || !f.pulls || f.joint != kNone || f.guide)
    check.report("it is wound on a drum, and is no cord between two points", "a cord that pulls, without a guide",
                 "wraps");
  check.check_positive("radius", drum.radius);
  check.check_finite("centre", drum.centre.allFinite());
  if (!(std::abs(drum.axis.norm() - 1) < 1e-9))
    check.report("its drum's axis has the length " + show(drum.axis.norm()), "a vector that is not zero", "axis");
  if (drum.wound) check.check_not_negative("wound", *drum.wound);
  if (!drum.wound && !f.limit)
    check.report("neither its length nor the angle that it is wound is given", "give `wound`, or `length`, or both",
                 "wraps");
  return check.errors.size() == before;
}

// Its end is outside the drum, and its length reaches from the drum to there.
void check_wound_end(Check& check, const OneSided& f) {
  constexpr double kRounding = 1e-9;  // of the radius: an end that lies on the drum
  const Model placed = place_markers(check.model);
  const Eigen::Vector3d end = place(placed, f.follower, f.point_follower) - place(placed, f.base, f.drum->centre);
  const Eigen::Vector3d axis = get_attitude(placed, f.base) * f.drum->axis;
  const double height = end.dot(axis), rho = (end - height * axis).norm(), radius = f.drum->radius;
  if (rho < radius * (1 - kRounding))
    return check.report(
        "its end is inside its drum, " + show(rho) + " m from an axis with the radius " + show(radius) + " m",
        "an end on the drum or outside", "wraps");
  const double tangent = std::sqrt(std::max(0.0, rho * rho - radius * radius)), needed = std::hypot(tangent, height);
  if (!f.drum->wound && *f.limit < needed * (1 - kRounding))
    check.report("its length is " + show(*f.limit) + " m, and its end is " + show(needed) + " m from the drum",
                 "a longer cord, or the angle that it is `wound`, which stretches it", "length");
}

// A stop's joint moves along its axis in one of its modes.
void check_travel(Check& check, const OneSided& f) {
  if (f.kind != OneSided::Kind::kStop || !is_index(f.joint, check.model.joints.size()) || !is_index(f.axis, kRows))
    return;
  const Joint& joint = check.model.joints[static_cast<std::size_t>(f.joint)];
  const auto holds = [&](const JointMode& mode) { return has_row(mode.rows, f.axis); };
  if (!joint.modes.empty() && std::all_of(joint.modes.begin(), joint.modes.end(), holds))
    check.report("every mode of joint '" + joint.name + "' holds " + kRowNames[f.axis] + ": it never moves there",
                 "an axis along which or about which the joint moves", "axis");
}

void check_one_sided(const Model& model, const OneSided& f, ModelErrors& errors) {
  Check check{model, quoted("element", f.name), errors};
  check_law(check, f);
  check.check_finite("limit", !f.limit || std::isfinite(*f.limit));
  const bool placeable = !f.drum || check_drum(check, f);
  if (f.joint != kNone) {
    if (!is_index(f.joint, model.joints.size())) check.report("it is on no joint", "a joint's index", "joint");
    if (!is_index(f.axis, kRows)) check.report("it has no axis", "x … rot_z", "axis");
    return check_travel(check, f);
  }
  check.check_finite("point", f.point_base.allFinite());
  check.check_finite("follower_point", f.point_follower.allFinite());
  const bool held = f.base == kGround || check.check_body(f.base, "between");
  const bool ends = check.check_body(f.follower, "between");
  if (ends && f.base == f.follower) check.report("it connects a body with itself", "name two bodies", "between");
  if (f.drum && placeable && held && ends) check_wound_end(check, f);
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
