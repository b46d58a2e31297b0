// What energy audits ask of a state: the observer's frame, and powers of switches. Against closed forms.
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "tests/support/contact_models.h"
#include "tests/support/modal_model.h"
#include "tests/support/simulation.h"
#include "unlatch/energy.h"
#include "unlatch/readings.h"

namespace unlatch::test::audit_frame_test {
namespace {

constexpr double kRounding = 1e-14;  // relative

AuditFrame calc_frame(Simulation& s) {
  EXPECT_EQ(update_outputs(s.plan, {s.commands}, s.state, s.workspace), StepStatus::kOk);
  return calc_audit_frame(s.plan, s.state, s.workspace);
}
void expect_frame(const Model& model, const Vec3& velocity) {
  Simulation s(model);
  const AuditFrame frame = calc_frame(s);
  EXPECT_FALSE(frame.grounded) << model.name;
  EXPECT_LT(norm(frame.velocity - velocity), kRounding * (1 + norm(velocity))) << model.name;
}
void expect_grounded(const Model& model, bool grounded) {
  Simulation s(model);
  EXPECT_EQ(calc_frame(s).grounded, grounded) << model.name;
}

Model build_two(const std::string& name) {
  Model model;
  model.name = name;
  model.bodies = {box("a", 3, 1, 1, 1), box("b", 2, 1, 1, 1)};
  model.bodies[1].p_WB = {0.5, 0, 0};
  model.bodies[0].v_WB = {1, -2, 0.5};
  model.bodies[1].v_WB = {3, -2, 0.5};
  return model;
}
constexpr Vec3 kOfTwo{(3 * 1 + 2 * 3) / 5.0, -2, 0.5};  // velocity of their centre of mass

TEST(AuditFrame, MovesWithTheCentreOfMassOfWhatNothingHolds) {
  expect_frame(build_two("free"), kOfTwo);
  Model model = build_two("friction");
  Joint slide;
  slide.name = "slide";
  slide.base = 0;
  slide.follower = 1;
  slide.point_base = {0.5, 0, 0};
  slide.modes = {{"slide", static_cast<RowSet>(kWeldRows & ~row_bit(kX))}};
  model.joints = {slide};
  JointFriction friction;
  friction.name = "friction";
  friction.coefficient = 0.3;
  model.frictions = {friction};
  expect_frame(model, kOfTwo);

  model = build_two("spheres");
  model.surfaces = {{"a", 0, {build_sphere(0.25)}}, {"b", 1, {build_sphere(0.25 + 1e-6)}}};
  model.contacts = {touch("a on b", 0, 1, 1e4)};
  add_contact_events(model);
  expect_frame(model, kOfTwo);

  model = build_two("air");
  model.environment = {.planet = Planet{.mu = 0, .j2 = 0}, .atmosphere = Atmosphere{}, .wind = {}, .launch = {}};
  Aerodynamics air{.name = "air", .body = 0, .area = 1, .terms = {}};
  air.terms = {{AeroTerm::Of::kDrag, kNone, 0.5, kNone}};
  model.aerodynamics = {air};
  for (Body& body : model.bodies) body.p_WB.x() += 6400e3;
  expect_frame(model, kOfTwo);

  model = build_two("spring between them");
  PointSpring spring;
  spring.name = "spring";
  spring.base = 0;
  spring.follower = 1;
  spring.stiffness = 10;
  model.point_springs = {spring};
  expect_frame(model, kOfTwo);
}

TEST(AuditFrame, CountsTheMassOfABodyThatBendsOnce) {
  const ModalBody lumped = build_lattice_mast(3, 4, Support::kFree);  // modes without momentum
  Model model;
  model.name = "mast";
  model.bodies = {build_flexible_body("mast", lumped), build_marker("tip", 0, lumped, 15, Eigen::Matrix3Xd::Zero(3, 4)),
                  box("box", 2, 1, 1, 1)};
  const double mass = model.bodies[0].mass;
  model.bodies[0].v_WB = {0, 3, 0};
  model.bodies[0].w_WB_B = {0.1, 0.2, 0.3};  // the tip moves otherwise
  model.bodies[2].p_WB = {9, 0, 0};
  model.bodies[2].v_WB = {6, 0, 1};
  expect_frame(model, {2 * 6 / (mass + 2), mass * 3 / (mass + 2), 2 * 1 / (mass + 2)});
}

TEST(AuditFrame, MovesWithTheCentreOfMassOfABodyWithAMassLawAndNotWithItsOrigin) {
  Model model = build_two("rocket");
  Body& rocket = model.bodies[0];
  const Eigen::Vector3d centre(0, 0.5, 0);
  rocket.law.emplace();
  rocket.law->knots = {{0, rocket.mass, centre, rocket.inertia}, {9, rocket.mass, centre, rocket.inertia}};
  rocket.w_WB_B = {0, 0, 4};
  // ω × r = (−2, 0, 0) m/s
  expect_frame(model, kOfTwo + Vec3{3 * -2.0 / 5, 0, 0});
}

TEST(AuditFrame, RestsWhileTheGroundHoldsABodyByAnElementThatIsOn) {
  for (const bool is_base : {true, false}) {
    Model ball = build_dropped_ball(0);
    if (!is_base) std::swap(ball.contacts[0].base, ball.contacts[0].follower);
    expect_grounded(ball, true);
  }
  Model model = build_two("spring");
  PointSpring spring;
  spring.name = "spring";
  spring.follower = 1;
  spring.stiffness = 10;
  model.point_springs = {spring};
  expect_grounded(model, true);
  model.point_springs[0].on = false;
  expect_grounded(model, false);
  expect_frame(model, kOfTwo);

  // A pusher that ends its stroke: until then the ground holds its body.
  model = build_two("pusher");
  for (Body& body : model.bodies) body.v_WB.setZero();
  OneSided pusher;
  pusher.name = "pusher";
  pusher.kind = OneSided::Kind::kPusher;
  pusher.follower = 1;
  pusher.stroke = 0.01;
  pusher.preload = 200;
  model.one_sided = {pusher};
  Simulation s(model);
  EXPECT_TRUE(calc_frame(s).grounded);
  for (int i = 0; i < 50; ++i) ASSERT_EQ(s.advance().status, StepStatus::kOk);
  const AuditFrame frame = calc_frame(s);
  EXPECT_FALSE(frame.grounded);
  const double speed = std::sqrt(2 * 200 * 0.01 / 2);  // of its work, at the second body
  EXPECT_NEAR(frame.velocity.x, 2 * speed / 5, 1e-7);
  // From another body nothing is held.
  model.one_sided[0].base = 0;
  expect_grounded(model, false);
}

// A spring between resting bodies whose switch runs from 0.2 to 0.8: its power is the scale's rate times ½ k x².
TEST(EnergyFlow, OfASwitchThatRunsIsItsRateTimesWhatTheSpringWouldStore) {
  constexpr double kStiffness = 50, kFree = 0.1, kBegin = 0.0105, kDuration = 0.02;
  Model model;
  model.bodies = {box("a", 1e9, 1e9, 1e9, 1e9), box("b", 1e9, 1e9, 1e9, 1e9)};
  model.bodies[1].p_WB = {0.5, 0, 0};
  PointSpring spring;
  spring.name = "spring";
  spring.base = 0;
  spring.follower = 1;
  spring.stiffness = kStiffness;
  spring.free_length = kFree;
  model.point_springs = {spring};
  Event begin;
  begin.name = "ramp";
  begin.when = when_time(kBegin);
  begin.then.resize(1);
  begin.then[0].kind = Action::Kind::kRamp;
  begin.then[0].value = 0.25;
  begin.then[0].duration = kDuration;
  model.events = {begin};
  const double stored = 0.5 * kStiffness * (0.5 - kFree) * (0.5 - kFree);
  Simulation s(model);
  for (int tick = 1; tick <= 40; ++tick) {
    ASSERT_EQ(s.advance().status, StepStatus::kOk);
    const double part = std::min(1.0, std::max(0.0, (s.get_time() - kBegin) / kDuration));
    const bool runs = part > 0 && part < 1;
    const EnergyFlow flow = calc_energy_flow(s.plan, s.state, s.workspace, {0, 0, 0});
    EXPECT_NEAR(flow.strain, (1 - 0.75 * part) * stored, 1e-9) << tick;
    EXPECT_NEAR(flow.power[static_cast<int>(PowerSource::kSwitching)], runs ? -0.75 / kDuration * stored : 0, 1e-7)
        << tick;
    EXPECT_NEAR(calc_point_spring(s.plan, s.state, 0).force, -(1 - 0.75 * part) * kStiffness * (0.5 - kFree), 1e-7);
  }
}

}  // namespace
}  // namespace unlatch::test::audit_frame_test
