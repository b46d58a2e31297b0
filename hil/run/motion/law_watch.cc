#include "hil/run/motion/law_watch.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

#include "hil/scenario/base/index.h"
#include "unlatch/quantities.h"

namespace unlatch::hil {
namespace {

constexpr int kDeepest = 12;    // bisections: 1/4096 of a step
constexpr double kSure = 0.5;   // of a step that is proposed, or its error: the ticks may lie elsewhere
constexpr double kBent = 0.1;   // of the middle off the chord, relative to the law: what a step resolves has less
constexpr double kFlat = 1e-4;  // what bounds may leave unknown, relative to the law's size
// Part of a step: jumps are located this near to the end of a sub-step, and corners are passed
// (kernel/events/corners.h).
constexpr double kEnd = 2e-5;

bool is_number(const Course& course) {
  return std::isfinite(course.begin) && std::isfinite(course.middle) && std::isfinite(course.end);
}

double get_size(const Course& course) {
  return std::max({std::abs(course.begin), std::abs(course.middle), std::abs(course.end)});
}

bool is_time(const unlatch::Quantity& quantity) {
  using Kind = unlatch::Quantity::Kind;
  return quantity.kind == Kind::kTime || quantity.kind == Kind::kOnTime;
}

// Quantities that these laws read, other than laws.
std::set<int> list_read(const Model& model, const std::vector<int>& laws) {
  std::set<int> read;
  for (const int law : laws)
    for (const LawStep& step : model.laws[at(law)].steps)
      if (step.kind == LawStep::Kind::kQuantity &&
          model.quantities[at(step.subject)].kind != unlatch::Quantity::Kind::kLaw)
        read.insert(step.subject);
  return read;
}

}  // namespace

LawWatch::LawWatch(const Model& model, const Plan& plan, Laws laws)
    : laws_(laws), dt_(plan.get_options().dt), courses_(model, plan), quantities_(model.quantities.size()) {
  const std::vector<std::vector<int>> bodies = list_bodies_of_laws(model, Reading::kDirect);
  std::set<int> read;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    if (bodies[i].empty()) continue;
    Watched watched{.law = static_cast<int>(i),
                    .behind = list_laws_behind(model, static_cast<int>(i)),
                    .bodies = bodies[i],
                    .whole = {},
                    .rising = {}};
    const std::set<int> own = list_read(model, watched.behind);
    if (laws == Laws::kOfTime &&
        (own.empty() || !std::ranges::all_of(own, [&](int q) { return is_time(model.quantities[at(q)]); })))
      continue;
    read.insert(own.begin(), own.end());
    for (const int law : watched.behind)
      if (std::ranges::find(behind_, law) == behind_.end()) behind_.push_back(law);
    watched_.push_back(std::move(watched));
  }
  for (const int quantity : read) {
    Path path{.quantity = quantity};
    path.is_angle = get_unit(model, model.quantities[at(quantity)]) == "rad";
    paths_.push_back(path);
  }
}

// The quantities over this piece. False if one of them is no smooth function of time there: an angle that goes on at
// the other end of its range.
bool LawWatch::follow(const Piece& piece) {
  const double h = piece.to - piece.from, before = to_ - from_;
  bool goes_on = begun_ && to_ == piece.from && before > 0.1 * h;
  for (const Path& path : paths_) goes_on = goes_on && path.end == piece.at_from[at(path.quantity)];
  bool smooth = true;
  for (Path& path : paths_) {
    path.before = path.begin;
    path.begin = piece.at_from[at(path.quantity)];
    path.end = piece.at_to[at(path.quantity)];
    path.bend = 0;
    smooth = smooth && !(path.is_angle && std::abs(path.end - path.begin) > std::numbers::pi);
    if (!goes_on) continue;
    const double r = before / h;
    path.bend = ((path.before - path.begin) + r * (path.end - path.begin)) / (r * (r + 1));
  }
  begun_ = true;
  from_ = piece.from;
  to_ = piece.to;
  return smooth;
}

void LawWatch::set_quantities(double from, double to) {
  for (const Path& path : paths_) {
    const double rise = path.end - path.begin;
    const auto value = [&](double s) { return path.begin + s * (rise + path.bend * (s - 1)); };
    quantities_[at(path.quantity)] =
        Course::of_parabola(value(from), value(0.5 * (from + to)), to == 1 ? path.end : value(to));
  }
}

// All laws over the whole piece; those that several of them read once.
void LawWatch::look_at_all() {
  set_quantities(0, 1);
  courses_.update(behind_, commands_, quantities_);
  for (Watched& watched : watched_)
    watched.whole = {courses_.get(watched.law), courses_.get_hidden(watched.law), courses_.get_marks(watched.law)};
}

// The law over a part of the piece.
const Course& LawWatch::calc(const Watched& watched, double from, double to, LawCourses::Sides sides) {
  set_quantities(from, to);
  courses_.update(watched.behind, commands_, quantities_, sides);
  return courses_.get(watched.law);
}

