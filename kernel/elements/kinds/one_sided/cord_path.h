// Path of a cord that is wound on a drum, see Drum in unlatch/model/elements.h: the shortest one from its anchor to its
// end that goes round the cylinder as often as the end has gone round its axis. Derivation and limits:
// kernel/THEORY.md, section 5.
#pragma once

#include "unlatch/readings.h"

namespace unlatch {

// World axes.
struct CordPath {
  double length;   // of the whole path, m
  Vec3 direction;  // gradient of the length over the end's place: along the straight part, unit unless the end is
                   // inside the drum; 0 where the path has no length
  double bearing;  // of the end about the drum's axis from the anchor, turns counted, rad
  double winding;  // angle that is wound, rad; negative: the cord is straight, and that far off the tangent
  double on_drum;  // length that is wound, m
};

// `R_WB`: attitude of the drum's body. `end`: of the cord, from that body's origin, world axes, m. `previous`: a
// bearing less than half a turn from the present one, rad.
CordPath calc_cord_path(const CordDrum& drum, const Mat3& R_WB, const Vec3& end, double previous) noexcept;

}  // namespace unlatch
