// Frames of flexible bodies. Other properties of frames are tested in report_test.py.
#include "tools/report/frames.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tools/report/structure.h"

namespace unlatch::test {
namespace {

// Two modes without coupling to the body's motion; their masses are 1.
Body build_swinging_body() {
  Body body;
  body.name = "panel";
  body.mass = 10;
  body.inertia = Eigen::Vector3d(1, 2, 2.5).asDiagonal();
  FlexibleBody flexible;
  flexible.frequencies = Eigen::Vector2d(10, 40);
  flexible.damping = Eigen::Vector2d::Zero();
  flexible.momentum = Eigen::Matrix3Xd::Zero(3, 2);
  flexible.first.assign(2, Eigen::Matrix3d::Zero());
  flexible.second.assign(4, Eigen::Matrix3d::Zero());
  flexible.second[0](0, 0) = flexible.second[3](1, 1) = 1;
  flexible.initial = Eigen::Vector2d(0.25, -0.5);
  body.flexible = flexible;
  return body;
}

TEST(Frames, HaveTheModalCoordinatesOfFlexibleBodies) {
  hil::Scenario scenario;
  scenario.dt = 1e-3;
  Body rigid = build_swinging_body();
  rigid.name = "rigid";
  rigid.flexible.reset();
  scenario.model.bodies = {rigid, build_swinging_body()};
  scenario.shapes.resize(2);
  hil::Simulation simulation(scenario.model, {.dt = scenario.dt});
  hil::RunAnalysis analysis(scenario, simulation);
  tools::FrameRecorder frames(scenario, simulation, analysis);
  StepReport report;
  for (int tick = 0; tick < 20; ++tick) {
    analysis.update(report);
    frames.look(report);
    report = simulation.step();
    ASSERT_EQ(report.status, StepStatus::kOk);
  }
  const auto bodies = tools::build_structure(scenario, analysis, frames.get_layout()).at("bodies");
  EXPECT_EQ(bodies[0].at("modal"), 0);
  ASSERT_EQ(bodies[1].at("modal"), 2);
  const auto json = frames.build_json(1'000'000);
  const std::size_t column = bodies[1].at("modal_column");
  EXPECT_EQ(json.at("first").at(column), 0.25);
  EXPECT_EQ(json.at("first").at(column + 1), -0.5);
  EXPECT_EQ(json.at("first").size(), column + 2);
  EXPECT_EQ(json.at("varying"), (std::vector<std::size_t>{column, column + 1})) << "nothing else moves";
  EXPECT_EQ(json.at("count"), 20);
}

}  // namespace
}  // namespace unlatch::test
