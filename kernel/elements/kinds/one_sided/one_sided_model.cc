#include <algorithm>
#include <cmath>

#include "kernel/elements/kinds/one_sided/one_sided.h"
#include "kernel/model/from_eigen.h"
#include "unlatch/elementary.h"
#include "unlatch/motion.h"
#include "unlatch/readings.h"

namespace unlatch {
namespace {

void check_table(const Check& check, const OneSided& f) {
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

void check_law(const Check& check, const OneSided& f) {
  check.check_not_negative("stroke", f.stroke);
  if (f.kind == OneSided::Kind::kPusher && f.stroke == 0)
    check.report("its stroke is 0", "the length over which it pushes", "stroke");
  check.check_not_negative("preload", f.preload);
  check.check_not_negative("stiffness", f.stiffness);
  if (f.kind == OneSided::Kind::kStop && f.stiffness == 0)
    check.report("its stiffness is 0, so that it stops nothing", "greater than 0, and finite", "stiffness");
  if (f.kind == OneSided::Kind::kCord && f.stiffness == 0)
    check.report("its stiffness is 0, so that its force does not show where it is taut",
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
bool check_drum(const Check& check, const OneSided& f) {
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
void check_wound_end(const Check& check, const OneSided& f) {
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
void check_travel(const Check& check, const OneSided& f) {
  if (f.kind != OneSided::Kind::kStop || !is_index(f.joint, check.model.joints.size()) || !is_index(f.axis, kRows))
    return;
  const Joint& joint = check.model.joints[static_cast<std::size_t>(f.joint)];
  const auto holds = [&](const JointMode& mode) { return has_row(mode.rows, f.axis); };
  if (!joint.modes.empty() && std::all_of(joint.modes.begin(), joint.modes.end(), holds))
    check.report("every mode of joint '" + joint.name + "' holds " + kRowNames[f.axis] + ": it never moves there",
                 "an axis along which or about which the joint moves", "axis");
}

}  // namespace

// The anchor is as far back from the end as the cord is wound, and the bearing of its tangent.
CordDrum place_drum(const Model& model, const OneSided& cord) {
  const Drum& drum = *cord.drum;
  const Eigen::Matrix3d R = get_attitude(model, cord.base);
  const Vec3 z = to_vec(drum.left ? Eigen::Vector3d(-drum.axis) : drum.axis);
  const Vec3 end =
      to_vec(R.transpose() * (place(model, cord.follower, cord.point_follower) - place(model, cord.base, drum.centre)));
  const double height = dot(z, end), r = drum.radius;
  const Vec3 out = end - height * z;
  const double rho = norm(out), straight = std::sqrt(std::max(0.0, (rho - r) * (rho + r)));
  double wound = drum.wound.value_or(0);
  if (!drum.wound && cord.limit)
    wound = (std::sqrt(std::max(0.0, *cord.limit * *cord.limit - height * height)) - straight) / r;
  const double bearing = elementary::atan2(straight, r) + std::max(0.0, wound);
  const Vec3 e = (1.0 / rho) * out, across = cross(z, e);
  double sine = 0, cosine = 1;
  elementary::sincos(bearing, sine, cosine);
  return {to_vec(drum.centre), {cosine * e - sine * across, sine * e + cosine * across, z}, r, bearing};
}

double calc_start(const Model& model, const Joint& joint, int row) {
  const Eigen::Matrix3d base = get_attitude(model, joint.base);
  if (row >= kRotX) {
    const RotationFrame frame = get_rotation_frame(model, joint);
    return calc_twist(to_mat(base * frame.base), to_mat(get_attitude(model, joint.follower) * frame.follower),
                      row - kRotX);
  }
  const Eigen::Vector3d line =
      place(model, joint.follower, joint.point_follower) - place(model, joint.base, joint.point_base);
  return (base * joint.axes).col(row).dot(line);
}

double calc_start(const Model& model, const OneSided& force) {
  if (force.drum) {
    const CordDrum drum = place_drum(model, force);
    const Eigen::Vector3d origin = place(model, force.base, Eigen::Vector3d::Zero());
    return calc_cord_path(drum, to_mat(get_attitude(model, force.base)),
                          to_vec(place(model, force.follower, force.point_follower) - origin), drum.bearing)
        .length;
  }
  if (force.joint == kNone) {
    const Eigen::Vector3d line =
        place(model, force.follower, force.point_follower) - place(model, force.base, force.point_base);
    return force.guide ? (get_attitude(model, force.base) * *force.guide).dot(line) : line.norm();
  }
  return calc_start(model, model.joints[at(force.joint)], force.axis);
}

double calc_limit(const Model& model, const OneSided& force) {
  return force.limit ? *force.limit : calc_start(model, force) + (force.pulls ? -force.stroke : force.stroke);
}

OneSidedForce calc_one_sided_force(const OneSided& force, double limit, const CordDrum* drum, double bearing,
                                   const BodyState& base, const BodyState& follower) noexcept {
  PlanOneSided own{};
  own.sign = force.pulls ? -1 : 1;
  own.limit = limit;
  own.guided = force.guide.has_value();
  if (force.guide) own.guide = to_vec(*force.guide);
  own.point_base = to_vec(force.point_base);
  own.point_follower = to_vec(force.point_follower);
  const OneSidedMotion m = calc_point_motion(own, drum, bearing, calc_body_frame(base), calc_body_frame(follower));
  return {m.direction, -own.sign * m.depth_rate, m.depth, m.depth_rate,
          own.sign * calc_one_sided_force(force, m.depth, m.depth_rate)};
}

ElementTraits OneSidedKind::describe(const Model& model, const OneSided& f) {
  const char* const kinds[] = {"pusher", "stop", "cord"};
  const char* const kind = kinds[static_cast<int>(f.kind)];
  ElementTraits traits{.kind = kind, .base = f.base, .follower = f.follower, .note = f.pulls ? "pulls" : "pushes"};
  if (f.joint != kNone) traits = describe_in_joint(kind, model, f.joint, f.axis);
  traits.has_stroke = true;
  traits.has_drum = f.drum.has_value();
  return traits;
}

void OneSidedKind::validate(const OneSided& f, const Check& check) {
  check_law(check, f);
  check.check_finite("limit", !f.limit || std::isfinite(*f.limit));
  const bool placeable = !f.drum || check_drum(check, f);
  if (f.joint != kNone) {
    check.check_joint_axis(f.joint, f.axis);
    return check_travel(check, f);
  }
  check.check_finite("point", f.point_base.allFinite());
  check.check_finite("follower_point", f.point_follower.allFinite());
  if (check.check_ends(f.base, f.follower) && f.drum && placeable) check_wound_end(check, f);
  if (f.guide) check.check_unit("guide", *f.guide);
}

PlanOneSided OneSidedKind::compile(const OneSided& f, ElementCompiler& compiler) {
  const Model& model = compiler.model;
  PlanDraft& plan = compiler.plan;
  PlanOneSided out{};
  out.number = static_cast<std::int32_t>(plan.one_sided.size());
  out.element = compiler.get_element();
  out.joint = f.joint;
  out.axis = f.axis;
  out.coordinate = f.joint == kNone ? kNone : compiler.find_coordinate(f.joint, f.axis);
  out.base = f.joint == kNone ? f.base : model.joints[at(f.joint)].base;
  out.follower = f.joint == kNone ? f.follower : model.joints[at(f.joint)].follower;
  out.sign = f.pulls ? -1 : 1;
  out.guided = f.guide.has_value();
  if (f.guide) out.guide = to_vec(*f.guide);
  out.point_base = to_vec(f.point_base);
  out.point_follower = to_vec(f.point_follower);
  out.limit = calc_limit(model, f);
  out.law = get_law(f);
  out.first = static_cast<std::int32_t>(plan.travels.size());
  out.count = static_cast<std::int32_t>(f.travels.size());
  plan.travels.insert(plan.travels.end(), f.travels.begin(), f.travels.end());
  plan.travel_forces.insert(plan.travel_forces.end(), f.forces.begin(), f.forces.end());
  if (f.drum) {
    out.drum = static_cast<std::int32_t>(plan.drums.size());
    plan.drums.push_back(place_drum(model, f));
  }
  out.engaged = out.sign * (out.limit - calc_start(model, f)) >= 0 ? 1 : 0;
  return out;
}

ElementStart OneSidedKind::start(const Model& model, const OneSided& f) {
  ElementStart out{.kind = describe(model, f).kind, .length = calc_start(model, f)};
  const double sign = f.pulls ? -1 : 1, depth = sign * (calc_limit(model, f) - out.length);
  if (depth < 0) return out;
  out.force = sign * calc_one_sided_force(f, depth, 0);
  out.energy = calc_one_sided_energy(f, depth);
  out.stroke = depth;
  return out;
}

}  // namespace unlatch
