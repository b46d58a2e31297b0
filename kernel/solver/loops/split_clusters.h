// The split of redundant_rows.h where loops are eliminated where they close (loop_clusters.h), in time linear like that
// elimination. With changes ν of the loops' multipliers, statics give those of the tree's joints, T ν, and nothing
// accelerates if Λ ν = 0: by the factor of Λ, each independent row's ν follows from those eliminated later,
//   ν_p = −Σ z ν,   z = row of Lᵀ.
// Minimises Σ (λ + change)² / k over ν in the order of elimination, with the blocks of Λ: independent rows are
// substituted, redundant ones are pivots, not below 1 in units in which every k is 1. So a redundancy that spans loops
// is split like one within a loop: by least energy over all rows. Compiled once per instruction set, see
// kernel/simd/pack.h.
#pragma once

#include <algorithm>
#include <cmath>

#include "kernel/joints/kinematics.h"
#include "kernel/solver/loops/loop_closures.h"

namespace unlatch::UNLATCH_ISA {

template <class T>
class ClusterSplit {
 public:
  using Numbers = LoopColumns<T>;

  ClusterSplit(const PlanData& plan, const State& state, Evaluation& ev) : plan_(plan), state_(state), ev_(ev) {}

  void run() const {
    for (std::size_t e = 0; e < plan_.closures.size(); ++e) begin(plan_.closures[e], ev_.closures[e]);
    for (std::size_t i = plan_.cluster_nodes.size(); i-- > 0;) carry(plan_.cluster_nodes[i]);
    for (std::size_t e = 0; e < plan_.closures.size(); ++e) eliminate(plan_.closures[e], ev_.closures[e]);
    for (std::size_t e = plan_.closures.size(); e-- > 0;) substitute(plan_.closures[e], ev_.closures[e]);
    store_changes();
  }
  // Largest multiplier of the loops' rows, in units in which every k is 1.
  double calc_largest() const {
    double largest = 0;
    for (std::size_t e = 0; e < plan_.closures.size(); ++e) {
      const ClosureWork& c = ev_.closures[e];
      for (int r = 0; r < c.count; ++r)
        largest = std::max(
            largest, std::abs(get_multiplier(plan_.closures[e], c, r) / get_scale(plan_.closures[e].joint, c.row[r])));
    }
    return largest;
  }

 private:
  // Of the quadratic form, and of the factor of Λ; `columns`: the loop of their columns.
  Numbers get_block(std::int32_t block, const ClosureWork& columns) const {
    return {find_loop_block(ev_.split_matrix, block), kEight, columns.count};
  }
  Numbers get_factor(std::int32_t block, const ClosureWork& columns) const {
    return {find_loop_block(ev_.cluster_matrix, block), kEight, columns.count};
  }
  // What a loop has at a node: its wrench; once that is passed on, its part of each row that the joint holds.
  Numbers get_columns(int slot) const {
    return {find_loop_block(ev_.split_columns, slot), kEight, get_slot_work(slot).count};
  }
  ClosureWork& get_work(const LoopLink& link) const { return ev_.closures[at(link.closure)]; }
  ClosureWork& get_slot_work(int slot) const { return ev_.closures[at(plan_.loop_slots[at(slot)].closure)]; }
  std::span<const LoopLink> get_links(const LoopClosure& closure) const {
    return {plan_.loop_links.data() + closure.first_link, static_cast<std::size_t>(closure.links)};
  }
  double get_scale(int joint, int row) const {
    const PlanJoint& j = plan_.joints[at(joint)];
    return row < kRotX ? j.share : j.turning_share;
  }
  double& get_multiplier(const LoopClosure& closure, const ClosureWork& c, int r) const {
    return ev_.multipliers.get(at(closure.joint), at(c.row[r]));
  }

  // Of no joint of the tree yet: the loop's own rows, and its scaled unit wrenches at its two bodies.
  void begin(const LoopClosure& closure, ClosureWork& c) const {
    const Numbers own = get_block(closure.block, c);
    own.clear(c.count);
    for (const LoopLink& link : get_links(closure)) get_block(link.block, get_work(link)).clear(c.count);
    for (int r = 0; r < kEight; ++r) c.gradient[r] = c.change[r] = c.scale[r] = 0;
    for (int r = 0; r < c.count; ++r) {
      c.scale[r] = get_scale(closure.joint, c.row[r]);
      c.gradient[r] = get_multiplier(closure, c, r) / c.scale[r];
      own.row(r)[r] = 1;
    }
    const JointFrame& f = ev_.non_tree_frames[at(closure.non_tree)];
    for (const bool follower : {true, false}) {
      const std::int32_t slot = follower ? closure.on_follower : closure.on_base;
      if (slot == kNone) continue;
      const Numbers F = get_columns(slot);
      F.clear(kRows);
      for (int r = 0; r < c.count; ++r) F.set_column(r, c.scale[r] * calc_row_wrench(f, c.row[r], follower));
    }
  }

