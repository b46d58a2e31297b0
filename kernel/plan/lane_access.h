// One body's numbers in the lanes, for code that works on one body at a time. Always inlined: the lanes use
// it too, see pack.h.
#pragma once

#include <type_traits>

#include "kernel/math/spatial.h"
#include "kernel/plan/lanes.h"

namespace unlatch {

// Of the number of a row, in Workspace::lanes.
UNLATCH_INLINE std::int32_t find(LaneSlot slot, int row) { return slot.data + row * slot.stride; }
UNLATCH_INLINE std::int32_t find(LaneSlot slot, JointField row) { return slot.joint + row * slot.stride; }
UNLATCH_INLINE std::int32_t find(LaneSlot slot, BodyField row) { return slot.body + row * kOctet; }
UNLATCH_INLINE std::int32_t find(LaneSlot slot, SharedField row) { return slot.shared + row * kOctet; }

// From one row to the next.
template <class Row>
UNLATCH_INLINE std::int32_t get_stride(LaneSlot slot, Row) {
  return std::is_same_v<Row, BodyField> || std::is_same_v<Row, SharedField> ? kOctet : slot.stride;
}

template <class Row>
// NOLINTNEXTLINE(readability-non-const-parameter): what it returns is written to
UNLATCH_INLINE double& get_number(double* lanes, LaneSlot slot, Row row) {
  return lanes[find(slot, row)];
}

template <class Row>
UNLATCH_INLINE Vec3 read_vec(const double* lanes, LaneSlot slot, Row row) {
  const double* from = lanes + find(slot, row);
  const std::int32_t stride = get_stride(slot, row);
  return {from[0], from[stride], from[2 * stride]};
}
template <class Row>
UNLATCH_INLINE Quat read_quat(const double* lanes, LaneSlot slot, Row row) {
  const double* from = lanes + find(slot, row);
  const std::int32_t stride = get_stride(slot, row);
  return {from[0], from[stride], from[2 * stride], from[3 * stride]};
}
template <class Row>
UNLATCH_INLINE Spatial read_spatial(const double* lanes, LaneSlot slot, Row row) {
  return {read_vec(lanes, slot, row), read_vec(lanes, slot, row + 3)};
}
template <class Row>
UNLATCH_INLINE Mat3 read_mat(const double* lanes, LaneSlot slot, Row row) {
  return {read_vec(lanes, slot, row), read_vec(lanes, slot, row + 3), read_vec(lanes, slot, row + 6)};
}

template <class Row>
UNLATCH_INLINE void write_vec(double* lanes, LaneSlot slot, Row row, const Vec3& a) {
  double* to = lanes + find(slot, row);
  const std::int32_t stride = get_stride(slot, row);
  to[0] = a.x;
  to[stride] = a.y;
  to[2 * stride] = a.z;
}
template <class Row>
UNLATCH_INLINE void write_quat(double* lanes, LaneSlot slot, Row row, const Quat& a) {
  double* to = lanes + find(slot, row);
  const std::int32_t stride = get_stride(slot, row);
  to[0] = a.w;
  to[stride] = a.x;
  to[2 * stride] = a.y;
  to[3 * stride] = a.z;
}
template <class Row>
UNLATCH_INLINE void write_spatial(double* lanes, LaneSlot slot, Row row, const Spatial& a) {
  write_vec(lanes, slot, row, a.lin);
  write_vec(lanes, slot, row + 3, a.ang);
}
template <class Row>
UNLATCH_INLINE void add_vec(double* lanes, LaneSlot slot, Row row, const Vec3& a) {
  double* to = lanes + find(slot, row);
  const std::int32_t stride = get_stride(slot, row);
  to[0] += a.x;
  to[stride] += a.y;
  to[2 * stride] += a.z;
}

}  // namespace unlatch
