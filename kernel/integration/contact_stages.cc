#include "kernel/integration/contact_stages.h"

#include <algorithm>
#include <array>

#include "kernel/dispatch/kernels.h"
#include "kernel/elements/kinds/contact/contact.h"
#include "kernel/elements/kinds/load.h"
#include "kernel/elements/push.h"
#include "kernel/joints/kinematics.h"

namespace unlatch {
namespace {

// Coefficients of ROS34PW2; `kGammas` without its diagonal, which is γ.
constexpr std::size_t kStages = ContactStages::kCount;
constexpr double kGamma34 = 4.3586652150845900e-1;
using Weights = std::array<double, kStages>;
constexpr std::array<Weights, kStages> kAlphas{{{0, 0, 0, 0},
                                                {8.7173304301691801e-1, 0, 0, 0},
                                                {8.4457060015369423e-1, -1.1299064236484185e-1, 0, 0},
                                                {0, 0, 1, 0}}};
constexpr std::array<Weights, kStages> kGammas{
    {{0, 0, 0, 0},
     {-8.7173304301691801e-1, 0, 0, 0},
     {-9.0338057013044082e-1, 5.4180672388095326e-2, 0, 0},
     {2.4212380706095346e-1, -1.2232505839045147, 5.4526025533510214e-1, 0}}};
constexpr Weights kEndWeights{2.4212380706095346e-1, -1.2232505839045147, 1.5452602553351020, kGamma34};

// Twice the vector part of q₀* q': the rate of turn, body axes, of a rate of a quaternion near q₀.
Vec3 calc_turn(const Quat& q, const Quat& rate) {
  const Quat product = Quat{q.w, -q.x, -q.y, -q.z} * rate;
  return {2 * product.x, 2 * product.y, 2 * product.z};
}

// Rate of the way along a row: of the follower's material, seen from the base's.
struct BodyRate {
  Vec3 linear, angular;  // W axes; body axes
};
template <class GetRate>
double calc_along(const ContactRow& row, const GetRate& get_rate) {
  double along = 0;
  if (row.follower != kGround) {
    const BodyRate rate = get_rate(at(row.follower));
    along += dot(row.u, rate.linear) + dot(row.lever_follower, rate.angular);
  }
  if (row.base != kGround) {
    const BodyRate rate = get_rate(at(row.base));
    along -= dot(row.u, rate.linear) + dot(row.lever_base, rate.angular);
  }
  return along;
}

Vec3 calc_lever(const BodyFrame& body, const Vec3& point, const Vec3& u) {
  return transpose_times(body.R, cross(point - body.p, u));
}

// The rows of one closed pair.
void add_rows(const PlanData& plan, const ClosedPair& pair, const PlanContact& contact, double scale,
              const Evaluation& ev, ContactRows& own) {
  const PairSlopes slopes = calc_slopes(contact, pair, scale);
  if (!(slopes.stiffness > 0)) return;
  const std::int32_t base = plan.shapes[at(contact.base)].body, follower = plan.shapes[at(contact.follower)].body;
  const BodyFrame at_base = get_body_frame(ev, base), at_follower = get_body_frame(ev, follower);
  const auto add = [&](const Vec3& u, double stiffness, double damping, std::int32_t impulse) {
    own.rows[own.count++] = {
        base,      follower, impulse, u, calc_lever(at_base, pair.point, u), calc_lever(at_follower, pair.point, u),
        stiffness, damping};
  };
  add(pair.normal, slopes.stiffness, slopes.damping, contact.auxiliary);
  if (!(slopes.across > 0)) return;
  const double slip = norm(pair.slip);
  const Vec3 helper = std::abs(pair.normal.x) < 0.5 ? Vec3{1, 0, 0} : Vec3{0, 1, 0};
  const Vec3 side = slip > 0 ? pair.slip : cross(pair.normal, helper);
  const Vec3 along = (1 / norm(side)) * side;
  add(along, 0, slopes.along, kNone);
  add(cross(pair.normal, along), 0, slopes.across, kNone);
}

// Accelerations of all bodies by a unit force along a row.
void calc_response(const PlanData& plan, const ContactRow& row, std::span<Spatial> response, Evaluation& ev) {
  double* blocks = ev.blocks.data();
  for (const Place& place : plan.places) write(blocks, place, &SharedLane::force, {{0, 0, 0}, {0, 0, 0}});
  const auto push_along = [&](std::int32_t body, double side, const Vec3& lever) {
    if (body != kGround) push(ev, body, side * row.u, side * (get_body_frame(ev, body).R * lever));
  };
  push_along(row.follower, 1, row.lever_follower);
  push_along(row.base, -1, row.lever_base);
  get_kernels(plan).solve(plan, ev, {.source = Source::kBodyForces, .biased = false, .multipliers = false});
  for (std::size_t b = 0; b < response.size(); ++b) {
    const Spatial a = ev.get_acceleration(static_cast<int>(b));
    response[b] = {a.lin, transpose_times(read(blocks, plan.places[b], &BodyLane::R), a.ang)};
  }
}

}  // namespace

void begin_contact_rows(const Instant& now, Evaluation& ev, ContactRows& own) noexcept {
  const PlanData& plan = now.plan;
  own.count = 0;
  for (const PlanContact& contact : plan.contacts) {
    const double scale = calc_scale(now.state.elements[at(contact.element)], now.t);
    if (!(scale > 0)) continue;
    for (std::size_t i = at(contact.first_pair); i < at(contact.first_pair + contact.pairs); ++i)
      if (now.state.contacts[i].closed != 0 && own.count + kRowsPerPair <= own.rows.size())
        add_rows(plan, ev.closed_pairs[i], contact, scale, ev, own);
  }
  for (std::size_t r = 0; r < own.count; ++r) {
    const std::span<Spatial> response = std::span(own.responses[r]).first(plan.bodies.size());
    calc_response(plan, own.rows[r], response, ev);
    for (std::size_t i = 0; i < own.count; ++i)
      own.mobility[i][r] = calc_along(own.rows[i], [&](std::size_t body) {
        return BodyRate{response[body].lin, response[body].ang};
      });
  }
}

double ContactStages::get_time(int stage) noexcept {
  double sum = 0;
  for (const double alpha : kAlphas[at(stage)]) sum += alpha;
  return sum;
}

ContactStages::ContactStages(const PlanData& plan, const ContactRows& rows, double h, Evaluation& ev) noexcept
    : plan_(plan), own_(rows), h_(h), ev_(ev) {
  factor();
}

// The matrix is positive definite.
void ContactStages::factor() {
  const std::size_t n = own_.count;
  const double gamma_h = kGamma34 * h_;
  auto& m = factor_;
  for (std::size_t r = 0; r < n; ++r) {
    for (std::size_t c = 0; c <= r; ++c) m[r][c] = own_.mobility[r][c];
    const ContactRow& row = own_.rows[r];
    inverse_slopes_[r] = 1 / (gamma_h * (row.damping + gamma_h * row.stiffness));
    m[r][r] += inverse_slopes_[r];
  }
  for (std::size_t p = 0; p < n; ++p) {
    const double inverse = 1 / m[p][p];
    for (std::size_t r = p + 1; r < n; ++r) {
      const double l = m[r][p] * inverse;
      for (std::size_t c = p + 1; c <= r; ++c) m[r][c] -= l * m[c][p];
    }
    for (std::size_t r = p + 1; r < n; ++r) m[r][p] *= inverse;
  }
}

// h Σ γ_ij of a number that each row has at each stage.
double ContactStages::calc_weighted(const std::array<PerRow, 4>& of, std::size_t stage, std::size_t row) const {
  double sum = 0;
  for (std::size_t j = 0; j < stage; ++j) sum += kGammas[stage][j] * of[j][row];
  return h_ * sum;
}

// z of a stage whose explicit rates are in rates_; and the rows' own rates.
void ContactStages::solve_rows(std::size_t stage) {
  const std::size_t n = own_.count;
  const double gamma_h = kGamma34 * h_;
  const auto& m = factor_;
  PerRow &z = forces_, &speeds = speeds_[stage], &places = places_[stage];
  for (std::size_t r = 0; r < n; ++r) {
    const ContactRow& row = own_.rows[r];
    speeds[r] = calc_along(row, [&](std::size_t body) {
      const MotionT<double>& rates = rates_[stage][body];
      return BodyRate{rates.v, rates.w};
    });
    places[r] = calc_along(row, [&](std::size_t body) {
      const MotionT<double>& rates = rates_[stage][body];
      const Quat start = read(ev_.blocks.data(), plan_.places[body], &BodyLane::start).q;
      return BodyRate{rates.p, calc_turn(start, rates.q)};
    });
    const double speed = calc_weighted(speeds_, stage, r), place = calc_weighted(places_, stage, r);
    const double later = row.damping * speed + row.stiffness * (gamma_h * (places[r] + speed) + place);
    places[r] += speed;
    z[r] = -speeds[r] - inverse_slopes_[r] * later;
  }
  for (std::size_t r = 0; r < n; ++r)
    for (std::size_t c = 0; c < r; ++c) z[r] -= m[r][c] * z[c];
  for (std::size_t r = 0; r < n; ++r) z[r] /= m[r][r];
  for (std::size_t k = 1; k <= n; ++k)
    for (std::size_t c = n - k + 1; c < n; ++c) z[n - k] -= m[c][n - k] * z[c];
  for (std::size_t r = 0; r < n; ++r) {
    for (std::size_t c = 0; c < n; ++c) speeds[r] += own_.mobility[r][c] * z[c];
    places[r] += gamma_h * speeds[r];
  }
}

// k of the stage, from its explicit rates.
void ContactStages::add_responses(std::size_t stage) {
  for (std::size_t b = 0; b < plan_.bodies.size(); ++b) {
    MotionT<double>& rates = rates_[stage][b];
    for (std::size_t r = 0; r < own_.count; ++r) {
      rates.v += forces_[r] * own_.responses[r][b].lin;
      rates.w += forces_[r] * own_.responses[r][b].ang;
    }
    Vec3 v = kGamma34 * rates.v, w = kGamma34 * rates.w;
    for (std::size_t j = 0; j < stage; ++j) {
      v += kGammas[stage][j] * rates_[j][b].v;
      w += kGammas[stage][j] * rates_[j][b].w;
    }
    rates.p += h_ * v;
    const Quat turn = quaternion_rate(read(ev_.blocks.data(), plan_.places[b], &BodyLane::start).q, h_ * w);
    rates.q = {rates.q.w + turn.w, rates.q.x + turn.x, rates.q.y + turn.y, rates.q.z + turn.z};
  }
  for (std::size_t r = 0; r < own_.count; ++r)
    if (own_.rows[r].impulse != kNone) auxiliary_[stage][at(own_.rows[r].impulse)] += forces_[r];
}

// From the beginning to the stage after `stage`, or to the end.
void ContactStages::move(std::size_t stage) {
  const bool ends = stage + 1 == kStages;
  const Weights& weights = ends ? kEndWeights : kAlphas[stage + 1];
  double* blocks = ev_.blocks.data();
  for (std::size_t b = 0; b < plan_.bodies.size(); ++b) {
    MotionT<double> motion = read(blocks, plan_.places[b], &BodyLane::start);
    for (std::size_t j = 0; j <= stage; ++j) {
      const double s = h_ * weights[j];
      const MotionT<double>& rates = rates_[j][b];
      motion.p += s * rates.p;
      motion.q = {motion.q.w + s * rates.q.w, motion.q.x + s * rates.q.x, motion.q.y + s * rates.q.y,
                  motion.q.z + s * rates.q.z};
      motion.v += s * rates.v;
      motion.w += s * rates.w;
    }
    if (ends) motion.q = normalized(motion.q);
    write(blocks, plan_.places[b], &BodyLane::motion, motion);
  }
  const Auxiliary& x = ev_.auxiliary;
  for (std::size_t i = 0; i < x.now.size(); ++i) {
    double sum = 0;
    for (std::size_t j = 0; j <= stage; ++j) sum += weights[j] * auxiliary_[j][i];
    x.now[i] = x.start[i] + h_ * sum;
  }
  get_kernels(plan_).update_kinematics(plan_, ev_);
}

void ContactStages::begin() noexcept {
  const double* blocks = ev_.blocks.data();
  for (std::size_t b = 0; b < plan_.bodies.size(); ++b) {
    const Place& place = plan_.places[b];
    const MotionT<double> start = read(blocks, place, &BodyLane::start);
    rates_[0][b] = {start.v, quaternion_rate(start.q, start.w), read(blocks, place, &BodyLane::start_v_rate),
                    read(blocks, place, &BodyLane::start_w_rate)};
  }
  std::copy(ev_.auxiliary.first.begin(), ev_.auxiliary.first.end(), auxiliary_[0].begin());
  solve_rows(0);
  add_responses(0);
  move(0);
}

void ContactStages::finish(int stage) noexcept {
  const double* blocks = ev_.blocks.data();
  for (std::size_t b = 0; b < plan_.bodies.size(); ++b) {
    const Place& place = plan_.places[b];
    const MotionT<double> now = read(blocks, place, &BodyLane::motion);
    const Spatial a = ev_.get_acceleration(static_cast<int>(b));
    rates_[at(stage)][b] = {now.v, quaternion_rate(now.q, now.w), a.lin,
                            transpose_times(read(blocks, place, &BodyLane::R), a.ang)};
  }
  std::copy(ev_.auxiliary.rate.begin(), ev_.auxiliary.rate.end(), auxiliary_[at(stage)].begin());
  solve_rows(at(stage));
  add_responses(at(stage));
  move(at(stage));
}

}  // namespace unlatch
