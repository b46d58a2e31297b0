// A blow of two spheres by Simbody's HuntCrossleyForce, without friction. Built where libsimbody-dev is installed
// (cmake/peers.cmake).
#pragma once

#include <Eigen/Dense>
#include <array>
#include <vector>

namespace unlatch::test {

struct SphereBlow {
  std::array<double, 2> mass, radius;              // kg, m
  std::array<Eigen::Vector3d, 2> place, velocity;  // of the centres at the start, m, m/s
  double modulus = 0, dissipation = 0;             // of both spheres, Pa, s/m
};
using SpherePlaces = std::array<Eigen::Vector3d, 4>;  // places and velocities of both centres

// Law of the force between two spheres of this modulus E and dissipation c, by Hertz: k δ^1.5 (1 + d dδ/dt) with
// k = 4/3 sqrt(R) E / sqrt(8), 1/R = 1/r_1 + 1/r_2, and d = 3/2 c.
double calc_hertz_stiffness(const SphereBlow& blow);  // k, N/m^1.5

// Motion of the two at dt, 2·dt, … count·dt.
std::vector<SpherePlaces> run_simbody_blow(const SphereBlow& blow, double dt, int count);

}  // namespace unlatch::test
