#include "tests/support/peers/simbody_system.h"

#include <Simbody.h>

#include <stdexcept>
#include <string>

namespace unlatch::test {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using SimTK::MobilizedBody;

SimTK::Vec3 to_vec(const Vector3d& v) { return {v.x(), v.y(), v.z()}; }
Vector3d to_eigen(const SimTK::Vec3& v) { return {v[0], v[1], v[2]}; }
SimTK::Transform to_transform(const Matrix3d& R, const Vector3d& p) {
  SimTK::Mat33 out;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) out(i, j) = R(i, j);
  return SimTK::Transform(SimTK::Rotation(out, true), to_vec(p));
}

SimTK::Body::Rigid build_body(const Body& body) {
  const Matrix3d& I = body.inertia;
  const SimTK::Inertia inertia(I(0, 0), I(1, 1), I(2, 2), I(0, 1), I(0, 2), I(1, 2));
  return SimTK::Body::Rigid(SimTK::MassProperties(body.mass, SimTK::Vec3(0), inertia));
}

// Reorders columns to the mobilizer's x, y, z.
Matrix3d reorder(const Matrix3d& m, int x, int y, int z) {
  Matrix3d out;
  out << m.col(x), m.col(y), m.col(z);
  return out;
}

bool is(const std::vector<int>& axes, std::initializer_list<int> expected) {
  return axes == std::vector<int>(expected);
}

// Degrees of freedom of the joint by Simbody's own mobilizers. Both frames of a mobilizer coincide in the initial
// state, so that all its coordinates are zero there.
class Mobilizer {
 public:
  Mobilizer(const Model& model, const TreeLink& link, MobilizedBody& parent)
      : model_(model),
        link_(link),
        parent_(parent),
        joint_(model.joints[static_cast<std::size_t>(link.joint)]),
        freedoms_(calc_freedoms(model, joint_)) {}

  // Builds the mobilized body; its speeds are returned in `speeds`.
  MobilizedBody build(std::vector<double>& speeds) {
    const Freedoms& f = freedoms_;
    const Matrix3d n = get_placement(model_, joint_.base).R * joint_.axes;
    if (f.slides.empty() && f.turns.empty()) return build_as<MobilizedBody::Weld>(n, false);
    if (f.slides.empty() && f.turns.size() == 1) {
      speeds = f.turn_speeds;
      return build_as<MobilizedBody::Pin>(
          reorder(n, (f.turn_axes[0] + 1) % 3, (f.turn_axes[0] + 2) % 3, f.turn_axes[0]), false);
    }
    if (f.slides.empty() && f.turns.size() == 2) {
      Matrix3d cross;
      cross << f.turns[0], f.turns[1], f.turns[0].cross(f.turns[1]);
      speeds = f.turn_speeds;
      return build_as<MobilizedBody::Universal>(cross, false);
    }
    if (f.slides.empty()) {
      speeds = f.turn_speeds;
      return build_as<MobilizedBody::Ball>(n, false);
    }
    if (is(f.slide_axes, {kZ}) && f.turns.empty()) {
      speeds = f.slide_speeds;
      return build_as<MobilizedBody::Slider>(reorder(n, 2, 0, 1), false);
    }
    if (is(f.slide_axes, {kZ}) && is(f.turn_axes, {2})) {
      speeds = {f.turn_speeds[0], f.slide_speeds[0]};
      return build_as<MobilizedBody::Cylinder>(n, false);
    }
    if (is(f.slide_axes, {kX, kY}) && is(f.turn_axes, {2})) {
      speeds = {f.turn_speeds[0], f.slide_speeds[0], f.slide_speeds[1]};
      return build_as<MobilizedBody::Planar>(n, false);
    }
    // The follower slides along the base's z and turns about y. Relative to the follower the base turns, then slides
    // along its own axis: bend and stretch.
    if (is(f.slide_axes, {kZ}) && is(f.turn_axes, {1})) {
      speeds = {-f.turn_speeds[0], -f.slide_speeds[0]};
      return build_as<MobilizedBody::BendStretch>(reorder(n, 2, 0, 1), true);
    }
    throw std::invalid_argument("joint '" + joint_.name + "' is none of Simbody's");
  }

 private:
  // `from_follower`: the mobilizer's coordinates are those of the base relative to the follower.
  template <class T>
  MobilizedBody build_as(const Matrix3d& axes, bool from_follower) {
    const auto frame_in = [&](int body) {
      const Placement b = get_placement(model_, body);
      return to_transform(b.R.transpose() * axes, b.R.transpose() * (freedoms_.point - b.p));
    };
    const SimTK::Transform inner = frame_in(link_.parent), outer = frame_in(link_.body);
    const SimTK::Body::Rigid body = build_body(model_.bodies[static_cast<std::size_t>(link_.body)]);
    if constexpr (std::is_same_v<T, MobilizedBody::Weld>)
      return T(parent_, inner, body, outer);
    else
      return T(parent_, inner, body, outer,
               link_.child_is_follower != from_follower ? MobilizedBody::Forward : MobilizedBody::Reverse);
  }

