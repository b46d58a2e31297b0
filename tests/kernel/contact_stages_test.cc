// Sub-steps that are implicit in the forces of contacts (kernel/integration/contact_stages.h): their order, balances,
// bits, and where the step takes them.
#include "kernel/integration/contact_stages.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <vector>

#include "tests/support/contact_models.h"
#include "tests/support/simulation.h"
#include "unlatch/contacts.h"

namespace unlatch::test::contact_stages_test {
namespace {

// A block on feet that a pendulum hangs from, and with `loop` a second one and a bar between the two: its contacts
// stick while the pendulums pull at it.
Model build_pulled_block(bool loop) {
  Model model = build_block_on_feet();
  model.contacts[0].stiffness = 2e5;
  model.contacts[0].friction = 0.6;
  model.contacts[0].slip_speed = 1e-2;
  model.bodies[0].p_WB.z() -= 5e-5;
  model.bodies.push_back(box("pendulum", 0.5, 0.002, 0.002, 0.002));
  model.bodies[1].p_WB = model.bodies[0].p_WB + Eigen::Vector3d(0.1, 0, 0.2);
  model.bodies[1].v_WB = {0, 0, 0.1};
  model.bodies[1].w_WB_B = {0, -1, 0};
  Joint hinge;
  hinge.name = "hinge";
  hinge.base = 0;
  hinge.follower = 1;
  hinge.point_base = {0, 0, 0.2};
  hinge.point_follower = {-0.1, 0, 0};
  hinge.modes = {{"hinge", static_cast<RowSet>(0b111 | 1u << kRotX | 1u << kRotZ)}};
  model.joints = {hinge};
  if (loop) {
    Joint second = hinge;  // the same rows once more: redundant
    second.name = "second";
    model.joints.push_back(second);
  }
  return model;
}

// The motion after `duration` in `count` sub-steps of one kind.
std::vector<double> integrate_by(const Model& model, double duration, int count, bool implicit) {
  Simulation s(model);
  Evaluation& ev = s.evaluation();
  const Inputs inputs{s.commands};
  const auto get_instant = [&](double t) { return Instant{s.data(), inputs, s.state, t}; };
  EXPECT_EQ(evaluate(get_instant(0), Changed::kState, ev), kNone);
  for (int i = 0; i < count; ++i) {
    const double begin = duration * i / count, end = duration * (i + 1) / count;
    const SubstepStart start =
        begin_substep(get_instant(begin), implicit ? Contacts::kImplicit : Contacts::kExplicit, ev);
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

TEST(ContactStages, TheirOrderIsThree) {
  constexpr double kDuration = 0.02;  // s
  for (const bool loop : {false, true}) {
    const Model model = build_pulled_block(loop);
    const std::vector<double> reference = integrate_by(model, kDuration, 4096, false);
    double before = 0;
    for (const int count : {64, 128, 256}) {
      const double error = calc_distance(integrate_by(model, kDuration, count, true), reference);
      if (before > 0) {
        EXPECT_NEAR(std::log2(before / error), 3, 0.35) << count << " sub-steps, error " << error;
      }
      before = error;
    }
    EXPECT_LT(before, 1e-6);
  }
}

TEST(ContactStages, ImpulsesAreThoseThatActed) {
  // Without joints: the momentum along the normal is gained by the contact and the weight alone.
  Model model = build_block_on_feet();
  model.contacts[0].friction = 0.6;
  model.bodies[0].v_WB = {0.3, 0, -0.2};
  model.bodies[0].p_WB.z() -= 5e-5;
  Simulation s(model);
  const std::vector<double> end = integrate_by(model, 0.02, 20, true);
  const double impulse = end[13];  // the first auxiliary state
  EXPECT_GT(impulse, 0.1);
  EXPECT_NEAR(impulse, model.bodies[0].mass * (end[9] + 0.2 + kGravity * 0.02), 1e-14);
}

// An explicit step would have 256 parts, and these would not be stable.
TEST(ContactStages, AStickingBlockTakesOnePartOfAStep) {
  const Model model = build_sticking_block();
  const Contact& contact = model.contacts[0];
  Simulation s(model);
  for (int i = 0; i < 1500; ++i) ASSERT_EQ(s.advance().status, StepStatus::kOk);
  const double place = s.state.bodies[0].p.x;
  int substeps = 0;
  constexpr int kSteps = 200;
  for (int i = 0; i < kSteps; ++i) substeps += s.advance().substeps;
  EXPECT_LE(substeps, 3 * kSteps / 2);
  const double slope = -model.gravity.uniform.x() / model.gravity.uniform.z();
  const double creep = contact.slip_speed * slope / std::sqrt(contact.friction * contact.friction - slope * slope);
  EXPECT_NEAR((s.state.bodies[0].p.x - place) / (kSteps * 1e-3), creep, 1e-4 * creep);
}

// The force grows from rest until the block slides: it leaves the implicit parts by itself, and returns to them.
TEST(ContactStages, ABlockThatSticksSlidesAndSticksAgainMovesAsWithFineParts) {
  Model model = build_block_on_feet();
  model.contacts[0].friction = 0.5;
  model.contacts[0].slip_speed = 1e-4;
  model.contacts[0].stiffness = 2e6;
  model.contacts[0].damping = 5;
  model.bodies[0].p_WB = {0, 0, 0.0625 - 2 * kGravity / 4 / 2e6};
  Load pull;
  pull.name = "pull";
  pull.direction = {1, 0, 0};
  pull.profile.kind = Profile::Kind::kTable;
  pull.profile.times = {0, 0.05, 0.1, 0.2};
  pull.profile.values = {0, 14, 4, 4};
  model.loads = {pull};
  Model fine = model;
  fine.contact_substeps = 64;
  Simulation a(model), b(fine);
  int substeps = 0, fine_substeps = 0;
  for (int i = 0; i < 200; ++i) {
    const StepReport own = a.advance(), other = b.advance();
    ASSERT_EQ(own.status, StepStatus::kOk);
    ASSERT_EQ(other.status, StepStatus::kOk);
    substeps += own.substeps;
    fine_substeps += other.substeps;
  }
  EXPECT_GT(b.state.bodies[0].p.x, 1e-3) << "it does not slide";
  EXPECT_NEAR(a.state.bodies[0].p.x, b.state.bodies[0].p.x, 1e-7);
  EXPECT_LT(2 * substeps, fine_substeps);
}

TEST(ContactStages, EveryInstructionSetHasTheSameBits) {
  Model model = build_pulled_block(true);
  model.contacts[0].slip_speed = 1e-4;
  std::vector<double> first;
  for (const InstructionSet set :
       {InstructionSet::kScalar, InstructionSet::k128, InstructionSet::k256, InstructionSet::k512}) {
    if (!is_supported(set)) continue;
    Simulation s(model, {.instruction_set = set});
    int substeps = 0;
    for (int i = 0; i < 50; ++i) {
      const StepReport report = s.advance();
      ASSERT_EQ(report.status, StepStatus::kOk);
      substeps += report.substeps;
    }
    EXPECT_LT(substeps, 50 * 64) << "explicit parts";
    std::vector<double> numbers;
    for (const BodyState& b : s.state.bodies)
      for (const double x : {b.p.x, b.p.y, b.p.z, b.v.x, b.v.y, b.v.z, b.w.x, b.w.y, b.w.z}) numbers.push_back(x);
    if (first.empty()) first = numbers;
    EXPECT_EQ(std::memcmp(first.data(), numbers.data(), first.size() * sizeof(double)), 0) << get_name(set);
  }
}

}  // namespace
}  // namespace unlatch::test::contact_stages_test
