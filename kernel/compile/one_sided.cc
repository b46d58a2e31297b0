#include "kernel/compile/one_sided.h"

#include <algorithm>
#include <cmath>

#include "kernel/model/from_eigen.h"
#include "unlatch/cords.h"
#include "unlatch/elementary.h"
#include "unlatch/motion.h"
#include "unlatch/readings.h"

namespace unlatch {
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

void compile_one_sided(const Model& model, const OneSided& f, std::int32_t element, std::int32_t coordinate,
                       PlanData& plan) {
  PlanOneSided out{};
  out.number = static_cast<std::int32_t>(plan.one_sided.size());
  out.element = element;
  out.joint = f.joint;
  out.axis = f.axis;
  out.coordinate = coordinate;
  out.base = f.joint == kNone ? f.base : model.joints[at(f.joint)].base;
  out.follower = f.joint == kNone ? f.follower : model.joints[at(f.joint)].follower;
  out.sign = f.pulls ? -1 : 1;
  out.guided = f.guide.has_value();
  if (f.guide) out.guide = to_vec(*f.guide);
  out.point_base = to_vec(f.point_base);
  out.point_follower = to_vec(f.point_follower);
  out.limit = calc_limit(model, f);
  out.law = get_law(f);
  out.law.travels = out.law.forces = {};
  out.first = static_cast<std::int32_t>(plan.travels.size());
  out.count = static_cast<std::int32_t>(f.travels.size());
  plan.travels.insert(plan.travels.end(), f.travels.begin(), f.travels.end());
  plan.travel_forces.insert(plan.travel_forces.end(), f.forces.begin(), f.forces.end());
  if (f.drum) {
    out.drum = static_cast<std::int32_t>(plan.drums.size());
    plan.drums.push_back(place_drum(model, f));
  }
  out.engaged = out.sign * (out.limit - calc_start(model, f)) >= 0 ? 1 : 0;
  plan.one_sided.push_back(out);
}

}  // namespace unlatch
