// unlatch telemetry: a session for control rooms and displays, as an ordinary subscriber.
#include <arpa/inet.h>

#include <charconv>
#include <chrono>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "bridge/telemetry/telemetry.h"
#include "bridge/telemetry/xtce.h"
#include "hil/scenario/base/module.h"
#include "hil/scenario/scenario.h"
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

constexpr auto kWait = 5ms;               // for a message, before the sockets are looked at again
constexpr auto kTelemetryLinger = 500ms;  // after a session's last State, for what is still on its way to clients

struct Options {
  TransportOptions transport;
  bridge::TelemetryOptions telemetry;
  std::string xtce, scenario, json;
  double seconds = 0;  // 0: until it is interrupted
  bool until_end = false;
};

// "" or the mistake in an address and port. Whether it can be opened, the sockets say.
std::string check_address(const std::string& text) {
  const std::string mistake =
      "'" + text + "' is no address and port; write it like 127.0.0.1:10015, localhost:10015 or [::1]:10015";
  const std::size_t colon = text.rfind(':');
  if (colon == std::string::npos) return mistake;
  std::uint16_t port = 0;
  const char* const end = text.data() + text.size();
  const auto [stop, fault] = std::from_chars(text.data() + colon + 1, end, port);
  if (fault != std::errc{} || stop != end || port == 0) return mistake + "; ports are 1 to 65535";
  std::string host = text.substr(0, colon);
  if (host.size() > 1 && host.front() == '[' && host.back() == ']') host = host.substr(1, host.size() - 2);
  host = host.substr(0, host.find('%'));  // the interface of an address that is valid on one link
  in6_addr address{};
  const bool known = host == "localhost" || inet_pton(AF_INET, host.c_str(), &address) == 1 ||
                     inet_pton(AF_INET6, host.c_str(), &address) == 1;
  return known ? "" : mistake;
}

std::unique_ptr<bridge::Telemetry> open(const bridge::TelemetryOptions& options) try {
  using Open = bridge::Telemetry*(const bridge::TelemetryOptions&);
  return std::unique_ptr<bridge::Telemetry>(
      hil::find_function<Open>("unlatch-telemetry", "unlatch_open_telemetry")(options));
} catch (const hil::ModuleError& error) {
  throw bridge::PortError(error.what());
}

nlohmann::ordered_json build_json(const bridge::OutletCounts& counts) {
  return {{"sent", counts.sent}, {"dropped", counts.dropped}, {"clients", counts.clients}, {"refused", counts.refused}};
}

nlohmann::ordered_json build_json(const bridge::TelemetryReport& report, const bridge::PortCounts& port,
                                  std::int64_t session) {
  return {{"schema", 1},
          {"session", session},
          {"heard", report.heard},
          {"early", report.early},
          {"states_left_out", report.thinned},
          {"packets", build_json(report.packets)},
          {"live", build_json(report.live)},
          {"malformed", port.malformed},
          {"lost", report.lost},
          {"states_lost", report.states_lost},
          {"transport_lost", port.lost}};
}

void print(std::FILE* to, const char* what, const bridge::OutletCounts& counts) {
  std::fprintf(to, "  %-8s %lld sent, %lld dropped; %s now, %lld refused\n", what, static_cast<long long>(counts.sent),
               static_cast<long long>(counts.dropped), count(counts.clients, "client").c_str(),
               static_cast<long long>(counts.refused));
}

