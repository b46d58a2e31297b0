// Trustworthiness of a run, as tables and as JSON: notices, energy, the comparison of three steps.
#pragma once

#include <cstdio>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "tools/unlatch/options/scenario_options.h"
#include "tools/unlatch/results/report.h"

namespace unlatch::tools {

// Name of a notice in the timeline: "accuracy.spring".
std::string get_full_name(const hil::RunNotice& notice);

void print_accuracy_notices(std::FILE* to, const RunReport& report);
void print_energy(std::FILE* to, const hil::EnergyBalance& energy);
void print_accuracy(std::FILE* to, const hil::AccuracyReport& accuracy, double dt);

nlohmann::ordered_json build_energy_json(const hil::EnergyBalance& energy);
// [{"what": "…", "value": 0.0, "error": 1e-9, "order": 4.0, …}]
nlohmann::ordered_json build_accuracy_json(const hil::AccuracyReport& accuracy);
// Tolerance, largest step, what limits it.
nlohmann::ordered_json build_step_json(const hil::AccuracyReport& accuracy);

// The options of the scenario at another step, with parts that contacts choose as much finer
// (hil::make_step_settings()).
ScenarioOptions set_step(const ScenarioOptions& options, const hil::Scenario& scenario, double step);

// The status of a run that ended well, but is not resolved.
inline constexpr const char* kUnresolved = "unresolved";
// Such a run's status and its message. True if so.
bool tell_unresolved(const hil::RunAnalysis& analysis, std::string& status, std::string& message);

// Adds how much a small change of the start grows until the end of the run, unless the comparison was interrupted: at
// the longest of sixteen, eight, four and two steps of the scenario at which the run ends alike, since growth need not
// be known to better than a tenth.
void measure_growth(const ScenarioOptions& options, const hil::Scenario& scenario, const hil::Simulation& simulation,
                    hil::AccuracyReport& accuracy);

// Runs the scenario at dt/2 and dt/4, and then at the largest step that meets `tolerance`, and compares. `simulation`
// and `analysis`: of the run at dt, at its end.
hil::AccuracyReport measure_accuracy(const ScenarioOptions& options, const hil::Scenario& scenario,
                                     const hil::Simulation& simulation, const hil::RunAnalysis& analysis,
                                     double tolerance);

}  // namespace unlatch::tools
