#include "tools/watch/screen.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "tools/common/terminal.h"
#include "tools/common/text.h"
#include "unlatch/model.h"

namespace unlatch::tools {
namespace {

using hil::MessageKind;
using hil::RunStatus;

constexpr std::size_t kBar = 24;  // characters
constexpr double kNsPerUs = 1000;

// The first `columns` characters.
std::string cut(const std::string& text, std::size_t columns) {
  std::size_t end = 0, left = columns;
  while (end < text.size()) {
    if ((text[end] & 0xc0) != 0x80 && left-- == 0) break;
    ++end;
  }
  return text.substr(0, end);
}

std::string pad(const std::string& text, std::size_t columns) {
  const std::string fit = cut(text, columns);
  return fit + std::string(columns - count_characters(fit), ' ');
}

std::string pad_left(const std::string& text, std::size_t columns) {
  const std::size_t length = count_characters(text);
  return (length < columns ? std::string(columns - length, ' ') : "") + text;
}

// Four digits, or as many as fit.
std::string write(double value, std::size_t columns) {
  std::string text;
  for (int digits = 4; digits > 0; --digits) {
    text = format("%.*g", digits, value);
    if (text.size() <= columns) break;
  }
  return text;
}

// A line of pieces, each in a colour of its own, never wider than the screen.
class Line {
 public:
  Line(const ScreenOptions& options) : colours_(options.colours), left_(options.columns) {}
  Line& add(const std::string& text) {
    const std::string fit = cut(text, left_);
    left_ -= count_characters(fit);
    text_ += fit;
    return *this;
  }
  Line& add(Colour colour, const std::string& text) {
    const std::string fit = cut(text, left_);
    left_ -= count_characters(fit);
    text_ += fit.empty() ? "" : paint(colours_, colour, fit);
    return *this;
  }
  [[nodiscard]] const std::string& get() const { return text_; }
  [[nodiscard]] std::size_t get_left() const { return left_; }

 private:
  bool colours_;
  std::size_t left_;
  std::string text_;
};

// Pieces behind a heading, each whole: one for which the line has no place begins another, indented line.
class Flow {
 public:
  Flow(const ScreenOptions& options, const std::string& heading) : options_(options), line_(options) {
    line_.add(Colour::kBold, heading);
  }
  Flow& add(const std::string& text) {
    place(text);
    line_.add(text);
    return *this;
  }
  // `rest` stands behind the coloured text, on the same line.
  Flow& add(Colour colour, const std::string& text, const std::string& rest = {}) {
    place(text + rest);
    line_.add(colour, text).add(rest);
    return *this;
  }
  [[nodiscard]] std::vector<std::string> get() const {
    std::vector<std::string> lines = full_;
    lines.push_back(line_.get());
    return lines;
  }

 private:
  static constexpr std::size_t kIndent = 10;

  // Makes place for a space and the piece.
  void place(const std::string& piece) {
    if (line_.get_left() > count_characters(piece)) {
      line_.add(" ");
      return;
    }
    full_.push_back(line_.get());
    line_ = Line(options_);
    line_.add(std::string(std::min(kIndent, options_.columns / 4), ' '));
  }

