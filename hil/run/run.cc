#include "hil/run/run.h"

#include <cmath>
#include <limits>
#include <random>
#include <utility>

#include "hil/run/notices/table_exit.h"
#include "hil/session/realtime/clock.h"
#include "hil/session/realtime/executive_timing.h"

namespace unlatch::hil {

std::unique_ptr<Simulation> build_simulation(const Scenario& scenario, InstructionSet set) {
  PlanOptions options;
  options.dt = scenario.dt;
  options.instruction_set = set;
  try {
    return std::make_unique<Simulation>(scenario.model, options, scenario.rates);
  } catch (const SimulationError& error) {
    std::vector<ScenarioMistake> mistakes;
    for (const ModelError& mistake : error.errors) {
      const auto place = scenario.marks.find(mistake.where);
      const SourceMark mark = place == scenario.marks.end() ? SourceMark{} : place->second;
      mistakes.push_back({scenario.files.at(static_cast<std::size_t>(mark.file)), mark, "",
                          mistake.where + ": " + mistake.what, mistake.mend});
    }
    throw ScenarioError(std::move(mistakes));
  }
}

std::int64_t draw_session() {
  std::random_device device;
  return std::uniform_int_distribution<std::int64_t>(1, std::numeric_limits<std::int64_t>::max())(device);
}

LogHeader build_log_header(const Scenario& scenario, const Simulation& simulation, Pace pace, std::int64_t session,
                           std::int64_t last_tick) {
  LogHeader header;
  header.pace = pace;
  header.session = session;
  header.model_hash = simulation.get_model_hash();
  header.first_tick = simulation.get_tick();
  header.last_tick = last_tick;
  header.dt = simulation.plan().get_options().dt;
  header.program = "unlatch " UNLATCH_VERSION;
  header.compiler = get_compiler();
  header.scenario_name = scenario.name;
  header.scenario_path = scenario.file;
  header.scenario_text = scenario.text;
  header.overrides = scenario.overrides;
  if (header.first_tick > 0) header.start = simulation.save();
  header.begins_unresolved = simulation.begins_unresolved();
  return header;
}

FastRun::FastRun(Simulation& simulation, RunAnalysis* analysis, Recorder* recorder, std::int64_t last_tick, Look look)
    : simulation_(simulation),
      analysis_(analysis),
      record_(simulation, recorder),
      last_tick_(last_tick),
      look_(std::move(look)) {
  if (analysis_ != nullptr) analysis_->update(StepReport{});
  record_.state(get_status());
  look_(StepReport{});
}

RunStatus FastRun::get_status() const {
  return simulation_.get_tick() == last_tick_ ? RunStatus::kDone : RunStatus::kRunning;
}

void FastRun::end_tick(const StepReport& report) {
  if (report.status != StepStatus::kOk) {
    end_.status = RunStatus::kFaulted;
    end_.step_status = static_cast<std::int32_t>(report.status);
    end_.joint = report.joint;
    fault_ = report;
    return;
  }
  if (analysis_ != nullptr) analysis_->update(report);
  record_.events(report);
  record_.state(get_status());
  look_(report);
}

void FastRun::interrupt() {
  end_.status = RunStatus::kAborted;
  end_.message = "interrupted";
}

LogEnd FastRun::finish() {
  end_.tick = simulation_.get_tick();
  end_.hash = simulation_.calc_hash();
  if (end_.status == RunStatus::kFaulted)
    end_.message = describe_fault(fault_, end_.tick, simulation_.model(), simulation_.plan().get_options().dt);
  return end_;
}

LogEnd run_fast(Simulation& simulation, RunAnalysis& analysis, Recorder* recorder, std::int64_t last_tick,
                const std::atomic<bool>& stop, const std::function<void()>& look) {
  Timing timing;
  FastRun run(simulation, &analysis, recorder, last_tick, [&look](const StepReport&) { look(); });
  while (run.goes_on()) {
    if (stop.load(std::memory_order_relaxed)) {
      run.interrupt();
      break;
    }
    run.begin_tick();
    const std::int64_t begin_ns = get_monotonic_ns();
    const StepReport report = simulation.step();
    timing.step.record(get_monotonic_ns() - begin_ns);
    run.end_tick(report);
  }
  LogEnd end = run.finish();
  end.timing = timing.summarize();
  return end;
}

std::string describe_fault(const StepReport& report, std::int64_t tick, const Model& model, double dt) {
  std::string text = get_status_text(report.status);
  if (report.joint >= 0 && static_cast<std::size_t>(report.joint) < model.joints.size())
    text += " at joint '" + model.joints[static_cast<std::size_t>(report.joint)].name + "'";
  if (report.contact >= 0 && static_cast<std::size_t>(report.contact) < model.contacts.size())
    text += " at contact '" + model.contacts[static_cast<std::size_t>(report.contact)].name + "'";
  if (report.wedged)
    text += ": its friction outgrows what its normal force decides, so that no motion follows (it wedges, Painlevé)";
  if (report.degenerate)
    text +=
        ": its shapes overlap by more than their radii, or its capsules are parallel, so that its force has no place "
        "(spheres along one of them, or a stiffness)";
  if (report.table >= 0 && static_cast<std::size_t>(report.table) < model.tables.size())
    text += ": " + describe_exit(model.tables[static_cast<std::size_t>(report.table)], report.exit);
  return text + ", tick " + std::to_string(tick) + " (t = " + std::to_string(static_cast<double>(tick) * dt) + " s)";
}

}  // namespace unlatch::hil
