// Laws: what a quantity, an expression and a table cost in a step.
//   table/<linear|smooth>/<axes>    one lookup; three axes of 47 knots are 1e5 entries, six of 7 are 1.2e5. Coordinates
//                                   move from call to call
//   expression/<operations>         one law of so many operations over constants and one quantity
//   quantity/<kind>                 one quantity of two bodies
#include <benchmark/benchmark.h>

#include <array>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "bench/least.h"
#include "kernel/laws/laws.h"
#include "kernel/laws/tables.h"
#include "kernel/quantities/quantities.h"
#include "tests/support/simulation.h"
#include "tests/support/small_models.h"

namespace unlatch::bench {
namespace {

Model build_pair() {
  Model model;
  model.bodies = {test::box("a", 3, 1.0, 1.2, 1.5), test::box("b", 2, 0.7, 0.8, 0.9)};
  model.bodies[1].p_WB = {2, 0.3, -0.2};
  model.quantities.emplace_back().name = "x";
  model.quantities[0].kind = Quantity::Kind::kPosition;
  model.quantities[0].subject = 1;
  model.quantities[0].other = 0;
  model.laws.emplace_back().name = "law";
  model.laws[0].steps = {{LawStep::Kind::kConstant, 0, 1}};
  return model;
}

void look_up(benchmark::State& bench, Table::Interpolation kind, std::size_t axes, std::size_t knots) {
  Model model = build_pair();
  Table& table = model.tables.emplace_back();
  table.name = "table";
  table.interpolation = kind;
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> number(0, 1);
  std::size_t count = 1;
  for (std::size_t a = 0; a < axes; ++a, count *= knots) {
    TableAxis& axis = table.axes.emplace_back();
    for (std::size_t i = 0; i < knots; ++i) axis.knots.push_back((static_cast<double>(i) + 0.3 * number(random)));
  }
  for (std::size_t i = 0; i < count; ++i) table.values.push_back(number(random));
  const test::Simulation simulation(model);
  const PlanLaws& plan = simulation.data().laws;
  constexpr std::size_t kPlaces = 256;
  std::vector<std::array<double, kMostTableAxes>> places(kPlaces);
  for (auto& place : places)
    for (double& x : place) x = number(random) * static_cast<double>(knots - 1);
  std::size_t i = 0;
  TableExit exit;
  for (auto _ : bench) benchmark::DoNotOptimize(calc_table(plan, plan.tables[0], places[i++ % kPlaces].data(), exit));
}

void calculate(benchmark::State& bench, int operations) {
  Model model = build_pair();
  std::vector<LawStep>& steps = model.laws[0].steps = {{LawStep::Kind::kQuantity, 0, 0}};
  constexpr LawStep::Kind kKinds[] = {LawStep::Kind::kMultiply, LawStep::Kind::kAdd, LawStep::Kind::kDivide,
                                      LawStep::Kind::kSubtract, LawStep::Kind::kMax};
  for (int i = 0; i < operations; ++i) {
    steps.push_back({LawStep::Kind::kConstant, 0, 1.0 + 0.1 * i});
    steps.push_back({kKinds[i % 5], 0, 0});
  }
  test::Simulation simulation(model);
  (void)simulation.advance();
  const Inputs inputs{simulation.commands};
  const Instant now{simulation.data(), inputs, simulation.state, simulation.get_time()};
  const Evaluation& ev = simulation.evaluation();
  for (auto _ : bench)
    benchmark::DoNotOptimize(calc_law(now, ev.law_operands, ev.laws, {ev.table_exits, ev.law_places, ev.branches}, 0));
}

void read_quantity(benchmark::State& bench, Quantity::Kind kind) {
  Model model = build_pair();
  model.quantities[0].kind = kind;
  test::Simulation simulation(model);
  (void)simulation.advance();
  const Inputs inputs{simulation.commands};
  const Instant now{simulation.data(), inputs, simulation.state, simulation.get_time()};
  const PlanQuantity& own = simulation.data().quantities[0];
  for (auto _ : bench) benchmark::DoNotOptimize(calc_scalar(now, simulation.evaluation(), own));
}

const int kRegistered = [] {
  for (const auto& [name, kind] :
       {std::pair("linear", Table::Interpolation::kLinear), std::pair("smooth", Table::Interpolation::kSmooth)})
    for (const auto& [axes, knots] : {std::pair(1, 1000), std::pair(2, 316), std::pair(3, 47), std::pair(6, 7)})
      keep_least(benchmark::RegisterBenchmark((std::string("table/") + name + "/" + std::to_string(axes)).c_str(),
                                              [kind = kind, axes = axes, knots = knots](benchmark::State& bench) {
                                                look_up(bench, kind, static_cast<std::size_t>(axes),
                                                        static_cast<std::size_t>(knots));
                                              }));
  for (const int operations : {1, 20, 100})
    keep_least(benchmark::RegisterBenchmark(("expression/" + std::to_string(operations)).c_str(),
                                            [operations](benchmark::State& bench) { calculate(bench, operations); }));
  for (const auto& [name, kind] :
       {std::pair("position", Quantity::Kind::kPosition), std::pair("attitude", Quantity::Kind::kAttitude)})
    keep_least(benchmark::RegisterBenchmark((std::string("quantity/") + name).c_str(),
                                            [kind = kind](benchmark::State& bench) { read_quantity(bench, kind); }));
  return 0;
}();

}  // namespace
}  // namespace unlatch::bench
