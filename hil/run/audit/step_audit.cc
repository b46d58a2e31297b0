#include "hil/run/audit/step_audit.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <memory>

#include "hil/scenario/base/index.h"

namespace unlatch::hil {
namespace {

constexpr std::size_t kWorkspaceAlignment = 64;
// Smaller changes are a body at rest, whose errors are compared with these: m, m/s, rad, rad/s.
constexpr double kLeastChange = 1e-6;
constexpr double kSteady = 1e-3;  // of a rate at the start: likewise
// A change of the change of a velocity from one step to the next, of its largest change: an error may be half of it.
constexpr double kJump = 0.02;
constexpr std::int64_t kFirstExtra = 12, kExtraEvery = 256;  // steps beside those of the blocks: at first; ticks a step

// Changes are measured at every tick at first, then at every few ticks, and where a step is compared.
constexpr std::int64_t kMeasureAll = 128, kMeasureEvery = 8;

std::int64_t draw_place(std::int64_t block) {  // splitmix64
  auto z = static_cast<std::uint64_t>(block) + 0x9E3779B97F4A7C15ull;
  z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9ull;
  z = (z ^ (z >> 27)) * 0x94D049BB133111EBull;
  return static_cast<std::int64_t>((z ^ (z >> 31)) % static_cast<std::uint64_t>(StepAudit::kBlock));
}

// Turn θ between two attitudes, as a vector of the length 2 sin(θ/2), rad.
Vec3 calc_turn(const Quat& a, const Quat& b) {
  const Vec3 u{a.x, a.y, a.z}, v{b.x, b.y, b.z};
  return 2.0 * ((a.w * v - b.w * u) - cross(u, v));
}

std::vector<std::uint64_t> make_block(const Plan& plan) {
  return std::vector<std::uint64_t>(plan.get_state_bytes() / sizeof(std::uint64_t));
}

State make_state(const Plan& plan, std::vector<std::uint64_t>& block) {
  return {plan, std::as_writable_bytes(std::span(block))};
}

// Both have done the same events: modes, switches and contacts are alike.
bool has_same_phases(const State& a, const State& b) {
  const auto is_alike = [](const auto& of_a, const auto& of_b, auto get) {
    return std::equal(of_a.begin(), of_a.end(), of_b.begin(),
                      [get](const auto& x, const auto& y) { return get(x) == get(y); });
  };
  return is_alike(a.joints, b.joints, [](const JointState& s) { return s.mode; }) &&
         is_alike(a.events, b.events, [](const EventState& s) { return s.phase; }) &&
         is_alike(a.contacts, b.contacts, [](const ContactState& s) { return s.closed; }) &&
         is_alike(a.engaged, b.engaged, [](std::int64_t s) { return s; });
}

}  // namespace

double StepAudit::Course::get_change(std::size_t part) const {
  // A rate that is constant but for the error of its steps has not changed by that.
  const double still = part == static_cast<std::size_t>(MotionPart::kRate) ? kSteady * norm(start.w) : 0;
  return std::max({std::sqrt(squared_change[part]), kLeastChange, still});
}

StepAudit::Half::Half(const Plan& whole)
    : plan(halve_step(whole)),
      block(make_block(whole)),
      memory(whole.get_workspace_bytes() + kWorkspaceAlignment),
      state(make_state(plan, block)) {
  void* first = memory.data();
  std::size_t space = memory.size();
  const std::size_t bytes = whole.get_workspace_bytes();
  workspace = Workspace(plan, {static_cast<std::byte*>(std::align(kWorkspaceAlignment, bytes, first, space)), bytes});
}

StepAudit::StepAudit(const Simulation& simulation)
    : simulation_(simulation),
      courses_(simulation.model().bodies.size()),
      half_(simulation.plan()),
      block_(make_block(simulation.plan())),
      before_(make_state(simulation.plan(), block_)) {
  double all = 0;
  for (const Body& body : simulation.model().bodies) {
    masses_.push_back(body.marker ? 0 : body.mass);
    all += masses_.back();
  }
  for (double& mass : masses_) mass /= all;
}

StepAudit::Centre StepAudit::calc_centre(const State& state) const {
  Centre centre{{0, 0, 0}, {0, 0, 0}};
  for (std::size_t b = 0; b < masses_.size(); ++b) {
    centre.p += masses_[b] * state.bodies[b].p;
    centre.v += masses_[b] * state.bodies[b].v;
  }
  return centre;
}

std::optional<StepAudit::Repeated> StepAudit::update(const StepReport& report) {
  if (!begun_) {
    begin();
    return {};
  }
  const std::int64_t tick = simulation_.get_tick() - 1;
  ++ticks_;
  const bool jumps = follow();
  std::optional<Repeated> repeated;
  if (is_due(tick, jumps || !report.events.empty()) && repeat(report))
    repeated.emplace(half_.plan, half_.state, half_.workspace, compare(tick));
  keep();
  return repeated;
}

void StepAudit::begin() {
  begun_ = true;
  origin_ = simulation_.get_tick();
  start_ = calc_centre(simulation_.state());
  centre_.latest = start_.v;
  for (std::size_t b = 0; b < courses_.size(); ++b) {
    const BodyState& body = simulation_.state().bodies[b];
    courses_[b].start = body;
    courses_[b].v.latest = body.v;
    courses_[b].w.latest = body.w;
  }
  keep();
}

bool StepAudit::follow() {
  const State& state = simulation_.state();
  const Centre centre = calc_centre(state);
  const Vec3 common = centre_.move(centre.v);
  const bool measures = ticks_ <= kMeasureAll || ticks_ % kMeasureEvery == 0;
  bool jumps = false;
  for (std::size_t b = 0; b < courses_.size(); ++b) {
    if (measures) measure(courses_[b], state.bodies[b], centre);
    jumps |= follow(courses_[b], state.bodies[b], common);
  }
  return jumps;
}

// `common`: the change of the change of the centre's velocity.
bool StepAudit::follow(Course& course, const BodyState& now, const Vec3& common) const {
  const Vec3 jump = course.v.move(now.v), turning = course.w.move(now.w);
  const auto is_jump = [&course](const Vec3& by_step, MotionPart part) {
    const double squared = course.squared_change[at(static_cast<int>(part))];
    return dot(by_step, by_step) > std::max(kJump * kJump * squared, kLeastChange * kLeastChange);
  };
  return is_jump(jump, MotionPart::kVelocity) || is_jump(jump - common, MotionPart::kOwnVelocity) ||
         is_jump(turning, MotionPart::kRate);
}

void StepAudit::measure(Course& course, const BodyState& now, const Centre& centre) const {
  const auto grow = [&course](MotionPart part, const Vec3& by) {
    double& change = course.squared_change[at(static_cast<int>(part))];
    change = std::max(change, dot(by, by));
  };
  const Vec3 moved = now.p - course.start.p, by = now.v - course.start.v;
  grow(MotionPart::kPlace, moved);
  grow(MotionPart::kOwnPlace, moved - (centre.p - start_.p));
  grow(MotionPart::kVelocity, by);
  grow(MotionPart::kOwnVelocity, by - (centre.v - start_.v));
  grow(MotionPart::kAttitude, calc_turn(now.q, course.start.q));
  grow(MotionPart::kRate, now.w - course.start.w);
}

bool StepAudit::is_due(std::int64_t tick, bool special) {
  const bool may = extra_ < kFirstExtra + ticks_ / kExtraEvery;
  if (special && may) origin_ = tick;
  const std::int64_t after = tick - origin_;
  const std::int64_t block = tick / kBlock;
  const bool is_drawn = (!calm_ || block % kCalmEvery == 0) && tick % kBlock == draw_place(block);
  const bool is_extra = may && after < kBlock && (after == 0 || std::has_single_bit(static_cast<std::uint64_t>(after)));
  if (is_extra && !is_drawn) ++extra_;
  return is_extra || is_drawn;
}

const State& StepAudit::find_before() const {
  const std::span<const MotionKnot> knots = simulation_.get_motion();
  return knots.empty() ? before_ : knots.front().state;
}

void StepAudit::keep() {
  if (!simulation_.get_motion().empty()) return;
  std::memcpy(block_.data(), simulation_.state().get_bytes().data(), simulation_.state().get_bytes().size());
}

bool StepAudit::repeat(const StepReport& report) {
  copy_to_halved(find_before(), half_.plan, half_.state);
  std::size_t fired = 0;
  for (int i = 0; i < 2; ++i) {
    const StepReport part = step(half_.plan, Inputs{simulation_.get_inputs()}, half_.state, half_.workspace);
    if (part.status != StepStatus::kOk) return false;
    for (const FiredEvent& event : part.events)
      if (fired >= report.events.size() || report.events[fired++].event != event.event) return false;
  }
  return fired == report.events.size() && has_same_phases(half_.state, simulation_.state());
}

// Returns the ticks since the step before that was compared.
double StepAudit::compare(std::int64_t tick) {
  const double between = latest_ == kNone ? 0 : static_cast<double>(tick - latest_ - 1);
  const Centre centre = calc_centre(simulation_.state()), halved = calc_centre(half_.state);
  const Vec3 p_common = centre.p - halved.p, v_common = centre.v - halved.v;
  calm_ = true;
  for (std::size_t b = 0; b < courses_.size(); ++b) {
    const BodyState &full = simulation_.state().bodies[b], &half = half_.state.bodies[b];
    measure(courses_[b], full, centre);
    const Vec3 p = full.p - half.p, v = full.v - half.v;
    // An error that all have is none of the own motion, and of a body without an error the centre's is not its own.
    const double own_p = std::min(norm(p), norm(p - p_common)), own_v = std::min(norm(v), norm(v - v_common));
    add_error(courses_[b], {norm(p), norm(v), own_p, own_v, norm(calc_turn(full.q, half.q)), norm(full.w - half.w)},
              between);
  }
  latest_ = tick;
  ++compared_;
  return between;
}

void StepAudit::add_error(Course& course, const std::array<double, kMotionParts>& errors, double between) {
  for (std::size_t i = 0; i < errors.size(); ++i) {
    course.error[i] += errors[i] + between * std::min(errors[i], course.latest[i]);
    course.latest[i] = errors[i];
  }
  judge(course, between);
}

void StepAudit::add_feedback(int body, const std::array<double, kMotionParts>& errors, double rate) {
  Course& course = courses_[at(body)];
  const bool compared = latest_ == simulation_.get_tick() - 1;
  for (std::size_t i = 0; i < errors.size(); ++i)
    course.error[i] += compared ? std::max(errors[i] - course.latest[i], 0.0) : errors[i];
  course.feedback = std::max(course.feedback, rate);
  judge(course, 0);
}

// `between`: ticks since the step before that was looked at, beside the latest.
void StepAudit::judge(Course& course, double between) {
  for (std::size_t i = 0; i < course.error.size(); ++i) {
    const double change = course.get_change(i);
    if (course.error[i] > kCalm * change) calm_ = false;
    if (course.error[i] <= kLimit * change) {
      if (course.since[i] != kNever) add_passed(course, i);
      course.since[i] = kNever;
    } else if (course.since[i] == kNever) {
      course.since[i] = simulation_.get_time();
      course.from[i] = course.since[i] - (between + 1) * simulation_.plan().get_options().dt;
    }
  }
  mark(course);
}

StepAudit::BodyErrors StepAudit::get_errors(const Course& course) {
  BodyErrors errors;
  errors.error = course.error;
  for (std::size_t i = 0; i < errors.change.size(); ++i) errors.change[i] = course.get_change(i);
  return errors;
}

// Errors grow from rounding on: by kGrowth some 200 times until they are as large as what they are of.
void StepAudit::mark(Course& course) const {
  const auto has_grown = [&course](std::size_t i) {
    return course.error[i] > kGrowth * course.marks.back().errors.error[i] &&
           course.error[i] > kCalm / 64 * course.get_change(i);
  };
  bool grown = course.marks.empty();
  for (std::size_t i = 0; i < course.error.size() && !grown; ++i) grown = has_grown(i);
  if (grown) course.marks.push_back({simulation_.get_time(), get_errors(course)});
}

// The errors came up between two marks: those of the later one hold.
StepAudit::BodyErrors StepAudit::get_errors(int body, double until) const {
  const Course& course = courses_[at(body)];
  const auto mark = std::ranges::lower_bound(course.marks, until, {}, &Mark::time);
  return mark == course.marks.end() ? get_errors(course) : mark->errors;
}

// The while from the first to the last of several, with the part that was last.
void StepAudit::add_passed(Course& course, std::size_t part) const {
  StepError& passed = course.passed;
  const double first = passed.until == kNever ? kNever : passed.from;
  passed = {static_cast<int>(&course - courses_.data()),
            static_cast<MotionPart>(part),
            course.error[part],
            course.get_change(part),
            course.since[part],
            std::min(first, course.from[part]),
            simulation_.get_time()};
}

// The part that is worst. Those beyond the limit were so at the latest step that was compared, by what the motion had
// changed then: what grows without bound later hides no error.
StepError StepAudit::find_worst(int body) const {
  const Course& course = courses_[at(body)];
  StepError worst{body};
  for (std::size_t i = 0; i < course.error.size(); ++i) {
    const StepError own{
        body, static_cast<MotionPart>(i), course.error[i], course.get_change(i), course.since[i], course.from[i]};
    const bool is_beyond = own.time != kNever, was_beyond = worst.time != kNever;
    if (is_beyond != was_beyond ? is_beyond : own.error * worst.change > worst.error * own.change) worst = own;
  }
  return worst;
}

StepError StepAudit::find_worst() const {
  StepError worst;
  for (std::size_t b = 0; b < courses_.size(); ++b) {
    const StepError own = find_worst(static_cast<int>(b));
    if (own.error * worst.change > worst.error * own.change) worst = own;
  }
  return worst;
}

std::vector<StepError> StepAudit::list_unresolved() const {
  std::vector<StepError> list;
  for (std::size_t b = 0; b < courses_.size(); ++b)
    if (const StepError worst = find_worst(static_cast<int>(b)); worst.time != kNever) list.push_back(worst);
  return list;
}

std::vector<StepError> StepAudit::list_errors(double part) const {
  std::vector<StepError> list;
  for (std::size_t b = 0; b < courses_.size(); ++b)
    if (const StepError worst = find_worst(static_cast<int>(b)); worst.error > part * worst.change)
      list.push_back(worst);
  return list;
}

std::vector<StepError> StepAudit::list_passed() const {
  std::vector<StepError> list;
  for (const Course& course : courses_)
    if (course.passed.until != kNever) list.push_back(course.passed);
  return list;
}

}  // namespace unlatch::hil
