// unlatch hil: a scenario with flight software in the loop. The cyclic thread steps; the bridge's threads carry its
// messages (in lockstep it does so itself); a recorder's thread writes; this thread watches. What engineers read off
// the run is found by replaying the recording, which also proves that it replays.
#include <pthread.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdlib>
#include <memory>
#include <optional>
#include <thread>

#include "bridge/core/direct_connection.h"
#include "bridge/core/threaded_connection.h"
#include "hil/run/run.h"
#include "hil/run/simulation/model_messages.h"
#include "hil/run/simulation/source_text.h"
#include "hil/scenario/text/number_text.h"
#include "hil/session/executive/executive.h"
#include "hil/session/messages/event_names.h"
#include "hil/session/realtime/real_time.h"
#include "hil/session/realtime/watchdog.h"
#include "tools/common/output.h"
#include "tools/common/terminal.h"
#include "tools/common/text.h"
#include "tools/program/exit_codes.h"
#include "tools/program/interrupt.h"
#include "tools/program/transport.h"
#include "tools/unlatch/options/output_options.h"
#include "tools/unlatch/options/pacing_options.h"
#include "tools/unlatch/options/scenario_notes.h"
#include "tools/unlatch/options/scenario_options.h"
#include "tools/unlatch/results/accuracy_report.h"
#include "tools/unlatch/results/report.h"
#include "tools/unlatch/results/verdict_report.h"
#include "tools/unlatch/run/hosted_software.h"
#include "tools/unlatch/run/recording_watch.h"
#include "tools/unlatch/run/verbs.h"

namespace unlatch::tools {
namespace {

struct HilOptions {
  ScenarioOptions scenario;
  TransportOptions transport;
  std::string pace_name;
  hil::Pace pace = hil::Pace::kRealtime;
  double start_timeout_s = 20;
  std::int64_t session = 0;  // 0: drawn at random
  PacingOptions pacing;
  std::string faults;             // file
  std::vector<std::string> fmus;  // FILE, or NAME=FILE
  std::vector<std::string> maps;  // VARIABLE=NAME, or a file of such lines
  OutputOptions output;
};

std::string describe(const hil::EventMessage& notice, const hil::FlightSoftware& flight_software) {
  const std::string name(hil::get_name(notice.name)), subject(hil::get_name(notice.subject));
  const std::string at = format("t = %.6f s: ", notice.time);
  if (name.starts_with(hil::kFaultPrefix)) return at + "fault script: " + name.substr(6) + " " + subject;
  if (name == hil::kJoined) return "flight software '" + subject + "' takes part";
  if (name == hil::kResumed) return at + "flight software '" + subject + "' is back, the run goes on";
  if (name == hil::kRejoined) return at + "flight software '" + subject + "' was started again and takes part";
  if (name == hil::kLeft) return at + "flight software '" + subject + "' has left";
  if (name == hil::kOtherSimulator) {
    return at + "another simulator is heard on this network, scenario '" + subject +
           "'; flight software belongs to one of them alone if each session has its own --session";
  }
  if (name == hil::kSecondOfName) {
    return at + "a second flight software named '" + subject +
           "' asks to take part and is refused; start each with a --name of its own";
  }
  if (name == hil::kNotAdmitted) {
    return at + "flight software '" + subject + "' is refused: built for another message schema, meant for another " +
           "model, or evicted";
  }
  return at + "flight software '" + subject + "' has not answered for " + hil::write_number(flight_software.timeout) +
         " s, or has left; policy '" + name.substr(hil::kPolicyPrefix.size()) + "' is applied";
}

class Session {
 public:
  Session(const HilOptions& options)
      : options_(options),
        scenario_(load(options.scenario)),
        simulation_(hil::build_simulation(scenario_)),
        last_tick_(calc_last_tick(scenario_)),
        session_(options.session != 0 ? options.session : hil::draw_session()),
        header_(hil::build_log_header(scenario_, *simulation_, options.pace, session_, last_tick_)) {}