  // Rows that a node's joint holds. along: scaled wrench on the child, at its origin, that a row carries with size −1.
  struct HeldRows {
    std::int32_t joint;
    int count = 0, row[kRows];
    SpatialT<T> along[kRows];
    double scale[kRows], load[kRows];
  };
  HeldRows get_held_rows(const ClusterNode& node) const {
    HeldRows held;
    held.joint = plan_.nodes[at(node.node)].joint;
    if (held.joint == kNone) return held;
    const RowSet rows = get_active_rows(plan_, state_, held.joint);
    const JointView view(plan_, ev_, held.joint);
    const bool follows = view.get_joint().child == view.get_joint().follower;
    const Vec3 arm = view.get_arm(follows);
    for (int r = 0; r < kRows; ++r) {
      if (!has_row(rows, r)) continue;
      const double scale = get_scale(held.joint, r);
      const Vec3 axis = (follows ? -1 / scale : 1 / scale) * view.get_axis(r);
      held.along[held.count] = spread<T>(r < kRotX ? Spatial{axis, {0, 0, 0}} : Spatial{-cross(axis, arm), axis});
      held.scale[held.count] = scale;
      held.load[held.count] = ev_.multipliers.get(at(held.joint), at(r)) / scale;
      held.row[held.count++] = r;
    }
    return held;
  }

  // From children to parents: the wrenches of the loops, and what they put on the rows of the joint in their place.
  void carry(const ClusterNode& node) const {
    if (node.closing == node.slots) return;
    const HeldRows held = get_held_rows(node);
    const Vec3T<T> offset = spread<T>(read(ev_.blocks.data(), node.place, &SolverLane::offset));
    for (int slot = node.first_slot + node.closing; slot < node.first_slot + node.slots; ++slot) {
      ClosureWork& work = get_slot_work(slot);
      const Numbers F = get_columns(slot);
      F.for_packs([&](int c) UNLATCH_INLINE_LAMBDA {
        const SpatialT<T> force = F.get_spatial(c);
        add_to_parent(plan_.loop_slots[at(slot)], offset, c, force);
        T gradient = load<T>(work.gradient + c);
        for (int k = 0; k < held.count; ++k) {
          const T part = dot(held.along[k], force);
          F.set(k, c, part);
          gradient = gradient + part * T(held.load[k]);
        }
        store(work.gradient + c, gradient);
      });
    }
    add_energies(node, held.count);
  }
  UNLATCH_INLINE void add_to_parent(const LoopSlot& slot, const Vec3T<T>& offset, int c, SpatialT<T> force) const {
    if (slot.parent == kNone) return;
    force.ang += cross(offset, force.lin);
    const Numbers to = get_columns(slot.parent);
    to.set_spatial(c, slot.begins != 0 ? force : to.get_spatial(c) + force);
  }
  // The quadratic form of what is on the node's joint.
  void add_energies(const ClusterNode& node, int rows) const {
    const std::int32_t* pair = plan_.loop_pairs.data() + node.first_pair;
    for (int i = node.first_slot + node.closing; i < node.first_slot + node.slots; ++i) {
      const Numbers left = get_columns(i);
      for (int j = i; j < node.first_slot + node.slots; ++j, ++pair) {
        const Numbers right = get_columns(j), block = get_block(*pair, get_slot_work(j));
        right.for_packs([&](int c) UNLATCH_INLINE_LAMBDA {
          for (int r = 0; r < left.get_count(); ++r) {
            T sum = block.get(r, c);
            for (int k = 0; k < rows; ++k) sum = sum + T(left.row(k)[r]) * right.get(k, c);
            block.set(r, c, sum);
          }
        });
      }
    }
  }

  // z of the k-th pivot over the columns of a block of the factor, and of a block of the quadratic form that is behind
  // it.
  struct Pivot {
    bool independent;
    int row;
    double scale;  // of z
    double half;   // of the pivot of the form
  };
  Pivot get_pivot(const LoopClosure& closure, const ClosureWork& c, int k) const {
    const int p = c.order[k];
    const double pivot = get_block(closure.block, c).row(p)[p];
    if (k < c.rank) return {true, p, c.inverse[k] / c.scale[p], 0.5 * pivot};
    return {false, p, 1 / pivot, 0};
  }
  UNLATCH_INLINE T relate(const Pivot& pivot, std::int32_t block, const ClosureWork& to, int c) const {
    if (pivot.independent) return (get_factor(block, to).get(pivot.row, c) * T(pivot.scale)) * load<T>(to.scale + c);
    return get_block(block, to).get(pivot.row, c) * T(pivot.scale);
  }
  // And u: the form += u zᵀ + z uᵀ.
  UNLATCH_INLINE void relate_columns(const Pivot& pivot, std::int32_t block, ClosureWork& to) const {
    for_packs<T>(to.count, [&](int c) UNLATCH_INLINE_LAMBDA {
      const T z = relate(pivot, block, to, c), q = get_block(block, to).get(pivot.row, c);
      store(to.z + c, z);
      store(to.u + c, pivot.independent ? T(pivot.half) * z - q : T(-0.5) * q);
    });
  }
  static UNLATCH_INLINE void add_pair(double* row, double u, double z, const ClosureWork& to) {
    for_packs<T>(to.count, [&](int c) UNLATCH_INLINE_LAMBDA {
      store(row + c, load<T>(row + c) + (T(u) * load<T>(to.z + c) + T(z) * load<T>(to.u + c)));
    });
  }

