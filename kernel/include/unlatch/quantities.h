// Traits of each kind of quantity: its name in the language, its subjects, its values, their unit and axes, and what
// it reads. Validation, joined models, guards, sensors, the scenario language, outputs and requirements follow from it.
#pragma once

#include <string>

#include "unlatch/model.h"

namespace unlatch {

// List that a subject of a quantity is an index into.
enum class SubjectOf {
  kNothing,   // the quantity has no subject
  kBody,      // Model::bodies; the other one may be the ground
  kMassLaw,   // Model::bodies, of those with a mass law
  kJoint,     // Model::joints
  kSurface,   // Model::surfaces
  kContact,   // Model::contacts
  kElement,   // Model::element_name()
  kOneSided,  // Model::one_sided
  kCord,      // Model::one_sided, of those with a drum
  kSignal,    // Model::signals
  kChannel,   // Model::channels
  kEvent,     // Model::events
  kLaw,       // Model::laws
};

// Values of a kind, and what `part` chooses among them.
enum class QuantityValues {
  kOne,         // one value; `part` is not read
  kOfMode,      // one value; `part` is the number of a mode of the joint
  kOfPointRow,  // one value; `part` is a Row from kX to kZ
  kOfTurnRow,   // one value; `part` is a Row from kRotX to kRotZ
  kOfRow,       // one value; `part` is a Row
  kRowValues,   // six values; `part` is a Row, or kAll
  kVector,      // three values; `part` is one of them, kSize or kAll, unless a direction is given
  kQuaternion,  // four values, w x y z; `part` is one of them, kSize (the angle, rad) or kAll
};

// What the value of a quantity depends on, other than the motion of the bodies.
enum QuantityReads : unsigned {
  kReadsMotion = 0,       // nothing else
  kReadsTime = 1,         // t
  kReadsInputs = 2,       // commanded values
  kReadsCoordinate = 4,   // of a joint: an entry of the plan's coordinates
  kReadsMultipliers = 8,  // or accelerations: the commands reach it through the forces
  kReadsEvents = 16,      // changes at events alone, or begins there
};

// What of the motion of bodies decides the value of a quantity: errors of a motion reach what depends on them.
enum class QuantityMotion {
  kOfAll,   // any motion of any body: of a kind whose row does not say less
  kOfNone,  // none
  kPlaces,  // where its subjects are
  kSpeeds,  // how fast its subjects move
  kForces,  // the forces on its subjects, and so their places and speeds
  kThrough  // what its subject depends on: an event, a signal or a law
};

// What is known of a kind.
struct QuantityTraits {
  Quantity::Kind kind;  // in the order of the enumerators
  const char* name;     // key of the language: "velocity"
  const char* phrase;   // for readers, before the name of its subject: "velocity of"
  SubjectOf of = SubjectOf::kNothing, other = SubjectOf::kNothing;  // subjects
  QuantityValues values = QuantityValues::kOne;                     // values
  const char* unit;  // SI; "1" for a plain number; of a command its channel's, of a law its own
  const char* angular_unit =
      nullptr;                    // of rotation rows, of elements that turn, of the size of an attitude, if it differs
  const char* frame = "";         // axes of the values: "W", "body", "joint"; empty for none
  unsigned reads = kReadsMotion;  // QuantityReads
  QuantityMotion motion = QuantityMotion::kOfAll;  // whose motion it reads
  bool holds = false;                              // it is 1 or 0, and changes at events alone
  bool of_reaction = false;                        // of the forces and moments by which its joint holds
  bool has_point = false, has_axes = false;        // `point` is read; `direction` and `other_direction` are
  bool of_planet = false, of_air = false;          // it needs a planet; it needs an atmosphere
};

// Traits of a kind.
const QuantityTraits& get_traits(Quantity::Kind kind) noexcept;
// Number of kinds: the enumerators from 0 on.
int count_quantity_kinds() noexcept;
// Name of a value of a vector, 0 to 2: "x", or by its axes "north", "roll", "along".
const char* get_component_name(const QuantityTraits& traits, int part) noexcept;
// Number of values of a kind with kAll.
int count_values(const QuantityTraits& traits) noexcept;
// True of the size of a vector: the root of a smooth function, which has a corner where it is zero.
bool is_size(const Quantity& quantity) noexcept;

// What a condition does between two knots of a smooth piece of motion (unlatch/motion.h).
enum class ConditionCourse {
  kParts,   // it combines its parts
  kSteps,   // it changes by events alone, or at ticks
  kOneWay,  // it compares what goes one way alone
  kCurve,   // it compares a function of time, which may come back: it may hold there alone
};

// Where a knot of the motion has what a condition compares or looks at.
enum class ConditionAtKnots {
  kNowhere,      // no knot has it
  kInParts,      // it combines its parts
  kTime,         // MotionKnot::time
  kRow,          // MotionKnot::multipliers, of row `axis` of joint `subject`
  kForceRows,    // the first three of joint `subject`
  kMomentRows,   // the last three
  kCoordinates,  // the poses of the bodies of joint `subject`: its coordinate along or about row `axis`
  kSpeeds,       // their velocities: its rate
  kRates,        // BodyState::w of body `subject`
  kSignals,      // State::signals
  kModes,        // JointState::mode
  kEngaged,      // State::engaged
  kCommands,     // the inputs of the step, beside the knots
  kQuantities,   // MotionKnot::quantities
};

// What is known of a kind of condition. No member has a default, so that a new kind says each of them.
struct ConditionTraits {
  Condition::Kind kind;       // in the order of the enumerators
  ConditionCourse course;     // between knots
  ConditionAtKnots at_knots;  // where they have it
  bool by_guards;  // kernel/events/guards.cc reads it without a quantity: frequent, or more than a comparison
};
// Traits of a kind of condition.
const ConditionTraits& get_traits(Condition::Kind kind) noexcept;

// Quantity that a condition without parts compares or looks at; that a sensor measures.
Quantity get_quantity(const Model& model, const Condition& condition);
Quantity get_quantity(const Model& model, const Sensor& sensor);

// Number of subjects of a kind in a model; the name of one of them.
std::size_t count_subjects(const Model& model, SubjectOf of);
std::string get_subject_name(const Model& model, SubjectOf of, int subject);

// Unit of a quantity of a model: "N m".
std::string get_unit(const Model& model, const Quantity& quantity);
// Description for readers: "velocity of pod relative to core along [1, 0, 0]", "reaction x of nose1", without
// `names_joint` "reaction x".
std::string describe(const Model& model, const Quantity& quantity, bool names_joint = true);

}  // namespace unlatch
