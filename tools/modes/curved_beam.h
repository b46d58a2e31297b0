// Natural frequencies and shapes of a circular arc of a thin strip, free at both ends, in its plane: two models.
//
// kShallow: Anshakov et al. (3.1), EJ (w'''' + w''/R²) + m ẅ = 0, with (3.2) w'' + w/R² = 0 and w''' + w'/R² = 0 at the
//   ends. Its frequency equation is (3.4), exactly. With v = w'' + w/R² it is a column clamped at both ends under the
//   load EJ/R²: so all roots are real and, up to a full circle, positive.
// kInextensional: the exact thin arc (Love), tangential displacement u, w = u' inwards:
//   u⁗″ + 2 u⁗ + u″ + Ω² (u − u″) = 0;  κ = u‴ + u′: κ = κ′ = κ″ − Ω² u′ = 0 at the ends.
//   The closed ring of it is Ω² = n² (n² − 1)²/(n² + 1).
// Ω = ω R² √(m/EJ); derivatives by the angle θ, from −α to α.
#pragma once

#include <complex>
#include <vector>

namespace unlatch::tools {

enum class ArcModel { kShallow, kInextensional };

struct ArcMode {
  double omega = 0;   // Ω, dimensionless
  bool even = false;  // the radial displacement is even about the middle
  // Shape over equidistant points from end to end, the largest |w| being 1.
  std::vector<double> radial;      // outwards
  std::vector<double> tangential;  // with the angle: its slope is −radial; empty for kShallow, which has none
};

// The frequency function of λ = Ω², without the zeros that are no frequencies, over a positive factor that keeps it
// finite: entire in λ, so that its zeros in a region can be counted by its argument along the border.
std::complex<double> calc_arc_determinant(ArcModel model, double half_angle, std::complex<double> lambda);

// Zeros with |λ − centre| < radius, multiplicities included: the winding number.
int count_arc_roots(ArcModel model, double half_angle, double centre, double radius);

// The lowest `count` modes with `points` points each, ascending. 0 < angle < 2π, rad. Throws std::runtime_error if the
// roots that were found are not as many as the argument counts.
std::vector<ArcMode> calc_arc_modes(ArcModel model, double angle, int count, int points);

}  // namespace unlatch::tools