// Adds the integral from one part of the piece to another.
void LawWatch::look_at(const Watched& watched, double from, double to, int depth) {
  const Course course = calc(watched, from, to);
  const double hidden = courses_.get_hidden(watched.law), middle = 0.5 * (from + to);
  const double bend = std::abs(course.begin - 2 * course.middle + course.end);
  const double size = std::max(look_.size, get_size(course));
  const bool flat = !courses_.get_marks(watched.law).sharp || (hidden + bend) * (to - from) <= kFlat * size;
  --look_.left;
  if (flat || depth == kDeepest || look_.left <= 0) {
    look_.integral += (to - from) / 6 * (course.begin + 4 * course.middle + course.end);
    if (!flat && depth == kDeepest)
      look_.jump = std::max({look_.jump, std::abs(course.middle - course.begin), std::abs(course.end - course.middle)});
    for (const Sample& sample : {Sample{from, course.begin}, Sample{middle, course.middle}, Sample{to, course.end}})
      look_.samples.push_back(sample);
    return;
  }
  look_at(watched, from, middle, depth + 1);
  look_at(watched, middle, to, depth + 1);
}

// Sets where the law is farthest from the line between both ends, and a step that sees it.
void LawWatch::set_extreme(const Watched& watched, const Piece& piece, PassedOver& passed) {
  const std::vector<Sample> samples = look_.samples;
  const Sample first = samples.front(), last = samples.back();
  const auto calc_height = [&](const Sample& sample) {
    const double part = (sample.part - first.part) / (last.part - first.part);
    return std::abs(sample.value - (first.value + part * (last.value - first.value)));
  };
  std::size_t top = 0;
  for (std::size_t i = 0; i < samples.size(); ++i)
    if (calc_height(samples[i]) > calc_height(samples[top])) top = i;
  const double half = 0.5 * calc_height(samples[top]);
  // Where it is half as far, beyond the last sample that is farther.
  const auto find_half = [&](std::ptrdiff_t way) {
    std::size_t i = top;
    const std::size_t end = way > 0 ? samples.size() - 1 : 0;
    while (i != end && calc_height(samples[i]) > half)
      i = static_cast<std::size_t>(static_cast<std::ptrdiff_t>(i) + way);
    double in = samples[top].part, out = samples[i].part;
    for (int k = 0; k < kDeepest; ++k) {
      const double middle = 0.5 * (in + out);
      (calc_height({middle, calc(watched, middle, middle).middle}) > half ? in : out) = middle;
    }
    return out;
  };
  const double width = find_half(1) - find_half(-1);
  passed.time = piece.from + samples[top].part * (piece.to - piece.from);
  passed.value = samples[top].value;
  passed.step = find_step(watched, samples[top].part, width) * (piece.to - piece.from);
}

// The longest of a few steps, as parts of the piece, that resolve the law about `top`, where it is above its half for
// `width`. Where it passes a corner, a step would be split.
double LawWatch::find_step(const Watched& watched, double top, double width) {
  constexpr int kLooks = 60;
  const auto is_resolved = [&](double from, double part) {
    const Course course = calc(watched, from, from + part);
    if (courses_.get_marks(watched.law).split) return true;
    look_.integral = look_.jump = 0;
    look_.left = kLooks;
    look_.samples.clear();
    look_at(watched, from, from + part, 0);
    const double taken = (course.begin + 4 * course.middle + course.end) / 6;
    return std::abs(look_.integral / part - taken) <= kSure * kLawError * watched.largest;
  };
  double part = 0.3 * width;
  for (const double least = std::exp2(-kDeepest); part > least; part *= 0.5) {
    bool good = true;
    for (double from = std::max(0.0, top - width); good && from + part <= std::min(1.0, top + width); from += part)
      good = is_resolved(from, part);
    if (good) break;
  }
  return part;
}

// What the step passed over, if anything; its error has the law's unit.
std::optional<PassedOver> LawWatch::measure(Watched& watched, const Piece& piece) {
  const double end = kEnd * dt_ / (piece.to - piece.from);
  if (!(end < 0.1)) return {};
  look_.integral = look_.jump = 0;
  look_.left = watched.evaluations;
  look_.size = std::max(watched.largest, get_size(watched.whole.course));
  if (std::isfinite(watched.whole.hidden)) look_.size = std::max(look_.size, watched.whole.hidden);
  look_.samples.clear();
  look_at(watched, end, 1 - end, 0);
  const Course first = calc(watched, 0, end);
  (void)calc(watched, end, 1 - end);
  const Course last = calc(watched, 1 - end, 1, LawCourses::Sides::kHold);
  for (const Sample& sample : look_.samples) watched.largest = std::max(watched.largest, std::abs(sample.value));
  watched.largest = std::max({watched.largest, get_size(first), get_size(last)});
  if (!std::isfinite(look_.integral)) return {};
  const double taken = (first.begin + 4 * watched.whole.course.middle + last.end) / 6;
  const double error = std::abs(look_.integral / (1 - 2 * end) - taken);
  const double jump = std::max({look_.jump, std::abs(first.end - first.begin), std::abs(last.end - last.begin)});
  PassedOver passed{.law = watched.law, .error = std::max(error, jump), .bodies = watched.bodies};
  if (!(passed.error > kLawError * watched.largest)) return {};
  set_extreme(watched, piece, passed);
  if (jump > kLawError * watched.largest) passed.step = 0;
  return passed;
}

