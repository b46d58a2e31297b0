#include "hil/run/run.h"

#include <cmath>
#include <limits>
#include <random>

#include "hil/realtime/clock.h"
#include "hil/realtime/executive_timing.h"
#include "hil/run/run_record.h"

namespace unlatch::hil {

std::unique_ptr<Simulation> build_simulation(const Scenario& scenario) {
  PlanOptions options;
  options.dt = scenario.dt;
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
  return header;
}

LogEnd run_fast(Simulation& simulation, RunAnalysis& analysis, Recorder* recorder, std::int64_t last_tick,
                const std::atomic<bool>& stop, const std::function<void()>& look) {
  LogEnd end;
  Timing timing;
  RunRecord record(simulation, recorder);
  analysis.update(StepReport{});
  record.state(simulation.get_tick() == last_tick ? RunStatus::kDone : RunStatus::kRunning);
  look();
  while (simulation.get_tick() < last_tick && end.status == RunStatus::kDone) {
    if (stop.load(std::memory_order_relaxed)) {
      end.status = RunStatus::kAborted;
      end.message = "interrupted";
      break;
    }
    record.tick();
    const std::int64_t begin_ns = get_monotonic_ns();
    const StepReport report = simulation.step();
    timing.step.record(get_monotonic_ns() - begin_ns);
    if (report.status != StepStatus::kOk) {
      end.status = RunStatus::kFaulted;
      end.step_status = static_cast<std::int32_t>(report.status);
      end.joint = report.joint;
      break;
    }
    analysis.update(report);
    record.events(report);
    record.state(simulation.get_tick() == last_tick ? RunStatus::kDone : RunStatus::kRunning);
    look();
  }
  end.tick = simulation.get_tick();
  end.hash = simulation.calc_hash();
  end.timing = timing.summarize();
  if (end.status == RunStatus::kFaulted) {
    end.message = describe_fault(end, simulation.model(), simulation.plan().get_options().dt);
  }
  return end;
}

std::string describe_fault(const LogEnd& end, const Model& model, double dt) {
  std::string text = get_status_text(static_cast<StepStatus>(end.step_status));
  if (end.joint >= 0 && static_cast<std::size_t>(end.joint) < model.joints.size()) {
    text += " at joint '" + model.joints[static_cast<std::size_t>(end.joint)].name + "'";
  }
  return text + ", tick " + std::to_string(end.tick) + " (t = " + std::to_string(static_cast<double>(end.tick) * dt) +
         " s)";
}

}  // namespace unlatch::hil
