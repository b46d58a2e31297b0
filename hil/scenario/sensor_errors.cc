#include "hil/scenario/sensor_errors.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "hil/scenario/base/normal.h"
#include "hil/scenario/base/philox.h"
#include "unlatch/elementary.h"
#include "unlatch/math.h"

namespace unlatch::hil {
namespace {

// Uses of one sensor and value that must not share numbers.
enum Purpose : std::uint32_t { kTurnOn, kNoise, kWalk, kDrift, kDropout, kPurposes };
constexpr std::uint32_t kMostDraws = 8;  // values of one sensor, more than any has

// The seed of one sensor: a number drawn from that of the scenario, at the place of its name.
std::uint64_t draw_seed(std::uint64_t seed, std::uint64_t name) {
  return draw_word(seed, RandomStream::kSensor, name, kMostDraws * kPurposes);
}

// A number of (0, 1) of a sensor's value at a sample, and a standard normal one.
double draw_unit_of(std::uint64_t seed, std::size_t value, Purpose purpose, std::int64_t sample) {
  const auto place = static_cast<std::uint32_t>(value) * kPurposes + purpose;
  return draw_unit(seed, RandomStream::kSensor, static_cast<std::uint64_t>(sample), place);
}
double draw_normal(std::uint64_t seed, std::size_t value, Purpose purpose, std::int64_t sample) {
  return calc_normal_quantile(draw_unit_of(seed, value, purpose, sample));
}

// Number of the sample that is taken at a tick; the one of tick 0 comes before that of the phase.
std::int64_t count_samples(std::int64_t tick, std::int64_t every) { return (tick + every - 1) / every; }

bool is_attitude(std::size_t width) { return width == 4; }

// The turn by a rotation vector, rad: (cos(a/2), sin(a/2) r/a), a = |r|.
Quat calc_turn(const Vec3& r) noexcept {
  const double half = 0.5 * std::sqrt(dot(r, r));
  double sine, cosine;
  elementary::sincos(half, sine, cosine);
  // sin(h)/h = 1 − h²/6 + …: below this half angle the rest, h⁴/120, is less than half a unit of the last place.
  constexpr double kSmall = 1e-4;
  const double ratio = half < kSmall ? 1 - half * half / 6 : sine / half;
  return Quat{cosine, 0.5 * ratio * r.x, 0.5 * ratio * r.y, 0.5 * ratio * r.z};
}

// What a converter makes of y: the nearest of its codes, which are the multiples of `quantum` within ±range.
double convert(double y, double quantum, double range) noexcept {
  constexpr double kWhole = 0x1p52;      // codes beyond this cannot be distinguished
  constexpr double kSameNumber = 1e-12;  // relative: range and quantum are decimal numbers, rounded
  if (quantum > 0 && std::abs(y / quantum) < kWhole) {
    double code = std::floor(y / quantum + 0.5);
    if (range > 0) {
      const double most = std::floor(range / quantum * (1 + kSameNumber));
      code = std::clamp(code, -most, most);
    }
    return code * quantum;
  }
  return range > 0 ? std::clamp(y, -range, range) : y;
}

}  // namespace

std::uint64_t calc_name_hash(std::string_view name) noexcept {
  std::uint64_t hash = 0xCBF29CE484222325u;
  for (const char letter : name) hash = (hash ^ static_cast<unsigned char>(letter)) * 0x100000001B3u;
  return hash;
}

std::uint64_t calc_hash(const SensorErrorModel& model, std::uint64_t hash) noexcept {
  if (model.sensors.empty()) return hash;
  const auto add = [&hash](std::uint64_t word) {
    hash = (hash ^ word) * 0x9E3779B97F4A7C15u;
    hash ^= hash >> 32;
  };
  const auto add_number = [&add](double number) { add(std::bit_cast<std::uint64_t>(number)); };
  add(model.seed);
  for (const SensorErrors& own : model.sensors) {
    add(static_cast<std::uint64_t>(own.sensor));
    add(own.name);
    add(own.bias.size());
    for (const double bias : own.bias) add_number(bias);
    for (const double number :
         {own.turn_on, own.noise, own.noise_density, own.walk, own.drift, own.drift_time, own.scale,
          own.misalignment.x(), own.misalignment.y(), own.misalignment.z(), own.quantum, own.range, own.dropout})
      add_number(number);
    add(static_cast<std::uint64_t>(own.delay));
  }
  return hash;
}

Measurement::Measurement(const Model& model, const SensorErrorModel& errors, std::span<const std::int64_t> every) {
  std::vector<std::size_t> first{0};
  for (const Sensor& sensor : model.sensors)
    first.push_back(first.back() + static_cast<std::size_t>(sensor_width(sensor.kind)));
  std::size_t memory = 0;
  for (const SensorErrors& own : errors.sensors) {
    const auto at = static_cast<std::size_t>(own.sensor);
    Own& added = sensors_.emplace_back();
    added.errors = own;
    added.first = first[at];
    added.width = first[at + 1] - first[at];
    added.draws = is_attitude(added.width) ? 3 : added.width;
    added.memory = memory;
    added.every = every[at];
    added.seed = draw_seed(errors.seed, own.name);
    const double period = static_cast<double>(added.every) * errors.dt;
    const double density = own.noise_density / std::sqrt(period);
    added.noise = std::sqrt(own.noise * own.noise + density * density);
    added.walk = own.walk * std::sqrt(period);
    added.keep = elementary::exp(-period / own.drift_time);
    added.renew = own.drift * std::sqrt(1 - added.keep * added.keep);
    memory += 2 * added.draws + static_cast<std::size_t>(own.delay) * added.width;
  }
  memory_.assign(memory, 0);
}

void Measurement::measure(std::int64_t tick, std::span<const std::int64_t> phase, std::span<const double> last,
                          std::span<double> values) noexcept {
  for (const Own& own : sensors_) {
    if (tick % own.every != phase[static_cast<std::size_t>(own.errors.sensor)] && tick != 0) continue;
    const std::span<double> mine = values.subspan(own.first, own.width);
    const std::int64_t sample = count_samples(tick, own.every);
    measure(own, sample, mine);
    if (own.errors.delay > 0) delay(own, tick, mine);
    const bool lost =
        own.errors.dropout > 0 && tick != 0 && draw_unit_of(own.seed, 0, kDropout, sample) < own.errors.dropout;
    if (lost) std::copy_n(last.begin() + static_cast<std::ptrdiff_t>(own.first), own.width, mine.begin());
  }
}

void Measurement::measure(const Own& own, std::int64_t sample, std::span<double> values) noexcept {
  const SensorErrors& errors = own.errors;
  const bool begins = sample == 0;
  std::array<double, kMostDraws> sum{};
  for (std::size_t i = 0; i < own.draws; ++i) {
    const auto draw = [&](Purpose purpose, std::int64_t at) { return draw_normal(own.seed, i, purpose, at); };
    double& walk = memory_[own.memory + i];
    double& drift = memory_[own.memory + own.draws + i];
    if (own.walk > 0 && !begins) walk += own.walk * draw(kWalk, sample);
    if (errors.drift > 0)
      drift = begins ? errors.drift * draw(kDrift, sample) : own.keep * drift + own.renew * draw(kDrift, sample);
    sum[i] = (errors.bias.empty() ? 0 : errors.bias[i]) + walk + drift;
    if (errors.turn_on > 0) sum[i] += errors.turn_on * draw(kTurnOn, 0);
    if (own.noise > 0) sum[i] += own.noise * draw(kNoise, sample);
  }
  if (is_attitude(own.width)) {
    const Quat q{values[0], values[1], values[2], values[3]};
    const Quat turned = normalized(q * calc_turn({sum[0], sum[1], sum[2]}));
    values[0] = turned.w;
    values[1] = turned.x;
    values[2] = turned.y;
    values[3] = turned.z;
    return;
  }
  if (own.width == 3) {
    const Vec3 x{values[0], values[1], values[2]};
    const Vec3 m{errors.misalignment.x(), errors.misalignment.y(), errors.misalignment.z()};
    const Vec3 seen = x - cross(m, x);
    values[0] = seen.x;
    values[1] = seen.y;
    values[2] = seen.z;
  }
  for (std::size_t i = 0; i < own.width; ++i)
    values[i] = convert((1 + errors.scale) * values[i] + sum[i], errors.quantum, errors.range);
}

// A ring of the latest samples; before the first has come through, the first.
void Measurement::delay(const Own& own, std::int64_t tick, std::span<double> values) noexcept {
  const auto count = static_cast<std::size_t>(own.errors.delay);
  double* const ring = memory_.data() + own.memory + 2 * own.draws;
  if (tick == 0)
    for (std::size_t k = 0; k < count; ++k) std::ranges::copy(values, ring + k * own.width);
  const std::size_t k = static_cast<std::size_t>(tick / own.every) % count;
  for (std::size_t i = 0; i < own.width; ++i) std::swap(ring[k * own.width + i], values[i]);
}

}  // namespace unlatch::hil
