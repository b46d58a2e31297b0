// unlatch log: an ordinary subscriber that writes what it hears into an LCM event log.
#include <array>
#include <chrono>
#include <nlohmann/json.hpp>

#include "hil/recording/log_file.h"
#include "tools/exit_codes.h"
#include "tools/interrupt.h"
#include "tools/transport.h"
#include "tools/unlatch/commands.h"
#include "tools/unlatch/report.h"

namespace unlatch::tools {
namespace {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

constexpr auto kPollWait = 50ms;
constexpr auto kLinger = 300ms;  // after a session's last State, for what is still on its way
constexpr auto kFlush = 100ms;

struct LogOptions {
  TransportOptions transport;
  std::string out, json;
};

// Messages of the first session.
class Listener {
 public:
  explicit Listener(const std::string& path) : writer_(path) {}

  void hear(const hil::Message& message) {
    if (message.kind == hil::MessageKind::kState && !follow(message.state)) return;
    std::array<std::uint8_t, hil::kMaxWireBytes> bytes;
    const std::size_t length = encode(message, bytes);
    writer_.append(time_us_, hil::get_channel(message.kind), {bytes.data(), length});
    ++counts_[static_cast<std::size_t>(message.kind)];
  }

  [[nodiscard]] nlohmann::ordered_json build_json(const LogOptions& options, const bridge::PortCounts& port) const {
    nlohmann::ordered_json messages = nlohmann::ordered_json::object();
    for (std::size_t i = 0; i < counts_.size(); ++i) {
      messages[std::string(hil::get_kind_name(static_cast<hil::MessageKind>(i)))] = counts_[i];
    }
    return {{"schema", 1},
            {"file", options.out},
            {"session", session_},
            {"ended", ended_},
            {"messages", messages},
            {"last_tick", tick_},
            {"t", static_cast<double>(time_us_) * 1e-6},
            {"states_missing", missing_},
            {"gaps", gaps_},
            {"repeated", repeated_},
            {"malformed", port.malformed}};
  }

  void flush() { writer_.flush(); }
  [[nodiscard]] bool has_ended() const { return ended_; }
  [[nodiscard]] bool was_started() const { return session_ != 0; }
  [[nodiscard]] const std::string& get_error() const { return writer_.get_error(); }

  void print(std::FILE* to, const bridge::PortCounts& port) const {
    for (std::size_t i = 0; i < counts_.size(); ++i) {
      if (counts_[i] == 0) continue;
      std::fprintf(to, "  %-10s %8lld\n", std::string(hil::get_kind_name(static_cast<hil::MessageKind>(i))).c_str(),
                   static_cast<long long>(counts_[i]));
    }
    std::fprintf(
        to, "  states up to tick %lld, t = %.3f s; %lld missing in %lld gaps, %lld repeated; %lld malformed messages\n",
        static_cast<long long>(tick_), static_cast<double>(time_us_) * 1e-6, static_cast<long long>(missing_),
        static_cast<long long>(gaps_), static_cast<long long>(repeated_), static_cast<long long>(port.malformed));
  }

 private:
  // Sequence numbers of the session; false for a State of another one.
  bool follow(const hil::StateMessage& state) {
    if (session_ == 0) session_ = state.session;
    if (state.session != session_) return false;
    if (state.status >= static_cast<int>(hil::RunStatus::kDone)) ended_ = true;
    if (state.part != 0) return true;
    if (state.sequence > next_) {
      ++gaps_;
      missing_ += state.sequence - next_;
    } else if (state.sequence < next_) {
      ++repeated_;
    }
    next_ = std::max(next_, state.sequence + 1);
    time_us_ = std::max(time_us_, state.time_ns / 1000);
    tick_ = std::max(tick_, state.tick);
    return true;
  }

  hil::LogFileWriter writer_;
  std::array<std::int64_t, hil::kMessageKinds> counts_{};
  std::int64_t session_ = 0, next_ = 0, gaps_ = 0, missing_ = 0, repeated_ = 0, time_us_ = 0, tick_ = 0;
  bool ended_ = false;
};

int run(const LogOptions& options) {
  never_wait_for_stderr();
  const std::atomic<bool>& stop = catch_interrupts();
  const auto port = open_port(options.transport, bridge::Role::kObserver);
  Listener listener(options.out);
  std::fprintf(stderr, "unlatch log: waits for a session on %s\n", options.transport.name.c_str());
  hil::Message message;
  auto heard = Clock::now(), flushed = heard;
  while (!stop.load() && !(listener.has_ended() && Clock::now() - heard > kLinger)) {
    if (port->poll(message, kPollWait)) {
      listener.hear(message);
      heard = Clock::now();
    }
    if (Clock::now() - flushed > kFlush) {
      listener.flush();
      flushed = Clock::now();
    }
  }
  listener.flush();
  std::FILE* const people = get_people_stream(options.json);
  std::fprintf(people, "%s: %s\n", options.out.c_str(),
               listener.was_started() ? "messages received" : "no session was found");
  listener.print(people, port->get_counts());
  write_json(listener.build_json(options, port->get_counts()), options.json);
  if (!listener.get_error().empty()) throw OutputError(listener.get_error());
  return listener.was_started() ? kExitDone : kExitFailed;
}

}  // namespace

void add_log(Command app, int& exit_code) {
  auto options = std::make_shared<LogOptions>();
  Command command = app.add_verb(
      "log",
      "Records the messages of a session into an LCM event log, as an ordinary subscriber, until the session ends.",
      "unlatch log --transport dds --out heard.log");
  add_transport_options(command, options->transport, false);
  command.add_option("--out", options->out, "file to write").required().type_name("FILE");
  command.add_json_option(options->json, "numbers of received messages");
  command.callback([options, &exit_code] { exit_code = run(*options); });
}

}  // namespace unlatch::tools
