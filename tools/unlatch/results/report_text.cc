#include <algorithm>
#include <array>
#include <cmath>

#include "tools/common/alike.h"
#include "tools/common/terminal.h"
#include "tools/common/text.h"
#include "tools/unlatch/results/accuracy_report.h"
#include "tools/unlatch/results/finding_report.h"
#include "tools/unlatch/results/redundancy.h"
#include "tools/unlatch/results/report.h"
#include "tools/unlatch/results/verdict_report.h"

namespace unlatch::tools {
namespace {

// Only what is not as it should be.
void print_search(std::FILE* to, const hil::SearchTotals& search) {
  const auto print = [&](std::int64_t number, const char* what, const char* text) {
    if (number > 0) std::fprintf(to, "  %s %s\n", count(static_cast<std::size_t>(number), what).c_str(), text);
  };
  print(search.postponed, "instant", "of events left to the next tick: the bound on splits of a step was reached");
  print(search.unlocated, "instant", "of events known badly: the tries of a step ran out");
  print(search.corners, "corner", "of laws at which no step was split: a step is split at eight of them");
  print(search.unseen, "step", "in which shapes may have touched unseen: its looks ran out");
}

// The model's events and what the executive said, in one order of time.
void print_timeline(std::FILE* to, const RunReport& report) {
  std::vector<hil::TimelineEntry> entries = report.analysis.timeline;
  for (const hil::EventMessage& notice : report.notices) {
    entries.push_back(
        {notice.time, std::string(hil::get_name(notice.name)), std::string(hil::get_name(notice.subject))});
  }
  std::stable_sort(entries.begin(), entries.end(), [](const auto& a, const auto& b) { return a.time < b.time; });
  print_heading(to, "Events");
  if (entries.empty()) std::fputs("  none\n", to);
  std::vector<std::string> keys, names, subjects;  // of one instant those alike are one
  for (const auto& entry : entries) {
    keys.push_back(format("%.6f ", entry.time) + without_numbers(entry.name) + " " + without_numbers(entry.subject));
    names.push_back(entry.name);
    subjects.push_back(entry.subject);
  }
  for (const std::vector<std::size_t>& group : group_alike(keys)) {
    const std::size_t first = group.front(), last = group.back();
    std::string shapes = first == last && !entries[first].shapes.empty() ? "  " + entries[first].shapes : "";
    if (const double uncertainty = report.analysis.calc_time_uncertainty(entries[first]);
        uncertainty > hil::TimelineEntry::kKnown)
      shapes += format("  ± %.2g s", uncertainty);
    std::fprintf(to, "  %12.6f s  %-20s %s%s\n", entries[first].time,
                 names[first] == names[last] ? names[first].c_str() : name_group(group, names).c_str(),
                 subjects[first] == subjects[last] ? subjects[first].c_str() : name_group(group, subjects).c_str(),
                 shapes.c_str());
  }
  print_search(to, report.analysis.search);
}

// "at 1.3000 s"; where the distance does not change for long, "from 0.0420 to 0.0800 s".
std::string describe_time(const hil::Clearance& clearance) {
  constexpr int kLong = 10;  // knots: fewer are the bottom of a smooth curve
  char text[64];
  if (clearance.tie.count < kLong)
    std::snprintf(text, sizeof text, "at %9.4f s", clearance.time);
  else
    std::snprintf(text, sizeof text, "from %.4f to %.4f s", clearance.tie.from, clearance.tie.to);
  return text;
}

std::string describe_touch(const hil::Clearance& clearance) {
  char text[80];
  const char* const format = clearance.smallest < 0 ? "  they overlap, touch at %.4f s"
                             : clearance.method == hil::DistanceMethod::kMesh
                                 ? "  they touch at %.4f s, and may overlap: triangles have no depth"
                                 : "  they touch at %.4f s";
  std::snprintf(text, sizeof text, format, clearance.touch.value_or(clearance.time));
  return text;
}

// Beside distances that are not those of the kernel's shapes.
std::string describe_method(const hil::Clearance& clearance) {
  if (clearance.method == hil::DistanceMethod::kExact) return "";
  return std::string("  ") + hil::get_method_name(clearance.method);
}

void print_clearances(std::FILE* to, const RunReport& report) {
  if (report.analysis.clearances().empty()) return;
  print_heading(to, "Smallest clearances");
  const auto& clearances = report.analysis.clearances();
  std::vector<std::string> keys, pairs;
  for (const hil::Clearance& clearance : clearances) {
    pairs.push_back(clearance.name_a + " – " + clearance.name_b);
    keys.push_back(without_numbers(pairs.back()));
  }
  for (const std::vector<std::size_t>& group : group_alike(keys)) {
    const std::size_t least = *std::min_element(group.begin(), group.end(), [&](std::size_t i, std::size_t k) {
      return clearances[i].smallest < clearances[k].smallest;
    });
    const hil::Clearance& clearance = clearances[least];
    const std::string of_group = "  the smallest of " + count(group.size(), "pair") + " " + keys[least];
    std::fprintf(to, "  %-28s %12.6g m %s%s%s%s\n", pairs[least].c_str(), clearance.smallest,
                 describe_time(clearance).c_str(), describe_method(clearance).c_str(),
                 clearance.smallest > 0 ? "" : paint(to, Colour::kRed, describe_touch(clearance)).c_str(),
                 group.size() == 1 ? "" : of_group.c_str());
    if (!clearance.after_release || clearance.after_release->smallest == clearance.smallest) continue;
    std::fprintf(to, "  %-28s %12.6g m at %9.4f s, from the release at %.4f s on\n", "",
                 clearance.after_release->smallest, clearance.after_release->time, clearance.after_release->from);
  }
}

void print_contacts(std::FILE* to, const RunReport& report) {
  const std::vector<hil::ContactRecord> contacts = report.analysis.list_contacts();
  if (contacts.empty()) return;
  print_heading(to, "Contacts (F_n in N, impulse in N s, slip and depth in m, loss in J)");
  for (const hil::ContactRecord& c : contacts) {
    if (c.touches == 0 && !c.closed_at_start) {
      std::fprintf(to, "  %-20s no touch\n", c.name.c_str());
      continue;
    }
    const std::string begin = c.closed_at_start ? "closed at the start"
                                                : format("touch at %.6f s", *c.touch) +
                                                      (c.touches > 1 ? ", " + count(c.touches, "touch") : "");
    const std::string end = c.closed || !c.lift ? "closed at the end" : format("lift at %.6f s", *c.lift);
    std::fprintf(to, "  %-20s %s, %s, closed for %.4g s\n", c.name.c_str(), begin.c_str(), end.c_str(), c.duration);
    std::fprintf(to, "  %-20s peak %.5g at %.6f s, impulse %.5g, depth %.3g, slip %.3g, loss %.5g\n", "", c.peak_force,
                 c.peak_time, c.totals.impulse, c.depth, c.totals.slip, c.totals.dissipated);
  }
}

constexpr double kLeastPeak = 1e-6;  // of the largest in a line: how well smaller ones are known is not said

// Peaks that may be off between ticks and events, for the lines below their table.
class UncertainPeaks {
 public:
  void add(const std::string& name, const hil::PeakReaction& peak) {
    if (peak.is_uncertain()) append(known_, name + format(" ± %.2g", peak.uncertainty));
    if (peak.at_ticks) append(at_ticks_, name);
  }
  void print(std::FILE* to) const {
    print(to, "known between steps", known_);
    print(to, "as sampled at ticks and events", at_ticks_);
  }

