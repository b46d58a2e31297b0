// Runs with triangle meshes: their clearances and requirements compared with those of exact shapes.
#include <cmath>

#include "hil/run/findings/findings.h"
#include "hil/scenario/shapes/mesh_file.h"
#include "tests/hil/run/analysed_run.h"
#include "tests/hil/scenario/mesh_support.h"

namespace unlatch::test::mesh_run_test {
namespace {

constexpr double kExact = 1e-9;    // m, shapes of some metres
constexpr double kLocated = 1e-6;  // s

std::string hold(const std::string& name, const Facets& facets) {
  return "--- # included: " + name + "\n" + hil::write_mesh_text(hil::read_mesh(write_binary_stl(facets), name));
}

// Builds a box that tumbles past a cylinder; `box`: its shape. Edge lengths of 0.5, 1 and 1.5 m are exact in single
// precision.
std::string build_passing(const std::string& box, const std::string& rest = "") {
  return R"(unlatch: 1
name: passing
step: {dt: 1 ms, until: 2}
bodies:
  still: {mass: 1, inertia: [1, 1, 1], shape: [{cylinder: {from: [-2, 0, 0], to: [2, 0, 0], radius: 0.5}}]}
  moving: {mass: 1, inertia: [1, 2, 2.5], position: [-5, 1.7, 0.3], velocity: [5, 0, 0.1], rate: [0.5, 3, 2], shape: [)" +
         box + R"(]}
events: [{name: gone, when: {time: 1.5}}]
clearance: all
requirements:
  - {id: near, text: It passes, clearance: [still, moving], at_least: 10 cm}
  - {id: far, text: It stays away, clearance: [still, moving], at_least: 2 m}
  - {id: late, text: It is gone, clearance: [still, moving], from: gone, at_least: 10 cm}
)" + rest;
}
const std::string kExactBox = "{box: {size: [0.5, 1, 1.5]}}",
                  kMeshBox = "{name: part, mesh: {file: box.stl, scale: 1 mm}}";

std::string build_mesh_passing() { return build_passing(kMeshBox, hold("box.stl", build_box_facets({250, 500, 750}))); }

TEST(MeshRun, ARequirementOnAMeshIsJudgedAsOnTheSameShape) {
  const AnalysedRun exact(build_passing(kExactBox)), mesh(build_mesh_passing());
  const hil::Clearance &of_exact = exact.analysis.clearances().at(0), &of_mesh = mesh.analysis.clearances().at(0);
  EXPECT_EQ(of_exact.method, hil::DistanceMethod::kExact);
  EXPECT_EQ(of_mesh.method, hil::DistanceMethod::kMesh);
  EXPECT_GT(of_exact.smallest, 0.1);
  EXPECT_NEAR(of_mesh.smallest, of_exact.smallest, kExact);
  EXPECT_NEAR(of_mesh.time, of_exact.time, 1e-4);
  for (const char* id : {"near", "far", "late"}) {
    const hil::Verdict of_shape = exact.judge(id), verdict = mesh.judge(id);
    EXPECT_TRUE(verdict.evaluated);
    EXPECT_EQ(verdict.is_met(), of_shape.is_met()) << id;
    EXPECT_NEAR(verdict.value, of_shape.value, kExact) << id;
  }
  EXPECT_TRUE(mesh.judge("near").is_met());
  EXPECT_FALSE(mesh.judge("far").is_met());
}

// A ball of facets falls through a plate of facets: it has no depth, but the instant of the touch.
TEST(MeshRun, MeshesThatCrossTouchAtTheirInstantAndHaveNoDepth) {
  const std::string text = R"(unlatch: 1
name: crossing
step: {dt: 1 ms, until: 1}
bodies:
  plate: {mass: 1, inertia: [1, 1, 1], shape: [{mesh: {file: plate.stl}}]}
  block: {mass: 1, inertia: [1, 1, 1], position: [0, 0, 1.0003], velocity: [0, 0, -1], shape: [{mesh: {file: block.stl}}]}
clearance: all
requirements:
  - {id: apart, text: They stay apart, clearance: [plate, block], at_least: 1 mm}
)" + hold("plate.stl", build_box_facets({2, 2, 0.25})) +
                           hold("block.stl", build_box_facets({0.5, 0.5, 0.25}));
  const AnalysedRun run(text);
  const hil::Clearance& clearance = run.analysis.clearances().at(0);
  EXPECT_EQ(clearance.smallest, 0);
  ASSERT_TRUE(clearance.touch.has_value());
  EXPECT_NEAR(*clearance.touch, 0.5003, kLocated);
  EXPECT_FALSE(run.judge("apart").is_met());
  EXPECT_EQ(run.judge("apart").value, 0);
}

// A ball flies through a hollow box of facets within one step of 20 ms: it touches the near wall, is inside, where no
// triangle is near, and touches the far wall.
TEST(MeshRun, AMeshThatIsPassedWithinAStepIsTouchedAtItsFirstWall) {
  for (const double gap : {0.2, 0.50003, 0.7, 1.1, 1.3}) {
    const std::string text = R"(unlatch: 1
name: passing
step: {dt: 20 ms, until: 0.1}
bodies:
  house: {mass: 1, inertia: [1, 1, 1], shape: [{mesh: {file: house.stl}}]}
  ball: {mass: 1, inertia: [1, 1, 1], position: [0.01, 0.02, )" +
                             std::to_string(0.25 + 0.0625 + gap) + R"(], velocity: [0, 0, -100], shape: [SHAPE]}
clearance: all
)" + hold("house.stl", build_box_facets({0.5, 0.5, 0.25})) +
                             hold("ball.stl", build_box_facets({0.03125, 0.03125, 0.0625}));
    for (const char* const shape : {"{sphere: {radius: 0.0625}}", "{mesh: {file: ball.stl}}"}) {
      std::string own = text;
      own.replace(own.find("SHAPE"), 5, shape);
      const AnalysedRun run(own);
      const hil::Clearance& clearance = run.analysis.clearances().at(0);
      EXPECT_EQ(clearance.smallest, 0) << gap << " " << shape;
      ASSERT_TRUE(clearance.touch.has_value()) << gap << " " << shape;
      EXPECT_NEAR(*clearance.touch, gap / 100, kLocated) << gap << " " << shape;
    }
  }
}

TEST(MeshRun, PiecesThatAreSkippedChangeNoBit) {
  const hil::Scenario scenario = hil::load_scenario_text(build_mesh_passing(), "run.yaml");
  const auto simulation = hil::build_simulation(scenario);
  simulation->keep_motion();
  hil::ClearanceHistory some(scenario), all(scenario, hil::Skipping::kOff);
  hil::MotionWindow window;
  some.begin(0, simulation->state().bodies);
  all.begin(0, simulation->state().bodies);
  for (int tick = 0; tick < 2000; ++tick) {
    ASSERT_EQ(simulation->step().status, StepStatus::kOk);
    const std::span<const MotionKnot> knots = simulation->get_motion();
    window.move_on(knots[0], knots[1]);
    some.add(window);
    all.add(window);
  }
  EXPECT_EQ(some.get()[0].smallest, all.get()[0].smallest);
  EXPECT_EQ(some.get()[0].time, all.get()[0].time);
  EXPECT_EQ(some.get()[0].now, all.get()[0].now);
}

TEST(MeshRun, MeshesThatCrossAtTheStartAreReportedWithoutADepth) {
  const std::string text = R"(unlatch: 1
name: crossing
step: {dt: 1 ms, until: 1}
bodies:
  plate: {mass: 1, inertia: [1, 1, 1], shape: [{mesh: {file: plate.stl}}]}
  ball: {mass: 1, inertia: [1, 1, 1], position: [0, 0, 0.5], shape: [{sphere: {radius: 0.3}}]}
clearance: all
)" + hold("plate.stl", build_box_facets({2, 2, 0.25}));
  const hil::Scenario scenario = hil::load_scenario_text(text, "run.yaml");
  bool found = false;
  for (const hil::Finding& finding : hil::list_findings(scenario, *hil::build_simulation(scenario)))
    found = found || (finding.name == "overlap" && finding.text.find("touches or crosses plate") != std::string::npos &&
                      finding.text.find("triangles have no depth") != std::string::npos);
  EXPECT_TRUE(found);
}

}  // namespace
}  // namespace unlatch::test::mesh_run_test
