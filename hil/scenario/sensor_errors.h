// Errors of sensors: what flight software receives instead of the true values. Random numbers are drawn by counters
// from the seed, the sensor's name and the number of the sample (hil/scenario/base/philox.h): they are the same on
// every machine, in every replay, beside other sensors, and with a step of half the size where the sensor has a period.
// The errors decide nothing in the step but through flight software.
//
// Of each value x of a sensor, at each of its samples, a period T apart:
//
//   y = (1 + scale) (x − m × x) + bias + turn_on N + walk + drift + noise N    N: a new standard normal number
//   walk grows by walk √T N;   drift' = φ drift + σ √(1 − φ²) N,  φ = exp(−T / time)
//
// m: misalignment, of sensors with three values. Then y is rounded to the nearest multiple of `quantum` within ±range,
// `delay` samples late, and held with the probability `dropout`. An attitude is turned by the sum of the errors, as a
// rotation vector in body axes, rad.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "unlatch/model.h"

namespace unlatch::hil {

// Errors of one sensor, in the unit of its values; rad of an attitude. The same sizes for each of its values.
struct SensorErrors {
  int sensor = 0;                    // index of the model
  std::uint64_t name = 0;            // hash of its name, from which its numbers are drawn
  std::vector<double> bias{};        // of each value (of an attitude three); empty: none
  double turn_on = 0;                // σ of a bias that is drawn once for a run
  double noise = 0;                  // σ of each sample
  double noise_density = 0;          // unit/√Hz: σ of a sample is this over √T
  double walk = 0;                   // unit/√s: σ of the bias' growth in a second
  double drift = 0, drift_time = 1;  // σ and correlation time, s, of a first-order Markov process
  double scale = 0;                  // relative
  Eigen::Vector3d misalignment = Eigen::Vector3d::Zero();  // turn of the sensor's axes, rad
  double quantum = 0;                                      // least significant bit; 0: none
  double range = 0;                                        // largest value; 0: no limit
  double dropout = 0;                                      // probability that a sample is lost and the last one held
  int delay = 0;                                           // samples
};

// All of a scenario.
struct SensorErrorModel {
  std::vector<SensorErrors> sensors;  // each at most once
  std::uint64_t seed = 1;
  double dt = 0;  // s, of a tick
};

std::uint64_t calc_hash(const SensorErrorModel& model, std::uint64_t hash) noexcept;
// Hash of a sensor's name: FNV-1a, 64 bits.
std::uint64_t calc_name_hash(std::string_view name) noexcept;

// Sensors with errors, compiled: only the constructor allocates.
class Measurement {
 public:
  // `every`: ticks from one sample to the next, of each sensor of the model.
  Measurement(const Model& model, const SensorErrorModel& errors, std::span<const std::int64_t> every);

  [[nodiscard]] bool is_exact() const noexcept { return sensors_.empty(); }
  // Replaces in `values`, of all sensors, the true values of those with errors that are sampled at `tick`. `last`: what
  // was delivered before. The sensors that are due: those whose period divides `tick` after their phase.
  void measure(std::int64_t tick, std::span<const std::int64_t> phase, std::span<const double> last,
               std::span<double> values) noexcept;

  // Walks, drifts and delayed samples: all that further samples depend on.
  [[nodiscard]] std::span<double> memory() noexcept { return memory_; }
  [[nodiscard]] std::span<const double> memory() const noexcept { return memory_; }

 private:
  struct Own {
    SensorErrors errors;
    std::size_t first, width, draws;  // values; numbers of errors: three of an attitude
    std::size_t memory;               // its first number there
    std::int64_t every;
    std::uint64_t seed;               // of the scenario's seed and the name
    double noise, walk, keep, renew;  // of a sample
  };
  void measure(const Own& own, std::int64_t sample, std::span<double> values) noexcept;
  void delay(const Own& own, std::int64_t tick, std::span<double> values) noexcept;

  std::vector<Own> sensors_;
  std::vector<double> memory_;
};

}  // namespace unlatch::hil
