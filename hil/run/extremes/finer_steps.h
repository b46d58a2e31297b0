// Steps of a run taken again as kParts shorter ones, for values between their ends: where a polynomial through the
// knots of the run does not tell an extreme well enough, one through the knots of these does.
//
// A step is taken again from where it began, with its inputs, off the cyclic thread; the run itself does not change. It
// does not count where the shorter steps see other events, or where too many steps have been taken again: one of kEvery
// beside the first kFirst, so that an analysis costs at most a quarter more than the steps themselves.
//
// Cost: a copy of the state a step; those steps.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "hil/run/motion/motion_window.h"
#include "hil/run/simulation/simulation.h"

namespace unlatch::hil {

// True where events, or what else changes at an instant alone, changed something between two knots of one instant: what
// is held, switched, closed, engaged. Forces and reactions may jump or bend there although no acceleration does.
bool is_switched(const MotionKnot& before, const MotionKnot& after);

// A knot of the shorter steps, in memory of its own; `begins`: it does not continue the motion before smoothly.
class FinerKnot {
 public:
  FinerKnot() = default;
  FinerKnot(const FinerKnot&) = delete;
  FinerKnot& operator=(const FinerKnot&) = delete;
  void copy(const Plan& plan, const MotionKnot& from, bool begins_here);

  MotionKnot knot;
  bool begins = false;

 private:
  std::vector<std::uint64_t> block_;
  std::vector<Spatial> accelerations_;
  std::vector<double> numbers_;
};

class FinerSteps {
 public:
  static constexpr int kHalvings = 3, kParts = 1 << kHalvings;

  // Keeps a reference.
  explicit FinerSteps(const Simulation& simulation) : simulation_(simulation) {}

  // Called after each step of the simulation, which keeps its motion.
  void add(const StepReport& report);

  // A step as the shorter ones have it; no knots: it does not count.
  struct Again {
    std::span<const std::unique_ptr<FinerKnot>> knots;
    std::span<const double> commands;
  };
  // Whether a step counts among those that may be taken again: those of a verdict in the meantime do not, so that it
  // changes none that follows.
  enum class Count { kYes, kNo };
  // The step in which the time between these lies, one of the latest kKept.
  Again take(double from, double to, Count count);

 private:
  static constexpr std::size_t kKept = 8;
  static constexpr std::int64_t kFirst = 64, kEvery = 32;
  // The beginning of a step.
  struct Start {
    std::int64_t tick = -1;
    std::vector<std::uint64_t> block;
    std::vector<double> inputs;
    std::vector<std::int32_t> fired;
  };
  // Plan of the shorter steps, and memory to step with it.
  struct Finer {
    explicit Finer(const Plan& whole);
    Plan plan;
    std::vector<std::uint64_t> block;
    std::vector<std::byte> memory, log_memory;
    State state;
    Workspace workspace;
    MotionLog log;
  };
  bool step_again(const Start& start);
  void keep(const MotionKnot& knot, bool begins);

  const Simulation& simulation_;
  std::array<Start, kKept> starts_;
  std::size_t next_ = 0;
  std::int64_t ticks_ = 0, taken_ = 0;
  std::int64_t counted_ = -1;     // tick of the step that was counted last
  std::unique_ptr<Finer> finer_;  // once a step is taken again
  std::vector<std::unique_ptr<FinerKnot>> knots_;
  std::size_t count_ = 0;
  std::int64_t latest_ = -1;  // tick of the step whose knots are there
};

// Finer steps for those who may take some, and whether they count.
struct FinerSource {
  FinerSteps* steps = nullptr;  // null: there are none
  FinerSteps::Count count = FinerSteps::Count::kYes;
  [[nodiscard]] FinerSteps::Again take(double from, double to) const {
    return steps != nullptr ? steps->take(from, to, count) : FinerSteps::Again{};
  }
};

}  // namespace unlatch::hil
