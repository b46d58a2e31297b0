// unlatch diff: where two recordings part, to the last bit.
#include <cinttypes>

#include "tools/common/output.h"
#include "tools/common/terminal.h"
#include "tools/common/text.h"
#include "tools/program/exit_codes.h"
#include "tools/unlatch/recordings/diff_report.h"
#include "tools/unlatch/recordings/verbs.h"
#include "tools/unlatch/results/report.h"

namespace unlatch::tools {
namespace {

constexpr std::size_t kFieldsShown = 12;  // to people; the JSON has all

struct DiffOptions {
  std::string logs[2], json;
};

std::string describe(const hil::LogEnding& ending) {
  if (!ending.status) return ending.message;
  const std::string status = get_status_name(*ending.status);
  return "its run ended, " + status + (ending.message.empty() ? "" : ": " + ending.message);
}

// --- For people -----------------------------------------------------------------------------------------------------

void print_fields(std::FILE* to, const DiffReport& report, const hil::StateDifference& difference) {
  if (difference.fields_tick < 0) {
    std::fprintf(to,
                 "  the fields that differ are unknown: one of the states was not recorded and cannot be computed\n");
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
    std::fprintf(to, "  … and %s\n", count(difference.fields.size() - kFieldsShown, "more field").c_str());
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
      std::fprintf(to, "  %s: %s set by %s %" PRId64 " of participant %d\n", report.get_log(k).c_str(),
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
      std::fprintf(to, "  %s: up to tick %" PRId64 "; %s\n", report.get_log(k).c_str(), ending.tick,
                   describe(ending).c_str());
    }
    if (ending.unreproduced >= 0) {
      const hil::LogHeader& header = report.opened[k].recording.header;
      std::fprintf(to, "  %s: this program gives other bits from tick %" PRId64 " on; it was recorded by %s, %s\n",
                   report.get_log(k).c_str(), ending.unreproduced, header.program.c_str(), header.compiler.c_str());
    }
  }
}

void print_diff(std::FILE* to, const DiffReport& report) {
  const hil::LogDiff& diff = report.diff;
  const std::string both = report.get_log(0) + " and " + report.get_log(1);
  if (diff.state) {
    const std::string text = "first difference at tick " + std::to_string(diff.state->tick);
    std::fprintf(to, "%s (t = %.9g s): state hash %s and %s\n", paint(to, Colour::kRed, text).c_str(),
                 report.get_time(diff.state->tick), to_hex(diff.state->hashes[0]).c_str(),
                 to_hex(diff.state->hashes[1]).c_str());
    print_fields(to, report, *diff.state);
    print_inputs(to, report, *diff.state);
  } else {
    const bool same = diff.agrees() && !diff.is_damaged();
    const std::string text = "the same bits at " + std::string(diff.compared == 1 ? "the " : "all ") +
                             count(static_cast<std::size_t>(diff.compared), "tick") + " of both";
    std::fprintf(to, "%s: %s, from tick %" PRId64 " on%s\n", both.c_str(),
                 paint(to, same ? Colour::kGreen : Colour::kYellow, text).c_str(), diff.first_tick,
                 same ? "" : ", and yet they differ");
  }
  if (diff.input) print_first_input(to, report, *diff.input);
  print_endings(to, report);
}

int run(const DiffOptions& options) {
  check_output(options.json);
  std::array<OpenedLog, 2> opened{OpenedLog(options.logs[0]), OpenedLog(options.logs[1])};
  const hil::LogHeader& header = opened[0].recording.header;
  Progress progress(header.dt, header.last_tick);
  const hil::LogDiff diff =
      hil::diff({&opened[0].recording, &opened[1].recording}, {opened[0].simulation.get(), opened[1].simulation.get()},
                [&progress](std::int64_t tick) { progress.show(tick); });
  progress.clear();
  const DiffReport report{opened, diff};
  print_diff(get_people_stream(options.json), report);
  write_json(report, options.json);
  if (!diff.state && diff.is_damaged()) return kExitUsage;
  return diff.agrees() ? kExitDone : kExitFailed;
}

}  // namespace

void add_diff(Command app, int& exit_code) {
  auto options = std::make_shared<DiffOptions>();
  Command command = app.add_verb(
      "diff",
      "Compares two recordings of one model. Prints the first tick, body and field that differ, the "
      "difference, and the "
      "inputs of that step. Exit code 0: same bits, inputs and end; 1: different; 2: they cannot be compared.",
      "unlatch diff yesterday.log today.log");
  command.add_option("A", options->logs[0], "recording made by --log").required();
  command.add_option("B", options->logs[1], "second recording").required();
  command.add_json_option(options->json);
  command.callback([options, &exit_code] { exit_code = run(*options); });
}

}  // namespace unlatch::tools
