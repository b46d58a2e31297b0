// Pairs of shapes within a piece of motion: dips of their distances, and bounds below them. The distance of two groups
// is the least of their pairs of shapes: between two knots a pair that is nearest at neither can come near and go
// again, and the values at the knots do not show it.
#pragma once

#include <cstddef>
#include <memory>
#include <optional>

#include "hil/run/motion/motion_window.h"
#include "hil/scenario/shapes/clearance.h"

namespace unlatch::hil {

struct Dip {
  double time = 0, value = 0;  // s, m
};

// kOn leaves out what a bound shows to be no result, kOff computes it; the results have the same bits.
enum class Skipping { kOn, kOff };

// What find() must know of a piece of motion.
struct DipSearch {
  double length = 0;      // m, of the relative motion within the piece (calc_length()); may be infinite
  double limit = 0;       // m: only smaller values count
  double resolution = 0;  // m: shallower dips are rounding
  // m, at the ends of the piece, of a watched pair that has one pair of shapes; computed where they are not given.
  std::optional<double> at_from{}, at_to{};
};

// Of one watched pair. Remembers distances of the latest piece's end, and the planes that part its shapes: what it
// saves changes no result.
class ShapeDips {
 public:
  // `a`, `b`: the pair's bodies, as in MotionPiece.
  ShapeDips(const ClearanceMonitor& monitor, std::size_t pair, std::size_t a, std::size_t b,
            Skipping skipping = Skipping::kOn);
  ~ShapeDips();
  ShapeDips(ShapeDips&&) noexcept;
  ShapeDips& operator=(ShapeDips&&) noexcept;

  // True only if no distance that the monitor computes within the piece is below `limit`, m.
  bool stays_above(const ClearanceMonitor& monitor, const MotionPiece& piece, double limit);

  // Distance of the watched pair at the end of the piece, to the bit that of the monitor; of convex shapes alone.
  std::optional<double> calc_end(const ClearanceMonitor& monitor, const MotionPiece& piece);

  // Likewise at a time within the present piece, or within the one before if that has left enough behind.
  std::optional<double> calc_within(const ClearanceMonitor& monitor, const MotionWindow& window, double time);

  // Least distance inside the piece of those pairs of shapes that dip there; empty if none is below the limit. Convex
  // shapes that move past each other steadily approach and then recede, so that a dip shows in the slopes at the ends
  // of the piece; other shapes are sampled.
  std::optional<Dip> find(const ClearanceMonitor& monitor, const MotionPiece& piece, const DipSearch& search);

 private:
  class Memory;
  std::unique_ptr<Memory> memory_;
  Skipping skipping_;
};

}  // namespace unlatch::hil
