// One node of the tree as its elimination left it (tree_sweeps.h), for the loops that pass it: the freedoms or the rows
// of its joint, with their pivots.
#pragma once

#include <bit>
#include <cstdint>

#include "kernel/plan/evaluation.h"
#include "kernel/plan/lanes.h"
#include "kernel/solver/loops/columns.h"
#include "kernel/solver/node.h"

namespace unlatch::UNLATCH_ISA {

class SolvedNode {
 public:
  using Freedom = LaneOf<FreedomBlock<double>>;
  using Row = LaneOf<RowBlock<double>>;

  SolvedNode(const PlanData& plan, Evaluation& ev, std::int32_t group, const Place& place)
      : group_(plan.groups[at(group)]), modes_(ev.modes[at(group)]), blocks_(ev.blocks.data()), place_(place) {}

  const Group& get_group() const { return group_; }
  template <class M>
  M read(M SolverBlock<double>::*member) const {
    return unlatch::read(blocks_, place_, member);
  }
  LaneParts get_parts() const { return {group_, blocks_, place_}; }

  // Solved by its freedoms, else by the rows of its joint.
  bool is_by_freedoms() const {
    return modes_.by_freedoms && (!group_.may_be_by_rows || is_set(read(&SolverBlock<double>::by_freedoms)));
  }
  // Calls run(r, freedom), run(r, row) for those that the joint has in its mode, in order.
  template <class Run>
  void for_freedoms(const Run& run) const {
    for (unsigned left = modes_.freedoms; left != 0; left &= left - 1) {
      const int r = std::countr_zero(left);
      const Freedom freedom = get_parts().freedom(r);
      if (is_set(freedom.read(&FreedomBlock<double>::mask))) run(r, freedom);
    }
  }
  template <class Run>
  void for_rows(const Run& run) const {
    for (unsigned left = modes_.rows; left != 0; left &= left - 1) {
      const int r = std::countr_zero(left);
      const Row row = get_parts().row(r);
      if (is_set(row.read(&RowBlock<double>::mask))) run(r, row);
    }
  }
  // Whether the joint holds row r.
  bool holds(int r) const {
    const LaneParts parts = get_parts();
    if (is_by_freedoms())
      return !(has_row(group_.freedoms, r) && has_row(modes_.freedoms, r) &&
               is_set(parts.freedom(r).read(&FreedomBlock<double>::mask)));
    return has_row(group_.rows, r) && has_row(modes_.rows, r) && is_set(parts.row(r).read(&RowBlock<double>::mask));
  }

  // Direction of freedom r at the node's origin.
  Spatial read_freedom(int r) const {
    if (r < kRotX) return {column(read(&SolverBlock<double>::axes), r), {0, 0, 0}};
    const Vec3 axis = column(get_parts().rotation_axes().read(), r - kRotX);
    return {cross(read(&SolverBlock<double>::arm_child), axis), axis};
  }
  // The body's own factor, if it is solved by rows.
  template <class T>
  FreeFactorT<T> read_free_factor() const {
    const FreeFactor f = get_parts().free().read(&FreeBlock<double>::factor);
    const auto spread3 = [](const Factor3T<double>& a) {
      return Factor3T<T>{T(a.l10), T(a.n20), T(a.l21), T(a.i0), T(a.i1), T(a.i2)};
    };
    return {spread3(f.M), {spread<T>(f.W.x), spread<T>(f.W.y), spread<T>(f.W.z)}, spread3(f.K)};
  }

 private:
  static bool is_set(double mask) { return __builtin_bit_cast(std::uint64_t, mask) != 0; }

  const Group& group_;
  const GroupModes& modes_;
  double* blocks_;
  Place place_;
};

}  // namespace unlatch::UNLATCH_ISA
