// Laws: the same bits side by side and in every width; the hash of a model has all of them.
#include <gtest/gtest.h>

#include <memory>
#include <optional>
#include <vector>

#include "tests/support/law_models.h"
#include "tests/support/simulation.h"
#include "unlatch/bundle.h"

namespace unlatch::test {
namespace {

using namespace laws;

Model build_scaled(double scale, double edge, TableAxis::End end) {
  Model model = build_pushed({quantity(0), step_of(Kind::kTable, 0), step_of(Kind::kCommand, 0), step_of(Kind::kAdd)});
  model.tables.push_back(table_of({{-1, 0, 0.3, edge}}, [](const auto& at) { return 3 - at[0] * at[0]; }));
  model.tables[0].interpolation = Table::Interpolation::kSmooth;
  model.tables[0].scale = scale;
  model.tables[0].axes[0].above = end;
  model.channels.push_back({"bias", 0.5, -1, 1, 0, "N"});
  model.quantities.push_back({});
  model.quantities[1].kind = Quantity::Kind::kLaw;
  model.quantities[1].name = "force";
  return model;
}

// Runs of these models alone and side by side.
struct Pairs {
  explicit Pairs(const std::vector<Model>& models) : runs(models.size()) {
    std::vector<const Model*> all;
    std::vector<const Plan*> plans;
    for (const Model& model : models) {
      alone.push_back(std::make_unique<Simulation>(model));
      beside.push_back(std::make_unique<Simulation>(model));
      all.push_back(&model);
      plans.push_back(&beside.back()->plan);
    }
    bundle = Bundle::build(all, plans);
    for (std::size_t m = 0; m < runs.size(); ++m) {
      runs[m].plan = &beside[m]->plan;
      runs[m].inputs = {beside[m]->commands};
      runs[m].state = &beside[m]->state;
      runs[m].workspace = &beside[m]->workspace;
    }
  }
  // A step of those that go on; use(m, the report alone, that beside the others).
  void step(const auto& use) {
    for (BundleRun& run : runs) run.goes_on = run.report.status == StepStatus::kOk;
    bundle->step(runs);
    for (std::size_t m = 0; m < runs.size(); ++m)
      if (runs[m].goes_on) use(m, alone[m]->advance(), runs[m].report);
  }

