// The one table of quantities. A new kind: an enumerator in unlatch/quantity.h, its calculation in the file of its
// family, a row here.
#include <cstddef>
#include <iterator>

#include "kernel/quantities/bodies.h"
#include "kernel/quantities/elements.h"
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

constexpr unsigned kTime = kReadsTime, kEvents = kReadsEvents, kInputs = kReadsInputs, kCoordinate = kReadsCoordinate,
                   kSolved = kReadsMultipliers;

struct QuantityRow {
  QuantityTraits traits;
  QuantityCalc calc;
};

constexpr QuantityRow kTable[] = {
    {{.kind = Kind::kTime, .name = "time", .phrase = "time", .unit = "s", .reads = kTime}, calc_time},
    {{.kind = Kind::kSince,
      .name = "since",
      .phrase = "time since",
      .of = Of::kEvent,
      .unit = "s",
      .reads = kTime | kEvents},
     calc_since},
    {{.kind = Kind::kSignal,
      .name = "signal",
      .phrase = "signal",
      .of = Of::kSignal,
      .unit = "1",
      .reads = kEvents,
      .holds = true},
     calc_signal},
    {{.kind = Kind::kCommand,
      .name = "command",
      .phrase = "command",
      .of = Of::kChannel,
      .unit = "1",
      .reads = kInputs},
     calc_command},
    {{.kind = Kind::kPosition,
      .name = "position",
      .phrase = "position of",
      .of = Of::kBody,
      .other = Of::kBody,
      .values = Values::kVector,
      .unit = "m",
      .frame = "W"},
     calc_position},
    {{.kind = Kind::kVelocity,
      .name = "velocity",
      .phrase = "velocity of",
      .of = Of::kBody,
      .other = Of::kBody,
      .values = Values::kVector,
      .unit = "m/s",
      .frame = "W"},
     calc_velocity},
    {{.kind = Kind::kRate,
      .name = "rate",
      .phrase = "rate of",
      .of = Of::kBody,
      .other = Of::kBody,
      .values = Values::kVector,
      .unit = "rad/s",
      .frame = "body"},
     calc_rate},
    {{.kind = Kind::kAttitude,
      .name = "attitude",
      .phrase = "attitude of",
      .of = Of::kBody,
      .other = Of::kBody,
      .values = Values::kQuaternion,
      .unit = "1",
      .angular_unit = "rad",
      .frame = "W"},
     calc_attitude},
    {{.kind = Kind::kAxes,
      .name = "axes",
      .phrase = "angle between axes of",
      .of = Of::kBody,
      .other = Of::kBody,
      .unit = "rad",
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
      .has_point = true},
     calc_acceleration},
    {{.kind = Kind::kAngularAcceleration,
      .name = "angular_acceleration",
      .phrase = "angular acceleration of",
      .of = Of::kBody,
      .values = Values::kVector,
      .unit = "rad/s2",
      .frame = "body",
      .reads = kSolved},
     calc_angular_acceleration},
    {{.kind = Kind::kSpecificForce,
      .name = "specific_force",
      .phrase = "specific force of",
      .of = Of::kBody,
      .values = Values::kVector,
      .unit = "m/s2",
      .frame = "body",
      .reads = kSolved,
      .has_point = true},
     calc_specific_force},
    {{.kind = Kind::kBurnt, .name = "burnt", .phrase = "burnt of", .of = Of::kMassLaw, .unit = "kg"}, calc_burnt},
    {{.kind = Kind::kDisplacement,
      .name = "displacement",
      .phrase = "displacement",
      .of = Of::kJoint,
      .values = Values::kOfPointRow,
      .unit = "m",
      .frame = "joint",
      .reads = kCoordinate},
     calc_coordinate},
    {{.kind = Kind::kAngle,
      .name = "angle",
      .phrase = "angle",
      .of = Of::kJoint,
      .values = Values::kOfTurnRow,
      .unit = "rad",
      .frame = "joint",
      .reads = kCoordinate},
     calc_coordinate},
    {{.kind = Kind::kSpeed,
      .name = "speed",
      .phrase = "speed",
      .of = Of::kJoint,
      .values = Values::kOfRow,
      .unit = "m/s",
      .angular_unit = "rad/s",
      .frame = "joint",
      .reads = kCoordinate},
     calc_speed},
    {{.kind = Kind::kReaction,
      .name = "reaction",
      .phrase = "reaction",
      .of = Of::kJoint,
      .values = Values::kRowValues,
      .unit = "N",
      .angular_unit = "N m",
      .frame = "joint",
      .reads = kSolved},
     calc_multipliers<kX, kRows>},
    {{.kind = Kind::kReactionForce,
      .name = "reaction_force",
      .phrase = "force of",
      .of = Of::kJoint,
      .values = Values::kVector,
      .unit = "N",
      .frame = "joint",
      .reads = kSolved},
     calc_multipliers<kX, 3>},
    {{.kind = Kind::kReactionMoment,
      .name = "reaction_moment",
      .phrase = "moment of",
      .of = Of::kJoint,
      .values = Values::kVector,
      .unit = "N m",
      .frame = "joint",
      .reads = kSolved},
     calc_multipliers<kRotX, 3>},
    {{.kind = Kind::kMode,
      .name = "mode",
      .phrase = "mode of",
      .of = Of::kJoint,
      .values = Values::kOfMode,
      .unit = "1",
      .reads = kEvents,
      .holds = true},
     calc_mode},
    {{.kind = Kind::kClearance,
      .name = "clearance",
      .phrase = "distance of",
      .of = Of::kSurface,
      .other = Of::kSurface,
      .unit = "m"},
     calc_clearance},
    {{.kind = Kind::kContactForce,
      .name = "contact_force",
      .phrase = "force of contact",
      .of = Of::kContact,
      .unit = "N"},
     calc_contact_force},
    {{.kind = Kind::kContactDepth,
      .name = "contact_depth",
      .phrase = "depth of contact",
      .of = Of::kContact,
      .unit = "m"},
     calc_contact_depth},
    {{.kind = Kind::kContactImpulse,
      .name = "contact_impulse",
      .phrase = "impulse of contact",
      .of = Of::kContact,
      .unit = "N s"},
     calc_contact_total<0>},
    {{.kind = Kind::kContactSlip, .name = "contact_slip", .phrase = "slip of contact", .of = Of::kContact, .unit = "m"},
     calc_contact_total<1>},
    {{.kind = Kind::kContactDissipated,
      .name = "contact_dissipated",
      .phrase = "energy dissipated by contact",
      .of = Of::kContact,
      .unit = "J"},
     calc_contact_total<2>},
    {{.kind = Kind::kClosed,
      .name = "contact",
      .phrase = "contact",
      .of = Of::kContact,
      .unit = "1",
      .reads = kEvents,
      .holds = true},
     calc_closed},
    {{.kind = Kind::kForce,
      .name = "force",
      .phrase = "force of",
      .of = Of::kElement,
      .unit = "N",
      .angular_unit = "N m",
      .reads = kTime | kInputs | kSolved},
     calc_reading<&ElementReading::force>},
    {{.kind = Kind::kLength,
      .name = "length",
      .phrase = "length of",
      .of = Of::kElement,
      .unit = "m",
      .angular_unit = "rad"},
     calc_reading<&ElementReading::length>},
    {{.kind = Kind::kLengthRate,
      .name = "length_rate",
      .phrase = "rate of the length of",
      .of = Of::kElement,
      .unit = "m/s",
      .angular_unit = "rad/s"},
     calc_reading<&ElementReading::rate>},
    {{.kind = Kind::kStroke,
      .name = "stroke",
      .phrase = "stroke left of",
      .of = Of::kElement,
      .unit = "m",
      .angular_unit = "rad"},
     calc_reading<&ElementReading::stroke>},
    {{.kind = Kind::kScale,
      .name = "scale",
      .phrase = "scale of",
      .of = Of::kElement,
      .unit = "1",
      .reads = kTime | kEvents},
     calc_reading<&ElementReading::scale>},
    {{.kind = Kind::kOneSidedForce,
      .name = "one_sided_force",
      .phrase = "force of",
      .of = Of::kOneSided,
      .unit = "N",
      .angular_unit = "N m",
      .reads = kTime},
     calc_one_sided_force},
    {{.kind = Kind::kEngaged,
      .name = "engaged",
      .phrase = "",
      .of = Of::kOneSided,
      .unit = "1",
      .reads = kEvents,
      .holds = true},
     calc_engaged},
    {{.kind = Kind::kReach,
      .name = "reach",
      .phrase = "reach of",
      .of = Of::kOneSided,
      .unit = "N",
      .angular_unit = "N m"},
     calc_own_reach},
    {{.kind = Kind::kWound, .name = "wound", .phrase = "angle wound of", .of = Of::kCord, .unit = "rad"}, calc_wound},
    {{.kind = Kind::kBearing, .name = "bearing", .phrase = "bearing of", .of = Of::kCord, .unit = "rad"}, calc_bearing},
    {{.kind = Kind::kLaw, .name = "law", .phrase = "law", .of = Of::kLaw, .unit = "1", .reads = kTime | kInputs},
     calc_law_value},
    {{.kind = Kind::kOnTime,
      .name = "on_time",
      .phrase = "time on of",
      .of = Of::kElement,
      .unit = "s",
      .reads = kTime | kEvents},
     calc_on_time},
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

void update_readings(const Instant& now, Evaluation& ev) noexcept {
  for (std::size_t i = 0; i < ev.quantities.size(); ++i)
    ev.quantities[i] = calc_scalar(now, ev, now.plan.quantities[i]);
  for (const PlanSensor& sensor : now.plan.sensors) {
    const PlanQuantity& own = now.plan.quantities[at(sensor.quantity)];
    double* const out = &ev.sensors[at(sensor.first)];
    if (sensor.whole)
      calc_values(now, ev, own, out);
    else
      *out = calc_scalar(now, ev, own);
  }
}

}  // namespace unlatch
