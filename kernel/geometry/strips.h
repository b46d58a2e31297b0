// Tangent strips of a thin wall, and lower bounds of their distances to a convex core over arcs of azimuths.
//
// The strip at an azimuth is the part of the tangent plane beside the wall's generator there; that of a half wall ends
// at the plane of its edges. wall.cc uses both.
#pragma once

#include "kernel/geometry/compiled_shape.h"
#include "kernel/geometry/core.h"

namespace unlatch::geometry {

struct Strip {
  Distance d;
  double azimuth = 0;  // rad
  double rate = 0;     // m/rad, of the distance by the azimuth
};

// A direction u that turns with the azimuth θ. The distance between the support planes of a strip and of B across u is
// a lower bound of their signed distance.
//
// The support H(θ) of B along −u has H + H'' ≥ −residue. So H + residue stays below the sinusoid that has its values at
// the two ends of an arc. For one point at the height z over the solid's centre, H + H'' = −u.z z. B is one part, whose
// residue is the largest of its points; a frustum is two, its rims: a radius r adds r (g + g''), see calc_roundness().
struct TurningDirection {
  double e, t, z;     // unit length, from the strip to B: radial, along the rims, along the axis
  double of_wall;     // m, the strip's extent along e and z
  double residue[2];  // m, of each part
};
struct Reach {
  double of[2];  // m, of each part, with its residue
};

// An arc's half: sine and cosine of half its width.
struct HalfArc {
  double sine = 0, cosine = 1;
};

// The strips of the wall of `solid`, a frustum or half of one, and their distances to B. Refers to both.
class Strips {
 public:
  Strips(const Core& solid, const Core& b);

  [[nodiscard]] double get_size() const { return size_; }  // m, of the pair
  [[nodiscard]] bool is_half() const { return is_half_; }
  // The azimuth, or of a half wall the edge next to it.
  [[nodiscard]] double clamp(double azimuth) const;
  [[nodiscard]] double calc_azimuth(const Vec3& point) const;

  // Axes of the strip at an azimuth: radial, and along the wall's rims.
  struct Axes {
    Vec3 e, t;
    double cosine, sine, azimuth;
  };
  [[nodiscard]] Axes calc_axes(double azimuth) const;
  [[nodiscard]] Strip calc_strip(const Axes& at) const;
  [[nodiscard]] Strip calc_strip(double azimuth) const { return calc_strip(calc_axes(azimuth)); }

  // The direction of a strip's own normal, in which the bound is its distance. A whole wall has no component t, because
  // its strips do not end along t.
  [[nodiscard]] TurningDirection calc_direction(const Strip& strip, const Axes& at) const;
  [[nodiscard]] Reach calc_reach(const TurningDirection& u, const Axes& at) const;

  // Lower bound of the distance of the strip at an azimuth, m.
  [[nodiscard]] double calc_bound(const TurningDirection& u, double azimuth, const Reach& at) const;
  // Lower bound for all strips of an arc, by the reaches at its ends: in between, that of each part stays below the
  // sinusoid through both.
  [[nodiscard]] double calc_bound(const TurningDirection& u, double from, double to, const HalfArc& half,
                                  const Reach& at_from, const Reach& at_to) const;

 private:
  // Extent of a strip across its generator, m.
  struct Extent {
    double low, high;
  };

  // The distance of a strip and B where the nearest point is inside of the strip and the only one. False elsewhere.
  bool find_foot(const Core& strip, Distance& out) const;
  // Neither end passes the plane of the edges: near an edge a strip is narrow.
  [[nodiscard]] Extent calc_extent(const Axes& at) const;
  [[nodiscard]] double calc_extent_of_b(const Vec3& d) const;
  // A lower bound of g + g'' over all azimuths, 0 at least: g = √(1 − x²) is the reach of a rim of radius 1, x = q + p
  // cos(θ − θ0) the cosine between the direction and B's axis. g + g'' = (1 + q² − p² − 3 q x + q x³) / g³, and 3 x −
  // x³ grows.
  [[nodiscard]] double calc_roundness(const TurningDirection& u) const;
  [[nodiscard]] double calc_bound_by_parts(const TurningDirection& u, double from, double to, double most_0,
                                           double most_1) const;

  const Core &solid_, &b_;
  double size_;
  bool is_half_, has_rims_;
};

}  // namespace unlatch::geometry