  int run() {
    warn_of_unstable_elements(scenario_);
    if (options_.pace == hil::Pace::kFast) warn_of_absent_flight_software(scenario_);
    open_tick_source();
    if (!options_.faults.empty())
      faults_.emplace(hil::load_faults(options_.faults, scenario_), simulation_->get_sensors().size());
    connect();
    header_.has_received =
        hil::shows_received(scenario_, faults_ ? hil::SensorsShown::kAlsoReceived : hil::SensorsShown::kAsScenario);
    recorder_.emplace(options_.output.log, header_);
    hil::LogEnd end = run_executive();
    if (hosted_) hosted_->stop();
    connection_.reset();
    const std::string failure = hosted_ ? hosted_->get_failure() : "";
    if (!failure.empty()) end.message = failure;
    recorder_->close(end);
    if (faults_) tell_faults();
    return report(end);
  }

 private:
  static constexpr std::size_t kCapacityOut = 1024;  // messages
  static constexpr int kLooksPerSecond = 100;
  static constexpr std::int64_t kListen_ns = 250'000'000;  // a simulator says Hello every tenth of a second

  void open_tick_source() {
    if (options_.pace != hil::Pace::kRealtime) return;
    tick_source_ = options_.pacing.open_source(std::llround(scenario_.dt * 1e9));
  }

  void connect() {
    if (options_.transport.name != "inproc") {
      port_ = open_port(options_.transport, bridge::Role::kSimulator);
    } else {
      port_ = hub_.open(bridge::Role::kSimulator);
      if (options_.pace != hil::Pace::kFast) hosted_.emplace(options_.fmus, options_.maps, scenario_).start(hub_);
    }
    if (options_.pace == hil::Pace::kLockstep) {
      connection_ = std::make_unique<bridge::DirectConnection>(*port_);
    } else {
      const std::size_t capacity = kCapacityOut + hil::build_catalog(scenario_.model).size();
      connection_ = std::make_unique<bridge::ThreadedConnection>(*port_, capacity);
    }
  }

  void tell_faults() {
    for (const auto& [fault, count] : faults_->list_tallies()) {
      std::fprintf(stderr, "fault script: %s %s affected %s\n",
                   hil::kFaultNames[static_cast<std::size_t>(fault->kind)].c_str(), fault->subject.c_str(),
                   tools::count(static_cast<std::size_t>(count), "message").c_str());
    }
  }

  hil::LogEnd run_executive() {
    hil::ExecutiveOptions options;
    if (faults_) options.faults = &*faults_;
    options.pace = options_.pace;
    options.session = session_;
    options.last_tick = last_tick_;
    options.flight_software = scenario_.flight_software;
    options.timing = scenario_.timing;
    options.ticks = tick_source_.get();
    if (options_.transport.name != "inproc") options.listen_ns = kListen_ns;
    options.beside_others = options_.session != 0;
    options.source = hil::build_source(scenario_.text, scenario_.overrides, session_);
    options.start_timeout_ns = static_cast<std::int64_t>(options_.start_timeout_s * 1e9);
    hil::Executive executive(*simulation_, *connection_, *recorder_, scenario_.name, options);

    std::optional<hil::ShallowIdle> awake;
    if (options_.pace == hil::Pace::kRealtime && !awake.emplace().get_refusal().empty()) refuse(awake->get_refusal());
    hil::LogEnd end;
    std::atomic<bool> ended{false};
    std::jthread cyclic([&] {
      pthread_setname_np(pthread_self(), "unlatch-cyclic");
      if (options_.pace == hil::Pace::kRealtime) {
        for (const std::string& refused : hil::request_real_time(options_.pacing.thread)) refuse(refused);
      }
      end = executive.run();
      ended.store(true, std::memory_order_release);
    });
    const auto watchdog = start_watchdog(executive);
    watch(executive, ended);
    cyclic.join();
    return end;
  }

  void refuse(const std::string& refused) {
    std::fprintf(stderr, "%s\n", refused.c_str());
    refused_.push_back(refused);
  }

