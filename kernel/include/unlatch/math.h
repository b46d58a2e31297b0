// Small fixed-size linear algebra of the stepping code: every sum has one written order, so that the bits do not depend
// on the compiler, its options or where a buffer lies. `T` is double or a pack of doubles, one per body: nothing here
// branches on a value.
#pragma once

#include <cmath>

namespace unlatch {

// Vector of three components.
template <class T>
struct Vec3T {
  T x, y, z;
};
using Vec3 = Vec3T<double>;  // a vector of doubles

template <class T>
[[gnu::always_inline]] constexpr Vec3T<T> operator+(const Vec3T<T>& a, const Vec3T<T>& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
template <class T>
[[gnu::always_inline]] constexpr Vec3T<T> operator-(const Vec3T<T>& a, const Vec3T<T>& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
template <class T>
[[gnu::always_inline]] constexpr Vec3T<T> operator-(const Vec3T<T>& a) {
  return {-a.x, -a.y, -a.z};
}
template <class T>
[[gnu::always_inline]] constexpr Vec3T<T> operator*(const T& s, const Vec3T<T>& a) {
  return {s * a.x, s * a.y, s * a.z};
}
template <class T>
[[gnu::always_inline]] constexpr Vec3T<T>& operator+=(Vec3T<T>& a, const Vec3T<T>& b) {
  return a = a + b;
}
template <class T>
[[gnu::always_inline]] constexpr Vec3T<T>& operator-=(Vec3T<T>& a, const Vec3T<T>& b) {
  return a = a - b;
}
// a · b.
template <class T>
[[gnu::always_inline]] constexpr T dot(const Vec3T<T>& a, const Vec3T<T>& b) {
  return (a.x * b.x + a.y * b.y) + a.z * b.z;
}
// a × b.
template <class T>
[[gnu::always_inline]] constexpr Vec3T<T> cross(const Vec3T<T>& a, const Vec3T<T>& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
// |a|.
[[gnu::always_inline]] inline double norm(const Vec3& a) { return std::sqrt(dot(a, a)); }

// Three columns. As a rotation R_AB its columns are B's axes in A.
template <class T>
struct Mat3T {
  Vec3T<T> x, y, z;
};
using Mat3 = Mat3T<double>;  // a matrix of doubles

template <class T>
[[gnu::always_inline]] constexpr Vec3T<T> operator*(const Mat3T<T>& m, const Vec3T<T>& a) {
  return {(m.x.x * a.x + m.y.x * a.y) + m.z.x * a.z, (m.x.y * a.x + m.y.y * a.y) + m.z.y * a.z,
          (m.x.z * a.x + m.y.z * a.y) + m.z.z * a.z};
}
template <class T>
[[gnu::always_inline]] constexpr Mat3T<T> operator*(const Mat3T<T>& a, const Mat3T<T>& b) {
  return {a * b.x, a * b.y, a * b.z};
}
// mᵀ a
template <class T>
[[gnu::always_inline]] constexpr Vec3T<T> transpose_times(const Mat3T<T>& m, const Vec3T<T>& a) {
  return {dot(m.x, a), dot(m.y, a), dot(m.z, a)};
}
template <class T>
[[gnu::always_inline]] constexpr const Vec3T<T>& column(const Mat3T<T>& m, int k) {
  return k == 0 ? m.x : (k == 1 ? m.y : m.z);
}
inline constexpr Mat3 kIdentity3{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};

// Symmetric 3x3.
template <class T>
struct Sym3T {
  T xx, yy, zz, xy, xz, yz;
};
using Sym3 = Sym3T<double>;  // a symmetric matrix of doubles

template <class T>
[[gnu::always_inline]] constexpr Vec3T<T> operator*(const Sym3T<T>& s, const Vec3T<T>& a) {
  return {(s.xx * a.x + s.xy * a.y) + s.xz * a.z, (s.xy * a.x + s.yy * a.y) + s.yz * a.z,
          (s.xz * a.x + s.yz * a.y) + s.zz * a.z};
}
// R S Rᵀ: a symmetric tensor given in B's axes, in A's.
template <class T>
[[gnu::always_inline]] constexpr Sym3T<T> rotate(const Mat3T<T>& R_AB, const Sym3T<T>& s) {
  const Vec3T<T> c0 = R_AB * Vec3T<T>{s.xx, s.xy, s.xz};
  const Vec3T<T> c1 = R_AB * Vec3T<T>{s.xy, s.yy, s.yz};
  const Vec3T<T> c2 = R_AB * Vec3T<T>{s.xz, s.yz, s.zz};
  const Vec3T<T> r0{R_AB.x.x, R_AB.y.x, R_AB.z.x};
  const Vec3T<T> r1{R_AB.x.y, R_AB.y.y, R_AB.z.y};
  const Vec3T<T> r2{R_AB.x.z, R_AB.y.z, R_AB.z.z};
  const Vec3T<T> row0{c0.x, c1.x, c2.x}, row1{c0.y, c1.y, c2.y}, row2{c0.z, c1.z, c2.z};
  return {dot(row0, r0), dot(row1, r1), dot(row2, r2), dot(row0, r1), dot(row0, r2), dot(row1, r2)};
}

// A force and a torque, or a linear and an angular velocity or acceleration; world axes, at a body's origin.
template <class T>
struct SpatialT {
  Vec3T<T> lin, ang;
};
using Spatial = SpatialT<double>;  // a spatial vector of doubles

// Attitude quaternion q_AB, B to A; rotation_matrix() divides by |q|², so that it is right for unnormalised q as well,
// which the stages of a Runge–Kutta step produce.
template <class T>
struct QuatT {
  T w, x, y, z;
};
using Quat = QuatT<double>;  // a quaternion of doubles

// |q|².
template <class T>
[[gnu::always_inline]] constexpr T norm_squared(const QuatT<T>& q) {
  return (q.w * q.w + q.x * q.x) + (q.y * q.y + q.z * q.z);
}
// Rotation of an attitude quaternion; q need not have length 1.
template <class T>
[[gnu::always_inline]] constexpr Mat3T<T> rotation_matrix(const QuatT<T>& q) {
  const T s = T(2) / norm_squared(q);
  const T xs = q.x * s, ys = q.y * s, zs = q.z * s;
  const T wx = q.w * xs, wy = q.w * ys, wz = q.w * zs;
  const T xx = q.x * xs, xy = q.x * ys, xz = q.x * zs, yy = q.y * ys, yz = q.y * zs, zz = q.z * zs;
  return {
      {T(1) - (yy + zz), xy + wz, xz - wy}, {xy - wz, T(1) - (xx + zz), yz + wx}, {xz + wy, yz - wx, T(1) - (xx + yy)}};
}
template <class T>
[[gnu::always_inline]] constexpr QuatT<T> operator*(const QuatT<T>& a, const QuatT<T>& b) {
  return {(a.w * b.w - a.x * b.x) - (a.y * b.y + a.z * b.z), (a.w * b.x + a.x * b.w) + (a.y * b.z - a.z * b.y),
          (a.w * b.y - a.x * b.z) + (a.y * b.w + a.z * b.x), (a.w * b.z + a.x * b.y) + (a.z * b.w - a.y * b.x)};
}
// The inverse rotation.
[[gnu::always_inline]] constexpr Quat conjugate(const Quat& q) { return {q.w, -q.x, -q.y, -q.z}; }
// q / |q|.
template <class T>
[[gnu::always_inline]] inline QuatT<T> normalized(const QuatT<T>& q) {
  using std::sqrt;
  const T s = T(1) / sqrt(norm_squared(q));
  return {q.w * s, q.x * s, q.y * s, q.z * s};
}
// dq/dt of a body that turns with w, given in its own axes: ½ q ⊗ (0, w).
template <class T>
[[gnu::always_inline]] constexpr QuatT<T> quaternion_rate(const QuatT<T>& q, const Vec3T<T>& w) {
  const T h = T(0.5);
  return {-h * ((q.x * w.x + q.y * w.y) + q.z * w.z), h * ((q.w * w.x + q.y * w.z) - q.z * w.y),
          h * ((q.w * w.y + q.z * w.x) - q.x * w.z), h * ((q.w * w.z + q.x * w.y) - q.y * w.x)};
}

}  // namespace unlatch
