// Loops eliminated where they close, on the way of the backward pass, in time linear in the number of bodies where the
// ways of few loops overlap. In the terms of loop_rows.h: with A, b the block and load of a body, F the unit wrenches
// of loops' rows there, c their targets and Λ what the pivots outboard of the body have given, the accelerations a and
// multipliers μ are stationary in
//   ½ aᵀ A a − bᵀ a − μᵀ (Fᵀ a − c) − ½ μᵀ Λ μ.
// A freedom s of the joint, with the pivot d and β = sᵀ F, adds β βᵀ / d to Λ and takes β sᵀb / d from c. A loop whose
// two ways have met at the body is complete: its rows are eliminated, the most independent first,
//   A += F Λ⁻¹ Fᵀ,   b += F Λ⁻¹ c,   and likewise for the F, c and Λ of loops that pass on,
// so that the way to the root carries only the loops that are open. Blocks of Λ are dense; which are there is compiled
// (kernel/tree/loop_clusters.h). The stages of a sub-step carry only rows that were independent at its beginning
// (LoopRows in loop_rows.h). Accelerations and multipliers come back in the forward pass. (Baraff 1996 leaves such
// rows to the end; closing each where it is complete is the local elimination of Jain, Multibody Syst. Dyn. 2012, and
// of Sathya and Carpentier, IEEE T-RO 2024.) Compiled once per instruction set, see kernel/simd/pack.h.
#pragma once

#include <bit>

#include "kernel/solver/loop_closures.h"

namespace unlatch::UNLATCH_ISA {

template <class T>
class LoopClusters {
 public:
  LoopClusters(const PlanData& plan, Evaluation& ev) : plan_(plan), ev_(ev), closures_(plan, ev) {}

  // --- Before the backward pass
  void begin_factor() const {
    for (std::size_t e = 0; e < plan_.closures.size(); ++e) closures_.begin(plan_.closures[e], ev_.closures[e]);
  }

  // --- Backward pass: before a group is eliminated, and after
  template <bool kFactor>
  void close(std::size_t g) const {
    for_nodes(g, [&](const ClusterNode& node) {
      for (int i = 0; i < node.closing; ++i)
        closures_.template close<kFactor>(plan_.loop_slots[at(node.first_slot + i)].closure);
    });
  }
  template <bool kFactor>
  void close_at_ground() const {
    for (std::size_t e = at(plan_.first_at_ground); e < plan_.closures.size(); ++e)
      closures_.template close<kFactor>(static_cast<int>(e));
  }
  template <bool kFactor>
  void pass(std::size_t g, bool biased) const {
    for_nodes(g, [&](const ClusterNode& node) {
      if (node.closing == node.slots) return;
      if (is_by_freedoms(node)) {
        const Freedoms f(*this, node);
        if constexpr (kFactor) pass_freedoms(node, f);
        pass_loads_by_freedoms(node, f, biased);
      } else {
        if constexpr (kFactor) pass_rows(node);
        pass_loads_by_rows(node);
      }
    });
  }

  // --- Forward pass
  void find_multipliers_at_ground() const {
    for (std::size_t e = plan_.closures.size(); e-- > at(plan_.first_at_ground);)
      closures_.find_multipliers(static_cast<int>(e), nullptr);
  }
  // What the open loops add to the loads of a group, before its accelerations are computed.
  void add_reactions(std::size_t g) const {
    for_nodes(g, [&](const ClusterNode& node) {
      if (node.closing == node.slots) return;
      if (is_by_freedoms(node)) {
        const Freedoms f(*this, node);
        for_passing(node, [&](const LoopSlot&, const ClosureWork& c, const double* numbers) {
          for (int k = 0; k < f.count; ++k) *f.beta[k] += combine(numbers + f.place[k], c.mu, c.count);
        });
      } else {
        add_to_rows(node);
      }
    });
  }
  // Multipliers of the loops that close at a group, and the reactions of the others in its joints.
  void finish(std::size_t g, bool multipliers) const {
    for_nodes(g, [&](const ClusterNode& node) {
      if (node.closing > 0) {
        const Spatial a = read(ev_.blocks.data(), node.place, &SharedBlock<double>::acceleration);
        for (int i = node.closing; i-- > 0;)
          closures_.find_multipliers(plan_.loop_slots[at(node.first_slot + i)].closure, &a);
      }
      if (multipliers && plan_.groups[at(node.group)].has_joint && node.closing < node.slots) add_to_joint(node);
    });
  }
  void store_multipliers() const {
    for (std::size_t e = 0; e < plan_.closures.size(); ++e) {
      const ClosureWork& c = ev_.closures[e];
      for (int r = 0; r < c.count; ++r) ev_.multipliers.get(at(plan_.closures[e].joint), at(c.row[r])) = c.mu[r];
    }
  }