  const ScreenOptions& options_;
  Line line_;
  std::vector<std::string> full_;
};

const char* get_status_text(RunStatus status) {
  static constexpr std::array<const char*, 8> kTexts{
      "waits for flight software", "configured", "armed", "running", "paused", "done", "aborted", "faulted"};
  return kTexts[static_cast<std::size_t>(status)];
}

Colour get_status_colour(const View& view) {
  if (view.silent_s > 1 && view.status < RunStatus::kDone) return Colour::kRed;
  if (view.status == RunStatus::kAborted || view.status == RunStatus::kFaulted) return Colour::kRed;
  return view.status == RunStatus::kPaused ? Colour::kYellow : Colour::kGreen;
}

std::string build_bar(double share) {
  const double bounded = std::isfinite(share) ? std::clamp(share, 0.0, 1.0) : 0.0;
  const auto filled = static_cast<std::size_t>(std::lround(bounded * static_cast<double>(kBar)));
  return "[" + std::string(filled, '#') + std::string(kBar - filled, '.') + "]";
}

// The typical value as #, up to the worst as -, of a limit.
std::string build_time_bar(double typical, double worst, double limit) {
  std::string bar = build_bar(limit > 0 ? worst / limit : 0);
  std::replace(bar.begin(), bar.end(), '#', '-');
  const double share = limit > 0 ? std::clamp(typical / limit, 0.0, 1.0) : 0.0;
  const auto filled = static_cast<std::size_t>(std::lround(share * static_cast<double>(kBar)));
  for (std::size_t i = 0; i < std::max<std::size_t>(filled, typical > 0 ? 1 : 0); ++i) bar[1 + i] = '#';
  return bar;
}

class Screen {
 public:
  Screen(const View& view, const ScreenOptions& options) : view_(view), options_(options) {}

  std::vector<std::string> draw() {
    if (view_.session != 0) {
      draw_timing();
      draw_messages();
      draw_participants();
    }
    const std::vector<std::string> below = std::move(lines_);
    lines_.clear();
    draw_head();
    if (view_.session != 0) {
      // Lists share what the fixed lines leave: joints first, then clearances, and the notices get the rest.
      const std::size_t fixed = lines_.size() + below.size() + kHeadings;
      const std::size_t room = options_.rows > fixed + kFewNotices ? options_.rows - fixed - kFewNotices : 2;
      const std::size_t joints =
          std::min(view_.joints.size(),
                   std::max<std::size_t>(
                       1, room - std::min(room - 1, std::min<std::size_t>(view_.clearances.size(), room / 3))));
      draw_joints(joints);
      draw_clearances(room > joints ? room - joints : 1);
      lines_.insert(lines_.end(), below.begin(), below.end());
      draw_notices();
    }
    if (lines_.size() > options_.rows) lines_.resize(options_.rows);
    return std::move(lines_);
  }

 private:
  static constexpr std::size_t kHeadings = 3;  // joints, clearances, notices
  static constexpr std::size_t kFewNotices = 4, kMostParticipants = 4;

  Line begin() const { return Line(options_); }
  void add(const Line& line) { lines_.push_back(line.get()); }
  Flow begin_flow(const std::string& heading) const { return {options_, heading}; }
  void add(const Flow& flow) {
    for (std::string& line : flow.get()) lines_.push_back(std::move(line));
  }

  void draw_head() {
    Flow line = begin_flow("unlatch watch");
    line.add(" " + options_.transport + " ");
    if (view_.session == 0) {
      add(line.add(Colour::kYellow, "waits for a simulator"));
      return;
    }
    line.add(Colour::kBold, view_.scenario.empty() ? "(no Hello yet)" : view_.scenario);
    line.add(format(" session %llx ", static_cast<unsigned long long>(view_.session)));
    const bool is_silent = view_.silent_s > 1 && view_.status < RunStatus::kDone;
    const std::string status = is_silent ? format("silent for %.0f s", view_.silent_s) : get_status_text(view_.status);
    const std::string pace =
        view_.has_hello ? ", " + std::string(get_text(static_cast<hil::Pace>(view_.hello.pace))) : "";
    add(line.add(get_status_colour(view_), status, pace));

    Line time = begin();
    time.add(format("t %.3f s", view_.time));
    if (view_.has_hello && view_.hello.last_tick > 0) {
      const double end = static_cast<double>(view_.hello.last_tick) * static_cast<double>(view_.hello.dt_ns) * 1e-9;
      time.add(format(" of %g s ", end) + build_bar(view_.time / end));
    }
    time.add(format("  tick %lld", static_cast<long long>(view_.tick)));
    if (view_.has_hello) time.add(format("  step %g ms", static_cast<double>(view_.hello.dt_ns) * 1e-6));
    add(time);
    if (!view_.scenario_note.empty()) add(begin().add(Colour::kYellow, view_.scenario_note));
  }

