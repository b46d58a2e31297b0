// Environment: the planet that the bodies fly near, its air, and a start from a point of a trajectory. SI units and
// radians. W has the axes of an inertial frame; its origin is the planet's centre, a point at rest beside it, or a
// point that falls freely (Planet::falling), so that positions near it keep their digits however far the centre is.
//
// Angles of the planet: latitudes are geodetic unless a name says geocentric; longitudes grow eastwards; north, east
// and down are those of the ellipsoid's normal. An azimuth is the angle from north towards east.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <optional>
#include <vector>

namespace unlatch {

struct Model;

// A planet of revolution that turns about its pole. The default is WGS-84.
struct Planet {
  double radius = 6378137;                           // equatorial, m, > 0
  double flattening = 1 / 298.257223563;             // (a − b) / a, from 0 to below 1
  double mu = 3.986004418e14;                        // m³/s², ≥ 0
  double j2 = 1.08262982e-3;                         // of the zonal harmonic; 0 for none
  double rate = 7.292115e-5;                         // about the pole, eastwards, rad/s
  double meridian = 0;                               // angle of longitude 0 about the pole at t = 0, from W's x (from
                                                     // W's y if the pole is along x), rad
  Eigen::Vector3d pole = Eigen::Vector3d::UnitZ();   // W, unit
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();  // at t = 0, W, m
  // W's origin falls freely in the central field of mu, from −centre with this velocity, which is seen from the centre;
  // an ellipse. Otherwise it rests beside the centre.
  bool falling = false;
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();  // m/s
  bool gradient_torque = true;                         // bodies are turned by the gradient of gravity over them

#if __cplusplus >= 202002L  // programs of C++17 may read models, and not compare them
  bool operator==(const Planet&) const = default;
#endif
};

// Density and pressure over the altitude.
struct Atmosphere {
  // kStandard: US Standard Atmosphere 1976, see kernel/environment/air.h. kTable: what follows.
  enum class Kind { kStandard, kTable };
  Kind kind = Kind::kStandard;      // which of them
  std::vector<double> altitudes{};  // strictly increasing, two or more, m
  std::vector<double> densities{};  // kg/m³, > 0
  std::vector<double> pressures{};  // Pa, > 0
#if __cplusplus >= 202002L          // programs of C++17 may read models, and not compare them
  bool operator==(const Atmosphere&) const = default;
#endif
};

// Velocity of the air over the planet's surface, in its direction of motion: linear between the altitudes, constant
// beyond them.
struct Wind {
  std::vector<double> altitudes{};            // strictly increasing, m; one or more
  std::vector<Eigen::Vector3d> velocities{};  // towards north, east, down, m/s
#if __cplusplus >= 202002L                    // programs of C++17 may read models, and not compare them
  bool operator==(const Wind&) const = default;
#endif
};

// A place that rests on the planet, and its axes: x along the azimuth, y to the right of it, z down.
struct LaunchSite {
  double latitude = 0, longitude = 0, altitude = 0;  // rad, rad, m
  double azimuth = 0;                                // of x, rad
#if __cplusplus >= 202002L                           // programs of C++17 may read models, and not compare them
  bool operator==(const LaunchSite&) const = default;
#endif
};

// Everything around the bodies.
struct Environment {
  std::optional<Planet> planet{};          // no planet: nothing below counts
  std::optional<Atmosphere> atmosphere{};  // turns with the planet
  std::optional<Wind> wind{};              // no wind: the air rests on the planet
  LaunchSite launch;                       // of quantities that are seen from it
#if __cplusplus >= 202002L                 // programs of C++17 may read models, and not compare them
  bool operator==(const Environment&) const = default;
#endif
};

// A point of a trajectory at which a model starts. The whole model is moved there as one: places, attitudes and motions
// that its bodies have in W become those in the frame that is put there.
struct Start {
  double latitude = 0, longitude = 0, altitude = 0;    // of the body, or of the frame's origin; rad, rad, m
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();  // towards north, east, down, m/s
  bool inertial = false;                               // the velocity is that in inertial space, not over the planet
  // Roll, pitch, yaw of the frame from north, east, down, rad; by default x is along the velocity, and y horizontal.
  std::optional<Eigen::Vector3d> euler{};
  Eigen::Vector3d rate = Eigen::Vector3d::Zero();  // axes of the frame, rad/s
  // What the rate is relative to: inertial space, the planet, the axes north, east, down where it flies.
  enum class Turns { kInertial, kPlanet, kLocal };
  Turns turns = Turns::kInertial;  // see above
  int body = -1;                   // whose origin and axes are the frame put there; −1: W's
  // Where W's origin is afterwards: stays, rests where the start is, or falls freely from there.
  enum class Origin { kKept, kStart, kFalling };
  Origin origin = Origin::kKept;  // see above
};

// The same model at the start; its planet has moved where the origin asks for it. Needs a planet.
Model place_start(const Model& model, const Start& start);

// A point of the planet.
struct GeodeticPoint {
  double latitude = 0, longitude = 0, altitude = 0;  // rad, rad, m
};
// Of a point given from the centre in axes that turn with the planet (z the pole, x the meridian of longitude 0), m.
// Within 1e-15 rad and 2 ulp of the distance from the centre, from 5000 km below the surface outwards.
GeodeticPoint calc_geodetic(const Planet& planet, const Eigen::Vector3d& point) noexcept;
// The inverse.
Eigen::Vector3d calc_point(const Planet& planet, const GeodeticPoint& point) noexcept;

// Air at one altitude.
struct AirState {
  double density = 0, pressure = 0;            // kg/m³, Pa
  double temperature = 0, speed_of_sound = 0;  // molecular-scale temperature, K; m/s
};
// Of a valid atmosphere at an altitude, m.
AirState calc_air(const Atmosphere& atmosphere, double altitude);

}  // namespace unlatch