  void eliminate(const LoopClosure& closure, ClosureWork& c) const {
    const std::span<const LoopLink> links = get_links(closure);
    const Numbers own = get_block(closure.block, c);
    for (int k = 0; k < c.count; ++k) {
      const Pivot pivot = get_pivot(closure, c, k);
      const double gradient = c.gradient[pivot.row];
      relate_columns(pivot, closure.block, c);
      for (int j = k + 1; j < c.count; ++j) {
        const int r = c.order[j];
        add_pair(own.row(r), c.u[r], c.z[r], c);
        c.gradient[r] -= gradient * c.z[r];
      }
      for (const LoopLink& link : links) {
        ClosureWork& other = get_work(link);
        const Numbers block = get_block(link.block, other);
        relate_columns(pivot, link.block, other);
        for (int j = k + 1; j < c.count; ++j) {
          const int r = c.order[j];
          add_pair(block.row(r), c.u[r], c.z[r], other);
        }
        subtract<T>(other.gradient, other.count, gradient, other.z);
      }
      const std::int32_t* pair = plan_.loop_pairs.data() + closure.first_pair;
      for (std::size_t i = 0; i < links.size(); ++i) {
        const ClosureWork& left = get_work(links[i]);
        for (std::size_t j = i; j < links.size(); ++j, ++pair) {
          const ClosureWork& right = get_work(links[j]);
          const Numbers block = get_block(*pair, right);
          for (int r = 0; r < left.count; ++r) add_pair(block.row(r), left.u[r], left.z[r], right);
        }
      }
    }
  }

  void substitute(const LoopClosure& closure, ClosureWork& c) const {
    for (int k = c.count; k-- > 0;) {
      const Pivot pivot = get_pivot(closure, c, k);
      double sum = pivot.independent ? 0 : c.gradient[pivot.row] * pivot.scale;
      relate_columns(pivot, closure.block, c);
      for (int j = k + 1; j < c.count; ++j) sum += c.z[c.order[j]] * c.change[c.order[j]];
      for (const LoopLink& link : get_links(closure)) {
        ClosureWork& other = get_work(link);
        relate_columns(pivot, link.block, other);
        sum += combine(other.z, other.change, other.count);
      }
      c.change[pivot.row] = -sum;
    }
  }

  void store_changes() const {
    for (std::size_t e = 0; e < plan_.closures.size(); ++e) {
      const ClosureWork& c = ev_.closures[e];
      for (int r = 0; r < c.count; ++r) get_multiplier(plan_.closures[e], c, r) += c.scale[r] * c.change[r];
    }
    for (const ClusterNode& node : plan_.cluster_nodes) {
      const std::int32_t joint = plan_.nodes[at(node.node)].joint;
      if (joint == kNone || node.closing == node.slots) continue;
      const RowSet rows = get_active_rows(plan_, state_, joint);
      int k = 0;
      for (int r = 0; r < kRows; ++r) {
        if (!has_row(rows, r)) continue;
        double sum = 0;
        for (int slot = node.first_slot + node.closing; slot < node.first_slot + node.slots; ++slot)
          sum += combine(get_columns(slot).row(k), get_slot_work(slot).change, get_slot_work(slot).count);
        ev_.multipliers.get(at(joint), at(r)) += get_scale(joint, r) * sum;
        ++k;
      }
    }
  }

  const PlanData& plan_;
  const State& state_;
  Evaluation& ev_;
};

template <int kWidest>
void split_cluster_rows(const PlanData& plan, const State& state, Evaluation& ev) {
  // Where independent rows nearly follow from others, the multipliers before the split are large and cancel in it: a
  // second one begins with multipliers of the size of the result.
  constexpr double kCancels = 100;
  const ClusterSplit<Pack<kWidest>> split(plan, state, ev);
  const double before = split.calc_largest();
  split.run();
  if (before > kCancels * split.calc_largest()) split.run();
}

}  // namespace unlatch::UNLATCH_ISA
