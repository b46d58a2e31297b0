// Simbody's realize(Acceleration) on the same tree. Either positions and velocities count as changed before each call,
// so that everything is computed anew, or only the stages are invalidated: then Simbody keeps what belongs to the
// positions, its factorisation (articulated inertias) included, and merely solves.
#include <Simbody.h>

#include "bench/solve_solver.h"

namespace unlatch::bench {
namespace {

SimTK::Vec3 to_vec(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }
SimTK::Rotation to_rotation(const Eigen::Matrix3d& m) {
  SimTK::Mat33 out;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) out(i, j) = m(i, j);
  return SimTK::Rotation(out, true);
}

SimTK::Body::Rigid build_body(const Body& body) {
  const Eigen::Matrix3d& I = body.inertia;
  const SimTK::Inertia inertia(I(0, 0), I(1, 1), I(2, 2), I(0, 1), I(0, 2), I(1, 2));
  return SimTK::Body::Rigid(SimTK::MassProperties(body.mass, SimTK::Vec3(0), inertia));
}

class Simbody final : public Solver {
 public:
  enum class Keep { kNothing, kFactorisation };

  Simbody(const Model& model, Keep keep)
      : model_(model),
        keep_(keep),
        matter_(system_),
        forces_(system_),
        gravity_(forces_, matter_, to_vec(model.gravity.uniform)) {
    bodies_.push_back(SimTK::MobilizedBody::Free(matter_.Ground(), build_body(model.bodies[0])));
    for (const Joint& joint : model.joints) {
      const Body& base = get_body(joint.base);
      const Body& follower = get_body(joint.follower);
      const Eigen::Matrix3d axes = follower.q_WB.conjugate() * (base.q_WB * joint.axes);
      bodies_.push_back(SimTK::MobilizedBody::Pin(bodies_[static_cast<std::size_t>(joint.base)],
                                                  SimTK::Transform(to_rotation(joint.axes), to_vec(joint.point_base)),
                                                  build_body(follower),
                                                  SimTK::Transform(to_rotation(axes), to_vec(joint.point_follower))));
    }
    state_ = system_.realizeTopology();
    system_.realizeModel(state_);
    set_root();
    for (const Joint& joint : model.joints) {
      const Body& base = get_body(joint.base);
      const Body& follower = get_body(joint.follower);
      const Eigen::Vector3d w = follower.q_WB * follower.w_WB_B - base.q_WB * base.w_WB_B;
      bodies_[static_cast<std::size_t>(joint.follower)].setOneU(state_, 0, w.dot(base.q_WB * joint.axes.col(2)));
    }
  }

  void solve() override {
    if (keep_ == Keep::kNothing) {
      (void)state_.updQ();
      (void)state_.updU();
    } else {
      state_.invalidateAllCacheAtOrAbove(SimTK::Stage::Position);
    }
    system_.realize(state_, SimTK::Stage::Acceleration);
  }

  Solution build_solution() const override {
    Solution solution;
    const SimTK::Vec3 linear = bodies_[0].getBodyOriginAcceleration(state_);
    const SimTK::Vec3 angular = bodies_[0].getBodyAngularAcceleration(state_);
    solution.accelerations = {linear[0], linear[1], linear[2], angular[0], angular[1], angular[2]};
    for (const Joint& joint : model_.joints)
      solution.accelerations.push_back(bodies_[static_cast<std::size_t>(joint.follower)].getOneUDot(state_, 0));
    return solution;
  }

 private:
  const Body& get_body(int index) const { return model_.bodies[static_cast<std::size_t>(index)]; }

  void set_root() {
    const Body& root = model_.bodies[0];
    bodies_[0].setQToFitTransform(state_,
                                  SimTK::Transform(to_rotation(root.q_WB.toRotationMatrix()), to_vec(root.p_WB)));
    bodies_[0].setUToFitVelocity(state_, SimTK::SpatialVec(to_vec(root.q_WB * root.w_WB_B), to_vec(root.v_WB)));
  }

  Model model_;
  Keep keep_;
  SimTK::MultibodySystem system_;
  SimTK::SimbodyMatterSubsystem matter_;
  SimTK::GeneralForceSubsystem forces_;
  SimTK::Force::UniformGravity gravity_;
  std::vector<SimTK::MobilizedBody> bodies_;
  SimTK::State state_;
};

}  // namespace

std::unique_ptr<Solver> build_simbody(const Model& model) {
  return std::make_unique<Simbody>(model, Simbody::Keep::kNothing);
}
std::unique_ptr<Solver> build_simbody_solve(const Model& model) {
  return std::make_unique<Simbody>(model, Simbody::Keep::kFactorisation);
}

}  // namespace unlatch::bench
