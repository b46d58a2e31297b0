#include "hil/run/notices/profile_watch.h"

#include <algorithm>
#include <cmath>

#include "unlatch/model/law_places.h"

namespace unlatch::hil {
namespace {

double calc_value(const Profile& profile, double s) {
  const std::vector<double>&times = profile.times, &values = profile.values;
  if (s <= times.front()) return values.front();
  if (s >= times.back()) return values.back();
  const std::size_t i = static_cast<std::size_t>(std::ranges::upper_bound(times, s) - times.begin());
  return values[i - 1] + (values[i] - values[i - 1]) * ((s - times[i - 1]) / (times[i] - times[i - 1]));
}

// Integral of the table from one time to another: trapezoids between its knots.
double calc_impulse(const Profile& profile, double from, double to) {
  double sum = 0, last = from, value = calc_value(profile, from);
  const auto first = std::ranges::upper_bound(profile.times, from);
  for (auto knot = first; knot != profile.times.end() && *knot < to; ++knot) {
    const double next = profile.values[static_cast<std::size_t>(knot - profile.times.begin())];
    sum += 0.5 * (*knot - last) * (value + next);
    last = *knot;
    value = next;
  }
  return sum + 0.5 * (to - last) * (value + calc_value(profile, to));
}

}  // namespace

double find_frequency(const Profile& profile) {
  if (profile.kind != Profile::Kind::kHarmonic) return 0;
  double largest = 0, frequency = 0;
  for (const Profile::Harmonic& sine : profile.harmonics) largest = std::max(largest, std::abs(sine.amplitude));
  for (const Profile::Harmonic& sine : profile.harmonics)
    if (sine.amplitude != 0 && std::abs(sine.amplitude) >= kSinePart * largest)
      frequency = std::max(frequency, std::abs(sine.frequency));
  return frequency;
}

ProfileWatch::ProfileWatch(const Profile& profile) : profile_(profile) {
  if (profile.kind != Profile::Kind::kTable) return;
  for (std::size_t i = 1; i < profile.times.size(); ++i)
    size_ += 0.5 * (profile.times[i] - profile.times[i - 1]) *
             (std::abs(profile.values[i - 1]) + std::abs(profile.values[i]));
}

double ProfileWatch::add(double from, double to) {
  if (!(size_ > 0) || !(to > from)) return 0;
  if (to <= profile_.times.front() || from >= profile_.times.back()) return largest_ / size_;
  const auto knot = std::ranges::upper_bound(profile_.times, from);
  if (std::ranges::lower_bound(profile_.times, to) - knot <= kMostCorners)
    return largest_ / size_;  // it is split there
  const double taken =
      (to - from) / 6 *
      (calc_value(profile_, from) + 4 * calc_value(profile_, 0.5 * (from + to)) + calc_value(profile_, to));
  error_ += taken - calc_impulse(profile_, from, to);
  largest_ = std::max(largest_, std::abs(error_));
  return largest_ / size_;
}

}  // namespace unlatch::hil