  void draw_joints(std::size_t shown) {
    if (view_.joints.empty()) return;
    const bool known = view_.reactions_tick >= 0;
    const bool wide = options_.columns >= 95;  // a terminal of 80 columns has all of it, in narrower ones
    const std::size_t name = wide ? 14 : 11, mode = wide ? 12 : 9, column = wide ? 10 : 9;
    std::string heading = pad("Joint", name) + pad("mode", mode);
    for (const char* row : kRowNames) heading += known ? pad_left(row, column) : "";
    add(begin().add(Colour::kBold, heading + (known ? (wide ? "  N, N m" : " N,N m") : "reactions: none yet")));
    for (std::size_t i = 0; i < std::min(shown, view_.joints.size()); ++i) {
      const WatchedJoint& joint = view_.joints[i];
      Line line = begin();
      line.add(pad(joint.name, name - 1) + " ").add(Colour::kGreen, pad(joint.mode, mode - 1)).add(" ");
      for (const double value : joint.reaction) {
        if (known) line.add(pad_left(write(value, column - 1), column));
      }
      add(line);
    }
    add_rest(view_.joints.size(), shown, "joints");
  }

  void draw_clearances(std::size_t shown) {
    if (view_.clearances.empty()) return;
    add(begin().add(Colour::kBold, pad("Clearance", 30) + "     now      smallest of the states seen here"));
    for (std::size_t i = 0; i < std::min(shown, view_.clearances.size()); ++i) {
      const hil::Clearance& clearance = view_.clearances[i];
      const std::string pair = clearance.name_a + " – " + clearance.name_b;
      Line line = begin();
      line.add(pad(pair, 29) + " ");
      line.add(clearance.now > 0 ? Colour::kGreen : Colour::kRed, format("%8.3f m", clearance.now));
      line.add(format("%8.3f m at %.3f s", clearance.smallest, clearance.time));
      if (clearance.method == hil::DistanceMethod::kMesh)
        line.add(Colour::kDim, std::string("  ") + hil::get_method_name(clearance.method));
      add(line);
    }
    add_rest(view_.clearances.size(), shown, "pairs");
  }

  void add_rest(std::size_t all, std::size_t shown, const char* what) {
    if (all > shown) add(begin().add(Colour::kDim, format("  … and %zu %s more", all - shown, what)));
  }

  void draw_timing() {
    if (!view_.health) {
      add(begin().add(Colour::kBold, "Time  ").add("no Health yet"));
      return;
    }
    const hil::HealthMessage& health = *view_.health;
    const auto us = [](std::int64_t ns) { return static_cast<double>(ns) / kNsPerUs; };
    const double tick_us = us(view_.hello.dt_ns);
    add(begin_flow("Step     ")
            .add(build_time_bar(us(health.step_p50_ns), us(health.step_max_ns), tick_us))
            .add(format("median %.1f,", us(health.step_p50_ns)))
            .add(format("worst %.1f of %g us", us(health.step_max_ns), tick_us)));
    add(begin_flow("Wake-up  ")
            .add(build_time_bar(us(health.wakeup_p50_ns), us(health.wakeup_max_ns), tick_us))
            .add(format("median %.1f,", us(health.wakeup_p50_ns)))
            .add(format("worst %.1f us;", us(health.wakeup_max_ns)))
            .add(health.overruns > 0 ? Colour::kRed : Colour::kGreen,
                 format("overruns %lld", static_cast<long long>(health.overruns))));
  }

