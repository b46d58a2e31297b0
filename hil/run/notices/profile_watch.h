// Impulse that the step takes from a load's profile, against the impulse of the profile itself.
//
// The classical Runge–Kutta method weighs a force that depends on time alone at the beginning, the middle and the end
// of a step by 1/6, 4/6, 1/6. What a table has between them, such as a pulse shorter than a step, is missed. The error
// is the difference of the two integrals, summed over the steps.
#pragma once

#include "unlatch/model.h"

namespace unlatch::hil {

// Error of a profile's impulse, relative to the impulse of its size over its whole time, beyond which the step does
// not resolve it.
inline constexpr double kProfileError = 1e-3;

// Angle of a sine in a step, rad, beyond which the step does not resolve it: at the beginning, the middle and the end
// of a step the method takes some 1/2880 of its fourth power from its impulse, and of larger angles may see anything.
inline constexpr double kSineAngle = 1;
// The largest angular frequency of a harmonic profile, of sines that are kSinePart of its largest or more, rad/s; 0 for
// other profiles.
inline constexpr double kSinePart = 1e-2;
double find_frequency(const Profile& profile);

class ProfileWatch {
 public:
  explicit ProfileWatch(const Profile& profile);  // keeps a reference

  // Adds a step of the profile's own time, s. Returns the largest error so far of the impulse, relative to that of its
  // size; 0 for profiles that are no tables.
  double add(double from, double to);

 private:
  const Profile& profile_;
  double size_ = 0;                 // ∫|values| of the table, N s or N m s
  double error_ = 0, largest_ = 0;  // N s or N m s
};

}  // namespace unlatch::hil