  // A cyclic thread that is stuck cannot be helped: that is said, and the process ended if the scenario wants that. Its
  // recording has every tick up to there.
  std::unique_ptr<hil::Watchdog> start_watchdog(const hil::Executive& executive) {
    const double limit_s = scenario_.timing.watchdog;
    if (limit_s <= 0) return nullptr;
    const int priority = options_.pace == hil::Pace::kRealtime ? options_.pacing.thread.priority + 1 : 0;
    const bool aborts = scenario_.timing.watchdog_aborts;
    // The wait for a tick is no silence.
    const auto limit_ns = std::llround(std::max(limit_s, 2 * scenario_.dt) * 1e9) + options_.pacing.get_patience_ns();
    return std::make_unique<hil::Watchdog>(
        executive.get_beats(), limit_ns, priority, [&executive, aborts](std::int64_t silent_ns) {
          std::fprintf(stderr, "watchdog: no progress of the cyclic thread for %.1f s, %s%s\n",
                       static_cast<double>(silent_ns) * 1e-9, executive.describe_place().c_str(),
                       aborts ? "; the process ends here (timing.watchdog.action: abort)" : "");
          if (aborts) std::_Exit(kExitFailed);
        });
  }

  void watch(hil::Executive& executive, const std::atomic<bool>& ended) {
    const std::atomic<bool>& interrupted = catch_interrupts();
    Progress progress(scenario_.dt, last_tick_);
    RecordingWatch recording(&*recorder_);
    bool last_look = false;
    for (int look = 0; !last_look; ++look) {
      last_look = ended.load(std::memory_order_acquire);
      if (look % kLooksPerSecond == 0 || last_look) {
        executive.watch_counts();
        watch_unfit(progress);
      }
      if (interrupted.load() || (hosted_ && !hosted_->get_failure().empty())) executive.request_stop();
      hil::EventMessage notice;
      while (executive.take_notice(notice)) {
        progress.clear();
        const std::string text = describe(notice, scenario_.flight_software);
        const bool good = hil::get_name(notice.name) == hil::kJoined;
        std::fprintf(stderr, "%s\n", good ? text.c_str() : paint(stderr, Colour::kYellow, text).c_str());
      }
      recording.look(progress);
      progress.show(executive.get_tick());
      std::this_thread::sleep_for(std::chrono::milliseconds(1000 / kLooksPerSecond));
    }
    progress.clear();
  }

  // Readers and writers of other programs that DDS does not connect, as soon as they are there.
  void watch_unfit(Progress& progress) {
    std::vector<std::string> unfit;
    for (const bridge::UnfitPeers& peers : port_->list_unfit()) unfit.push_back(describe(peers));
    for (const std::string& text : unfit) {
      if (std::find(unfit_.begin(), unfit_.end(), text) != unfit_.end()) continue;
      progress.clear();
      std::fprintf(stderr, "%s\n", paint(stderr, Colour::kYellow, text).c_str());
    }
    unfit_ = std::move(unfit);
  }

  // The recording, from its file or, without --log, from the nameless one.
  hil::LogFileReader open_recording() {
    if (!options_.output.log.empty()) return hil::LogFileReader(options_.output.log);
    return {recorder_->rewind(), "the recording"};
  }

  int report(const hil::LogEnd& end) {
    const std::string& error = recorder_->get_error();
    const auto again = hil::build_simulation(scenario_);
    hil::RunAnalysis analysis(scenario_, *again);
    hil::RecordingReader recording(open_recording());
    hil::RunOutputs outputs(scenario_, *again, {end.tick}, scenario_.outputs, hil::get_sensors_shown(header_));
    std::optional<hil::ReplayResult> replayed;
    std::string message = end.message;
    try {
      replayed =
          hil::replay(recording, *again, &analysis, [&](const StepReport&) { outputs.look(recording.received); });
      outputs.finish();
    } catch (const hil::LogError& lossy) {
      message += (message.empty() ? "" : "; ") + std::string(lossy.what());
    }
    if (!recording.shortfall.empty()) {
      message +=
          (message.empty() ? "" : "; ") + std::string("the results end with the recording: ") + recording.shortfall;
    }
    std::string status = get_status_name(end.status);
    if (replayed && !replayed->agrees()) status = "different";
    tell_unresolved(analysis, status, message);
    const RunReport report{
        scenario_,         *again,   analysis, status, message, end.tick, end.hash,         end.timing,
        recording.notices, replayed, refused_, unfit_, {},      &outputs, recording.events, recording.events_left_out};
    print_report(get_people_stream(options_.output.json), report);
    write_json(report, options_.output.json);
    write_junit(report, options_.output.junit, wall_time_.get());
    if (!error.empty()) throw OutputError(error);
    return status == "ok" && is_met(report) ? kExitDone : kExitFailed;
  }