 private:
  LaneParts get_parts(const ClusterNode& node) const {
    return {plan_.groups[at(node.group)], ev_.blocks.data(), node.place};
  }
  // Children before parents.
  template <class Run>
  UNLATCH_INLINE void for_nodes(std::size_t g, const Run& run) const {
    for (std::int32_t i = plan_.group_clusters[g + 1]; i-- > plan_.group_clusters[g];) run(plan_.cluster_nodes[at(i)]);
  }
  // Loops with rows that pass on, and their numbers at the node.
  template <class Run>
  UNLATCH_INLINE void for_passing(const ClusterNode& node, const Run& run) const {
    for (int i = node.closing; i < node.slots; ++i) {
      const LoopSlot& slot = plan_.loop_slots[at(node.first_slot + i)];
      ClosureWork& c = ev_.closures[at(slot.closure)];
      if (c.count > 0) run(slot, c, ev_.cluster_columns.data() + slot.numbers);
    }
  }
  static bool is_set(double mask) { return __builtin_bit_cast(std::uint64_t, mask) != 0; }
  template <class M>
  M read_solver(const ClusterNode& node, M SolverBlock<double>::*member) const {
    return read(ev_.blocks.data(), node.place, member);
  }
  bool is_by_freedoms(const ClusterNode& node) const {
    const GroupModes& modes = ev_.modes[at(node.group)];
    return modes.by_freedoms && (!plan_.groups[at(node.group)].may_be_by_rows ||
                                 is_set(read_solver(node, &SolverBlock<double>::by_freedoms)));
  }
  static int count_below(unsigned all, int r) { return std::popcount(all & ((1u << static_cast<unsigned>(r)) - 1)); }
  int count_freedoms(const ClusterNode& node) const {
    return std::popcount(static_cast<unsigned>(plan_.groups[at(node.group)].freedoms));
  }

  // Freedoms of a node's joint that its mode has. place: of what a loop's rows meet there, behind their wrenches.
  struct Freedoms {
    int count = 0, row[kRows], place[kRows];
    double inverse[kRows];
    double *U[kRows], *beta[kRows];
    std::ptrdiff_t stride;

    Freedoms(const LoopClusters& clusters, const ClusterNode& node) : stride(node.place.width) {
      using Freedom = FreedomBlock<double>;
      const unsigned all = clusters.plan_.groups[at(node.group)].freedoms;
      const LaneParts parts = clusters.get_parts(node);
      for (unsigned left = clusters.ev_.modes[at(node.group)].freedoms; left != 0; left &= left - 1) {
        const int r = std::countr_zero(left);
        const LaneOf<Freedom> own = parts.freedom(r);
        if (!is_set(own.read(&Freedom::mask))) continue;
        row[count] = r;
        place[count] = (6 + count_below(all, r)) * kEight;
        inverse[count] = own.read(&Freedom::inverse_pivot);
        U[count] = own.find(&Freedom::U);
        beta[count++] = own.find(&Freedom::beta);
      }
    }
    Spatial read_U(int k) const { return collect<Spatial>(U[k], stride); }
  };
  // Rows of a node's joint that its mode holds, likewise.
  struct Rows {
    int count = 0, place[kRows];
    LaneOf<RowBlock<double>> row[kRows];

    Rows(const LoopClusters& clusters, const ClusterNode& node) {
      const unsigned all = clusters.plan_.groups[at(node.group)].rows;
      const LaneParts parts = clusters.get_parts(node);
      for (unsigned left = clusters.ev_.modes[at(node.group)].rows; left != 0; left &= left - 1) {
        const int r = std::countr_zero(left);
        const LaneOf<RowBlock<double>> own = parts.row(r);
        if (!is_set(own.read(&RowBlock<double>::mask))) continue;
        place[count] = (6 + clusters.count_freedoms(node) + 6 + count_below(all, r)) * kEight;
        row[count++] = own;
      }
    }
  };