 private:
  struct List {
    std::string text;
    std::size_t count = 0;
  };
  static constexpr std::size_t kMost = 6;
  static void append(List& list, const std::string& item) {
    if (++list.count <= kMost) list.text += (list.count > 1 ? ", " : "") + item;
  }
  static void print(std::FILE* to, const char* what, const List& list) {
    if (list.count == 0) return;
    const std::string more = list.count > kMost ? " and " + std::to_string(list.count - kMost) + " more" : "";
    std::fprintf(to, "  %s: %s%s\n", what, list.text.c_str(), more.c_str());
  }
  List known_, at_ticks_;
};

void print_reactions(std::FILE* to, const RunReport& report) {
  const auto& joints = report.scenario.model.joints;
  if (joints.empty()) return;
  print_heading(to, "Peak reactions (on the follower; N, N m) and the mode at the end");
  std::fprintf(to, "  %-12s", "joint");
  for (const char* row : kRowNames) std::fprintf(to, " %12s", row);
  std::fputs("  mode\n", to);
  const auto get_mode = [&](std::size_t i) -> const std::string& {
    return joints[i].modes[static_cast<std::size_t>(report.simulation.state().joints[i].mode)].name;
  };
  std::vector<std::string> keys, names;
  UncertainPeaks uncertain;
  for (std::size_t i = 0; i < joints.size(); ++i) {
    keys.push_back(without_numbers(joints[i].name) + " " + get_mode(i));
    names.push_back(joints[i].name);
  }
  for (const std::vector<std::size_t>& group : group_alike(keys)) {
    if (group.size() > 1) std::fprintf(to, "  %s, the largest of each row:\n", name_group(group, names).c_str());
    std::fprintf(to, "  %-12s", group.size() > 1 ? "" : names[group[0]].c_str());
    std::array<hil::PeakReaction, kRows> peaks{};
    std::array<std::size_t, kRows> of{};
    double largest = 0;  // N or N m, of any row
    for (std::size_t row = 0; row < kRows; ++row)
      for (const std::size_t i : group) {
        const hil::PeakReaction peak = report.analysis.get_peak(i, row);
        if (std::abs(peak.value) > std::abs(peaks[row].value)) peaks[row] = peak, of[row] = i;
        largest = std::max(largest, std::abs(peak.value));
      }
    for (std::size_t row = 0; row < kRows; ++row) {
      std::fprintf(to, " %12.5g", drop_rounding(peaks[row].value, largest));
      if (std::abs(peaks[row].value) > kLeastPeak * largest)
        uncertain.add(joints[of[row]].name + " " + kRowNames[row], peaks[row]);
    }
    std::fprintf(to, "  %s\n", get_mode(group[0]).c_str());
  }
  uncertain.print(to);
  for (const hil::SharedReactions& shared : report.analysis.shared)
    std::fprintf(to, "  %s, %g s to %g s\n", describe(report.scenario.model, shared.rows).c_str(), shared.from,
                 shared.until);
}

// Changes by events beyond the allowed ones. Allowed are: none for a release, its impulse and loss for a latch.
void print_audit(std::FILE* to, const std::vector<EventAudit>& audits) {
  if (audits.empty()) return;
  double momentum = 0, angular = 0, energy = 0, entitled = 0;
  for (const EventAudit& audit : audits) {
    momentum = std::max(momentum, norm(audit.jump.momentum - audit.allowed.momentum));
    angular = std::max(angular, norm(audit.jump.angular_momentum - audit.allowed.angular_momentum));
    energy = std::max(energy, std::abs(audit.jump.kinetic - audit.allowed.kinetic));
    entitled = std::max(entitled, std::abs(audit.allowed.kinetic));
  }
  print_heading(to, "Audit of momentum and energy");
  std::fprintf(to, "  at %s of events, largest unexplained change: %.3g kg m/s, %.3g kg m2/s, %.3g J\n",
               count(audits.size(), "instant").c_str(), momentum, angular, energy);
  std::fprintf(to, "  largest allowed change of kinetic energy by an event: %.6g J\n", entitled);
}

double to_us(std::int64_t ns) { return static_cast<double>(ns) * 1e-3; }

void print_durations(std::FILE* to, const char* name, const hil::DurationSummary& summary) {
  if (summary.count == 0) return;
  std::fprintf(to, "  %-22s", name);
  for (const std::int64_t ns :
       {summary.p50, summary.p90, summary.p99, summary.p999, summary.p9999, summary.p99999, summary.max}) {
    std::fprintf(to, " %9.1f", to_us(ns));
  }
  std::fputc('\n', to);
}

// Ticks that ended after the next was due: how many for which cause, and the worst of them.
void print_overruns(std::FILE* to, const hil::TimingSummary& timing) {
  std::fprintf(to, "  overruns %lld", static_cast<long long>(timing.overruns));
  const char* separator = " (";
  for (std::size_t i = 0; i < hil::kOverrunCauses; ++i) {
    if (timing.overrun_causes[i] == 0) continue;
    std::fprintf(to, "%s%s %lld", separator, hil::kOverrunCauseNames[i].data(),
                 static_cast<long long>(timing.overrun_causes[i]));
    separator = ", ";
  }
  if (timing.overruns > 0) std::fputc(')', to);
  if (timing.slipped_ns > 0) std::fprintf(to, ", slipped %.1f us", to_us(timing.slipped_ns));
  if (timing.skipped_outputs > 0) {
    std::fprintf(to, ", states not sent %lld", static_cast<long long>(timing.skipped_outputs));
  }
  std::fprintf(to, ", late commands %lld", static_cast<long long>(timing.late_commands));
  if (timing.late_answers > 0)
    std::fprintf(to, ", answers after the next State %lld", static_cast<long long>(timing.late_answers));
  if (timing.unanswered > 0)
    std::fprintf(to, ", States without an answer %lld", static_cast<long long>(timing.unanswered));
  std::fputc('\n', to);
  constexpr std::size_t kShown = 5;
  for (std::size_t i = 0; i < std::min(kShown, timing.worst_overruns.size()); ++i) {
    const hil::Overrun& overrun = timing.worst_overruns[i];
    std::fprintf(to,
                 "    tick %lld, %.1f us late, %s: woken %.1f, inputs %.1f, step %.1f (%s), outputs %.1f us; "
                 "since the one before: page faults %lld, preemptions %lld\n",
                 static_cast<long long>(overrun.timing.tick), to_us(overrun.late_ns),
                 hil::kOverrunCauseNames[static_cast<std::size_t>(overrun.cause)].data(),
                 to_us(overrun.timing.wakeup_ns), to_us(overrun.timing.input_ns), to_us(overrun.timing.step_ns),
                 count(static_cast<std::size_t>(overrun.timing.substeps), "integration").c_str(),
                 to_us(overrun.timing.output_ns), static_cast<long long>(overrun.page_faults),
                 static_cast<long long>(overrun.preemptions));
  }
}

void print_timing(std::FILE* to, const hil::TimingSummary& timing) {
  if (timing.step.count == 0) return;
  print_heading(to, "Timing");
  std::fprintf(to, "  %-22s %9s %9s %9s %9s %9s %9s %9s\n", "microseconds", "p50", "p90", "p99", "p99.9", "p99.99",
               "p99.999", "max");
  print_durations(to, "step", timing.step);
  print_durations(to, "wake-up latency", timing.wakeup);
  print_durations(to, "command in, state out", timing.turnaround);
  print_durations(to, "state out, answer in", timing.round_trip);
  if (timing.wakeup.count > 0) print_overruns(to, timing);
  std::int64_t refused = 0;
  std::string reasons;
  for (std::size_t i = 0; i < hil::kRejectReasons; ++i) {
    refused += timing.rejected[i];
    if (timing.rejected[i] == 0) continue;
    reasons += (reasons.empty() ? " (" : ", ") + std::string(hil::get_text(static_cast<hil::Reject>(i))) + " " +
               std::to_string(timing.rejected[i]);
  }
  if (timing.round_trip.count > 0 || timing.dropped > 0) {
    std::fprintf(
        to, "  messages dropped %lld, states resent %lld, commands refused %lld%s%s\n",
        static_cast<long long>(timing.dropped), static_cast<long long>(timing.resent), static_cast<long long>(refused),
        reasons.empty() ? "" : (reasons + ")").c_str(),
        timing.unused_commands == 0
            ? ""
            : (", " + count(static_cast<std::size_t>(timing.unused_commands), "command") + " for ticks after the end")
                  .c_str());
  }
}

void print_verdicts(std::FILE* to, const RunReport& report) {
  const std::vector<std::string> verdicts = build_verdicts(report);
  std::vector<std::string> keys;
  for (const std::string& verdict : verdicts) keys.push_back(without_numbers(verdict));
  for (const std::vector<std::size_t>& group : group_alike(keys)) {
    const std::string more = group.size() == 1 ? "" : "; and so for " + std::to_string(group.size() - 1) + " more";
    std::fprintf(to, "\n%s\n", paint(to, Colour::kRed, verdicts[group[0]] + more).c_str());
  }
}

void print_replay(std::FILE* to, const hil::ReplayResult& replay) {
  if (replay.agrees()) {
    const std::string text = "replayed: every bit agrees at " + std::string(replay.compared == 1 ? "the " : "all ") +
                             count(static_cast<std::size_t>(replay.compared), "tick") + " compared";
    std::fprintf(to, "  %s\n", paint(to, Colour::kGreen, text).c_str());
  } else if (replay.difference) {
    std::fprintf(
        to, "  %s\n",
        paint(to, Colour::kRed,
              "replayed: first difference at tick " + std::to_string(replay.difference->tick) + " (recorded " +
                  to_hex(replay.difference->recorded) + ", replayed " + to_hex(replay.difference->replayed) + ")")
            .c_str());
  } else {
    std::fprintf(to, "  %s\n", paint(to, Colour::kRed, "replayed: " + replay.mismatch).c_str());
  }
}

}  // namespace

void print_report(std::FILE* to, const RunReport& report) {
  const double dt = report.simulation.plan().get_options().dt;
  print_timeline(to, report);
  print_clearances(to, report);
  print_contacts(to, report);
  print_separations(to, report);
  print_reactions(to, report);
  print_audit(to, report.analysis.audits);
  print_energy(to, report.analysis.accuracy().get_energy());
  print_findings(to, report.scenario, list_warnings(report.scenario));
  print_accuracy_notices(to, report);
  if (report.accuracy) print_accuracy(to, *report.accuracy, dt);
  print_timing(to, report.timing);
  print_verdicts(to, report);
  print_requirements(to, report);
  print_session_verdicts(to, report);
  const bool ok = report.status == "ok";
  std::fprintf(to, "\n%s: %s, %s of %g s, t = %g s, state hash %s\n",
               paint(to, Colour::kBold, report.scenario.name).c_str(),
               paint(to, ok ? Colour::kGreen : Colour::kRed, report.status).c_str(),
               count(static_cast<std::size_t>(report.tick), "tick").c_str(), dt, static_cast<double>(report.tick) * dt,
               to_hex(report.hash).c_str());
  if (report.replay) print_replay(to, *report.replay);
  if (!report.message.empty()) std::fprintf(to, "  %s\n", report.message.c_str());
}

}  // namespace unlatch::tools
