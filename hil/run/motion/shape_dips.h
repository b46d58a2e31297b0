// Dips of single pairs of shapes inside a step. The distance of two groups is the least of their pairs of shapes:
// between two knots a pair that is nearest at neither can come near and go again, and the values at the knots do not
// show it.
#pragma once

#include <cstddef>
#include <optional>

#include "hil/run/motion/motion_window.h"
#include "hil/scenario/shapes/clearance.h"

namespace unlatch::hil {

struct Dip {
  double time = 0, value = 0;  // s, m
};

// What find_dip() must know of a piece of motion.
struct DipSearch {
  std::size_t pair = 0;      // watched pair
  std::size_t a = 0, b = 0;  // its bodies, as in MotionPiece
  double length = 0;         // m, of the relative motion within the piece (calc_length()); may be infinite
  double limit = 0;          // m: only smaller values count
  double resolution = 0;     // m: shallower dips are rounding
};

// Least distance inside the piece of those pairs of shapes of a watched pair that dip there; empty if none is below the
// limit. Convex shapes that move past each other steadily approach and then recede, so that a dip shows in the slopes
// at the ends of the piece; other shapes are sampled.
std::optional<Dip> find_dip(const ClearanceMonitor& monitor, const MotionPiece& piece, const DipSearch& search);

}  // namespace unlatch::hil