  // Of one pivot, or a part of it: `x`, `y`: positions behind a slot's numbers.
  void give(const ClusterNode& node, double scale, int x, int y) const {
    const std::int32_t* pair = plan_.loop_pairs.data() + node.first_pair;
    for (int i = node.closing; i < node.slots; ++i) {
      const LoopSlot& a = plan_.loop_slots[at(node.first_slot + i)];
      ClosureWork& own = ev_.closures[at(a.closure)];
      const double* left = ev_.cluster_columns.data() + a.numbers + x;
      const double* right = ev_.cluster_columns.data() + a.numbers + y;
      for (int j = i; j < node.slots; ++j, ++pair) {
        const LoopSlot& b = plan_.loop_slots[at(node.first_slot + j)];
        add_outer_block<T>(closures_.get_block(*pair), own.count, ev_.closures[at(b.closure)].count, scale, left,
                           ev_.cluster_columns.data() + b.numbers + y);
      }
      for_lanes<T>(own.count, [&](int c) UNLATCH_INLINE_LAMBDA {
        store(own.own + c, load<T>(own.own + c) + (T(scale) * load<T>(left + c)) * load<T>(right + c));
      });
    }
  }
  // Moved to the parent's origin, `offset` away, and added to what is there.
  UNLATCH_INLINE void hand_on(const LoopSlot& slot, const Vec3T<T>& offset, int c, SpatialT<T> F) const {
    if (slot.parent == kNone) return;
    F.ang += cross(offset, F.lin);
    double* to = closures_.get_numbers(slot.parent);
    store_lanes(to, c, slot.begins != 0 ? F : load_lanes<T>(to, c) + F);
  }

  Spatial read_freedom(const ClusterNode& node, int r) const {
    if (r < kRotX) return {column(read_solver(node, &SolverBlock<double>::axes), r), {0, 0, 0}};
    const Vec3 axis = column(get_parts(node).rotation_axes().read(), r - kRotX);
    return {cross(read_solver(node, &SolverBlock<double>::arm_child), axis), axis};
  }

  void pass_freedoms(const ClusterNode& node, const Freedoms& f) const {
    SpatialT<T> s[kRows], U[kRows];
    for (int k = 0; k < f.count; ++k) {
      s[k] = spread<T>(read_freedom(node, f.row[k]));
      U[k] = spread<T>(f.read_U(k));
    }
    const Vec3T<T> offset = spread<T>(read_solver(node, &SolverBlock<double>::offset));
    for_passing(node, [&](const LoopSlot& slot, const ClosureWork& work, double* numbers) {
      for_lanes<T>(work.count, [&](int c) UNLATCH_INLINE_LAMBDA {
        SpatialT<T> F = load_lanes<T>(numbers, c);
        for (int k = 0; k < f.count; ++k) {
          const T beta = dot(s[k], F);
          store(numbers + f.place[k] + c, beta);
          F = F - (beta * T(f.inverse[k])) * U[k];
        }
        hand_on(slot, offset, c, F);
      });
    });
    for (int k = 0; k < f.count; ++k) give(node, f.inverse[k], f.place[k], f.place[k]);
  }

  void pass_rows(const ClusterNode& node) const {
    using Row = RowBlock<double>;
    const FreeFactor free = get_parts(node).free().read(&FreeBlock<double>::factor);
    const auto spread3 = [](const Factor3T<double>& f) {
      return Factor3T<T>{T(f.l10), T(f.n20), T(f.l21), T(f.i0), T(f.i1), T(f.i2)};
    };
    const FreeFactorT<T> factor{
        spread3(free.M), {spread<T>(free.W.x), spread<T>(free.W.y), spread<T>(free.W.z)}, spread3(free.K)};
    const int reply = (6 + count_freedoms(node)) * kEight;
    const Vec3T<T> offset = spread<T>(read_solver(node, &SolverBlock<double>::offset));
    const Rows rows(*this, node);
    SpatialT<T> w[kRows];
    double inverse[kRows];
    for (int k = 0; k < rows.count; ++k) {
      w[k] = spread<T>(rows.row[k].read(&Row::wrench));
      inverse[k] = rows.row[k].read(&Row::inverse_pivot);
    }
    for_passing(node, [&](const LoopSlot& slot, const ClosureWork& work, double* numbers) {
      for_lanes<T>(work.count, [&](int c) {
        const SpatialT<T> response = solve_free(factor, load_lanes<T>(numbers, c));
        store_lanes(numbers + reply, c, response);
        const T o(0.0);
        SpatialT<T> F{{o, o, o}, {o, o, o}};
        for (int k = 0; k < rows.count; ++k) {
          const T part = dot(w[k], response);
          store(numbers + rows.place[k] + c, part);
          F = F + (part * T(inverse[k])) * w[k];
        }
        hand_on(slot, offset, c, F);
      });
    });
    for (int i = 0; i < 6; ++i) give(node, 1, i * kEight, reply + i * kEight);
    for (int k = 0; k < rows.count; ++k) give(node, -inverse[k], rows.place[k], rows.place[k]);
  }

