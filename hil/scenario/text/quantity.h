// Numbers with a physical dimension, and the units by which a scenario may name them.
#pragma once

#include <array>
#include <string>
#include <string_view>
#include <vector>

namespace unlatch::hil {

// Exponents of m, kg, s, rad, cycles and K. Radians are separate so that 5 deg is not accepted as a plain number. SI
// often omits them: v/r is a rate and N m turns a torsion spring. So they must agree only where both quantities have
// them. Cycles, as in Hz, have one purpose: 10 Hz is no angular rate until it is multiplied by 2*pi rad.
struct Dimension {
  enum Base { kLength, kMass, kTime, kAngle, kCycle, kTemperature };
  std::array<int, 6> exponents{};

  bool operator==(const Dimension&) const = default;
  bool is_plain() const;
  // True if a quantity of dimension `other` is accepted where this one is expected.
  bool takes(const Dimension& other) const;
};

struct Quantity {
  double value = 0;  // SI
  Dimension dimension;
};

// A value in a unit is value / divisor · factor in SI. Factors of metric units are exact, so that `12 ms` is the double
// nearest to 0.012.
struct Unit {
  std::string_view name;
  double factor, divisor;
  Dimension dimension;
};

const Unit* find_unit(std::string_view name);  // m, kN, deg …; null if there is none

// Names of all units.
std::vector<std::string> list_unit_names();

// Description in words: "a mass (kg)", "a plain number", "a quantity in kg m".
std::string describe_dimension(const Dimension& dimension);

// SI units that an expression takes after a number: "N m", "m2/s"; "" for a plain number. Energies are written as
// torques here.
std::string describe_unit(const Dimension& dimension);

// Dimension of an SI unit such as "N m s/rad"; "" is plain. Throws std::logic_error: the program's own units are never
// wrong.
Dimension dimension_of(std::string_view si);

// Other spellings of an SI unit: kN m and so on for N m.
std::vector<std::string> list_units(std::string_view si);

}  // namespace unlatch::hil
