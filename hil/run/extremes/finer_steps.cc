#include "hil/run/extremes/finer_steps.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "unlatch/plan/halved_plan.h"

namespace unlatch::hil {
namespace {

constexpr std::size_t kLine = 64;  // alignment of a workspace

Plan divide_step(const Plan& whole) {
  Plan plan = whole;
  for (int i = 0; i < FinerSteps::kHalvings; ++i) plan = halve_step(plan);
  return plan;
}

std::span<std::byte> align_to_line(std::vector<std::byte>& memory, std::size_t bytes) {
  void* first = memory.data();
  std::size_t space = memory.size();
  return {static_cast<std::byte*>(std::align(kLine, bytes, first, space)), bytes};
}

template <class T>
bool has_same_bits(std::span<T> a, std::span<T> b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size_bytes()) == 0;
}

// What is held, closed and engaged.
bool has_same_links(const State& a, const State& b) {
  const auto same = [](const auto& of_a, const auto& of_b, auto get) {
    return std::equal(of_a.begin(), of_a.end(), of_b.begin(), of_b.end(),
                      [get](const auto& x, const auto& y) { return get(x) == get(y); });
  };
  return same(a.joints, b.joints, [](const JointState& joint) { return joint.mode; }) &&
         same(a.contacts, b.contacts, [](const ContactState& pair) { return pair.closed != 0; }) &&
         has_same_bits(a.engaged, b.engaged);
}

}  // namespace

bool is_switched(const MotionKnot& before, const MotionKnot& after) {
  const State &a = before.state, &b = after.state;
  return !has_same_links(a, b) || !has_same_bits(a.elements, b.elements) || !has_same_bits(a.events, b.events) ||
         !has_same_bits(a.signals, b.signals);
}

void FinerKnot::copy(const Plan& plan, const MotionKnot& from, bool begins_here) {
  const std::span<const std::byte> bytes = from.state.get_bytes();
  block_.resize(bytes.size() / sizeof(std::uint64_t));
  std::memcpy(block_.data(), bytes.data(), bytes.size());
  accelerations_.assign(from.accelerations.begin(), from.accelerations.end());
  const std::size_t multipliers = from.multipliers.size(), sensors = from.sensors.size();
  numbers_.assign(from.multipliers.begin(), from.multipliers.end());
  numbers_.insert(numbers_.end(), from.sensors.begin(), from.sensors.end());
  numbers_.insert(numbers_.end(), from.quantities.begin(), from.quantities.end());
  knot = from;
  knot.state = State(plan, std::as_writable_bytes(std::span(block_)));
  knot.accelerations = accelerations_;
  const std::span<double> all = numbers_;
  knot.multipliers = all.first(multipliers);
  knot.sensors = all.subspan(multipliers, sensors);
  knot.quantities = all.subspan(multipliers + sensors);
  begins = begins_here;
}

FinerSteps::Finer::Finer(const Plan& whole)
    : plan(divide_step(whole)),
      block(whole.get_state_bytes() / sizeof(std::uint64_t)),
      memory(whole.get_workspace_bytes() + kLine),
      log_memory(MotionLog::get_bytes(plan) + kLine),
      state(plan, std::as_writable_bytes(std::span(block))),
      workspace(plan, align_to_line(memory, whole.get_workspace_bytes())),
      log(plan, align_to_line(log_memory, MotionLog::get_bytes(plan))) {}

void FinerSteps::add(const StepReport& report) {
  const std::span<const MotionKnot> knots = simulation_.get_motion();
  if (knots.empty() || report.substeps == 0) return;
  Start& start = starts_[next_];
  next_ = (next_ + 1) % kKept;
  const std::span<const std::byte> bytes = knots.front().state.get_bytes();
  start.block.resize(bytes.size() / sizeof(std::uint64_t));
  std::memcpy(start.block.data(), bytes.data(), bytes.size());
  start.tick = knots.front().state.header->tick;
  start.inputs.assign(simulation_.get_inputs().begin(), simulation_.get_inputs().end());
  start.fired.clear();
  for (const FiredEvent& event : report.events) start.fired.push_back(event.event);
  ++ticks_;
}

FinerSteps::Again FinerSteps::take(double from, double to, Count count) {
  const auto tick = static_cast<std::int64_t>(std::floor(0.5 * (from + to) / simulation_.plan().get_options().dt));
  const auto start = std::ranges::find(starts_, tick, &Start::tick);
  if (start == starts_.end()) return {};
  if (count == Count::kYes && counted_ != tick) {
    if (taken_ >= kFirst + ticks_ / kEvery) return {};
    ++taken_;
    counted_ = tick;
  }
  if (latest_ != tick) {
    latest_ = tick;
    if (!step_again(*start)) count_ = 0;
  }
  return {std::span(knots_).first(count_), start->inputs};
}

void FinerSteps::keep(const MotionKnot& knot, bool begins) {
  if (count_ == knots_.size()) knots_.push_back(std::make_unique<FinerKnot>());
  knots_[count_++]->copy(finer_->plan, knot, begins);
}

// False where the shorter steps fail, or see other events.
bool FinerSteps::step_again(const Start& start) {
  count_ = 0;
  if (!finer_) finer_ = std::make_unique<Finer>(simulation_.plan());
  Finer& finer = *finer_;
  std::memcpy(finer.block.data(), start.block.data(), start.block.size() * sizeof(std::uint64_t));
  finer.state.header->plan_hash = finer.plan.get_hash();
  finer.state.header->tick *= kParts;
  MotionWindow window;
  bool switched = true;
  std::size_t fired = 0;
  for (int i = 0; i < kParts; ++i) {
    const StepReport report = step(finer.plan, Inputs{start.inputs}, finer.state, finer.workspace, &finer.log);
    if (report.status != StepStatus::kOk) return false;
    for (const FiredEvent& event : report.events)
      if (fired >= start.fired.size() || start.fired[fired++] != event.event) return false;
    const std::span<const MotionKnot> knots = finer.log.get_knots();
    for (std::size_t k = 1; k < knots.size(); ++k) {
      const MotionKnot &from = knots[k - 1], &to = knots[k];
      if (to.begins) {
        switched = switched || is_switched(from, to);
        continue;
      }
      window.move_on(from, to);
      if (switched || !window.is_smooth()) keep(from, true);
      keep(to, false);
      switched = false;
    }
  }
  if (fired != start.fired.size()) return false;
  // What changed without an event, as a contact that closed, is that of the step.
  const std::int64_t behind = start.tick + 1;
  if (simulation_.get_tick() == behind) return has_same_links(finer.state, simulation_.state());
  const auto next = std::ranges::find(starts_, behind, &Start::tick);
  if (next == starts_.end()) return false;
  return has_same_links(finer.state, State(simulation_.plan(), std::as_writable_bytes(std::span(next->block))));
}

}  // namespace unlatch::hil
