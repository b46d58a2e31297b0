#include "hil/run/motion/motion_window.h"

#include <cstring>

namespace unlatch::hil {
namespace {

// Quintic Hermite interpolation at the fraction s of an interval h, for vectors of any kind.
struct Quintic {
  double place[2], rate[2], acceleration[2];  // weights of the values at both ends
  Quintic(double s, double h) {
    const double s2 = s * s, s3 = s2 * s, s4 = s3 * s, s5 = s4 * s;
    place[1] = 10 * s3 - 15 * s4 + 6 * s5;
    place[0] = 1 - place[1];
    rate[0] = h * (s - 6 * s3 + 8 * s4 - 3 * s5);
    rate[1] = h * (-4 * s3 + 7 * s4 - 3 * s5);
    acceleration[0] = h * h * (0.5 * s2 - 1.5 * s3 + 1.5 * s4 - 0.5 * s5);
    acceleration[1] = h * h * (0.5 * s3 - s4 + 0.5 * s5);
  }
};

// Its derivative.
struct QuinticRate {
  double place[2], rate[2], acceleration[2];
  QuinticRate(double s, double h) {
    const double s2 = s * s, s3 = s2 * s, s4 = s3 * s;
    place[1] = (30 * s2 - 60 * s3 + 30 * s4) / h;
    place[0] = -place[1];
    rate[0] = 1 - 18 * s2 + 32 * s3 - 15 * s4;
    rate[1] = -12 * s2 + 28 * s3 - 15 * s4;
    acceleration[0] = h * (s - 4.5 * s2 + 6 * s3 - 2.5 * s4);
    acceleration[1] = h * (1.5 * s2 - 4 * s3 + 2.5 * s4);
  }
};

struct Cubic {
  double place[2], rate[2];
  Cubic(double s, double h) {
    const double s2 = s * s, s3 = s2 * s;
    place[1] = 3 * s2 - 2 * s3;
    place[0] = 1 - place[1];
    rate[0] = h * (s - 2 * s2 + s3);
    rate[1] = h * (s3 - s2);
  }
};

Quat add(const Quat& a, double s, const Quat& b) {
  return {a.w + s * b.w, a.x + s * b.x, a.y + s * b.y, a.z + s * b.z};
}

double dot(const Quat& a, const Quat& b) { return (a.w * b.w + a.x * b.x) + (a.y * b.y + a.z * b.z); }

// Attitude of a body with its first two derivatives, and its angular acceleration in body axes.
struct Turning {
  Quat q, rate, acceleration;
  Vec3 w_rate;
  Turning(const BodyState& body, const Spatial& a)
      : q(body.q), rate(quaternion_rate(q, body.w)), w_rate(transpose_times(rotation_matrix(q), a.ang)) {
    acceleration = add(quaternion_rate(rate, body.w), 1, quaternion_rate(q, w_rate));
  }
};

// The attitude between two, or its rate; not of size 1.
template <class Weights>
Quat interpolate(const Weights& five, const Turning& a, const Turning& b) {
  const double sign = dot(a.q, b.q) < 0 ? -1 : 1;  // q and −q are one attitude
  Quat q = add({0, 0, 0, 0}, five.place[0], a.q);
  q = add(add(q, five.rate[0], a.rate), five.acceleration[0], a.acceleration);
  q = add(q, sign * five.place[1], b.q);
  return add(add(q, sign * five.rate[1], b.rate), sign * five.acceleration[1], b.acceleration);
}

}  // namespace

BodyState get_rest() { return {{0, 0, 0}, {1, 0, 0, 0}, {0, 0, 0}, {0, 0, 0}}; }

BodyState MotionPiece::calc_body(std::size_t body, double time) const {
  const BodyState &a = start[body], &b = end[body];
  const double h = to - from;
  if (!(h > 0) || time >= to) return b;
  if (time <= from) return a;
  const Spatial &acc_a = at_start[body], &acc_b = at_end[body];
  const double s = (time - from) / h;
  const Quintic five(s, h);
  const Cubic three(s, h);
  const Turning turn_a(a, acc_a), turn_b(b, acc_b);
  const Quat q = interpolate(five, turn_a, turn_b);
  return {five.place[0] * a.p + five.rate[0] * a.v + five.acceleration[0] * acc_a.lin + five.place[1] * b.p +
              five.rate[1] * b.v + five.acceleration[1] * acc_b.lin,
          normalized(q),
          three.place[0] * a.v + three.rate[0] * acc_a.lin + three.place[1] * b.v + three.rate[1] * acc_b.lin,
          three.place[0] * a.w + three.rate[0] * turn_a.w_rate + three.place[1] * b.w + three.rate[1] * turn_b.w_rate};
}

BodyState MotionPiece::calc_moving_body(std::size_t body, double time) const {
  BodyState out = calc_body(body, time);
  const double h = to - from;
  if (!(h > 0) || time >= to || time <= from) return out;
  const BodyState &a = start[body], &b = end[body];
  const Spatial &acc_a = at_start[body], &acc_b = at_end[body];
  const double s = (time - from) / h;
  const QuinticRate rate(s, h);
  const Turning turn_a(a, acc_a), turn_b(b, acc_b);
  out.v = rate.place[0] * a.p + rate.rate[0] * a.v + rate.acceleration[0] * acc_a.lin + rate.place[1] * b.p +
          rate.rate[1] * b.v + rate.acceleration[1] * acc_b.lin;
  const Quat q = interpolate(Quintic(s, h), turn_a, turn_b);
  const Quat turn = Quat{q.w, -q.x, -q.y, -q.z} * interpolate(rate, turn_a, turn_b);
  out.w = (2 / dot(q, q)) * Vec3{turn.x, turn.y, turn.z};
  return out;
}

// Moves to the piece between two knots. Motion is smooth if neither state nor accelerations jump, a step begins with
// its inputs, which may be new, and if there is no corner.
void MotionWindow::move_on(const MotionKnot& from, const MotionKnot& to) {
  const MotionPiece& before = pieces_[present_];
  const auto same = [](const auto& a, const auto& b) {
    return a.size() == b.size() + 1 && std::memcmp(a.data(), b.data(), b.size() * sizeof(b[0])) == 0;
  };
  continuous_ = begun_ && before.to == from.time && same(before.end, from.state.bodies) &&
                same(before.at_end, from.accelerations);
  smooth_ = continuous_ && !corner_ && !from.corner;
  smooth_readings_ = !reading_corner_ && !from.reading_corner;
  begun_ = true;
  corner_ = to.corner;
  reading_corner_ = to.reading_corner;
  present_ = 1 - present_;
  MotionPiece& piece = pieces_[present_];
  piece.from = from.time;
  piece.to = to.time;
  if (smooth_) {
    piece.start = before.end;
    piece.at_start = before.at_end;
  } else {
    const Place& start = keep(from);
    piece.start = start.bodies;
    piece.at_start = start.accelerations;
  }
  const Place& end = keep(to);
  piece.end = end.bodies;
  piece.at_end = end.accelerations;
}

// Two pieces have at most four places, so those of the present ones are not overwritten.
MotionWindow::Place& MotionWindow::keep(const MotionKnot& knot) {
  Place& place = places_[next_];
  next_ = (next_ + 1) % places_.size();
  place.bodies.assign(knot.state.bodies.begin(), knot.state.bodies.end());
  place.bodies.push_back(get_rest());
  place.accelerations.assign(knot.accelerations.begin(), knot.accelerations.end());
  place.accelerations.push_back({{0, 0, 0}, {0, 0, 0}});
  return place;
}

const MotionPiece& MotionWindow::get_piece(double time) const {
  return time < get_present().from ? get_previous() : get_present();
}

BodyState MotionWindow::calc_body(int body, double time) const {
  return body < 0 ? get_rest() : get_piece(time).calc_body(static_cast<std::size_t>(body), time);
}

BodyState MotionWindow::calc_moving_body(int body, double time) const {
  return body < 0 ? get_rest() : get_piece(time).calc_moving_body(static_cast<std::size_t>(body), time);
}

}  // namespace unlatch::hil
