// PlanLaws: laws and tables in a plan. Their evaluation is kernel/laws.
#pragma once

#include <cstdint>

#include "kernel/plan/list_kinds.h"
#include "unlatch/model/law.h"

namespace unlatch {

// An axis of a table. Its knots, and of smooth tables the polynomials of its cells, are in PlanLaws::numbers.
struct PlanTableAxis {
  std::int32_t knots, count;           // the first of them; how many
  std::int32_t cells;                  // smooth: kCellNumbers of each cell from here on
  std::int32_t buckets, bucket_count;  // PlanLaws::buckets: per uniform part of the axis, the cell where it begins
  std::int32_t support;                // knots that one value takes in: 2, smooth up to kCellKnots
  std::int32_t stride;                 // of the values along this axis
  TableAxis::End below, above;
  double bucket_scale;  // parts per unit of the axis
};
inline constexpr int kCellKnots = 4;
// Per knot of a cell's support, the four coefficients of its weight over the cell, 0 to 1.
inline constexpr int kCellNumbers = 4 * kCellKnots;

// Tables with the same axes and values share them.
struct PlanTable {
  std::int32_t first_axis, axis_count;  // into PlanLaws::axes
  std::int32_t values;                  // into PlanLaws::numbers
  bool smooth;
  std::int32_t scale_channel, offset_channel;
  double scale, offset;
};

// The step of a law; of a quantity `subject` is its place in Evaluation::law_operands, of a law, which is a kind of
// quantity to the model, in Evaluation::laws.
struct PlanLawStep {
  LawStep::Kind kind;
  std::int32_t subject;
  double value;
  std::int32_t place;  // of a table its coordinates, of a branch what decides it: in Evaluation::law_places; or kNone
  bool of_law;
};

// Where a law that forces read has corners: where a number of Evaluation::law_places is at one of these knots.
struct PlanCorner {
  std::int32_t place, knots, count;  // the first knot, into PlanLaws::numbers; how many
  bool jumps;                        // the value may jump there: `if_less`
};

// A body whose air a law reads that forces read: where its altitude has corners, the law has them too. While
// `aerodynamics` acts on that body, it finds them itself, and the place has NaN.
struct PlanAirPlace {
  std::int32_t place, body;   // place: in Evaluation::law_places
  std::int32_t aerodynamics;  // on that body, in PlanData::aerodynamics; or kNone
  std::int32_t knots, count;  // those altitudes, in PlanLaws::numbers
};

struct PlanLaw {
  std::int32_t first, count;  // into PlanLaws::steps
  std::int32_t scale_channel, offset_channel;
  double scale, offset;
};

// In PlanNumbers.
struct PlanLawNumbers {
  std::int32_t driving = 0, driving_operands = 0;  // of PlanLaws::order and PlanLaws::operands, the first
  std::int32_t places = 0;                         // numbers of Evaluation::law_places
  bool strict = false;                             // some table ends the run where it is left
};

// In PlanElementLists.
template <template <class> class List>
struct PlanLawLists {
  List<PlanLaw> list;  // the model's
  List<PlanLawStep> steps;
  List<PlanTable> tables;  // the model's
  List<PlanTableAxis> axes;
  List<double> numbers;
  List<std::int32_t> buckets;
  // Order of evaluation: a law behind those that it reads. The first are those that forces read, directly or through
  // others; likewise the operands, which are places in PlanData::quantities.
  List<std::int32_t> order, operands;
  List<std::int32_t> loads;  // that a law sizes
  List<PlanCorner> corners;
  List<PlanAirPlace> air_places;

  bool empty() const { return list.empty(); }

  // Calls use(list…) with each list: that of one name of all `lists`. A new list goes here as well.
  template <class Use, class... Lists>
  static constexpr void for_each(const Use& use, Lists&... lists) {
    use(lists.list...);
    use(lists.steps...);
    use(lists.tables...);
    use(lists.axes...);
    use(lists.numbers...);
    use(lists.buckets...);
    use(lists.order...);
    use(lists.operands...);
    use(lists.loads...);
    use(lists.corners...);
    use(lists.air_places...);
  }
};
using PlanLaws = PlanLawLists<FixedList>;

}  // namespace unlatch