  std::vector<std::unique_ptr<Simulation>> alone, beside;
  std::optional<Bundle> bundle;
  std::vector<BundleRun> runs;
};

TEST(Laws, HaveTheirBitsSideBySideToo) {
  std::vector<Model> models;
  for (int i = 0; i < 5; ++i) models.push_back(build_scaled(1 + 0.1 * i, 0.9 - 0.1 * (i == 3), TableAxis::End::kError));
  Pairs pairs(models);
  ASSERT_TRUE(pairs.bundle);
  bool left = false;
  for (int tick = 0; tick < 1100; ++tick)
    pairs.step([&](std::size_t m, const StepReport& report, const StepReport& beside) {
      ASSERT_EQ(report.status, beside.status) << m << " " << tick;
      left = left || report.status == StepStatus::kOutsideTable;
      if (report.status != StepStatus::kOk) return;
      const Simulation &a = *pairs.alone[m], &b = *pairs.beside[m];
      ASSERT_EQ(a.state.bodies[0].p.x, b.state.bodies[0].p.x) << m << " " << tick;
      ASSERT_EQ(a.workspace.laws[0], b.workspace.laws[0]);
      ASSERT_EQ(a.workspace.quantities[1], b.workspace.quantities[1]);
    });
  EXPECT_TRUE(left);
}

// Members whose steps are split at points of their tables over time take these steps alone.
TEST(Laws, TablesOverTimeHaveTheirBitsSideBySideToo) {
  std::vector<Model> models;
  for (int i = 0; i < 5; ++i) {
    Model& model = models.emplace_back(build_pushed({constant(1)}));
    Profile& profile = model.loads[0].profile = {};
    profile.kind = Profile::Kind::kTable;
    profile.times = {0, 0.0123 + 0.01 * i, 0.0321 + 0.01 * i};
    profile.values = {1, 9, 2};
  }
  Pairs pairs(models);
  ASSERT_TRUE(pairs.bundle);
  int splits = 0;
  for (int tick = 0; tick < 100; ++tick)
    pairs.step([&](std::size_t m, const StepReport& report, const StepReport& beside) {
      ASSERT_EQ(report.status, StepStatus::kOk);
      splits += report.substeps > 1 ? 1 : 0;
      ASSERT_EQ(report.substeps, beside.substeps) << m << " " << tick;
      const BodyState &a = pairs.alone[m]->state.bodies[0], &b = pairs.beside[m]->state.bodies[0];
      ASSERT_EQ(a.p.x, b.p.x) << m << " " << tick;
      ASSERT_EQ(a.v.x, b.v.x) << m << " " << tick;
    });
  EXPECT_EQ(splits, 10);
}

// Likewise where a body whose air a law reads passes a row of the wind. Two laws read it, and a table stands behind
// them.
TEST(Laws, OfTheAirHaveTheirBitsSideBySideToo) {
  std::vector<Model> models;
  for (int i = 0; i < 4; ++i) {
    Model model = build_pushed({quantity(1), constant(-1e-4), step_of(Kind::kMultiply), quantity(2), quantity(2),
                                step_of(Kind::kMultiply), step_of(Kind::kMultiply)});
    for (const Quantity::Kind kind : {Quantity::Kind::kDensity, Quantity::Kind::kAirspeed}) {
      model.quantities.push_back(along_x(kind, kind == Quantity::Kind::kDensity ? "density" : "speed"));
    }
    model.laws.push_back(law_of({quantity(2), step_of(Kind::kTable, 0)}, "other"));
    model.tables.push_back(table_of({{0, 1000}}, [](const auto& at) { return 0.001 * at[0]; }));
    model.loads.push_back(load_by(1));
    model.loads.back().name = "other";
    model.environment = {.planet = Planet{}, .atmosphere = Atmosphere{}, .wind = Wind{}, .launch = {}};
    model.environment.wind = {.altitudes = {9e3, 9.9e3, 10.1e3}, .velocities = {{0, 0, 0}, {20, 0, 0}, {-10, 0, 0}}};
    Start start;
    start.body = 0;
    start.altitude = 10e3;
    start.velocity = {100, 0, 300};
    start.origin = Start::Origin::kStart;
    models.push_back(place_start(model, start));
    models.back().bodies[0].v_WB *= 1 + 0.01 * i;
  }
  Pairs pairs(models);
  ASSERT_TRUE(pairs.bundle);
  int splits = 0;
  for (int tick = 0; tick < 500; ++tick)
    pairs.step([&](std::size_t m, const StepReport& report, const StepReport& beside) {
      ASSERT_EQ(report.status, StepStatus::kOk);
      splits += report.substeps > 1 ? 1 : 0;
      ASSERT_EQ(report.substeps, beside.substeps) << m << " " << tick;
      const BodyState &a = pairs.alone[m]->state.bodies[0], &b = pairs.beside[m]->state.bodies[0];
      ASSERT_EQ(norm(a.p - b.p) + norm(a.v - b.v), 0) << m << " " << tick;
    });
  EXPECT_EQ(splits, 4);
}

TEST(Laws, HaveTheSameBitsInEveryWidth) {
  std::vector<double> places;
  for (const InstructionSet set :
       {InstructionSet::kScalar, InstructionSet::k128, InstructionSet::k256, InstructionSet::k512}) {
    if (!is_supported(set)) continue;
    Simulation s(build_scaled(1.3, 5, TableAxis::End::kError), {.instruction_set = set});
    for (int i = 0; i < 700; ++i) ASSERT_EQ(s.advance().status, StepStatus::kOk);
    places.push_back(s.state.bodies[0].p.x);
    EXPECT_EQ(places.back(), places.front());
  }
}

TEST(Laws, ChangeTheHashOfTheirModel) {
  const Model model = build_scaled(1.3, 5, TableAxis::End::kError);
  const auto hash = [](const Model& m) { return compile_or_throw(m, {}).get_hash(); };
  const auto expect_other = [&](const auto& change) {
    Model other = model;
    change(other);
    EXPECT_NE(hash(other), hash(model));
  };
  expect_other([](Model& m) { m.tables[0].values[1] += 1e-9; });
  expect_other([](Model& m) { m.tables[0].axes[0].knots[1] += 1e-9; });
  expect_other([](Model& m) { m.tables[0].axes[0].above = TableAxis::End::kClamp; });
  expect_other([](Model& m) { m.tables[0].interpolation = Table::Interpolation::kLinear; });
  expect_other([](Model& m) { m.tables[0].scale = 1; });
  expect_other([](Model& m) { m.tables[0].offset = 1; });
  expect_other([](Model& m) { m.tables[0].scale_channel = 0; });
  expect_other([](Model& m) { m.laws[0].offset_channel = 0; });
  expect_other([](Model& m) { m.laws[0].scale = 2; });
  expect_other([](Model& m) { m.laws[0].steps.back().kind = Kind::kSubtract; });
}

}  // namespace
}  // namespace unlatch::test
