// unlatch watch: a session as it goes, from any machine that hears it.
#include <chrono>
#include <optional>

#include "tools/common/output.h"
#include "tools/common/terminal.h"
#include "tools/program/exit_codes.h"
#include "tools/program/interrupt.h"
#include "tools/program/transport.h"
#include "tools/unlatch/run/verbs.h"
#include "tools/watch/live_terminal.h"
#include "tools/watch/observation.h"
#include "tools/watch/screen.h"

namespace unlatch::tools {
namespace {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

constexpr auto kLook = 100ms;
constexpr auto kLine = 1s;             // between two lines where there is no terminal
constexpr double kOncePatience_s = 3;  // --once: for what is still on its way behind the first State

struct WatchOptions {
  TransportOptions transport;
  std::string json;
  double seconds = 0;  // 0: until it is interrupted
  bool once = false;
};

// Destination of each view: the whole screen, or a line each second.
class Output {
 public:
  explicit Output(const WatchOptions& options) : options_(options), json_(options.json) {
    if (options.json.empty() && !options.once && is_terminal(stdout)) terminal_.emplace();
  }

  // False when the user has had enough.
  bool show(const View& view, Clock::time_point now) {
    if (terminal_) {
      const auto [columns, rows] = terminal_->get_size();
      terminal_->show(draw(view, {columns, rows, has_colours(stdout), options_.transport.name}));
      return terminal_->read_key() != 'q';
    }
    if (!options_.once && (!shown_ || now - *shown_ >= kLine)) {
      write(view);
      shown_ = now;
    }
    return true;
  }

  void write(const View& view) {
    if (!options_.json.empty()) return json_.write(build_json(view));
    if (!options_.once) {
      std::printf("%s\n", describe(view).c_str());
    } else {
      for (const std::string& line : draw(view, {kWide, kLong, has_colours(stdout), options_.transport.name}))
        std::printf("%s\n", line.c_str());
    }
    std::fflush(stdout);
  }

 private:
  static constexpr std::size_t kWide = 120, kLong = 200;
  const WatchOptions& options_;
  JsonLines json_;
  std::optional<LiveTerminal> terminal_;
  std::optional<Clock::time_point> shown_;
};

// Nothing more is to be expected of a first look.
bool is_whole(const View& view, double since_state_s) {
  if (!view.has_state) return false;
  return (view.has_hello && view.knows_scenario && view.reactions_tick >= 0 && view.health) ||
         since_state_s > kOncePatience_s;
}

int run(const WatchOptions& options) {
  const std::atomic<bool>& stop = catch_interrupts();
  const auto port = open_port(options.transport, bridge::Role::kObserver);
  Output output(options);
  Observation observation;
  hil::Message message;
  const auto begun = Clock::now();
  auto looked = begun, state_heard = begun;
  bool was_heard = false;
  const auto calc_age = [](Clock::time_point now, Clock::time_point since) {
    return std::chrono::duration<double>(now - since).count();
  };
  while (!stop.load() && (options.seconds <= 0 || calc_age(Clock::now(), begun) < options.seconds)) {
    if (port->poll(message, kLook / 2)) observation.hear(message, Clock::now());
    const auto now = Clock::now();
    if (now - looked < kLook) continue;
    looked = now;
    const View& view = observation.look(now, port->get_counts());
    if (!view.has_state) state_heard = now;
    was_heard = was_heard || view.session != 0;
    if (options.once && is_whole(view, calc_age(now, state_heard))) {
      output.write(view);
      return kExitDone;
    }
    if (!output.show(view, now)) break;
  }
  if (options.once) std::fprintf(stderr, "unlatch watch: no session was found\n");
  return was_heard && !options.once ? kExitDone : kExitFailed;
}

}  // namespace

void add_watch(Command app, int& exit_code) {
  auto options = std::make_shared<WatchOptions>();
  Command command = app.add_verb(
      "watch",
      "Shows a session while it runs: modes and reactions of the joints, clearances, times, "
      "messages, participants, events. It only receives, on any machine, and continues with the next "
      "session when one ends. On a terminal it updates ten times a second (q: quit); elsewhere it prints a "
      "line each second.",
      "unlatch watch --transport dds");
  add_transport_options(command, options->transport, false);
  command.add_option("--for", options->seconds, "ends after this wall time, s (default: never)")
      .type_name("SECONDS")
      .seconds();
  command.add_flag("--once", options->once, "prints one complete snapshot and exits");
  command.add_json_option(options->json, "one object on each line, each second");
  command.callback([options, &exit_code] { exit_code = run(*options); });
}

}  // namespace unlatch::tools
