// unlatch diff: where two recordings part, to the last bit.
#include <bit>
#include <cinttypes>

#include "hil/log_diff.h"
#include "hil/replay.h"
#include "tools/exit_codes.h"
#include "tools/unlatch/commands.h"
#include "tools/unlatch/report.h"
#include "tools/unlatch/terminal.h"

namespace unlatch::tools {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kFieldsShown = 12;  // to people; the JSON has all

struct DiffOptions {
  std::string logs[2], json;
};

// One recording, and a simulation at its beginning.
struct Opened {
  explicit Opened(const std::string& path)
      : recording(hil::LogFileReader(path)),
        scenario(hil::load_recorded_scenario(recording.header)),
        simulation(hil::build_recorded_simulation(recording.header, scenario, path)) {}
  hil::RecordingReader recording;
  const hil::Scenario scenario;
  const std::unique_ptr<hil::Simulation> simulation;
};

struct DiffReport {
  const DiffOptions& options;
  const std::array<Opened, 2>& opened;
  const hil::LogDiff& diff;

  [[nodiscard]] const Model& get_model() const { return opened[0].scenario.model; }
  [[nodiscard]] double get_time(std::int64_t tick) const {
    return static_cast<double>(tick) * opened[0].recording.header.dt;
  }
};

const char* get_result(const hil::LogDiff& diff) {
  if (diff.state) return "different";
  if (diff.is_damaged()) return "damaged";
  if (diff.agrees()) return "same";
  return diff.input ? "inputs" : "ends";
}

bool has_same_bits(const hil::Two& values) {
  return std::bit_cast<std::uint64_t>(values[0]) == std::bit_cast<std::uint64_t>(values[1]);
}

std::string describe(const hil::LogEnding& ending) {
  if (!ending.status) return ending.message;
  const std::string status = get_status_name(*ending.status);
  return "its run ended, " + status + (ending.message.empty() ? "" : ": " + ending.message);
}

const char* get_cause_name(hil::ChangeCause cause) {
  return hil::kChangeCauseNames[static_cast<std::size_t>(cause)];  // of a record that was decoded: it has one
}

// --- For people -----------------------------------------------------------------------------------------------------

void print_fields(std::FILE* to, const DiffReport& report, const hil::StateDifference& difference) {
  if (difference.fields_tick < 0) {
    std::fprintf(to, "  which fields differ cannot be told: not both states can be computed or are recorded\n");
    return;
  }
  if (difference.fields_tick != difference.tick) {
    std::fprintf(to, "  of the states recorded next, at tick %" PRId64 " (t = %.9g s):\n", difference.fields_tick,
                 report.get_time(difference.fields_tick));
  }
  for (std::size_t i = 0; i < difference.fields.size() && i < kFieldsShown; ++i) {
    const hil::FieldDifference& field = difference.fields[i];
    const auto ulps = field.calc_ulps();
    std::fprintf(to, "  %-24s %-10s %24.17g %24.17g", field.of.c_str(), field.field.c_str(), field.get_a(),
                 field.get_b());
    if (ulps) std::fprintf(to, "  %" PRIu64 " ULP", *ulps);
    std::fprintf(to, "\n");
  }
  if (difference.fields.size() > kFieldsShown) {
    std::fprintf(to, "  … and %zu fields more\n", difference.fields.size() - kFieldsShown);
  }
}

void print_inputs(std::FILE* to, const DiffReport& report, const hil::StateDifference& difference) {
  if (difference.channels.empty()) {
    std::fprintf(to, "  no step led there: the recordings begin with it\n");
    return;
  }
  std::fprintf(to, "inputs of the step to it, from tick %" PRId64 ":\n", difference.tick - 1);
  for (std::size_t i = 0; i < difference.channels.size(); ++i) {
    const hil::Two& values = difference.channels[i];
    std::fprintf(to, "  %-24s %-10s %24.17g %24.17g  %s\n", report.get_model().channels[i].name.c_str(), "", values[0],
                 values[1], has_same_bits(values) ? "" : "differs");
  }
  for (std::size_t k = 0; k < 2; ++k) {
    for (const hil::LogChange& change : difference.changes[k]) {
      std::fprintf(to, "  %s: %s set by %s %" PRId64 " of participant %d\n", report.options.logs[k].c_str(),
                   report.get_model().channels[static_cast<std::size_t>(change.channel)].name.c_str(),
                   get_cause_name(change.cause), change.sequence, change.participant);
    }
  }
}

void print_first_input(std::FILE* to, const DiffReport& report, const hil::InputDifference& input) {
  std::fprintf(to, "first difference of inputs: channel '%s' of the step from tick %" PRId64 ": %.17g and %.17g\n",
               report.get_model().channels[static_cast<std::size_t>(input.channel)].name.c_str(), input.tick,
               input.values[0], input.values[1]);
}

void print_endings(std::FILE* to, const DiffReport& report) {
  for (std::size_t k = 0; k < 2; ++k) {
    const hil::LogEnding& ending = report.diff.endings[k];
    if (!report.diff.state) {
      std::fprintf(to, "  %s: up to tick %" PRId64 "; %s\n", report.options.logs[k].c_str(), ending.tick,
                   describe(ending).c_str());
    }
    if (ending.unreproduced >= 0) {
      const hil::LogHeader& header = report.opened[k].recording.header;
      std::fprintf(to, "  %s: this program gives other bits from tick %" PRId64 " on; it was recorded by %s, %s\n",
                   report.options.logs[k].c_str(), ending.unreproduced, header.program.c_str(),
                   header.compiler.c_str());
    }
  }
}

void print_diff(std::FILE* to, const DiffReport& report) {
  const hil::LogDiff& diff = report.diff;
  const std::string both = report.options.logs[0] + " and " + report.options.logs[1];
  if (diff.state) {
    const std::string text = "first difference at tick " + std::to_string(diff.state->tick);
    std::fprintf(to, "%s (t = %.9g s): state hash %s and %s\n", paint(to, Colour::kRed, text).c_str(),
                 report.get_time(diff.state->tick), to_hex(diff.state->hashes[0]).c_str(),
                 to_hex(diff.state->hashes[1]).c_str());
    print_fields(to, report, *diff.state);
    print_inputs(to, report, *diff.state);
  } else {
    const bool same = diff.agrees() && !diff.is_damaged();
    const std::string text = "the same bits at all " + std::to_string(diff.compared) + " ticks that both have";
    std::fprintf(to, "%s: %s, from tick %" PRId64 " on%s\n", both.c_str(),
                 paint(to, same ? Colour::kGreen : Colour::kYellow, text).c_str(), diff.first_tick,
                 same ? "" : ", and yet they differ");
  }
  if (diff.input) print_first_input(to, report, *diff.input);
  print_endings(to, report);
}

// --- For programs ---------------------------------------------------------------------------------------------------

Json build_difference(const DiffReport& report, const hil::StateDifference& difference) {
  Json fields = Json::array(), inputs = Json::array(), changes = Json::array();
  for (const hil::FieldDifference& field : difference.fields) {
    fields.push_back({{"of", field.of}, {"field", field.field}, {"a", field.get_a()}, {"b", field.get_b()}});
    if (const auto ulps = field.calc_ulps()) fields.back()["ulp"] = *ulps;
  }
  const auto channel_name = [&](std::size_t i) { return report.get_model().channels[i].name; };
  for (std::size_t i = 0; i < difference.channels.size(); ++i) {
    const hil::Two& values = difference.channels[i];
    inputs.push_back(
        {{"channel", channel_name(i)}, {"a", values[0]}, {"b", values[1]}, {"same", has_same_bits(values)}});
  }
  for (const auto& side : difference.changes) {
    Json& list = changes.emplace_back(Json::array());
    for (const hil::LogChange& change : side) {
      list.push_back({{"channel", channel_name(static_cast<std::size_t>(change.channel))},
                      {"value", change.value},
                      {"cause", get_cause_name(change.cause)},
                      {"participant", change.participant},
                      {"sequence", change.sequence}});
    }
  }
  return {{"tick", difference.tick},
          {"t", report.get_time(difference.tick)},
          {"hash", {to_hex(difference.hashes[0]), to_hex(difference.hashes[1])}},
          {"fields_tick", difference.fields_tick},
          {"fields", fields},
          {"inputs", inputs},
          {"changes", changes}};
}

Json build_json(const DiffReport& report) {
  const hil::LogDiff& diff = report.diff;
  const hil::LogHeader& header = report.opened[0].recording.header;
  Json json = {{"schema", 1},     {"scenario", header.scenario_name}, {"result", get_result(diff)},
               {"dt", header.dt}, {"first_tick", diff.first_tick},    {"ticks_compared", diff.compared}};
  if (diff.state) json["difference"] = build_difference(report, *diff.state);
  if (diff.input) {
    json["first_input"] = {{"tick", diff.input->tick},
                           {"channel", report.get_model().channels[static_cast<std::size_t>(diff.input->channel)].name},
                           {"a", diff.input->values[0]},
                           {"b", diff.input->values[1]}};
  }
  json["logs"] = Json::array();
  for (std::size_t k = 0; k < 2; ++k) {
    const hil::LogEnding& ending = diff.endings[k];
    Json& log = json["logs"].emplace_back(Json{{"file", report.options.logs[k]}, {"last_tick", ending.tick}});
    if (ending.status) log["status"] = get_status_name(*ending.status);
    if (!ending.message.empty()) log["message"] = ending.message;
    if (ending.unreproduced >= 0) log["unreproduced_from"] = ending.unreproduced;
  }
  return json;
}

int run(const DiffOptions& options) {
  std::array<Opened, 2> opened{Opened(options.logs[0]), Opened(options.logs[1])};
  const hil::LogDiff diff =
      hil::diff({&opened[0].recording, &opened[1].recording}, {opened[0].simulation.get(), opened[1].simulation.get()});
  const DiffReport report{options, opened, diff};
  print_diff(get_people_stream(options.json), report);
  write_json(build_json(report), options.json);
  if (!diff.state && diff.is_damaged()) return kExitUsage;
  return diff.agrees() ? kExitDone : kExitFailed;
}

}  // namespace

void add_diff(CLI::App& app, int& exit_code) {
  auto options = std::make_shared<DiffOptions>();
  CLI::App* command = app.add_subcommand(
      "diff",
      "Compares two recordings of one model: the first tick, body and field that differ, by how much, and what the "
      "step "
      "that led there was told. Exit code 0: the same bits and inputs to the same end; 1: not; 2: they cannot be "
      "compared.\nExample: unlatch diff yesterday.log today.log");
  command->add_option("A", options->logs[0], "recording made by --log")->required();
  command->add_option("B", options->logs[1], "another")->required();
  command->add_option("--json", options->json, "file for the result as JSON, or - for standard output");
  command->callback([options, &exit_code] { exit_code = run(*options); });
}

}  // namespace unlatch::tools