int run(const Options& options) {
  never_wait_for_stderr();
  const std::atomic<bool>& stop = catch_interrupts();
  check_output(options.json);
  check_output(options.xtce);
  std::optional<hil::Scenario> scenario;
  if (!options.scenario.empty()) scenario = hil::load_scenario(options.scenario);
  const std::unique_ptr<bridge::Telemetry> telemetry = open(options.telemetry);
  const auto port = open_port(options.transport, bridge::Role::kObserver);
  std::int64_t session = 0;
  telemetry->on_layout = [&](const bridge::SessionLayout& layout) {
    session = layout.get_session();
    std::fprintf(stderr, "unlatch telemetry: session of '%s'\n", layout.get_scenario().c_str());
    if (options.xtce.empty()) return;
    bridge::SessionLayout named = layout;
    if (scenario && !named.take_modes(scenario->model))
      std::fprintf(stderr,
                   "unlatch telemetry: the session has other joints than %s, so modes have their numbers alone in %s\n",
                   options.scenario.c_str(), options.xtce.c_str());
    write_text(bridge::write_xtce(named), options.xtce);
    std::fprintf(stderr, "unlatch telemetry: its packets are described in %s\n", options.xtce.c_str());
  };
  std::fprintf(stderr, "unlatch telemetry: waits for a session on %s\n", options.transport.name.c_str());

  hil::Message message;
  const auto begun = Clock::now();
  auto ended = Clock::time_point::max();
  bool busy = false;
  for (auto now = begun; !stop.load() && now - kTelemetryLinger < ended; now = Clock::now()) {
    if (options.seconds > 0 && now - begun > std::chrono::duration<double>(options.seconds)) break;
    if (port->poll(message, busy ? 0ms : kWait)) {
      telemetry->hear(message, now);
      const bool is_last = message.kind == hil::MessageKind::kState && message.state.part == 0 &&
                           message.state.status >= static_cast<std::int32_t>(hil::RunStatus::kDone) &&
                           message.state.session == session;
      if (is_last && options.until_end && ended == Clock::time_point::max()) ended = now;
    }
    busy = telemetry->serve();
  }
  const bridge::TelemetryReport report = telemetry->get_report();
  std::FILE* const people = get_people_stream(options.json);
  std::fprintf(people, "%s\n", session == 0 ? "no session was found" : "telemetry of a session");
  print(people, "packets", report.packets);
  print(people, "live", report.live);
  if (report.lost > 0)
    std::fprintf(
        stderr,
        "unlatch telemetry: %s of the session never came here, by their numbers (%lld of State): nobody behind "
        "this program received them\n",
        count(report.lost, "message").c_str(), static_cast<long long>(report.states_lost));
  write_json(build_json(report, port->get_counts(), session), options.json);
  return session != 0 ? kExitDone : kExitFailed;
}

}  // namespace

void add_telemetry(Command app, int& exit_code) {
  auto options = std::make_shared<Options>();
  Command command = app.add_verb(
      "telemetry",
      "Gives a running session to control rooms and displays: as CCSDS space packets over UDP and TCP with their XTCE "
      "description, for Yamcs and COSMOS, and live over the Foxglove WebSocket protocol. It is an ordinary subscriber: "
      "the simulator never waits for it.",
      "unlatch telemetry --transport udp --packets-tcp 127.0.0.1:10015 --xtce session.xml\n"
      "unlatch telemetry --transport udp --live 127.0.0.1:8765");
  add_transport_options(command, options->transport, false);
  command.add_option("--packets", options->telemetry.udp, "sends each space packet as a datagram to this address")
      .type_name("ADDRESS:PORT")
      .check(check_address);
  command
      .add_option("--packets-tcp", options->telemetry.tcp,
                  "space packets back to back for TCP clients at this address; at most 8")
      .type_name("ADDRESS:PORT")
      .check(check_address);
  command.add_option("--xtce", options->xtce, "XTCE description of the session's packets to write").type_name("FILE");
  command
      .add_option("--scenario", options->scenario,
                  "the session's scenario, for --xtce: modes of joints have their names, which no message has")
      .type_name("SCENARIO");
  command.add_option("--live", options->telemetry.live, "Foxglove WebSocket at this address; at most 8 clients")
      .type_name("ADDRESS:PORT")
      .check(check_address);
  command
      .add_option("--origin", options->telemetry.origins,
                  "origin of a web page that may connect to --live, beside those of this machine and of Foxglove")
      .type_name("URL")
      .repeatable();
  command.add_option("--rate", options->telemetry.rate, "States in a second of wall time at most; 0: all")
      .type_name("HZ")
      .not_negative()
      .default_shown();
  command.add_option("--for", options->seconds, "ends after this wall time, s (default: never)")
      .type_name("SECONDS")
      .seconds();
  command.add_flag("--until-end", options->until_end, "ends with the session");
  command.add_json_option(options->json, "numbers of messages and clients");
  command.parsed_callback([options] {
    const bridge::TelemetryOptions& to = options->telemetry;
    if (to.udp.empty() && to.tcp.empty() && to.live.empty() && options->xtce.empty())
      refuse_option("--packets", "nothing to write to: give --packets, --packets-tcp, --live or --xtce");
    if (!options->scenario.empty() && options->xtce.empty())
      refuse_option("--scenario", "it gives modes their names in the file of --xtce: give that, too");
  });
  command.callback([options, &exit_code] { exit_code = run(*options); });
}

}  // namespace unlatch::tools
