#include "hil/executive.h"

#include <cmath>

#include "hil/pacer.h"
#include "hil/run.h"

namespace unlatch::hil {

Executive::Executive(Simulation& simulation, Link& link, Recorder& recorder, const std::string& scenario,
                     const ExecutiveOptions& options)
    : simulation_(simulation),
      link_(link),
      recorder_(recorder),
      options_(options),
      dt_ns_(std::llround(simulation.plan().options.dt * 1e9)),
      timeout_ns_(std::llround(options.flight_software.timeout * 1e9)),
      catalog_(build_catalog(simulation.model())),
      model_events_(build_event_messages(simulation.model())),
      roster_(options.pace == Pace::kFast ? std::vector<std::string>{} : options.flight_software.required),
      desk_(simulation.model().channels, options.session, options.pace == Pace::kRealtime),
      commander_(simulation.model().channels.size(), kNobody) {
  hello_.session = options.session;
  hello_.schema_hash = kSchemaHash;
  hello_.model_hash = static_cast<std::int64_t>(simulation.plan().hash);
  hello_.dt_ns = dt_ns_;
  hello_.last_tick = options.last_tick;
  hello_.protocol = kProtocolVersion;
  hello_.pace = static_cast<std::int32_t>(options.pace);
  hello_.timeout_ns = timeout_ns_;
  hello_.policy = static_cast<std::int32_t>(options.flight_software.policy);
  for (const std::string& name : options.flight_software.required) {
    Catalog& item = catalog_.emplace_back();
    item.kind = static_cast<std::int32_t>(CatalogKind::kParticipant);
    item.index = hello_.participant_count++;
    set_name(item.name, name);
  }
  for (Catalog& item : catalog_) {
    item.session = options.session;
    switch (static_cast<CatalogKind>(item.kind)) {
      case CatalogKind::kBody:
        ++hello_.body_count;
        break;
      case CatalogKind::kJoint:
        ++hello_.joint_count;
        break;
      case CatalogKind::kChannel:
        ++hello_.channel_count;
        break;
      case CatalogKind::kSensor:
        ++hello_.sensor_count;
        break;
      case CatalogKind::kSignal:
        ++hello_.signal_count;
        break;
      case CatalogKind::kParticipant:
        break;  // counted above
    }
  }
  set_name(hello_.scenario, scenario);
}

LogEnd Executive::run() {
  std::string failure;
  hash_ = simulation_.calc_hash();
  if (!introduce(failure)) return conclude(RunStatus::kAborted, failure);

  started_ns_ = health_ns_ = get_monotonic_ns();
  deadline_ns_ = started_ns_;
  publish_state(options_.last_tick == 0 ? RunStatus::kDone : RunStatus::kRunning);

  while (simulation_.get_tick() < options_.last_tick) {
    if (stop_.load(std::memory_order_relaxed)) return conclude(RunStatus::kAborted, "interrupted");

    // 1. Wait for the tick's time, or for its answers.
    std::int64_t latency_ns = 0;
    if (options_.pace == Pace::kRealtime) {
      deadline_ns_ += dt_ns_;
      sleep_until_ns(deadline_ns_);
      latency_ns = get_monotonic_ns() - deadline_ns_;
      if (wait_realtime() == Go::kStop) return conclude(RunStatus::kAborted, end_message_);
    } else if (options_.pace == Pace::kLockstep) {
      if (wait_lockstep() == Go::kStop) return conclude(RunStatus::kAborted, end_message_);
    }

    // 2. Its inputs are decided.
    apply_commands();
    recorder_.tick(simulation_.get_tick(), hash_);

    // 3. Step.
    const std::int64_t begin_ns = get_monotonic_ns();
    const StepReport report = simulation_.step();
    timing_.step.record(get_monotonic_ns() - begin_ns);
    if (report.status != StepStatus::kOk) {
      LogEnd end = conclude(RunStatus::kFaulted, "");
      end.step_status = static_cast<std::int32_t>(report.status);
      end.joint = report.joint;
      end.message = describe_fault(end, simulation_.model(), simulation_.plan().options.dt);
      return end;
    }

    // 4. Say what has become of it.
    hash_ = simulation_.calc_hash();
    tick_.store(simulation_.get_tick(), std::memory_order_relaxed);
    for (const FiredEvent& fired : report.events) {
      publish_event(model_events_[static_cast<std::size_t>(fired.event)], fired.time, false);
    }
    publish_state(simulation_.get_tick() == options_.last_tick ? RunStatus::kDone : RunStatus::kRunning);

    // 5. Account for the time.
    const std::int64_t now_ns = get_monotonic_ns();
    if (options_.pace == Pace::kRealtime) timing_.account(latency_ns, now_ns, deadline_ns_, deadline_ns_ + dt_ns_);
    if (now_ns - health_ns_ >= 1'000'000'000) publish_health(now_ns);
  }
  return conclude(RunStatus::kDone, "");
}

}  // namespace unlatch::hil