  void draw_messages() {
    Flow line = begin_flow("Messages ");
    for (const MessageKind kind :
         {MessageKind::kState, MessageKind::kCommand, MessageKind::kStepAck, MessageKind::kEvent}) {
      line.add(format("%s %.0f/s%c", std::string(get_kind_name(kind)).c_str(),
                      view_.rates[static_cast<std::size_t>(kind)], kind == MessageKind::kEvent ? ';' : ','));
    }
    const std::int64_t lost = std::max(view_.lost, view_.port.lost);
    add(line.add(lost > 0 ? Colour::kRed : Colour::kGreen, format("lost %lld", static_cast<long long>(lost)),
                 format(", repeated %lld, malformed %lld", static_cast<long long>(view_.repeated),
                        static_cast<long long>(view_.port.malformed)) +
                     (view_.port.unfit > 0 ? format(", unfit %lld", static_cast<long long>(view_.port.unfit)) : "")));
    if (!view_.health) return;
    std::int64_t refused = 0;
    for (const std::int64_t count : view_.health->rejected) refused += count;
    add(begin_flow("Simulator")
            .add(format("commands late %lld, refused %lld;", static_cast<long long>(view_.health->late),
                        static_cast<long long>(refused)))
            .add(format("dropped %lld, resent %lld;", static_cast<long long>(view_.health->dropped),
                        static_cast<long long>(view_.health->resent)))
            .add(format("absent %lld", static_cast<long long>(view_.health->missing))));
  }

  void draw_participants() {
    for (std::size_t i = 0; i < std::min(view_.participants.size(), kMostParticipants); ++i) {
      const WatchedParticipant& one = view_.participants[i];
      const bool is_ready = one.status == hil::AckStatus::kReady;
      Flow line = begin_flow("Participant");
      line.add(pad(one.name, 14));
      const bool is_over = view_.status >= hil::RunStatus::kDone;
      const std::string status = is_ready                                 ? "ready"
                                 : one.status == hil::AckStatus::kRefused ? "refuses"
                                 : is_over                                ? "has left"
                                                                          : "is missing";
      line.add(is_ready ? Colour::kGreen : Colour::kYellow, status, one.tick >= 0 ? "," : "");
      if (one.tick >= 0) {
        line.add(format("answered tick %lld, %lld behind;", static_cast<long long>(one.tick),
                        static_cast<long long>(std::max<std::int64_t>(0, view_.tick - one.tick))));
        line.add(count(static_cast<std::size_t>(one.commands), "command"));
      }
      add(line);
    }
  }

  void draw_notices() {
    if (view_.notices.empty() || lines_.size() + 2 > options_.rows) return;
    add(begin().add(Colour::kBold, "Notices"));
    const std::size_t shown = std::min(view_.notices.size(), options_.rows - lines_.size());
    for (auto notice = view_.notices.end() - static_cast<std::ptrdiff_t>(shown); notice != view_.notices.end();
         ++notice) {
      Line line = begin();
      line.add(format("  %10.4f s  ", notice->time));
      const std::string text =
          notice->text + (notice->count > 1 ? "  (" + std::to_string(notice->count) + " times)" : "");
      notice->is_bad ? line.add(Colour::kYellow, text) : line.add(text);
      add(line);
    }
  }

  const View& view_;
  const ScreenOptions& options_;
  std::vector<std::string> lines_;
};

}  // namespace

std::vector<std::string> draw(const View& view, const ScreenOptions& options) { return Screen(view, options).draw(); }

std::string describe(const View& view) {
  if (view.session == 0) return "waits for a simulator";
  std::string text = format("t %.3f s, tick %lld, ", view.time, static_cast<long long>(view.tick));
  const bool is_silent = view.silent_s > 1 && view.status < RunStatus::kDone;
  text += is_silent ? format("silent for %.0f s", view.silent_s) : get_status_text(view.status);
  text += format("; %.0f states/s, lost %lld", view.rates[static_cast<std::size_t>(MessageKind::kState)],
                 static_cast<long long>(std::max(view.lost, view.port.lost)));
  if (view.health) {
    text +=
        format("; step %.1f us, worst %.1f us, overruns %lld", static_cast<double>(view.health->step_p50_ns) / kNsPerUs,
               static_cast<double>(view.health->step_max_ns) / kNsPerUs, static_cast<long long>(view.health->overruns));
  }
  for (const WatchedJoint& joint : view.joints) text += "; " + joint.name + " " + joint.mode;
  return text;
}

}  // namespace unlatch::tools