  void pass_loads_by_freedoms(const ClusterNode& node, const Freedoms& f, bool biased) const {
    double reply[kRows];
    for (int k = 0; k < f.count; ++k) reply[k] = *f.beta[k] * f.inverse[k];
    const bool moves = biased && plan_.groups[at(node.group)].has_joint;
    const Spatial bias = moves ? read_solver(node, &SolverBlock<double>::bias) : Spatial{{0, 0, 0}, {0, 0, 0}};
    for_passing(node, [&](const LoopSlot&, ClosureWork& work, const double* numbers) {
      for_lanes<T>(work.count, [&](int c) UNLATCH_INLINE_LAMBDA {
        T target = load<T>(work.target + c);
        for (int k = 0; k < f.count; ++k) target = target - load<T>(numbers + f.place[k] + c) * T(reply[k]);
        if (moves) target = target - dot(load_lanes<T>(numbers, c), spread<T>(bias));
        store(work.target + c, target);
      });
    });
  }
  void pass_loads_by_rows(const ClusterNode& node) const {
    const Spatial response = get_parts(node).free().read(&FreeBlock<double>::response);
    const Rows rows(*this, node);
    for_passing(node, [&](const LoopSlot&, ClosureWork& work, const double* numbers) {
      for_lanes<T>(work.count, [&](int c) {
        T target = load<T>(work.target + c) - dot(load_lanes<T>(numbers, c), spread<T>(response));
        for (int k = 0; k < rows.count; ++k)
          target = target + load<T>(numbers + rows.place[k] + c) * T(rows.row[k].read(&RowBlock<double>::mu));
        store(work.target + c, target);
      });
    });
  }

  // Σ of a loop's six numbers times its multipliers.
  static Spatial combine_spatial(const double* F, const ClosureWork& c) {
    double sums[6];
    for (int i = 0; i < 6; ++i) sums[i] = combine(F + i * kEight, c.mu, c.count);
    return collect<Spatial>(sums, 1);
  }
  void add_to_rows(const ClusterNode& node) const {
    const Rows rows(*this, node);
    const int reply = (6 + count_freedoms(node)) * kEight;
    for_passing(node, [&](const LoopSlot&, const ClosureWork& c, const double* numbers) {
      get_parts(node).free().add(&FreeBlock<double>::response, combine_spatial(numbers + reply, c));
      for (int k = 0; k < rows.count; ++k)
        *rows.row[k].find(&RowBlock<double>::mu) +=
            rows.row[k].read(&RowBlock<double>::inverse_pivot) * combine(numbers + rows.place[k], c.mu, c.count);
    });
  }

  // The part of the open loops in the wrench that the joint puts on the child.
  void add_to_joint(const ClusterNode& node) const {
    Spatial sum{{0, 0, 0}, {0, 0, 0}};
    for_passing(node,
                [&](const LoopSlot&, const ClosureWork& c, const double* F) { sum = sum + combine_spatial(F, c); });
    const std::int32_t joint = plan_.nodes[at(node.node)].joint;
    const double side = plan_.joints[at(joint)].child == plan_.joints[at(joint)].follower ? 1 : -1;
    const LaneParts parts = get_parts(node);
    const Mat3 n = read_solver(node, &SolverBlock<double>::axes), m = parts.rotation_axes().read();
    const Vec3 moment = sum.ang - cross(read_solver(node, &SolverBlock<double>::arm_child), sum.lin);
    const bool by_freedoms = is_by_freedoms(node);
    const Group& group = plan_.groups[at(node.group)];
    for (int r = 0; r < kRows; ++r) {
      const bool holds = by_freedoms ? !(has_row(group.freedoms, r) && has_row(ev_.modes[at(node.group)].freedoms, r) &&
                                         is_set(parts.freedom(r).read(&FreedomBlock<double>::mask)))
                                     : has_row(group.rows, r) && has_row(ev_.modes[at(node.group)].rows, r) &&
                                           is_set(parts.row(r).read(&RowBlock<double>::mask));
      if (!holds) continue;
      const double size = r < kRotX ? dot(column(n, r), sum.lin) : dot(column(m, r - kRotX), moment);
      ev_.multipliers.get(at(joint), at(r)) -= side * size;
    }
  }

  const PlanData& plan_;
  Evaluation& ev_;
  LoopClosures<T> closures_;
};

}  // namespace unlatch::UNLATCH_ISA