  const Model& model_;
  const TreeLink& link_;
  MobilizedBody& parent_;
  const Joint& joint_;
  Freedoms freedoms_;
};

// Constraints in place of a joint that closes a loop: those of a weld, or of a point and two angles between axes.
void close_loop(const Model& model, int joint, MobilizedBody& base, MobilizedBody& follower) {
  const ClosingJoint closing = get_closing_joint(model, joint);
  const Placement b = get_placement(model, closing.base), f = get_placement(model, closing.follower);
  const SimTK::Vec3 at_base = to_vec(b.R.transpose() * (closing.point - b.p)),
                    at_follower = to_vec(f.R.transpose() * (closing.point - f.p));
  if (closing.weld) {
    SimTK::Constraint::Weld(base, to_transform(b.R.transpose(), b.R.transpose() * (closing.point - b.p)), follower,
                            to_transform(f.R.transpose(), f.R.transpose() * (closing.point - f.p)));
    return;
  }
  SimTK::Constraint::Ball(base, at_base, follower, at_follower);
  for (const int across : {0, 1})
    SimTK::Constraint::ConstantAngle(base, SimTK::UnitVec3(to_vec(b.R.transpose() * closing.hinge.col(across))),
                                     follower, SimTK::UnitVec3(to_vec(f.R.transpose() * closing.hinge.col(2))),
                                     SimTK::Pi / 2);
}

}  // namespace

struct SimbodySystem::Data {
  SimTK::MultibodySystem system;
  SimTK::SimbodyMatterSubsystem matter{system};
  SimTK::GeneralForceSubsystem forces{system};
  std::vector<MobilizedBody> bodies;
  SimTK::State state;
};

SimbodySystem::SimbodySystem(const Model& model, const std::vector<Wrench>& wrenches)
    : data_(std::make_unique<Data>()) {
  Data& d = *data_;
  SimTK::Force::UniformGravity(d.forces, d.matter, to_vec(model.gravity.uniform));
  SimTK::Force::DiscreteForces applied(d.forces, d.matter);
  const std::vector<TreeLink> links = build_tree_links(model);
  std::vector<std::vector<double>> speeds(links.size());
  d.bodies.resize(model.bodies.size());
  const auto get_body = [&](int body) -> MobilizedBody& {
    return body == kGround ? static_cast<MobilizedBody&>(d.matter.updGround())
                           : d.bodies[static_cast<std::size_t>(body)];
  };
  for (std::size_t k = 0; k < links.size(); ++k) {
    const TreeLink& link = links[k];
    const auto body = static_cast<std::size_t>(link.body);
    MobilizedBody& parent = get_body(link.parent);
    if (link.joint == kNone)
      d.bodies[body] = MobilizedBody::Free(parent, build_body(model.bodies[body]));
    else
      d.bodies[body] = Mobilizer(model, link, parent).build(speeds[k]);
  }
  for (const int j : list_closing_joints(model)) {
    const Joint& joint = model.joints[static_cast<std::size_t>(j)];
    close_loop(model, j, get_body(joint.base), get_body(joint.follower));
  }
  d.state = d.system.realizeTopology();
  d.system.realizeModel(d.state);
  for (std::size_t k = 0; k < links.size(); ++k) {
    const MobilizedBody& body = d.bodies[static_cast<std::size_t>(links[k].body)];
    if (links[k].joint == kNone) {
      const Placement root = get_placement(model, links[k].body);
      body.setQToFitTransform(d.state, to_transform(root.R, root.p));
      body.setUToFitVelocity(d.state, SimTK::SpatialVec(to_vec(root.w), to_vec(root.v)));
    }
    for (std::size_t i = 0; i < speeds[k].size(); ++i) body.setOneU(d.state, static_cast<int>(i), speeds[k][i]);
  }
  for (std::size_t b = 0; b < wrenches.size(); ++b)
    applied.setOneBodyForce(d.state, d.bodies[b],
                            SimTK::SpatialVec(to_vec(wrenches[b].torque), to_vec(wrenches[b].force)));
}

SimbodySystem::~SimbodySystem() = default;

void SimbodySystem::solve() {
  (void)data_->state.updQ();
  (void)data_->state.updU();
  data_->system.realize(data_->state, SimTK::Stage::Acceleration);
}

void SimbodySystem::solve_factored() {
  data_->state.invalidateAllCacheAtOrAbove(SimTK::Stage::Position);
  data_->system.realize(data_->state, SimTK::Stage::Acceleration);
}

BodyAccelerations SimbodySystem::calc_accelerations() const {
  BodyAccelerations out;
  for (const MobilizedBody& body : data_->bodies) {
    out.linear.push_back(to_eigen(body.getBodyOriginAcceleration(data_->state)));
    out.angular.push_back(to_eigen(body.getBodyAngularAcceleration(data_->state)));
  }
  return out;
}

}  // namespace unlatch::test
