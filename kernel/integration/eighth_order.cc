#include "kernel/integration/eighth_order.h"

#include <algorithm>

#include "kernel/dispatch/kernels.h"
#include "kernel/joints/kinematics.h"

namespace unlatch {
namespace {

constexpr std::size_t kEighthStages = EighthOrderStages::kCount;
using EighthWeights = std::array<double, kEighthStages>;

constexpr double kRoot21 = 4.58257569495584000659;
// Row i: of the rates before stage i; the last one: of the end.
constexpr std::array<EighthWeights, kEighthStages + 1> kEighthWeights{{
    {},
    {1.0 / 2},
    {1.0 / 4, 1.0 / 4},
    {1.0 / 7, (-7 - 3 * kRoot21) / 98, (21 + 5 * kRoot21) / 49},
    {(11 + kRoot21) / 84, 0, (18 + 4 * kRoot21) / 63, (21 - kRoot21) / 252},
    {(5 + kRoot21) / 48, 0, (9 + kRoot21) / 36, (-231 + 14 * kRoot21) / 360, (63 - 7 * kRoot21) / 80},
    {(10 - kRoot21) / 42, 0, (-432 + 92 * kRoot21) / 315, (633 - 145 * kRoot21) / 90, (-504 + 115 * kRoot21) / 70,
     (63 - 13 * kRoot21) / 35},
    {1.0 / 14, 0, 0, 0, (14 - 3 * kRoot21) / 126, (13 - 3 * kRoot21) / 63, 1.0 / 9},
    {1.0 / 32, 0, 0, 0, (91 - 21 * kRoot21) / 576, 11.0 / 72, (-385 - 75 * kRoot21) / 1152, (63 + 13 * kRoot21) / 128},
    {1.0 / 14, 0, 0, 0, 1.0 / 9, (-733 - 147 * kRoot21) / 2205, (515 + 111 * kRoot21) / 504, (-51 - 11 * kRoot21) / 56,
     (132 + 28 * kRoot21) / 245},
    {0, 0, 0, 0, (-42 + 7 * kRoot21) / 18, (-18 + 28 * kRoot21) / 45, (-273 - 53 * kRoot21) / 72,
     (301 + 53 * kRoot21) / 72, (28 - 28 * kRoot21) / 45, (49 - 7 * kRoot21) / 18},
    {1.0 / 20, 0, 0, 0, 0, 0, 0, 49.0 / 180, 16.0 / 45, 49.0 / 180, 1.0 / 20},
}};
constexpr double kEarly = (7 - kRoot21) / 14, kLate = (7 + kRoot21) / 14;
constexpr EighthWeights kEighthTimes{0, 0.5, 0.5, kLate, kLate, 0.5, kEarly, kEarly, 0.5, kLate, 1};

}  // namespace

double EighthOrderStages::get_time(int stage) noexcept { return kEighthTimes[at(stage)]; }

// From the beginning to the stage after `stage`, or to the end.
void EighthOrderStages::move(std::size_t stage) {
  const bool ends = stage + 1 == kEighthStages;
  // the rates that count, and their weights
  std::array<std::size_t, kEighthStages> of;
  EighthWeights weights;
  std::size_t count = 0;
  for (std::size_t j = 0; j <= stage; ++j) {
    if (kEighthWeights[stage + 1][j] == 0) continue;
    of[count] = j;
    weights[count++] = h_ * kEighthWeights[stage + 1][j];
  }
  double* blocks = ev_.blocks.data();
  for (std::size_t b = 0; b < plan_.bodies.size(); ++b) {
    MotionT<double> motion = read(blocks, plan_.places[b], &BodyLane::start);
    for (std::size_t j = 0; j < count; ++j) {
      const double s = weights[j];
      const MotionT<double>& rates = rates_[of[j]][b];
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
  std::copy(x.start.begin(), x.start.end(), x.now.begin());
  for (std::size_t j = 0; j < count; ++j)
    for (std::size_t i = 0; i < x.now.size(); ++i) x.now[i] += weights[j] * auxiliary_[of[j]][i];
  get_kernels(plan_).update_kinematics(plan_, ev_);
}

void EighthOrderStages::begin() noexcept {
  const double* blocks = ev_.blocks.data();
  for (std::size_t b = 0; b < plan_.bodies.size(); ++b) {
    const Place& place = plan_.places[b];
    const MotionT<double> start = read(blocks, place, &BodyLane::start);
    rates_[0][b] = {start.v, quaternion_rate(start.q, start.w), read(blocks, place, &BodyLane::start_v_rate),
                    read(blocks, place, &BodyLane::start_w_rate)};
  }
  std::copy(ev_.auxiliary.first.begin(), ev_.auxiliary.first.end(), auxiliary_[0].begin());
  move(0);
}

void EighthOrderStages::finish(int stage) noexcept {
  const double* blocks = ev_.blocks.data();
  for (std::size_t b = 0; b < plan_.bodies.size(); ++b) {
    const Place& place = plan_.places[b];
    const MotionT<double> now = read(blocks, place, &BodyLane::motion);
    const Spatial a = ev_.get_acceleration(static_cast<int>(b));
    rates_[at(stage)][b] = {now.v, quaternion_rate(now.q, now.w), a.lin,
                            transpose_times(read(blocks, place, &BodyLane::R), a.ang)};
  }
  std::copy(ev_.auxiliary.rate.begin(), ev_.auxiliary.rate.end(), auxiliary_[at(stage)].begin());
  move(at(stage));
}

}  // namespace unlatch
