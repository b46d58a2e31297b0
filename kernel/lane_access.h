// One body's numbers in the lanes, for code that works on one body at a time. Always inlined: the lanes use
// it too, see pack.h.
#pragma once

#include "kernel/articulated.h"
#include "kernel/lanes.h"

namespace unlatch {

UNLATCH_INLINE double& get_number(double* lanes, LaneSlot slot, int row) {
  return lanes[slot.offset + row * slot.stride];
}

UNLATCH_INLINE Vec3 read_vec(const double* lanes, LaneSlot slot, int row) {
  const double* from = lanes + slot.offset + row * slot.stride;
  return {from[0], from[slot.stride], from[2 * slot.stride]};
}
UNLATCH_INLINE Spatial read_spatial(const double* lanes, LaneSlot slot, int row) {
  return {read_vec(lanes, slot, row), read_vec(lanes, slot, row + 3)};
}
UNLATCH_INLINE Mat3 read_mat(const double* lanes, LaneSlot slot, int row) {
  return {read_vec(lanes, slot, row), read_vec(lanes, slot, row + 3), read_vec(lanes, slot, row + 6)};
}

UNLATCH_INLINE void write_vec(double* lanes, LaneSlot slot, int row, const Vec3& a) {
  double* to = lanes + slot.offset + row * slot.stride;
  to[0] = a.x;
  to[slot.stride] = a.y;
  to[2 * slot.stride] = a.z;
}
UNLATCH_INLINE void write_spatial(double* lanes, LaneSlot slot, int row, const Spatial& a) {
  write_vec(lanes, slot, row, a.lin);
  write_vec(lanes, slot, row + 3, a.ang);
}
UNLATCH_INLINE void add_vec(double* lanes, LaneSlot slot, int row, const Vec3& a) {
  double* to = lanes + slot.offset + row * slot.stride;
  to[0] += a.x;
  to[slot.stride] += a.y;
  to[2 * slot.stride] += a.z;
}

}  // namespace unlatch
