// Quantity: a named number of the instant, such as the velocity of one body seen from another. Guards compare it with a
// threshold; sensors measure it; outputs, requirements and objectives name it. unlatch/quantities.h has what is known
// of each kind; kernel/quantities/table.cc is the one table of them.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>

namespace unlatch {

// One such number: its kind, its subject, and what chooses among several values.
struct Quantity {
  // In the order of the table. New kinds go to the end: the numbers are hashed.
  enum class Kind : std::int32_t {
    kTime,                 // t, s
    kSince,                // time since event `subject` acted last, s; 0 before, and while it is pending
    kSignal,               // 1 while signal `subject` is raised, else 0
    kCommand,              // commanded value of channel `subject`, in its unit
    kPosition,             // of body `subject`: p_a − p_b, axes of body `other` (ground: W), m
    kVelocity,             // v_a − v_b of the origins, axes of `other`, m/s
    kRate,                 // w_a − w_b, axes of `subject`, rad/s
    kAttitude,             // quaternion w x y z, axes of `subject` to those of `other`; its size is the angle, rad
    kAxes,                 // angle between `direction` of body `subject` and `other_direction` of `other`, rad, 0 to π
    kAcceleration,         // of `point` of body `subject`, body axes, m/s²
    kAngularAcceleration,  // of body `subject`, body axes, rad/s²
    kSpecificForce,        // of `point` of body `subject`, less gravity, body axes, m/s²
    kBurnt,                // what body `subject`, which has a mass law, has burnt, kg
    kDisplacement,         // of joint `subject` along row `part`, m
    kAngle,                // of joint `subject` about row `part`, turns counted, rad
    kSpeed,                // rate of either, m/s or rad/s
    kReaction,             // multiplier of row `part` of joint `subject`, N or N m; 0 of a row that does not hold
    kReactionForce,        // multipliers of x y z of joint `subject`, joint frame, N
    kReactionMoment,       // multipliers of rot_x rot_y rot_z of joint `subject`, rotation frame, N m
    kMode,                 // 1 while joint `subject` is in mode number `part`, else 0
    kClearance,            // signed distance of surfaces `subject` and `other`, m
    kContactForce,         // sum of the normal forces of contact `subject`, N
    kContactDepth,         // depth of its deepest pair, m; 0 while it is open
    kContactImpulse,       // impulse of its normal forces since the start, N s
    kContactSlip,          // length of its slip path since the start, m
    kContactDissipated,    // energy that it dissipated since the start, J
    kClosed,               // 1 while some pair of its shapes is closed, else 0
    kForce,                // of element `subject`: see ElementReading::force, N or N m
    kLength,               // of element `subject`: see ElementReading::length, m or rad
    kLengthRate,           // of element `subject`, rate of its length, m/s or rad/s
    kStroke,               // that element `subject` has left, m or rad
    kScale,                // of the switch of element `subject`, 0 to 1
    kOneSidedForce,        // of one-sided force `subject` by its number, never negative, N or N m
    kEngaged,              // 1 while one-sided force `subject` is engaged, else 0
    kReach,                // depth or force of one-sided force `subject`, whichever is less: for complete_events()
    kWound,                // angle that cord `subject` (number of a one-sided force) is wound on its drum, rad
    kBearing,              // bearing of its end about the drum, turns counted, rad
    kLaw,                  // value of law `subject`, in its unit
    kOnTime,               // time since element `subject` was switched on, s; 0 while it is off
    // Of body `subject` beside the planet, of its origin; see unlatch/model/environment.h.
    kAltitude,                 // above the ellipsoid, m
    kLatitude,                 // geodetic, rad
    kGeocentricLatitude,       // rad
    kLongitude,                // eastwards, −π to π, rad
    kDensity,                  // of the air there, kg/m³
    kPressure,                 // Pa
    kTemperature,              // molecular-scale temperature, K
    kSpeedOfSound,             // m/s
    kMach,                     // speed relative to the air by that of sound
    kDynamicPressure,          // ½ ρ V², Pa
    kAirspeed,                 // V: relative to the air, m/s
    kAirVelocity,              // u v w: relative to the air, body axes, m/s
    kAngleOfAttack,            // atan2(w, u), rad
    kSideslip,                 // asin(v / V), rad
    kGravity,                  // acceleration of free fall in inertial space, W, m/s²
    kSurfaceVelocity,          // over the turning planet: north, east, down, m/s
    kFlightPathAngle,          // of that above the horizon, rad
    kAzimuth,                  // of that from north towards east, −π to π, rad
    kInertialPosition,         // from the centre, axes of W, m
    kInertialVelocity,         // seen from the centre, axes of W, m/s
    kInertialFlightPathAngle,  // of that, rad
    kInertialAzimuth,          // of that, rad
    kEulerAngles,              // roll pitch yaw of the body's axes from north, east, down, rad
    kLaunchPosition,           // from the launch site, its axes, m
    kLaunchVelocity,           // over the turning planet, the launch site's axes, m/s
    kOrbitPosition,            // p_a − p_b (ground: from the centre) radially, along the orbit, across it, of b, m
    kOrbitVelocity,            // its rate in those axes, which turn, m/s
  };
  // `part` of a kind with several values: all of them, for sensors alone; their size. Otherwise the number of a value,
  // a Row or the number of a mode.
  static constexpr int kAll = -2, kSize = -1;

  std::string name;                                           // unique among the model's quantities
  Kind kind = Kind::kTime;                                    // kind
  int subject = 0;                                            // index; the kind says of which list
  int other = -1;                                             // second subject: body (kGround) or surface
  int part = kSize;                                           // see above
  Eigen::Vector3d direction = Eigen::Vector3d::Zero();        // the component along it, unless zero; unit
  Eigen::Vector3d other_direction = Eigen::Vector3d::Zero();  // kAxes: unit
  Eigen::Vector3d point = Eigen::Vector3d::Zero();            // body axes, from the origin, m
};

}  // namespace unlatch
