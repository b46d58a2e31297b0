// unlatch log: an ordinary subscriber that writes what it hears into an LCM event log.
#include <array>
#include <chrono>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>

#include "hil/run/recording/log_file.h"
#include "tools/common/output.h"
#include "tools/common/text.h"
#include "tools/program/exit_codes.h"
#include "tools/program/interrupt.h"
#include "tools/program/transport.h"
#include "tools/unlatch/run/verbs.h"

namespace unlatch::tools {
namespace {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

constexpr auto kPollWait = 50ms;
constexpr auto kLinger = 300ms;  // after a session's last State, for what is still on its way
constexpr auto kFlush = 100ms;

// The first event of the file: JSON that says what was heard, padded with blanks to this length, and kept up to date.
constexpr const char* kHeader = "UNLATCH_HEARD";
constexpr std::size_t kHeaderBytes = 8192;

struct LogOptions {
  TransportOptions transport;
  std::string out, json;
};

// Messages of the first session.
class Listener {
 public:
  Listener(const std::string& path, std::string transport) : writer_(path), transport_(std::move(transport)) {
    writer_.append(0, kHeader, build_header());
    writer_.flush();
  }

  void hear(const hil::Message& message) {
    if (message.kind == hil::MessageKind::kState && !follow(message.state)) return;
    take_terms(message);
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
            {"malformed", port.malformed},
            {"unfit", port.unfit}};
  }

  // The header as well.
  void flush() {
    const std::vector<std::uint8_t> header = build_header();
    if (header != header_) writer_.amend_first(header);
    header_ = header;
    writer_.flush();
  }
  [[nodiscard]] bool has_ended() const { return ended_; }
  [[nodiscard]] bool was_started() const { return session_ != 0; }
  [[nodiscard]] const std::string& get_error() const { return writer_.get_error(); }

  void print(std::FILE* to, const bridge::PortCounts& port) const {
    for (std::size_t i = 0; i < counts_.size(); ++i) {
      if (counts_[i] == 0) continue;
      std::fprintf(to, "  %-10s %8lld\n", std::string(hil::get_kind_name(static_cast<hil::MessageKind>(i))).c_str(),
                   static_cast<long long>(counts_[i]));
    }
    std::fprintf(to, "  states up to tick %lld, t = %.3f s; %lld missing in %s, %lld repeated; %s\n",
                 static_cast<long long>(tick_), static_cast<double>(time_us_) * 1e-6, static_cast<long long>(missing_),
                 count(static_cast<std::size_t>(gaps_), "gap").c_str(), static_cast<long long>(repeated_),
                 count(port.malformed, "malformed message").c_str());
  }

 private:
  // Scenario, step and versions of the session, and who took part in it.
  void take_terms(const hil::Message& message) {
    if (message.kind == hil::MessageKind::kHello && (session_ == 0 || message.hello.session == session_)) {
      hello_ = message.hello;
    } else if (message.kind == hil::MessageKind::kHelloAck) {
      participants_.emplace(hil::get_name(message.hello_ack.name));
    } else if (message.kind == hil::MessageKind::kCatalog &&
               message.catalog.kind == static_cast<std::int32_t>(hil::CatalogKind::kParticipant)) {
      required_.emplace(hil::get_name(message.catalog.name));
    }
  }

  [[nodiscard]] std::vector<std::uint8_t> build_header() const {
    nlohmann::ordered_json json = {{"schema", 1}, {"program", "unlatch " UNLATCH_VERSION}, {"transport", transport_}};
    if (hello_) {
      json["scenario"] = hil::get_name(hello_->scenario);
      json["protocol"] = hello_->protocol;
      json["schema_hash"] = to_hex(hello_->schema_hash);
      json["model_hash"] = to_hex(hello_->model_hash);
      json["dt"] = static_cast<double>(hello_->dt_ns) * 1e-9;
      json["pace"] = hil::get_text(static_cast<hil::Pace>(hello_->pace));
    }
    json["session"] = session_;
    json["ended"] = ended_;
    json["last_tick"] = tick_;
    json["t"] = static_cast<double>(time_us_) * 1e-6;
    json["states_missing"] = missing_;
    json["topics"] = nlohmann::ordered_json::object();
    for (std::size_t i = 0; i < counts_.size(); ++i)
      if (counts_[i] > 0) json["topics"][std::string(hil::get_channel(static_cast<hil::MessageKind>(i)))] = counts_[i];
    json["required"] = required_;
    json["participants"] = participants_;
    constexpr auto kReplace = nlohmann::ordered_json::error_handler_t::replace;
    std::string text = json.dump(-1, ' ', false, kReplace);
    if (text.size() > kHeaderBytes) {  // of more participants than it has room for the numbers
      json["required"] = required_.size();
      json["participants"] = participants_.size();
      text = json.dump(-1, ' ', false, kReplace);
    }
    text.resize(kHeaderBytes, ' ');
    return {text.begin(), text.end()};
  }

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
  const std::string transport_;
  std::vector<std::uint8_t> header_;  // as last written
  std::optional<hil::HelloMessage> hello_;
  std::set<std::string> required_, participants_;
  std::array<std::int64_t, hil::kMessageKinds> counts_{};
  std::int64_t session_ = 0, next_ = 0, gaps_ = 0, missing_ = 0, repeated_ = 0, time_us_ = 0, tick_ = 0;
  bool ended_ = false;
};

int run(const LogOptions& options) {
  never_wait_for_stderr();
  const std::atomic<bool>& stop = catch_interrupts();
  check_output(options.json);
  const auto port = open_port(options.transport, bridge::Role::kObserver);
  Listener listener(options.out, options.transport.name);
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
  for (const bridge::UnfitPeers& peers : port->list_unfit()) std::fprintf(people, "  %s\n", describe(peers).c_str());
  write_json(listener.build_json(options, port->get_counts()), options.json);
  if (!listener.get_error().empty()) throw OutputError(listener.get_error());
  return listener.was_started() ? kExitDone : kExitFailed;
}

}  // namespace

void add_log(Command app, int& exit_code) {
  auto options = std::make_shared<LogOptions>();
  Command command = app.add_verb(
      "log",
      "Records the messages of a session into an LCM event log, as an ordinary subscriber, until the session ends. The "
      "first event, UNLATCH_HEARD, is JSON: scenario, transport, versions, participants, topics and their counts.",
      "unlatch log --transport dds --out heard.log");
  add_transport_options(command, options->transport, false);
  command.add_option("--out", options->out, "file to write").required().type_name("FILE");
  command.add_json_option(options->json, "numbers of received messages");
  command.callback([options, &exit_code] { exit_code = run(*options); });
}

}  // namespace unlatch::tools