  const WallTime wall_time_;
  const HilOptions& options_;
  const hil::Scenario scenario_;
  const std::unique_ptr<hil::Simulation> simulation_;
  const std::int64_t last_tick_, session_;
  hil::LogHeader header_;
  std::unique_ptr<hil::TickSource> tick_source_;
  std::vector<std::string> refused_, unfit_;
  bridge::InprocHub hub_;
  std::unique_ptr<bridge::Port> port_;
  std::unique_ptr<hil::Connection> connection_;
  std::optional<HostedSoftware> hosted_;  // with --transport inproc
  std::optional<hil::FaultInjector> faults_;
  std::optional<hil::Recorder> recorder_;
};

}  // namespace

void add_hil(Command app, int& exit_code) {
  auto options = std::make_shared<HilOptions>();
  Command command = app.add_verb(
      "hil",
      "Runs a scenario with flight software in the loop. The flight software is another process, started before or "
      "after this one. With --transport inproc the reference flight software runs in this process, or with --fmu a "
      "controller FMU. Exit code 1 if a requirement is not met.",
      "unlatch hil hil/scenarios/boosters/scenario.yaml --transport dds --pace realtime --log run.log &\n"
      "unlatch-fsw --transport dds\n"
      "unlatch hil hil/scenarios/boosters/scenario.yaml --fmu controller.fmu --transport inproc --pace lockstep");
  add_scenario_options(command, options->scenario);
  add_transport_options(command, options->transport, true);
  command
      .add_option("--pace", options->pace_name,
                  "realtime: by the clock; lockstep: by the answers; fast: without flight software")
      .required()
      .one_of({"realtime", "lockstep", "fast"});
  command.add_option("--start-timeout", options->start_timeout_s, "longest wait for the flight software, s")
      .type_name("SECONDS")
      .seconds()
      .default_shown();
  command
      .add_option(
          "--session", options->session,
          "number of this session, for flight software with the same --session; allows other simulators, of other "
          "numbers, beside it")
      .type_name("NUMBER")
      .not_negative();
  command
      .add_option("--fmu", options->fmus,
                  "FMU (FMI 2.0 or 3.0, co-simulation) as flight software, NAME=FILE for one of several; in lockstep, "
                  "inproc. Inputs are named as sensors or states, outputs as channels")
      .type_name("FILE");
  command
      .add_option(
          "--map", options->maps,
          "name in the scenario of a variable of the FMU that is called otherwise: In1=gyro.x, Out1=main_engine; "
          "In3=- leaves an input at its start value; or a file with such a line each (# begins a comment). Of "
          "one of several FMUs: fsw:In1=gyro.x")
      .type_name("VARIABLE=NAME|FILE");
  add_pacing_options(command, options->pacing);
  command.add_option("--faults", options->faults, "fault script (.yaml), see hil/scenarios/FAULTS.md")
      .type_name("FILE");
  add_output_options(command, options->output);
  command.callback([options, &exit_code] {
    options->pace = options->pace_name == "realtime"   ? hil::Pace::kRealtime
                    : options->pace_name == "lockstep" ? hil::Pace::kLockstep
                                                       : hil::Pace::kFast;
    if (options->pace == hil::Pace::kFast && options->transport.name != "inproc") {
      refuse_option("--pace", "fast is a run without flight software, and sends nothing over " +
                                  options->transport.name + "; use --transport inproc, or unlatch run");
    }
    if (!options->fmus.empty() && (options->transport.name != "inproc" || options->pace != hil::Pace::kLockstep))
      refuse_option("--fmu", "an FMU is stepped in this process and in lockstep: --transport inproc --pace lockstep");
    never_wait_for_stderr();
    options->pacing.add_overrides(options->scenario.overrides);
    check_output(options->output.json);
    check_output(options->output.junit);
    exit_code = Session(*options).run();
  });
}

}  // namespace unlatch::tools
