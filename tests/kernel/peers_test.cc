// The kernel compared with MuJoCo and Simbody, which use joint coordinates and are independent of it: accelerations of
// random trees of the joint kinds that all of them have, and of Simbody's contacts a blow. (MuJoCo's are soft
// constraints of another law.)
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/support/random_model.h"
#include "tests/support/solve_comparison.h"
#include "tests/support/tree_links.h"
#ifdef UNLATCH_PEER_MUJOCO
#include "tests/support/peers/mujoco_system.h"
#endif
#ifdef UNLATCH_PEER_SIMBODY
#include "tests/support/contact_models.h"
#include "tests/support/peers/simbody_blow.h"
#include "tests/support/peers/simbody_system.h"
#endif

namespace unlatch::test::peers_test {
namespace {

constexpr double kAgreement = 1e-9;  // joint accelerations, relative to the largest
constexpr std::uint64_t kFirstSeed = 7001;
constexpr int kSystems = 150;

struct System {
  Model model;
  std::vector<Wrench> wrenches;
};

System build_system(std::uint64_t seed) {
  RandomModelOptions options;
  options.bodies = 2 + static_cast<int>(seed % 39);
  options.first_mode_chance = 1;
  options.common_kinds = true;
  System system{build_random_model(seed, options), {}};
  Random random(seed);
  system.wrenches = add_random_loads(system.model, random);
  system.model.gravity.uniform = {random.uniform(-10, 10), random.uniform(-10, 10), random.uniform(-10, 10)};
  return system;
}

BodyAccelerations solve_by_kernel(const Model& model) {
  Simulation s(model);
  EXPECT_EQ(update_outputs(s.plan, {s.commands}, s.state, s.workspace), StepStatus::kOk);
  const KernelSolution solution = read_solution(s);
  BodyAccelerations out{solution.linear, {}};
  for (std::size_t b = 0; b < model.bodies.size(); ++b)
    out.angular.push_back(get_placement(model, static_cast<int>(b)).R * solution.angular[b]);
  return out;
}

template <class Peer>
void expect_to_agree(const char* name) {
  double worst = 0;
  std::size_t joints = 0;
  for (std::uint64_t seed = kFirstSeed; seed < kFirstSeed + kSystems; ++seed) {
    const System system = build_system(seed);
    Peer peer(system.model, system.wrenches);
    peer.solve();
    const std::vector<double> theirs = calc_joint_accelerations(system.model, peer.calc_accelerations());
    const std::vector<double> ours = calc_joint_accelerations(system.model, solve_by_kernel(system.model));
    ASSERT_EQ(ours.size(), theirs.size());
    double size = 1e-3, error = 0;  // m/s², rad/s²: of a system that is welded to the ground
    for (std::size_t i = 0; i < ours.size(); ++i) {
      size = std::max(size, std::abs(theirs[i]));
      error = std::max(error, std::abs(ours[i] - theirs[i]));
    }
    EXPECT_LT(error / size, kAgreement) << "seed " << seed << ", " << system.model.bodies.size() << " bodies";
    worst = std::max(worst, error / size);
    joints += system.model.joints.size();
  }
  std::printf("%s, %d random trees from seed %d, %zu joints: accelerations differ by %.1e at most\n", name, kSystems,
              static_cast<int>(kFirstSeed), joints, worst);
}

TEST(Peers, MuJoCoFindsTheSameAccelerations) {
#ifdef UNLATCH_PEER_MUJOCO
  expect_to_agree<MujocoSystem>("MuJoCo");
#else
  GTEST_SKIP() << "built without MuJoCo: libmujoco-dev was not installed (tools/setup test)";
#endif
}

TEST(Peers, SimbodyFindsTheSameAccelerations) {
#ifdef UNLATCH_PEER_SIMBODY
  expect_to_agree<SimbodySystem>("Simbody");
#else
  GTEST_SKIP() << "built without Simbody: libsimbody-dev was not installed (tools/setup test)";
#endif
}

#ifdef UNLATCH_PEER_SIMBODY
Model build_spheres(const SphereBlow& blow) {
  Model model;
  model.name = "blow";
  for (std::size_t i = 0; i < 2; ++i) {
    const std::string name = i == 0 ? "a" : "b";
    model.bodies.push_back(box(name, blow.mass[i], 1, 1, 1));
    model.bodies[i].p_WB = blow.place[i];
    model.bodies[i].v_WB = blow.velocity[i];
    model.surfaces.push_back({name, static_cast<int>(i), {build_sphere(blow.radius[i])}});
  }
  model.contacts = {touch("blow", 0, 1, calc_hertz_stiffness(blow))};
  model.contacts[0].exponent = 1.5;
  model.contacts[0].damping = 1.5 * blow.dissipation;
  return model;
}
#endif

// Both have F = k δ^1.5 (1 + d dδ/dt): Simbody between spheres by their moduli. An oblique blow, compared all the way.
TEST(Peers, SimbodyFindsTheSameBlowOfTwoSpheres) {
#ifdef UNLATCH_PEER_SIMBODY
  constexpr double kStep = 1e-5, kRelative = 1e-8;  // s; of 3 m/s, and of 3 m
  constexpr int kTicks = 2000;
  for (const double dissipation : {0.0, 0.05, 0.4}) {
    const SphereBlow blow{.mass = {2, 5},
                          .radius = {0.25, 0.5},
                          .place = {Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(0.72, 0.25, -0.0625)},
                          .velocity = {Eigen::Vector3d(2, 0, 0.5), Eigen::Vector3d(-1, -0.25, 0)},
                          .modulus = 3e7,
                          .dissipation = dissipation};
    Simulation s(build_spheres(blow), {.dt = kStep});
    const std::vector<SpherePlaces> theirs = run_simbody_blow(blow, kStep, kTicks);
    double place = 0, speed = 0;
    for (const SpherePlaces& their : theirs) {
      ASSERT_EQ(s.advance().status, StepStatus::kOk);
      for (std::size_t i = 0; i < 2; ++i) {
        const auto& own = s.state.bodies[i];
        place = std::max(place, (Eigen::Vector3d(own.p.x, own.p.y, own.p.z) - their[i]).norm());
        speed = std::max(speed, (Eigen::Vector3d(own.v.x, own.v.y, own.v.z) - their[i + 2]).norm());
      }
    }
    const double thrown = (theirs.back()[2] - blow.velocity[0]).norm();
    EXPECT_GT(thrown, 1) << "m/s: they have met";
    EXPECT_LT(speed, kRelative * 3);
    EXPECT_LT(place, kRelative * 3);
    std::printf(
        "Simbody, blow with a dissipation of %g s/m that throws one back by %.3f m/s: velocities differ by %.1e m/s, "
        "places by %.1e m at most\n",
        dissipation, thrown, speed, place);
  }
#else
  GTEST_SKIP() << "built without Simbody: libsimbody-dev was not installed (tools/setup test)";
#endif
}

}  // namespace
}  // namespace unlatch::test::peers_test
