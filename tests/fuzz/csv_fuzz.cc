// CSV files of tables: alone, and in a scenario.
#include <cmath>

#include "hil/run/run.h"
#include "hil/scenario/text/csv_table.h"
#include "tests/fuzz/fuzz.h"

using namespace unlatch;

namespace {

constexpr const char* kScenario = R"(unlatch: 1
name: csv
step: {dt: 1 ms, until: 1 s}
bodies: {b: {mass: 2, inertia: [1, 1, 1]}}
tables: {made: {file: t.csv, interpolation: smooth}}
--- # included: t.csv
)";

// A complete grid has as many values as combinations, in the order of its rows.
void check_grid(const hil::CsvTable& table) {
  const std::size_t columns = table.names.size();
  fuzz::require(columns == table.values.size() && columns <= 64, "columns without headings");
  for (const std::vector<double>& column : table.values) {
    fuzz::require(column.size() == table.values[0].size(), "columns of different lengths");
    for (const double value : column) fuzz::require(std::isfinite(value), "a value that is not finite");
  }
  if (columns < 2) return;
  std::vector<std::size_t> axes(columns - 1);
  for (std::size_t i = 0; i < axes.size(); ++i) axes[i] = i;
  const hil::CsvGrid grid = hil::read_grid(table, axes, columns - 1);
  std::size_t count = 1;
  for (const std::vector<double>& knots : grid.knots) {
    count *= knots.size();
    for (std::size_t i = 1; i < knots.size(); ++i) fuzz::require(knots[i] > knots[i - 1], "knots that do not rise");
  }
  fuzz::require(count == grid.values.size(), "a grid with gaps");
}

}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string text = fuzz::to_text(data, size);
  try {
    check_grid(hil::read_csv(text));
  } catch (const hil::CsvError& error) {
    fuzz::require(error.line >= 1 && error.column >= 1 && !error.mend.empty(), "a refusal without a place");
  }
  try {
    const auto simulation = hil::build_simulation(hil::load_scenario_text(kScenario + text, "csv.yaml"));
    fuzz::step_a_little(*simulation);
  } catch (const hil::ScenarioError& error) {
    fuzz::require(!error.mistakes.empty(), "a refusal without a mistake");
  }
  return 0;
}
