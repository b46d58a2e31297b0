// Contacts where their two sides, their laws and their neighbours are of every kind: implicit parts between two bodies,
// scenes that are turned, rigid pairs with and without friction in one blow, pairs without a row.
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "kernel/elements/kinds/contact/contact_parts.h"
#include "kernel/integration/contact_stages.h"
#include "tests/support/rigid_models.h"
#include "tests/support/simulation.h"
#include "unlatch/contacts.h"
#include "unlatch/energy.h"

namespace unlatch::test::contact_kinds_test {
namespace {

// A block that is pressed onto a heavy table, both free: it sticks while a force along the table pulls at it.
Model build_pressed(bool table_is_base, double exponent) {
  Model model;
  model.name = "pressed";
  model.bodies = {box("table", 8, 0.5, 0.6, 0.9), box("block", 2, 0.02, 0.02, 0.03)};
  model.bodies[1].p_WB = {0.0625, 0.03125, 0.0625 - 5e-5};
  geometry::Shape top;
  top.kind = geometry::ShapeKind::kBox;
  top.from = {0, 0, -0.25};
  top.size = {2, 2, 0.5};
  Surface feet{"feet", 1, {}};
  for (const double x : {-0.125, 0.125})
    for (const double y : {-0.125, 0.125}) feet.shapes.push_back(build_sphere(0.03125, {x, y, -0.03125}));
  model.surfaces = {{"top", 0, {top}}, feet};
  model.contacts = {touch("feet on top", table_is_base ? 0 : 1, table_is_base ? 1 : 0, exponent == 1 ? 2e5 : 3e7)};
  Contact& contact = model.contacts[0];
  contact.exponent = exponent;
  contact.damping = 5;
  contact.friction = 0.6;
  contact.slip_speed = 1e-2;
  for (const double z : {-40.0, 3.0}) {  // presses, pulls
    Load load;
    load.name = z < 0 ? "press" : "pull";
    load.body = 1;
    load.frame = Load::Frame::kWorld;
    load.direction = z < 0 ? Eigen::Vector3d(0, 0, z) : Eigen::Vector3d(z, 1, 0);
    model.loads.push_back(load);
  }
  add_contact_events(model);
  return model;
}

std::vector<double> list_numbers(const State& state) {
  std::vector<double> numbers;
  for (const BodyState& b : state.bodies)
    for (const double x : {b.p.x, b.p.y, b.p.z, b.q.w, b.q.x, b.q.y, b.q.z, b.v.x, b.v.y, b.v.z, b.w.x, b.w.y, b.w.z})
      numbers.push_back(x);
  return numbers;
}

// The motion after `duration` in `count` sub-steps of one kind.
std::vector<double> integrate_by(Simulation& s, double duration, int count, Contacts kind) {
  Evaluation& ev = s.evaluation();
  const Inputs inputs{s.commands};
  const auto get_instant = [&](double t) { return Instant{s.data(), inputs, s.state, t}; };
  EXPECT_EQ(evaluate(get_instant(0), Changed::kState, ev), kNone);
  for (int i = 0; i < count; ++i) {
    const double begin = duration * i / count, end = duration * (i + 1) / count;
    const SubstepStart start = begin_substep(get_instant(begin), kind, ev);
    EXPECT_EQ(integrate(get_instant(end), start, end, ev), kNone);
    EXPECT_EQ(evaluate(get_instant(end), Changed::kVelocities, ev), kNone);
    store_substep(s.data(), ev, s.state);
  }
  return list_numbers(s.state);
}

double calc_distance(const std::vector<double>& a, const std::vector<double>& b) {
  double most = 0;
  for (std::size_t i = 0; i < a.size(); ++i) most = std::max(most, std::abs(a[i] - b[i]));
  return most;
}

TEST(ContactKinds, BetweenTwoBodiesImplicitPartsAreOfOrderThreeWhicheverIsTheBase) {
  constexpr double kDuration = 0.02;  // s
  for (const double exponent : {1.0, 1.5})
    for (const bool table_is_base : {true, false}) {
      const Model model = build_pressed(table_is_base, exponent);
      const auto fly = [&](int count, Contacts kind) {
        Simulation s(model);
        return integrate_by(s, kDuration, count, kind);
      };
      const std::vector<double> reference = fly(4096, Contacts::kExplicit);
      double before = 0;
      for (const int count : {64, 128, 256}) {
        const double error = calc_distance(fly(count, Contacts::kImplicit), reference);
        if (before > 0) {
          EXPECT_NEAR(std::log2(before / error), 3, 0.4) << count << " sub-steps, error " << error;
        }
        before = error;
      }
      EXPECT_LT(before, 1e-6);
    }
}

TEST(ContactKinds, BetweenTwoBodiesImplicitPartsKeepWhatTheForcesFromOutsideGive) {
  constexpr double kDuration = 0.02;  // s
  for (const bool table_is_base : {true, false}) {
    const Model model = build_pressed(table_is_base, 1);
    Simulation s(model);
    (void)integrate_by(s, kDuration, 8, Contacts::kImplicit);
    const Vec3 momentum = 8.0 * s.state.bodies[0].v + 2.0 * s.state.bodies[1].v;
    const Vec3 given = kDuration * Vec3{3, 1, -40};
    EXPECT_LT(norm(momentum - given), 1e-13);
    EXPECT_GT(norm(s.state.bodies[0].v), 0.05) << "the table is pushed";
  }
}

// The same scene with its axes exchanged: whichever axis a normal lies along, no direction is special.
TEST(ContactKinds, ASceneThatIsTurnedMovesLikewise) {
  for (const double exponent : {1.0, 1.5})
    for (const bool sticks : {true, false}) {
      const auto build = [&](const Eigen::Quaterniond& turn) {
        Model model = build_pressed(true, exponent);
        for (Body& body : model.bodies) {
          body.p_WB = turn * body.p_WB;
          body.q_WB = turn * Eigen::Quaterniond(body.q_WB);
          if (!sticks && body.name == "block") body.v_WB = turn * Eigen::Vector3d(0.5, 0.25, 0);
        }
        for (Load& load : model.loads) load.direction = turn * load.direction;
        return model;
      };
      Simulation plain(build(Eigen::Quaterniond::Identity()));
      int substeps = 0;
      for (int i = 0; i < 40; ++i) {
        const StepReport report = plain.advance();
        ASSERT_EQ(report.status, StepStatus::kOk);
        substeps += report.substeps;
      }
      for (const Eigen::Quaterniond& turn :
           {Eigen::Quaterniond(Eigen::AngleAxisd(std::acos(-1.0) / 2, Eigen::Vector3d::UnitY())),
            Eigen::Quaterniond(Eigen::AngleAxisd(std::acos(-1.0) / 2, Eigen::Vector3d::UnitX())),
            Eigen::Quaterniond(Eigen::AngleAxisd(2, Eigen::Vector3d(1, 2, -1).normalized()))}) {
        Simulation turned(build(turn));
        int own = 0;
        for (int i = 0; i < 40; ++i) {
          const StepReport report = turned.advance();
          ASSERT_EQ(report.status, StepStatus::kOk);
          own += report.substeps;
        }
        EXPECT_NEAR(own, substeps, 0.1 * substeps);
        for (std::size_t b = 0; b < 2; ++b) {
          const auto to_eigen = [](const Vec3& v) { return Eigen::Vector3d(v.x, v.y, v.z); };
          const BodyState &a = plain.state.bodies[b], &c = turned.state.bodies[b];
          constexpr double kOfParts = 1e-7;  // m, m/s: numbers of parts depend on rounding
          EXPECT_LT((turn * to_eigen(a.p) - to_eigen(c.p)).norm(), kOfParts);
          EXPECT_LT((turn * to_eigen(a.v) - to_eigen(c.v)).norm(), 100 * kOfParts);
        }
      }
    }
}

TEST(ContactKinds, ImplicitPartsAreOfFewRigidBodiesWithoutStiffSpringsOrRigidContacts) {
  const auto may = [](const Model& model) {
    const Plan plan = compile_or_throw(model, {});
    return may_be_implicit(get_data(plan));
  };
  const Model model = build_block_on_feet();
  EXPECT_TRUE(may(model));
  Model other = model;
  other.contact_substeps = 4;
  EXPECT_FALSE(may(other)) << "a number of parts is given";
  other = model;
  other.contacts.clear();
  other.events.clear();
  EXPECT_FALSE(may(other)) << "no contact";
  other = model;
  other.bodies[0].law = MassLaw{};
  other.bodies[0].law->knots = {{0, 2, {0, 0, 0}, other.bodies[0].inertia}, {1, 1, {0, 0, 0}, other.bodies[0].inertia}};
  EXPECT_FALSE(may(other)) << "a mass varies";
  other = model;
  for (int i = 1; i < 17; ++i) {
    other.bodies.push_back(box("free" + std::to_string(i), 1, 1, 1, 1));
    other.bodies.back().p_WB = {5.0 * i, 0, 5};
    EXPECT_EQ(may(other), i < 16) << i;
  }
  other = model;
  other.bodies.push_back(box("wheel", 1, 1, 1, 1));
  other.bodies[1].p_WB = {5, 0, 5};
  Joint hinge;
  hinge.name = "hinge";
  hinge.follower = 1;
  hinge.point_base = {5, 0, 5};
  hinge.modes = {{"hinge", kRevoluteRows}};
  other.joints = {hinge};
  EXPECT_TRUE(may(other));
  JointSpring spring;
  spring.name = "spring";
  spring.stiffness = 1e8;
  spring.implicit = true;
  other.joint_springs = {spring};
  EXPECT_FALSE(may(other)) << "a spring is implicit";
  EXPECT_FALSE(may(build_rigid_feet())) << "a contact is rigid";
  // Each contact has auxiliary states of its own.
  other = model;
  bool ended = false;
  for (int i = 1; i < 40 && !ended; ++i) {
    other.surfaces.push_back({"far" + std::to_string(i), 0, {build_sphere(0.01, {0, 0, 0.02})}});
    other.contacts.push_back(touch("contact" + std::to_string(i), 0, i + 1, 1e4));
    ended = !may(other);
  }
  EXPECT_TRUE(ended) << "contacts without end";
}

// A ball that hits a rough floor and a smooth wall at one instant: the wall bears what friction pushes against it.
TEST(ContactKinds, ABlowOfARoughAndASmoothPairHasTheImpulsesOfTheClosedForm) {
  constexpr double kRadius = 0.125, kInertia = 0.4 * kRadius * kRadius, kFriction = 0.25, kSpin = 64, kWay = 0.015625;
  for (const double restitution : {0.0, 0.5})
    for (const bool wall_first : {true, false}) {
      Model model;
      model.name = "corner";
      model.bodies = {box("ball", 1, kInertia, kInertia, kInertia)};
      model.bodies[0].p_WB = {-kRadius - kWay, 0, kRadius + kWay};
      model.bodies[0].v_WB = {1, 0, -1};
      model.bodies[0].w_WB_B = {0, -kSpin, 0};  // its lowest point moves towards +x: friction drives it from the wall
      geometry::Shape wall = build_floor();
      wall.normal = {-1, 0, 0};
      model.surfaces = {
          {"floor", kGround, {build_floor()}}, {"wall", kGround, {wall}}, {"ball", 0, {build_sphere(kRadius)}}};
      Contact rough = touch_rigidly("ball on floor", 0, 2, restitution),
              smooth = touch_rigidly("ball on wall", 1, 2, restitution);
      rough.friction = kFriction;
      model.contacts = wall_first ? std::vector<Contact>{smooth, rough} : std::vector<Contact>{rough, smooth};
      add_contact_events(model);
      Simulation s(model);
      for (int i = 0; i < 16; ++i) ASSERT_EQ(s.advance().status, StepStatus::kOk);
      const double floor = 1 + restitution, side = kFriction * floor;
      EXPECT_NEAR(get_contact_totals(s.plan, s.state, wall_first ? 1 : 0).impulse, floor, 1e-12);
      // Friction acts along −x: the wall has that much less to turn round.
      EXPECT_NEAR(get_contact_totals(s.plan, s.state, wall_first ? 0 : 1).impulse, floor - side, 1e-12);
      EXPECT_NEAR(s.state.bodies[0].v.x, -restitution, 1e-12);
      EXPECT_NEAR(s.state.bodies[0].v.z, restitution, 1e-12);
      EXPECT_NEAR(s.state.bodies[0].w.y, -kSpin + side * kRadius / kInertia, 1e-10);
    }
}

// A blow is the same whichever side of the contact the ground is.
TEST(ContactKinds, ABlowOnTheGroundIsTheSameWhicheverSideItIs) {
  for (const double friction : {0.0, 0.3}) {
    BodyState states[2];
    ContactTotals totals[2];
    for (const bool ground_is_base : {true, false}) {
      Model model = build_rigid_feet();
      model.contacts[0].restitution = 0.5;
      model.contacts[0].friction = friction;
      if (!ground_is_base) std::swap(model.contacts[0].base, model.contacts[0].follower);
      model.bodies[0].p_WB.z() += 0.01;
      model.bodies[0].v_WB = {0.5, 0.25, -1};
      model.bodies[0].w_WB_B = {0.3, -0.2, 0.1};
      Simulation s(model);
      for (int i = 0; i < 40; ++i) ASSERT_EQ(s.advance().status, StepStatus::kOk);
      states[ground_is_base] = s.state.bodies[0];
      totals[ground_is_base] = get_contact_totals(s.plan, s.state, 0);
    }
    EXPECT_GT(totals[0].impulse, 1);
    EXPECT_NEAR(totals[0].impulse, totals[1].impulse, 1e-10);
    EXPECT_NEAR(totals[0].dissipated, totals[1].dissipated, 1e-10);
    EXPECT_LT(norm(states[0].p - states[1].p), 1e-11);
    EXPECT_LT(norm(states[0].v - states[1].v), 1e-9);
    EXPECT_LT(norm(states[0].w - states[1].w), 1e-9);
  }
}

// A stiff contact of one body and rigid ones of another in one model: both move as each does by itself.
TEST(ContactKinds, StiffAndRigidOnesBesideEachOtherMoveAsEachAlone) {
  for (const double friction : {0.0, 0.4}) {
    Model rigid = build_rigid_feet();
    rigid.contacts[0].friction = friction;
    rigid.contacts[0].restitution = 0.3;
    rigid.bodies[0].p_WB.z() += 0.01;
    rigid.bodies[0].v_WB = {0.5, 0.25, 0};
    const Model stiff = build_dropped_ball(0.02);
    Model both = rigid;
    both.bodies.push_back(stiff.bodies[0]);
    both.bodies[1].p_WB.x() += 5;
    Surface ball = stiff.surfaces[1];
    ball.body = 1;
    both.surfaces.push_back(ball);
    both.contacts.insert(both.contacts.begin(), stiff.contacts[0]);  // the stiff one comes first
    both.contacts[0].follower = 2;
    both.events.clear();
    add_contact_events(both);
    Simulation a(rigid), b(stiff), c(both);
    for (int i = 0; i < 300; ++i)
      for (Simulation* s : {&a, &b, &c}) ASSERT_EQ(s->advance().status, StepStatus::kOk) << i;
    constexpr double kOfParts = 1e-6;  // m, m/s: the stiff contact cuts the steps of the other body too
    EXPECT_LT(norm(c.state.bodies[0].p - a.state.bodies[0].p), kOfParts);
    EXPECT_LT(norm(c.state.bodies[0].v - a.state.bodies[0].v), kOfParts);
    EXPECT_LT(norm(c.state.bodies[1].p - (b.state.bodies[0].p + Vec3{5, 0, 0})), kOfParts);
    EXPECT_LT(norm(c.state.bodies[1].v - b.state.bodies[0].v), 100 * kOfParts);
    EXPECT_NEAR(get_contact_totals(c.plan, c.state, 1).impulse, get_contact_totals(a.plan, a.state, 0).impulse, 1e-5);
    EXPECT_NEAR(get_contact_totals(c.plan, c.state, 0).impulse, get_contact_totals(b.plan, b.state, 0).impulse, 1e-4);
  }
}

// A block that falls flat on four rough feet and against a smooth wall at one instant, sliding along the wall: the feet
// bear what falls, the wall what comes towards it, and friction takes its part of the rest.
TEST(ContactKinds, AFlatFallOnRoughFeetAgainstASmoothWallHasTheImpulsesOfTheClosedForm) {
  constexpr double kFriction = 0.25, kWay = 0.015625, kMass = 2;
  for (const double along : {0.75, -2.0}) {
    Model model = build_rigid_feet();
    model.gravity.uniform.setZero();
    model.contacts[0].friction = kFriction;
    model.bodies[0].p_WB.z() += kWay;
    model.bodies[0].v_WB = {1, along, -1};
    geometry::Shape wall = build_floor();
    wall.normal = {-1, 0, 0};
    wall.from = {0.5 + kWay, 0, 0};
    Surface bumpers{"bumpers", 0, {}};
    for (const double y : {-0.125, 0.125}) bumpers.shapes.push_back(build_sphere(0.125, {0.375, y, 0}));
    model.surfaces.push_back({"wall", kGround, {wall}});
    model.surfaces.push_back(bumpers);
    model.contacts.push_back(touch_rigidly("bumpers on wall", 2, 3));
    model.events.clear();
    add_contact_events(model);
    Simulation s(model);
    for (int i = 0; i < 16; ++i) ASSERT_EQ(s.advance().status, StepStatus::kOk);
    EXPECT_NEAR(get_contact_totals(s.plan, s.state, 0).impulse, kMass, 1e-9);
    EXPECT_NEAR(get_contact_totals(s.plan, s.state, 1).impulse, kMass, 1e-9);
    const Vec3 left{0, along - std::copysign(kFriction, along), 0};
    EXPECT_LT(norm(s.state.bodies[0].v - left), 1e-9);
    EXPECT_LT(norm(s.state.bodies[0].w), 1e-8);
  }
}

TEST(ContactKinds, ParallelCapsulesThatLieOnEachOtherAtTheStartHaveNoRowEither) {
  Model model;
  model.gravity.uniform = {0, 0, -kGravity};
  model.bodies = {box("rod", 1, 1e-3, 0.1, 0.1)};
  model.bodies[0].p_WB = {0, 0, 0.25};
  geometry::Shape peg = build_sphere(0.125, {-1, 0, 0});
  peg.kind = geometry::ShapeKind::kCapsule;
  peg.to = {1, 0, 0};
  model.surfaces = {{"peg", kGround, {peg}}, {"rod", 0, {peg}}};
  model.contacts = {touch_rigidly("rod on peg", 0, 1)};
  add_contact_events(model);
  Simulation s(model);
  const StepReport report = s.advance();
  EXPECT_EQ(report.status, StepStatus::kRigidContact);
  EXPECT_TRUE(report.degenerate);
  EXPECT_EQ(report.contact, 0);
}

// A force from outside that turns over: what a contact's switch leaves of it counts, none of one that is off.
TEST(ContactKinds, OneThatIsSwitchedOffHoldsNothing) {
  for (const bool rigid : {true, false}) {
    Model model = rigid ? build_rigid_feet() : build_block_on_feet();
    Event off;
    off.name = "off";
    off.when = when_time(0.0105);
    off.then.push_back({});
    off.then[0].kind = Action::Kind::kSwitch;
    off.then[0].subject = 0;
    model.events.push_back(off);
    Simulation s(model);
    const double start = model.bodies[0].p_WB.z();
    for (int i = 0; i < 110; ++i) ASSERT_EQ(s.advance().status, StepStatus::kOk) << i;
    const double fallen = 0.5 * kGravity * (0.11 - 0.0105) * (0.11 - 0.0105);
    EXPECT_NEAR(s.state.bodies[0].p.z, start - fallen, rigid ? 1e-10 : 2e-3);
    const ContactReading reading = calc_contact(s.plan, s.state, 0);
    EXPECT_EQ(reading.normal, 0);
    EXPECT_EQ(norm(reading.force), 0);
  }
}

}  // namespace
}  // namespace unlatch::test::contact_kinds_test
