#include "kernel/dynamics/varying.h"

#include "kernel/dynamics/forces.h"
#include "kernel/plan/lane_access.h"

namespace unlatch {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

// Between two knots, or at the nearer end; `slope`: what of the difference of the two one unit of the law's variable
// is.
struct Place {
  const MassKnot *low, *high;
  double part, slope;
};

Place find_place(std::span<const MassKnot> knots, double s) {
  if (s < knots.front().at || knots.size() == 1) return {&knots.front(), &knots.front(), 0, 0};
  if (s >= knots.back().at) return {&knots.back(), &knots.back(), 0, 0};
  std::size_t low = 0, high = knots.size() - 1;
  while (high - low > 1) {
    const std::size_t middle = (low + high) / 2;
    (knots[middle].at <= s ? low : high) = middle;
  }
  const double width = knots[high].at - knots[low].at;
  return {&knots[low], &knots[high], (s - knots[low].at) / width, 1 / width};
}

Sym3 add(const Sym3& a, double k, const Sym3& b) {
  return {a.xx + k * b.xx, a.yy + k * b.yy, a.zz + k * b.zz, a.xy + k * b.xy, a.xz + k * b.xz, a.yz + k * b.yz};
}

}  // namespace

void update_masses(const Plan& plan, double t, Workspace& ws) noexcept {
  for (std::size_t i = 0; i < plan.varying.size(); ++i) {
    const PlanVarying& law = plan.varying[i];
    VaryingBody& body = ws.varying[i];
    const std::span<const MassKnot> knots = std::span(plan.mass_knots).subspan(at(law.first), at(law.count));
    const Place p = find_place(knots, law.by_burnt ? ws.extras.now[i] : t);
    const Sym3 change = add(p.high->inertia, -1, p.low->inertia);
    body.mass = p.low->mass + p.part * (p.high->mass - p.low->mass);
    body.centre_B = p.low->centre + p.part * (p.high->centre - p.low->centre);
    body.inertia_B = add(p.low->inertia, p.part, change);
    body.mass_slope = p.slope * (p.high->mass - p.low->mass);
    body.inertia_slope_B = add({0, 0, 0, 0, 0, 0}, p.slope, change);
  }
}

void update_varying_kinematics(const Plan& plan, Workspace& ws) noexcept {
  double* lanes = ws.lanes.data();
  for (std::size_t i = 0; i < plan.varying.size(); ++i) {
    const LaneSlot slot = ws.slots[at(plan.varying[i].body)];
    const Mat3 R = read_mat(lanes, slot, kRotation);
    const Sym3 J = rotate(R, ws.varying[i].inertia_B);
    ws.varying[i].centre = R * ws.varying[i].centre_B;
    write_vec(lanes, slot, kInertia, {J.xx, J.yy, J.zz});
    write_vec(lanes, slot, kInertia + 3, {J.xy, J.xz, J.yz});
  }
}

void add_varying_forces(const Plan& plan, Workspace& ws) noexcept {
  double* lanes = ws.lanes.data();
  for (std::size_t i = 0; i < plan.varying.size(); ++i) {
    const PlanVarying& law = plan.varying[i];
    const VaryingBody& body = ws.varying[i];
    const LaneSlot slot = ws.slots[at(law.body)];
    const Vec3 w = read_vec(lanes, slot, kOmega), p = read_vec(lanes, slot, kPose);
    const Vec3 force = body.mass * (calc_gravity(plan, p + body.centre) - cross(w, cross(w, body.centre)));
    Vec3 torque = cross(body.centre, force);
    if (law.jet_damping) {
      const Mat3 R = read_mat(lanes, slot, kRotation);
      const double rate = law.by_burnt ? ws.extras.rate[i] : 1;
      const Vec3 r = R * law.exit - body.centre;
      torque += rate * (body.mass_slope * cross(r, cross(w, r)) - rotate(R, body.inertia_slope_B) * w);
    }
    add_vec(lanes, slot, kForce, force);
    add_vec(lanes, slot, kForce + 3, torque);
  }
}

void add_varying_blocks(const Plan& plan, Workspace& ws) noexcept {
  double* lanes = ws.lanes.data();
  for (std::size_t i = 0; i < plan.varying.size(); ++i) {
    const LaneSlot slot = ws.slots[at(plan.varying[i].body)];
    const double m = ws.varying[i].mass;
    const Vec3 c = ws.varying[i].centre;
    const auto add = [&](int row, const Vec3& a) { add_vec(lanes, slot, kBlock + row, a); };
    add(0, {m, m, m});
    // H = −m c̃ by columns, I += −m c̃ c̃
    add(6, {0, -m * c.z, m * c.y});
    add(9, {m * c.z, 0, -m * c.x});
    add(12, {-m * c.y, m * c.x, 0});
    add(15, {m * (c.y * c.y + c.z * c.z), m * (c.z * c.z + c.x * c.x), m * (c.x * c.x + c.y * c.y)});
    add(18, {-m * c.x * c.y, -m * c.x * c.z, -m * c.y * c.z});
  }
}

}  // namespace unlatch
