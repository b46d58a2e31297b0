// Law: a number that follows from quantities of the instant by an expression, and Table: values over one to six axes
// that expressions look up. Forces, guards, sensors, outputs and requirements name laws; kernel/laws computes them.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace unlatch {

struct Model;

// One axis of a table.
struct TableAxis {
  // What happens where the table is looked up beyond an end: the value at the end holds, and
  enum class End {
    kClamp,   // nothing else
    kNotice,  // the workspace has it (unlatch/workspace.h), so that a run can report it
    kError,   // the step fails with StepStatus::kOutsideTable
  };
  std::string name;                              // for readers: "mach"
  std::vector<double> knots;                     // at least two, strictly increasing
  End below = End::kClamp, above = End::kClamp;  // before the first knot, after the last one
};

// Values over its axes: T(x) · scale · command of scale_channel + offset + command of offset_channel.
struct Table {
  // Interpolation between the knots, a tensor product over the axes: both give the values at the knots.
  enum class Interpolation {
    kLinear,  // continuous, with corners at the knots; error of the order h²
    kSmooth,  // continuous second derivatives: on each axis the cubic spline whose two outer cells share a cubic ("not
              // a knot", de Boor 1978); error of the order h⁴, exact for cubics; swings about the values beside a jump,
              // less by a factor of 0.27 from knot to knot
  };
  std::string name;                                      // unique among tables
  std::vector<TableAxis> axes;                           // one to kMostTableAxes
  std::vector<double> values;                            // one per combination of knots, the last axis fastest
  Interpolation interpolation = Interpolation::kLinear;  // between the knots
  double scale = 1, offset = 0;                          // see above; offset in the unit of the values
  int scale_channel = -1, offset_channel = -1;           // command channels, kNone for none
};
inline constexpr std::size_t kMostTableAxes = 6;          // of one table
inline constexpr std::size_t kMostTableKnots = 65536;     // of one axis
inline constexpr std::size_t kMostTableValues = 1 << 22;  // of one table

// One step of an expression in postfix order: takes its arguments from a stack, and puts its result there.
struct LawStep {
  // `takes` of the kinds: get_law_arity().
  enum class Kind {
    kConstant,  // → value
    kQuantity,  // → quantity number `subject` of the model
    kCommand,   // → commanded value of channel `subject`
    kTable,     // coordinates in the order of the axes → value of table `subject`
    kAdd,       // a b → a + b
    kSubtract,  // a b → a − b
    kMultiply,  // a b → a · b
    kDivide,    // a b → a / b
    kPower,     // a → a to the power `subject`, −8 to 8
    kNegate,    // a → −a
    kSqrt,      // a → √a
    kAbs,       // a → |a|
    kSin,       // a, rad → sin a
    kCos,       // a, rad → cos a
    kTan,       // a, rad → tan a
    kAsin,      // a → its angle, rad
    kAcos,      // a → its angle, rad
    kAtan,      // a → its angle, rad
    kAtan2,     // y x → angle of the point (x, y), rad
    kExp,       // a → eᵃ
    kLog,       // a → natural logarithm
    kMin,       // a b → the smaller
    kMax,       // a b → the larger
    kIfLess,    // a b c d → c where a < b, else d
  };
  Kind kind = Kind::kConstant;  // what it computes
  int subject = 0;              // see above
  double value = 0;             // kConstant
};

// An expression: E · scale · command of scale_channel + offset + command of offset_channel.
struct Law {
  std::string name;                             // unique among laws
  std::vector<LawStep> steps;                   // at most kMostLawSteps
  std::string unit = "1";                       // of its value, SI, for readers
  double scale = 1, offset = 0;                 // see above; offset in the unit of the value
  int scale_channel = -1, offset_channel = -1;  // command channels, kNone for none
};
inline constexpr std::size_t kMostLawSteps = 512;  // of one law
inline constexpr int kLawStack = 32;               // values that a law may keep at once

// Number of arguments of a kind of step; of kTable the number of its axes is.
int get_law_arity(LawStep::Kind kind);

// Per law of a valid model: some force reads it, or a law that a force reads.
std::vector<bool> list_driving_laws(const Model& model);

}  // namespace unlatch
