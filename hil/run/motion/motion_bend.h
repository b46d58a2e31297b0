// How far the motion of two bodies within a piece departs from a straight one: a bound.
//
// Of the quintics q(s) = chord + H1(s) u₀ + H1(1 − s) u₁ + H2(s) a₀h² + H2(1 − s) a₁h² with uᵢ = vᵢ h − Δq, u₁
// reversed, H1 = s (1 − s)³ (1 + 3 s) ≤ 0.2 and H2 = s² (1 − s)³ / 2 ≤ 0.0175 (MotionPiece::calc_body).
//
// A rotation R(q) is quadratic in q: with the chord of two unit quaternions and what q departs from it by, e, the
// matrix departs from the chord of both matrices by |Δq|²/4 + 2e + e², and as much again where q is normalised.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "hil/run/motion/motion_window.h"

namespace unlatch::hil {
namespace bend {

inline constexpr double kRates = 0.2, kAccelerations = 0.0175;

inline double norm(const Quat& q) { return std::sqrt((q.w * q.w + q.x * q.x) + (q.y * q.y + q.z * q.z)); }
inline Quat scale(double s, const Quat& q) { return {s * q.w, s * q.x, s * q.y, s * q.z}; }
inline Quat subtract(const Quat& a, const Quat& b) { return {a.w - b.w, a.x - b.x, a.y - b.y, a.z - b.z}; }

// Of an attitude: how far its matrix departs from the chord, and how much it changes.
struct Turn {
  double bend, change;
};
inline Turn calc_turn(const MotionPiece& piece, std::size_t body) {
  const BodyState &a = piece.start[body], &b = piece.end[body];
  const double h = piece.to - piece.from;
  const double sign = (a.q.w * b.q.w + a.q.x * b.q.x) + (a.q.y * b.q.y + a.q.z * b.q.z) < 0 ? -1 : 1;
  const Quat end = scale(sign, b.q), change = subtract(end, a.q);
  const Quat u0 = subtract(scale(h, quaternion_rate(a.q, a.w)), change),
             u1 = subtract(scale(h, quaternion_rate(end, b.w)), change);
  const auto calc_acceleration = [](const BodyState& state, const Spatial& acceleration) {  // of q, at most
    return 0.5 * norm(acceleration.ang) + 0.25 * dot(state.w, state.w);
  };
  const double e = kRates * (norm(u0) + norm(u1)) +
                   kAccelerations * (h * h) *
                       (calc_acceleration(a, piece.at_start[body]) + calc_acceleration(b, piece.at_end[body]));
  const double turned = norm(change);
  return {2 * (0.25 * turned * turned + 2 * e + e * e), 2 * turned};
}

}  // namespace bend

// Seen from the body `from`, the points of the body `seen` that are within `reach` of its origin move along any fixed
// direction as the chord between the ends of the piece does, within this, m: so their least coordinate is at least the
// lesser of both ends' less this.
inline double calc_bend(const MotionPiece& piece, std::size_t from, std::size_t seen, double reach) {
  const double h = piece.to - piece.from;
  const BodyState &from_a = piece.start[from], &from_b = piece.start[seen], &to_a = piece.end[from],
                  &to_b = piece.end[seen];
  const Vec3 begin = from_b.p - from_a.p, end = to_b.p - to_a.p, change = end - begin;
  const Vec3 u0 = h * (from_b.v - from_a.v) - change, u1 = h * (to_b.v - to_a.v) - change;
  const double pushes =
      norm(piece.at_start[seen].lin - piece.at_start[from].lin) + norm(piece.at_end[seen].lin - piece.at_end[from].lin);
  const double path = bend::kRates * (norm(u0) + norm(u1)) + bend::kAccelerations * (h * h) * pushes;
  const bend::Turn of_from = bend::calc_turn(piece, from), of_seen = bend::calc_turn(piece, seen);
  const double farthest = std::max(norm(begin), norm(end)) + path + reach;
  return of_from.bend * farthest + (path + of_seen.bend * reach) +
         0.25 * of_from.change * (norm(change) + of_seen.change * reach);
}

// Within so small a part of the piece next to either of its ends, 0.01 at most, it is this many times the bound and the
// part: H1 ≤ 5 s 0.2, H2 ≤ s² / 2, s (1 − s) ≤ 4 s / 4, and what is small of the other end.
inline double calc_bend_near_end(double bend, double part) { return 6 * part * bend; }

}  // namespace unlatch::hil
