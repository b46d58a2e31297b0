// Sub-steps of order eight in blows of contacts (kernel/integration/eighth_order.h): their order, balances, and where
// the step takes them.
#include "kernel/integration/eighth_order.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "kernel/integration/integrator.h"
#include "tests/support/contact_models.h"
#include "tests/support/simulation.h"
#include "unlatch/contacts.h"

namespace unlatch::test::eighth_order_test {
namespace {

// A block that is pressed into the floor and slides, with a pendulum that hangs from it.
Model build_sliding_block() {
  Model model = build_block_on_feet();
  model.contacts[0].stiffness = 2e5;
  model.contacts[0].friction = 0.3;
  model.contacts[0].slip_speed = 5e-2;
  model.contacts[0].damping = 2;
  model.bodies[0].p_WB.z() -= 1.1 * (model.bodies[0].mass + 0.1) * kGravity / (4 * 2e5);
  model.bodies[0].v_WB = {0.2, 0.1, 0};
  model.bodies.push_back(box("pendulum", 0.1, 0.002, 0.002, 0.002));
  model.bodies[1].p_WB = model.bodies[0].p_WB + Eigen::Vector3d(0.02, 0, 0.2);
  model.bodies[1].v_WB = {0.2, 0.1, 0.001};
  model.bodies[1].w_WB_B = {0, -0.05, 0};
  Joint hinge;
  hinge.name = "hinge";
  hinge.base = 0;
  hinge.follower = 1;
  hinge.point_base = {0, 0, 0.2};
  hinge.point_follower = {-0.02, 0, 0};
  hinge.modes = {{"hinge", static_cast<RowSet>(0b111 | 1u << kRotX | 1u << kRotZ)}};
  model.joints = {hinge};
  return model;
}

// The motion after `duration` in `count` sub-steps of one kind, all pairs closed.
std::vector<double> integrate_by(const Model& model, double duration, int count, Contacts contacts) {
  Simulation s(model);
  Evaluation& ev = s.evaluation();
  const Inputs inputs{s.commands};
  const auto get_instant = [&](double t) { return Instant{s.data(), inputs, s.state, t}; };
  EXPECT_EQ(evaluate(get_instant(0), Changed::kState, ev), kNone);
  for (int i = 0; i < count; ++i) {
    const double begin = duration * i / count, end = duration * (i + 1) / count;
    const SubstepStart start = begin_substep(get_instant(begin), contacts, ev);
    EXPECT_EQ(integrate(get_instant(end), start, end, ev), kNone);
    EXPECT_EQ(evaluate(get_instant(end), Changed::kVelocities, ev), kNone);
    store_substep(s.data(), ev, s.state);
  }
  std::vector<double> numbers;
  for (const BodyState& b : s.state.bodies)
    for (const double x : {b.p.x, b.p.y, b.p.z, b.q.w, b.q.x, b.q.y, b.q.z, b.v.x, b.v.y, b.v.z, b.w.x, b.w.y, b.w.z})
      numbers.push_back(x);
  for (const double x : s.state.auxiliary) numbers.push_back(x);
  return numbers;
}

double calc_distance(const std::vector<double>& a, const std::vector<double>& b) {
  double most = 0;
  for (std::size_t i = 0; i < a.size(); ++i) most = std::max(most, std::abs(a[i] - b[i]));
  return most;
}

TEST(EighthOrder, ItsErrorsFallByTheEighthPower) {
  constexpr double kDuration = 0.008;  // s
  const Model model = build_sliding_block();
  const std::vector<double> reference = integrate_by(model, kDuration, 512, Contacts::kEighthOrder);
  EXPECT_LT(calc_distance(integrate_by(model, kDuration, 4096, Contacts::kExplicit), reference), 1e-10);
  double before = 0;
  for (const int count : {8, 16, 32}) {
    const double error = calc_distance(integrate_by(model, kDuration, count, Contacts::kEighthOrder), reference);
    if (before > 0) {
      EXPECT_NEAR(std::log2(before / error), 8, 0.5) << count << " sub-steps, error " << error;
    }
    before = error;
  }
  EXPECT_LT(before, 1e-11);
}

TEST(EighthOrder, ImpulsesAreThoseThatActed) {
  Model model = build_block_on_feet();
  model.contacts[0].friction = 0.6;
  model.bodies[0].v_WB = {0.3, 0, -0.2};
  model.bodies[0].p_WB.z() -= 5e-5;
  const std::vector<double> end = integrate_by(model, 0.02, 20, Contacts::kEighthOrder);
  const double impulse = end[13];  // the first auxiliary state
  EXPECT_GT(impulse, 0.1);
  EXPECT_NEAR(impulse, model.bodies[0].mass * (end[9] + 0.2 + kGravity * 0.02), 1e-14);
}

// A ball of 1 kg falls on a floor of 1 MN/m: a blow of 3 ms, of which a step of 1 ms is 1/ω. Parts of RK4 would be more
// than eight a step (0.12 of the rate, 0.3 of it here).
TEST(EighthOrder, ABlowTakesFewPartsAndPartsWithItsRestitution) {
  for (const double restitution : {0.3, 0.9}) {
    constexpr double kSpeed = 0.5;
    Model model = build_dropped_ball(1e-4);
    Contact& contact = model.contacts[0];
    contact.stiffness = 1e6;
    contact.damping = calc_contact_damping(restitution, kSpeed);
    contact.friction = 0;
    model.gravity.uniform = {0, 0, 0};
    model.bodies[0].v_WB = {0, 0, -kSpeed};
    Simulation s(model);
    int substeps = 0, steps = 0;
    bool closed = false;
    for (int i = 0; i < 1000 && !(closed && s.state.contacts[0].closed == 0); ++i) {
      const int own = s.advance().substeps;
      if (s.state.contacts[0].closed == 0) continue;
      closed = true;
      substeps += own;
      ++steps;
    }
    ASSERT_TRUE(closed);
    EXPECT_LE(substeps, 8 * steps) << restitution;
    EXPECT_NEAR(s.state.bodies[0].v.z, restitution * kSpeed, 1e-6 * kSpeed);
  }
}

}  // namespace
}  // namespace unlatch::test::eighth_order_test