// Of a law that only rises, or only falls, over the piece: by Simpson's rule for both halves.
PassedOver LawWatch::measure_rise(const Watched& watched, const Piece& piece) {
  const Course& whole = watched.whole.course;
  const Course first = calc(watched, 0, 0.5), last = calc(watched, 0.5, 1);
  const double halves = (first.begin + 4 * (first.middle + last.middle) + 2 * first.end + last.end) / 12;
  const double taken = (whole.begin + 4 * whole.middle + whole.end) / 6;
  const bool up = std::abs(whole.end) > std::abs(whole.begin);
  return {.law = watched.law,
          .time = up ? piece.to : piece.from,
          .value = up ? whole.end : whole.begin,
          .error = std::abs(halves - taken),
          .step = piece.to - piece.from,
          .bodies = watched.bodies};
}

PassedOver LawWatch::finish_rise(const Watched& watched) {
  PassedOver rising = *watched.rising;
  if (watched.rises_smoothly)  // by the method's order
    rising.step *= kSure * std::pow(kLawError * watched.largest / rising.error, 0.25);
  return rising;
}

std::vector<PassedOver> LawWatch::list_rising() const {
  std::vector<PassedOver> list;
  for (const Watched& watched : watched_) {
    if (!watched.rising) continue;
    PassedOver rising = finish_rise(watched);
    rising.error /= watched.largest;
    if (rising.error > kLawError) list.push_back(rising);
  }
  return list;
}

void LawWatch::report(const Watched& watched, PassedOver passed) {
  passed.error /= watched.largest;
  if (passed.error > kLawError) passed_.push_back(passed);
}

// Looks into a piece over which the law may hide something. A law that rises steeply, and is largest at the end of the
// piece, as a bell far from its middle does, is judged when it has ceased to rise: only then is its size known.
void LawWatch::judge(Watched& watched, const Piece& piece) {
  const Course& whole = watched.whole.course;
  constexpr double kSteep = 1.5;
  const double size = get_size(whole), before = watched.seen;
  const bool rises = size > kSteep * before;
  watched.seen = std::max(before, size);
  watched.largest = std::max(watched.largest, size);
  if (watched.rising && !rises) {
    report(watched, finish_rise(watched));
    watched.rising.reset();
  }
  const double bend = std::abs(whole.begin - 2 * whole.middle + whole.end);
  const double hidden = watched.whole.hidden;
  const bool sharp = watched.whole.marks.sharp && hidden + bend > kFlat * watched.largest;
  if (!sharp && bend <= kBent * watched.largest) {
    watched.evaluations = std::min(2 * watched.evaluations, kMostEvaluations);
    return;
  }
  const auto keep = [&](const PassedOver& rising, bool smoothly) {
    if (watched.rising && rising.error <= watched.rising->error) return;
    watched.rising = rising;
    watched.rises_smoothly = smoothly;
  };
  if (sharp && rises && hidden <= kFlat * watched.largest) {
    keep(measure_rise(watched, piece), true);
    return;
  }
  const double largest = watched.largest;
  const std::optional<PassedOver> passed = measure(watched, piece);
  if (!passed)  // as at the last steps: what bounds cannot decide is not worth many looks
    watched.evaluations = std::max(watched.evaluations / 2, kFewestEvaluations);
  else if (rises && watched.largest <= kSteep * largest)
    keep(*passed, false);
  else
    report(watched, *passed);
}

std::span<const PassedOver> LawWatch::update(const Piece& piece, std::span<const double> commands) {
  passed_.clear();
  if (watched_.empty() || !(piece.to > piece.from)) return {};
  commands_ = commands;
  const bool smooth = follow(piece);
  look_at_all();
  for (Watched& watched : watched_) {
    const bool is_split = laws_ == Laws::kOfTime && watched.whole.marks.split;
    if (is_number(watched.whole.course) && smooth && !is_split) judge(watched, piece);
  }
  return passed_;
}

std::span<const PassedOver> LawWatch::update(std::span<const MotionKnot> knots, std::span<const double> commands) {
  if (watched_.empty()) return {};
  std::vector<PassedOver> all;
  for (std::size_t i = 1; i < knots.size(); ++i) {
    if (knots[i].begins) continue;
    const Piece piece{knots[i - 1].time, knots[i].time, knots[i - 1].quantities, knots[i].quantities};
    const std::span<const PassedOver> found = update(piece, commands);
    all.insert(all.end(), found.begin(), found.end());
  }
  passed_ = std::move(all);
  return passed_;
}

}  // namespace unlatch::hil
