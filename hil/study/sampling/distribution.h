// Distribution of a parameter's value. A probability in (0, 1) gives a value by the quantile function, with the same
// bits on every machine.
#pragma once

#include <array>
#include <vector>

namespace unlatch::hil {

struct Distribution {
  enum class Kind {
    kUniform,     // from a to b
    kNormal,      // mean a, standard deviation b
    kLognormal,   // the logarithm has mean a and standard deviation b
    kTriangular,  // from a over the mode c to b
    kDiscrete,    // values[k] with probability up to cumulative[k]
    kEmpirical,   // sorted values, linear between them
    kCone,        // angle from a direction, rad; uniform over the cap of half angle b
    kNormalCone,  // likewise; tilts about two perpendicular axes are normal with standard deviation a
  };
  Kind kind = Kind::kUniform;
  double a = 0, b = 0, c = 0;
  double low = 0, high = 1;  // probabilities at which the whole distribution is truncated
  std::vector<double> values{}, cumulative{};

  // Value of a probability p in (0, 1).
  [[nodiscard]] double calc_quantile(double p) const;
  // Probability below x of the untruncated distribution; normal and lognormal only.
  [[nodiscard]] double calc_cdf(double x) const;
  // Truncates the distribution to values between two limits.
  void cut(double least, double most);

  [[nodiscard]] bool is_cone() const { return kind == Kind::kCone || kind == Kind::kNormalCone; }
  // Numbers in (0, 1) that a draw uses: 2 for a direction.
  [[nodiscard]] std::size_t get_dimensions() const { return is_cone() ? 2 : 1; }
};

// Unit vector at an angle, rad, from a direction (any length but 0), rotated about it by 2 pi times `turn`.
std::array<double, 3> tilt(const std::array<double, 3>& direction, double angle, double turn);

}  // namespace unlatch::hil
