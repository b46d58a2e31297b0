// The one table of quantities, in one file whatever its length. A new kind: an enumerator in unlatch/model/quantity.h,
// its calculation in the file of its family, a row here.
#include <cstddef>
#include <iterator>

#include "kernel/quantities/bodies.h"
#include "kernel/quantities/elements.h"
#include "kernel/quantities/flight.h"
#include "kernel/quantities/instants.h"
#include "kernel/quantities/joints.h"
#include "kernel/quantities/quantities.h"
#include "kernel/quantities/shapes.h"
#include "unlatch/quantities.h"

namespace unlatch {
namespace {

using namespace quantities;
using Kind = Quantity::Kind;
using Of = SubjectOf;
using Values = QuantityValues;
using Motion = QuantityMotion;

constexpr unsigned kTime = kReadsTime, kEvents = kReadsEvents, kInputs = kReadsInputs, kCoordinate = kReadsCoordinate,
                   kSolved = kReadsMultipliers;

struct QuantityRow {
  QuantityTraits traits;
  QuantityCalc calc;
};

enum class Needs { kPlanet, kAir };

// A kind of a body beside the planet; a vector if it has a frame.
constexpr QuantityTraits of_flight(Kind kind, const char* name, const char* phrase, const char* unit, Needs needs,
                                   Motion motion, const char* frame = "", Of other = Of::kNothing) {
  return {.kind = kind,
          .name = name,
          .phrase = phrase,
          .of = Of::kBody,
          .other = other,
          .values = frame[0] != 0 ? Values::kVector : Values::kOne,
          .unit = unit,
          .frame = frame,
          .reads = kTime,
          .motion = motion,
          .of_planet = true,
          .of_air = needs == Needs::kAir};
}

constexpr QuantityRow kTable[] = {
    {{.kind = Kind::kTime, .name = "time", .phrase = "time", .unit = "s", .reads = kTime, .motion = Motion::kOfNone},
     calc_time},
    {{.kind = Kind::kSince,
      .name = "since",
      .phrase = "time since",
      .of = Of::kEvent,
      .unit = "s",
      .reads = kTime | kEvents,
      .motion = Motion::kThrough},
     calc_since},
    {{.kind = Kind::kSignal,
      .name = "signal",
      .phrase = "signal",
      .of = Of::kSignal,
      .unit = "1",
      .reads = kEvents,
      .motion = Motion::kThrough,
      .holds = true},
     calc_signal},
    {{.kind = Kind::kCommand,
      .name = "command",
      .phrase = "command",
      .of = Of::kChannel,
      .unit = "1",
      .reads = kInputs,
      .motion = Motion::kOfNone},
     calc_command},
    {{.kind = Kind::kPosition,
      .name = "position",
      .phrase = "position of",
      .of = Of::kBody,
      .other = Of::kBody,
      .values = Values::kVector,
      .unit = "m",
      .frame = "W",
      .motion = Motion::kPlaces},
     calc_position},
    {{.kind = Kind::kVelocity,
      .name = "velocity",
      .phrase = "velocity of",
      .of = Of::kBody,
      .other = Of::kBody,
      .values = Values::kVector,
      .unit = "m/s",
      .frame = "W",
      .motion = Motion::kSpeeds},
     calc_velocity},
    {{.kind = Kind::kRate,
      .name = "rate",
      .phrase = "rate of",
      .of = Of::kBody,
      .other = Of::kBody,
      .values = Values::kVector,
      .unit = "rad/s",
      .frame = "body",
      .motion = Motion::kSpeeds},
     calc_rate},
    {{.kind = Kind::kAttitude,
      .name = "attitude",
      .phrase = "attitude of",
      .of = Of::kBody,
      .other = Of::kBody,
      .values = Values::kQuaternion,
      .unit = "1",
      .angular_unit = "rad",
      .frame = "W",
      .motion = Motion::kPlaces},
     calc_attitude},
    {{.kind = Kind::kAxes,
      .name = "axes",
      .phrase = "angle between axes of",
      .of = Of::kBody,
      .other = Of::kBody,
      .unit = "rad",
      .motion = Motion::kPlaces,
      .has_axes = true},
     calc_axes},
    {{.kind = Kind::kAcceleration,
      .name = "acceleration",
      .phrase = "acceleration of",
      .of = Of::kBody,
      .values = Values::kVector,
      .unit = "m/s2",
      .frame = "body",
      .reads = kSolved,
      .motion = Motion::kForces,
      .has_point = true},
     calc_acceleration},
    {{.kind = Kind::kAngularAcceleration,
      .name = "angular_acceleration",
      .phrase = "angular acceleration of",
      .of = Of::kBody,
      .values = Values::kVector,
      .unit = "rad/s2",
      .frame = "body",
      .reads = kSolved,
      .motion = Motion::kForces},
     calc_angular_acceleration},
    {{.kind = Kind::kSpecificForce,
      .name = "specific_force",
      .phrase = "specific force of",
      .of = Of::kBody,
      .values = Values::kVector,
      .unit = "m/s2",
      .frame = "body",
      .reads = kSolved,
      .motion = Motion::kForces,
      .has_point = true},
     calc_specific_force},
    {{.kind = Kind::kBurnt,
      .name = "burnt",
      .phrase = "burnt of",
      .of = Of::kMassLaw,
      .unit = "kg",
      .motion = Motion::kPlaces},
     calc_burnt},
    {{.kind = Kind::kDisplacement,
      .name = "displacement",
      .phrase = "displacement",
      .of = Of::kJoint,
      .values = Values::kOfPointRow,
      .unit = "m",
      .frame = "joint",
      .reads = kCoordinate,
      .motion = Motion::kPlaces},
     calc_coordinate},
    {{.kind = Kind::kAngle,
      .name = "angle",
      .phrase = "angle",
      .of = Of::kJoint,
      .values = Values::kOfTurnRow,
      .unit = "rad",
      .frame = "joint",
      .reads = kCoordinate,
      .motion = Motion::kPlaces},
     calc_coordinate},
    {{.kind = Kind::kSpeed,
      .name = "speed",
      .phrase = "speed",
      .of = Of::kJoint,
      .values = Values::kOfRow,
      .unit = "m/s",
      .angular_unit = "rad/s",
      .frame = "joint",
      .reads = kCoordinate,
      .motion = Motion::kSpeeds},
     calc_speed},
    {{.kind = Kind::kReaction,
      .name = "reaction",
      .phrase = "reaction",
      .of = Of::kJoint,
      .values = Values::kRowValues,
      .unit = "N",
      .angular_unit = "N m",
      .frame = "joint",
      .reads = kSolved,
      .motion = Motion::kForces,
      .of_reaction = true},
     calc_multipliers<kX, kRows>},
    {{.kind = Kind::kReactionForce,
      .name = "reaction_force",
      .phrase = "force of",
      .of = Of::kJoint,
      .values = Values::kVector,
      .unit = "N",
      .frame = "joint",
      .reads = kSolved,
      .motion = Motion::kForces,
      .of_reaction = true},
     calc_multipliers<kX, 3>},
    {{.kind = Kind::kReactionMoment,
      .name = "reaction_moment",
      .phrase = "moment of",
      .of = Of::kJoint,
      .values = Values::kVector,
      .unit = "N m",
      .frame = "joint",
      .reads = kSolved,
      .motion = Motion::kForces,
      .of_reaction = true},
     calc_multipliers<kRotX, 3>},
    {{.kind = Kind::kMode,
      .name = "mode",
      .phrase = "mode of",
      .of = Of::kJoint,
      .values = Values::kOfMode,
      .unit = "1",
      .reads = kEvents,
      .motion = Motion::kPlaces,
      .holds = true},
     calc_mode},
    {{.kind = Kind::kClearance,
      .name = "clearance",
      .phrase = "distance of",
      .of = Of::kSurface,
      .other = Of::kSurface,
      .unit = "m",
      .motion = Motion::kPlaces},
     calc_clearance},
    {{.kind = Kind::kContactForce,
      .name = "contact_force",
      .phrase = "force of contact",
      .of = Of::kContact,
      .unit = "N",
      .motion = Motion::kForces},
     calc_contact_force},
    {{.kind = Kind::kContactDepth,
      .name = "contact_depth",
      .phrase = "depth of contact",
      .of = Of::kContact,
      .unit = "m",
      .motion = Motion::kPlaces},
     calc_contact_depth},
    {{.kind = Kind::kContactImpulse,
      .name = "contact_impulse",
      .phrase = "impulse of contact",
      .of = Of::kContact,
      .unit = "N s",
      .motion = Motion::kForces},
     calc_contact_total<0>},
    {{.kind = Kind::kContactSlip,
      .name = "contact_slip",
      .phrase = "slip of contact",
      .of = Of::kContact,
      .unit = "m",
      .motion = Motion::kSpeeds},
     calc_contact_total<1>},
    {{.kind = Kind::kContactDissipated,
      .name = "contact_dissipated",
      .phrase = "energy dissipated by contact",
      .of = Of::kContact,
      .unit = "J",
      .motion = Motion::kForces},
     calc_contact_total<2>},
    {{.kind = Kind::kClosed,
      .name = "contact",
      .phrase = "contact",
      .of = Of::kContact,
      .unit = "1",
      .reads = kEvents,
      .motion = Motion::kPlaces,
      .holds = true},
     calc_closed},
    {{.kind = Kind::kForce,
      .name = "force",
      .phrase = "force of",
      .of = Of::kElement,
      .unit = "N",
      .angular_unit = "N m",
      .reads = kTime | kInputs | kSolved,
      .motion = Motion::kForces},
     calc_reading<&ElementReading::force>},
    {{.kind = Kind::kLength,
      .name = "length",
      .phrase = "length of",
      .of = Of::kElement,
      .unit = "m",
      .angular_unit = "rad",
      .motion = Motion::kPlaces},
     calc_reading<&ElementReading::length>},
    {{.kind = Kind::kLengthRate,
      .name = "length_rate",
      .phrase = "rate of the length of",
      .of = Of::kElement,
      .unit = "m/s",
      .angular_unit = "rad/s",
      .motion = Motion::kSpeeds},
     calc_reading<&ElementReading::rate>},
    {{.kind = Kind::kStroke,
      .name = "stroke",
      .phrase = "stroke left of",
      .of = Of::kElement,
      .unit = "m",
      .angular_unit = "rad",
      .motion = Motion::kPlaces},
     calc_reading<&ElementReading::stroke>},
    {{.kind = Kind::kScale,
      .name = "scale",
      .phrase = "scale of",
      .of = Of::kElement,
      .unit = "1",
      .reads = kTime | kEvents,
      .motion = Motion::kPlaces},
     calc_reading<&ElementReading::scale>},
    {{.kind = Kind::kOneSidedForce,
      .name = "one_sided_force",
      .phrase = "force of",
      .of = Of::kOneSided,
      .unit = "N",
      .angular_unit = "N m",
      .reads = kTime,
      .motion = Motion::kForces},
     calc_one_sided_force},
    {{.kind = Kind::kEngaged,
      .name = "engaged",
      .phrase = "",
      .of = Of::kOneSided,
      .unit = "1",
      .reads = kEvents,
      .motion = Motion::kPlaces,
      .holds = true},
     calc_engaged},
    {{.kind = Kind::kReach,
      .name = "reach",
      .phrase = "reach of",
      .of = Of::kOneSided,
      .unit = "N",
      .angular_unit = "N m",
      .motion = Motion::kForces},
     calc_own_reach},
    {{.kind = Kind::kWound,
      .name = "wound",
      .phrase = "angle wound of",
      .of = Of::kCord,
      .unit = "rad",
      .motion = Motion::kPlaces},
     calc_wound},
    {{.kind = Kind::kBearing,
      .name = "bearing",
      .phrase = "bearing of",
      .of = Of::kCord,
      .unit = "rad",
      .motion = Motion::kPlaces},
     calc_bearing},
    {{.kind = Kind::kLaw,
      .name = "law",
      .phrase = "law",
      .of = Of::kLaw,
      .unit = "1",
      .reads = kTime | kInputs,
      .motion = Motion::kThrough},
     calc_law_value},
    {{.kind = Kind::kOnTime,
      .name = "on_time",
      .phrase = "time on of",
      .of = Of::kElement,
      .unit = "s",
      .reads = kTime | kEvents,
      .motion = Motion::kPlaces},
     calc_on_time},
    {of_flight(Kind::kAltitude, "altitude", "altitude of", "m", Needs::kPlanet, Motion::kPlaces), calc_altitude},
    {of_flight(Kind::kLatitude, "latitude", "latitude of", "rad", Needs::kPlanet, Motion::kPlaces), calc_latitude},
    {of_flight(Kind::kGeocentricLatitude, "geocentric_latitude", "geocentric latitude of", "rad", Needs::kPlanet,
               Motion::kPlaces),
     calc_geocentric_latitude},
    {of_flight(Kind::kLongitude, "longitude", "longitude of", "rad", Needs::kPlanet, Motion::kPlaces), calc_longitude},
    {of_flight(Kind::kDensity, "density", "density of the air at", "kg/m3", Needs::kAir, Motion::kPlaces),
     calc_air_value<&AirState::density>},
    {of_flight(Kind::kPressure, "pressure", "pressure of the air at", "Pa", Needs::kAir, Motion::kPlaces),
     calc_air_value<&AirState::pressure>},
    {of_flight(Kind::kTemperature, "temperature", "temperature of the air at", "K", Needs::kAir, Motion::kPlaces),
     calc_air_value<&AirState::temperature>},
    {of_flight(Kind::kSpeedOfSound, "speed_of_sound", "speed of sound at", "m/s", Needs::kAir, Motion::kPlaces),
     calc_air_value<&AirState::speed_of_sound>},
    {of_flight(Kind::kMach, "mach", "Mach number of", "1", Needs::kAir, Motion::kSpeeds), calc_mach},
    {of_flight(Kind::kDynamicPressure, "dynamic_pressure", "dynamic pressure on", "Pa", Needs::kAir, Motion::kSpeeds),
     calc_dynamic_pressure},
    {of_flight(Kind::kAirspeed, "airspeed", "airspeed of", "m/s", Needs::kAir, Motion::kSpeeds), calc_airspeed},
    {of_flight(Kind::kAirVelocity, "air_velocity", "velocity through the air of", "m/s", Needs::kAir, Motion::kSpeeds,
               "body"),
     calc_air_velocity},
    {of_flight(Kind::kAngleOfAttack, "angle_of_attack", "angle of attack of", "rad", Needs::kAir, Motion::kSpeeds),
     calc_air_angle<calc_angle_of_attack>},
    {of_flight(Kind::kSideslip, "sideslip", "sideslip of", "rad", Needs::kAir, Motion::kSpeeds),
     calc_air_angle<calc_sideslip>},
    {of_flight(Kind::kGravity, "gravity", "gravity at", "m/s2", Needs::kPlanet, Motion::kPlaces, "W"),
     calc_own_gravity},
    {of_flight(Kind::kSurfaceVelocity, "surface_velocity", "velocity over the planet of", "m/s", Needs::kPlanet,
               Motion::kSpeeds, "local"),
     calc_local_velocity},
    {of_flight(Kind::kFlightPathAngle, "flight_path_angle", "flight-path angle of", "rad", Needs::kPlanet,
               Motion::kSpeeds),
     calc_surface_angle<calc_path_angle>},
    {of_flight(Kind::kAzimuth, "azimuth", "azimuth of the motion of", "rad", Needs::kPlanet, Motion::kSpeeds),
     calc_surface_angle<unlatch::calc_azimuth>},
    {of_flight(Kind::kInertialPosition, "inertial_position", "position from the planet's centre of", "m",
               Needs::kPlanet, Motion::kPlaces, "W"),
     calc_inertial_position},
    {of_flight(Kind::kInertialVelocity, "inertial_velocity", "inertial velocity of", "m/s", Needs::kPlanet,
               Motion::kSpeeds, "W"),
     calc_inertial_velocity},
    {of_flight(Kind::kInertialFlightPathAngle, "inertial_flight_path_angle", "inertial flight-path angle of", "rad",
               Needs::kPlanet, Motion::kSpeeds),
     calc_inertial_angle<calc_path_angle>},
    {of_flight(Kind::kInertialAzimuth, "inertial_azimuth", "inertial azimuth of the motion of", "rad", Needs::kPlanet,
               Motion::kSpeeds),
     calc_inertial_angle<unlatch::calc_azimuth>},
    {of_flight(Kind::kEulerAngles, "euler_angles", "Euler angles of", "rad", Needs::kPlanet, Motion::kPlaces, "local"),
     calc_euler_angles},
    {of_flight(Kind::kLaunchPosition, "launch_position", "position from the launch site of", "m", Needs::kPlanet,
               Motion::kPlaces, "launch"),
     calc_launch_position},
    {of_flight(Kind::kLaunchVelocity, "launch_velocity", "velocity from the launch site of", "m/s", Needs::kPlanet,
               Motion::kSpeeds, "launch"),
     calc_launch_velocity},
    {of_flight(Kind::kOrbitPosition, "orbit_position", "orbital position of", "m", Needs::kPlanet, Motion::kSpeeds,
               "orbit", Of::kBody),
     calc_orbit_position},
    {of_flight(Kind::kOrbitVelocity, "orbit_velocity", "orbital velocity of", "m/s", Needs::kPlanet, Motion::kSpeeds,
               "orbit", Of::kBody),
     calc_orbit_velocity},
};

constexpr bool is_in_order() {
  for (std::size_t i = 0; i < std::size(kTable); ++i)
    if (static_cast<std::size_t>(kTable[i].traits.kind) != i) return false;
  return true;
}
static_assert(is_in_order(), "the rows stand in the order of Quantity::Kind");

const QuantityRow& get_row(Kind kind) { return kTable[static_cast<std::size_t>(kind)]; }

}  // namespace

const QuantityTraits& get_traits(Kind kind) noexcept { return get_row(kind).traits; }
int count_quantity_kinds() noexcept { return static_cast<int>(std::size(kTable)); }

const char* get_component_name(const QuantityTraits& traits, int part) noexcept {
  static constexpr const char *kAxes[3] = {"x", "y", "z"}, *kLocal[3] = {"north", "east", "down"},
                              *kOrbit[3] = {"radial", "along", "across"}, *kTurns[3] = {"roll", "pitch", "yaw"};
  const char* const* names = kAxes;
  if (traits.kind == Kind::kEulerAngles)
    names = kTurns;
  else if (traits.kind == Kind::kSurfaceVelocity)
    names = kLocal;
  else if (traits.kind == Kind::kOrbitPosition || traits.kind == Kind::kOrbitVelocity)
    names = kOrbit;
  return names[part];
}

int count_values(const QuantityTraits& traits) noexcept {
  switch (traits.values) {
    case Values::kRowValues:
      return kRows;
    case Values::kVector:
      return 3;
    case Values::kQuaternion:
      return 4;
    default:
      return 1;
  }
}

int calc_values(const Instant& now, const Evaluation& ev, const PlanQuantity& own, double* out) noexcept {
  const QuantityRow& row = get_row(own.kind);
  row.calc(now, ev, own, out);
  return count_values(row.traits);
}

double calc_scalar(const Instant& now, const Evaluation& ev, const PlanQuantity& own) noexcept {
  double values[kMostValues];
  const int count = calc_values(now, ev, own, values);
  if (count == 1) return values[0];
  if (own.part >= 0) return values[own.part];
  if (count == 4) return calc_turn(values);
  const Vec3 v{values[0], values[1], values[2]};
  return own.along ? dot(v, own.direction) : norm(v);
}

void update_readings(const Instant& now, Evaluation& ev, const std::uint8_t* unread) noexcept {
  for (std::size_t i = 0; i < ev.quantities.size(); ++i)
    ev.quantities[i] = calc_scalar(now, ev, now.plan.quantities[i]);
  for (std::size_t i = 0; i < now.plan.sensors.size(); ++i) {
    if (unread != nullptr && unread[i] != 0) continue;
    const PlanSensor& sensor = now.plan.sensors[i];
    const PlanQuantity& own = now.plan.quantities[at(sensor.quantity)];
    double* const out = &ev.sensors[at(sensor.first)];
    if (sensor.whole)
      calc_values(now, ev, own, out);
    else
      *out = calc_scalar(now, ev, own);
  }
}

bool is_any_reading_commanded(const PlanData& plan) noexcept {
  const auto is_commanded = [&](std::size_t quantity) {
    return (get_traits(plan.quantities[quantity].kind).reads & kReadsInputs) != 0;
  };
  for (std::size_t i = 0; i < at(plan.quantity_count); ++i)
    if (is_commanded(i)) return true;
  for (const PlanSensor& sensor : plan.sensors)
    if (is_commanded(at(sensor.quantity))) return true;
  return false;
}

}  // namespace unlatch
