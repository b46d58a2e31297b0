// Copies of one mechanism in one model share groups of joints and packs of lanes: each copy has the bits that it has
// alone, however many there are, in every mode of its joints and every width. With a loop each, of which a larger model
// may be solved in another way, it moves likewise to rounding.
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "tests/support/simulation.h"
#include "tests/support/small_models.h"

namespace unlatch::test::copies_test {
namespace {

constexpr int kBodies = 5, kJoints = 5;  // of one copy, without the joint that closes its loop
constexpr int kTicks = 12;
constexpr double kRounding = 1e-9;  // m, m/s, N: of reactions of 100 N after some solutions of twelve rows

// Modes of the joints in the order in which add_copy() adds them.
using Modes = int[kJoints];

Joint build_joint(const std::string& name, int base, int follower, const Eigen::Vector3d& at, const Model& model,
                  std::vector<JointMode> modes) {
  Joint joint;
  joint.name = name;
  joint.base = base;
  joint.follower = follower;
  joint.point_base = base == kGround ? at : Eigen::Vector3d(at - model.bodies[static_cast<std::size_t>(base)].p_WB);
  joint.point_follower = at - model.bodies[static_cast<std::size_t>(follower)].p_WB;
  joint.modes = std::move(modes);
  return joint;
}

// A crank on the ground, a rod on it by a ball, a lever on the rod by a hinge; on the crank a bob by a ball and a vane
// by a hinge. In a loop the lever's end slides along y. Number `number` has a load of its own.
void add_copy(Model& model, int number, const Modes& modes, bool loop) {
  const int first = static_cast<int>(model.bodies.size());
  const std::string of = " " + std::to_string(number);
  const auto add = [&](const char* name, double mass, const Eigen::Vector3d& at) {
    model.bodies.push_back(box(name + of, mass, 0.11 * mass, 0.07 * mass, 0.13 * mass));
    model.bodies.back().p_WB = at;
  };
  add("crank", 2, {0.5, 0, 0});
  add("rod", 1.5, {1.5, 0, 0});
  add("lever", 1, {2, 0.5, 0});
  add("bob", 0.7, {0.5, -1, 0.1});
  add("vane", 0.4, {0.5, 1, -0.1});
  const JointMode hinge{"hinge", kRevoluteRows}, ball{"ball", kPointRows}, weld{"weld", kWeldRows}, free{"free", 0};
  const auto join = [&](const char* name, int base, int follower, const Eigen::Vector3d& at, const JointMode& usual,
                        int mode) {
    model.joints.push_back(build_joint(name + of, base == kGround ? kGround : first + base, first + follower, at, model,
                                       {usual, weld, free}));
    model.joints.back().mode = mode;
  };
  join("crank", kGround, 0, {0, 0, 0}, hinge, modes[0]);
  join("rod", 0, 1, {1, 0, 0}, ball, modes[1]);
  join("lever", 1, 2, {2, 0, 0}, hinge, modes[2]);
  join("bob", 0, 3, {0.5, -0.5, 0}, ball, modes[3]);
  join("vane", 0, 4, {0.5, 0.5, 0}, hinge, modes[4]);
  if (loop)
    model.joints.push_back(build_joint("slide" + of, kGround, first + 2, {2, 1, 0}, model,
                                       {{"slide", static_cast<RowSet>(row_bit(kX) | row_bit(kZ))}, free}));
  for (const int body : {1, 3}) {
    Load& load = model.loads.emplace_back();
    load.name = "load" + of + (body == 1 ? " on the rod" : " on the bob");
    load.body = first + body;
    load.direction = {1.0 + number, 0.25, -0.5 * number};
    load.point = {0.1, 0.2, 0};
  }
}

Model build(int first, int count, const Modes& modes, bool loop) {
  Model model;
  model.name = "copies";
  model.gravity.uniform = {0.3, -9.81, 1};
  for (int i = 0; i < count; ++i) add_copy(model, first + i, modes, loop);
  return model;
}

// The bodies of one copy, and the reactions of its joints.
std::vector<double> list_numbers(const Simulation& s, int copy, bool loop) {
  std::vector<double> numbers;
  for (std::size_t b = 0; b < kBodies; ++b) {
    const BodyState& body = s.state.bodies[static_cast<std::size_t>(copy * kBodies) + b];
    for (const double x : {body.p.x, body.p.y, body.p.z, body.q.w, body.q.x, body.q.y, body.q.z, body.v.x, body.v.y,
                           body.v.z, body.w.x, body.w.y, body.w.z})
      numbers.push_back(x);
  }
  const std::size_t joints = kJoints + (loop ? 1 : 0);
  for (std::size_t i = 0; i < joints * kRows; ++i)
    numbers.push_back(s.workspace.multipliers[static_cast<std::size_t>(copy) * joints * kRows + i]);
  return numbers;
}

TEST(Copies, MoveAsEachAloneInEveryModeAndWidth) {
  constexpr int kUsual = 0, kWelded = 1, kFree = 2;
  const Modes all[] = {{kUsual, kUsual, kUsual, kUsual, kUsual},   {kWelded, kUsual, kUsual, kUsual, kUsual},
                       {kUsual, kWelded, kUsual, kWelded, kUsual}, {kUsual, kUsual, kWelded, kUsual, kWelded},
                       {kUsual, kUsual, kUsual, kFree, kFree},     {kFree, kUsual, kUsual, kWelded, kWelded},
                       {kUsual, kWelded, kWelded, kUsual, kFree}};
  for (const InstructionSet set : {InstructionSet::kScalar, InstructionSet::k128, InstructionSet::kAuto}) {
    if (!is_supported(set)) continue;
    for (const bool loop : {false, true})
      for (const Modes& modes : all) {
        std::vector<std::vector<double>> alone;
        constexpr int kMost = 9;
        for (int i = 0; i < kMost; ++i) {
          Simulation s(build(i, 1, modes, loop), {.instruction_set = set});
          for (int tick = 0; tick < kTicks; ++tick) ASSERT_EQ(s.advance().status, StepStatus::kOk);
          alone.push_back(list_numbers(s, 0, loop));
        }
        for (const int count : {2, 3, 4, 7, 8, kMost}) {
          Simulation s(build(0, count, modes, loop), {.instruction_set = set});
          for (int tick = 0; tick < kTicks; ++tick) ASSERT_EQ(s.advance().status, StepStatus::kOk);
          for (int i = 0; i < count; ++i) {
            const std::vector<double> own = list_numbers(s, i, loop);
            ASSERT_EQ(own.size(), alone[at(i)].size());
            double most = 0;
            for (std::size_t k = 0; k < own.size(); ++k) most = std::max(most, std::abs(own[k] - alone[at(i)][k]));
            ASSERT_LE(most, loop ? kRounding : 0.0)
                << "copy " << i << " of " << count << ", loop " << loop << ", modes " << modes[0] << modes[1]
                << modes[2] << modes[3] << modes[4] << ", " << get_name(set);
          }
        }
      }
  }
}

}  // namespace
}  // namespace unlatch::test::copies_test
