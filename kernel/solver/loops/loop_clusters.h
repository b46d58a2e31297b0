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

#include "kernel/solver/loops/loop_closures.h"
#include "kernel/solver/loops/solved_node.h"

namespace unlatch::UNLATCH_ISA {

template <class T>
class LoopClusters {
 public:
  using Numbers = LoopColumns<T>;

  LoopClusters(const PlanData& plan, Evaluation& ev) : plan_(plan), ev_(ev), closures_(plan, ev) {}

  // --- Before the backward pass
  void begin_factor() const {
    for (std::size_t e = 0; e < plan_.closures.size(); ++e) closures_.begin(static_cast<int>(e));
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
    for_passed_nodes(g, [&](const ClusterNode& node, const SolvedNode& solved) {
      if (solved.is_by_freedoms()) {
        const Freedoms f(solved);
        if constexpr (kFactor) pass_freedoms(node, solved, f);
        pass_loads_by_freedoms(node, solved, f, biased);
      } else {
        if constexpr (kFactor) pass_rows(node, solved);
        pass_loads_by_rows(node, solved);
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
    for_passed_nodes(g, [&](const ClusterNode& node, const SolvedNode& solved) {
      if (!solved.is_by_freedoms()) return add_to_rows(node, solved);
      const Freedoms f(solved);
      for_passing(node, [&](const LoopSlot&, const ClosureWork& c, const Numbers& numbers) {
        for (int k = 0; k < f.count; ++k) *f.beta[k] += combine(numbers.row(f.place[k]), c.mu, c.count);
      });
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
  SolvedNode get_solved(const ClusterNode& node) const { return {plan_, ev_, node.group, node.place}; }
  // Children before parents.
  template <class Run>
  UNLATCH_INLINE void for_nodes(std::size_t g, const Run& run) const {
    for (std::int32_t i = plan_.group_clusters[g + 1]; i-- > plan_.group_clusters[g];) run(plan_.cluster_nodes[at(i)]);
  }
  // Likewise, those that a loop passes on its way to where it closes.
  template <class Run>
  UNLATCH_INLINE void for_passed_nodes(std::size_t g, const Run& run) const {
    for_nodes(g, [&](const ClusterNode& node) {
      if (node.closing < node.slots) run(node, get_solved(node));
    });
  }
  // Loops with rows that pass on, and what they have at the node.
  template <class Run>
  UNLATCH_INLINE void for_passing(const ClusterNode& node, const Run& run) const {
    for (std::int32_t i = node.first_slot + node.closing; i < node.first_slot + node.slots; ++i) {
      const LoopSlot& slot = plan_.loop_slots[at(i)];
      ClosureWork& c = ev_.closures[at(slot.closure)];
      if (c.count > 0) run(slot, c, closures_.get_numbers(i));
    }
  }

  // Freedoms of a node's joint that its mode has. place: the row of SlotRows for what loops do along it.
  struct Freedoms {
    int count = 0, row[kRows], place[kRows];
    double inverse[kRows];
    double* beta[kRows];
    SolvedNode::Freedom own[kRows];

    explicit Freedoms(const SolvedNode& node) {
      using Freedom = FreedomBlock<double>;
      const SlotRows rows(node.get_group());
      node.for_freedoms([&](int r, const SolvedNode::Freedom& freedom) {
        row[count] = r;
        place[count] = rows.freedom(r);
        inverse[count] = freedom.read(&Freedom::inverse_pivot);
        beta[count] = freedom.find(&Freedom::beta);
        own[count++] = freedom;
      });
    }
  };
  // Rows of a node's joint that its mode holds, likewise.
  struct Rows {
    int count = 0, place[kRows], response;
    SolvedNode::Row row[kRows];

    explicit Rows(const SolvedNode& node) {
      const SlotRows rows(node.get_group());
      response = rows.response();
      node.for_rows([&](int r, const SolvedNode::Row& own) {
        place[count] = rows.row(r);
        row[count++] = own;
      });
    }
  };

  // scale · x yᵀ of one pivot, or a part of it; `x`, `y`: rows of SlotRows.
  struct Outer {
    double scale;
    int x, y;
  };
  static constexpr int kMostOuters = SlotRows::kWrenches + kRows;

  // Λ += the parts, one after the other in each entry.
  void add_to_matrix(const ClusterNode& node, const Outer* parts, int count) const {
    const std::int32_t* pair = plan_.loop_pairs.data() + node.first_pair;
    const std::int32_t end = node.first_slot + node.slots;
    for (std::int32_t i = node.first_slot + node.closing; i < end; ++i) {
      ClosureWork& own = ev_.closures[at(plan_.loop_slots[at(i)].closure)];
      if (own.count == 0) {
        pair += end - i;
        continue;
      }
      const Numbers left = closures_.get_numbers(i);
      double x[kMostOuters][kEight];
      for (int k = 0; k < count; ++k)
        for (int r = 0; r < own.count; ++r) x[k][r] = parts[k].scale * left.row(parts[k].x)[r];
      for (std::int32_t j = i; j < end; ++j, ++pair) {
        const Numbers right = closures_.get_numbers(j);
        const double* y[kMostOuters];
        for (int k = 0; k < count; ++k) y[k] = right.row(parts[k].y);
        closures_.get_block(*pair, plan_.loop_slots[at(j)].closure).add_outers(own.count, count, x, y);
      }
      left.for_packs([&](int c) UNLATCH_INLINE_LAMBDA {
        T sum = load<T>(own.own + c);
        for (int k = 0; k < count; ++k)
          sum = sum + (T(parts[k].scale) * left.get(parts[k].x, c)) * left.get(parts[k].y, c);
        store(own.own + c, sum);
      });
    }
  }
  // Moves the wrenches of a pack of rows to the parent's origin, `offset` away, and adds them to what is there.
  UNLATCH_INLINE void add_to_parent(const LoopSlot& slot, const Vec3T<T>& offset, int c, SpatialT<T> F) const {
    if (slot.parent == kNone) return;
    F.ang += cross(offset, F.lin);
    const Numbers to = closures_.get_numbers(slot.parent);
    to.set_spatial(c, slot.begins != 0 ? F : to.get_spatial(c) + F);
  }

  void pass_freedoms(const ClusterNode& node, const SolvedNode& solved, const Freedoms& f) const {
    SpatialT<T> s[kRows], U[kRows];
    for (int k = 0; k < f.count; ++k) {
      s[k] = spread<T>(solved.read_freedom(f.row[k]));
      U[k] = spread<T>(f.own[k].read(&FreedomBlock<double>::U));
    }
    const Vec3T<T> offset = spread<T>(solved.read(&SolverBlock<double>::offset));
    for_passing(node, [&](const LoopSlot& slot, const ClosureWork&, const Numbers& numbers) {
      numbers.for_packs([&](int c) UNLATCH_INLINE_LAMBDA {
        SpatialT<T> F = numbers.get_spatial(c);
        for (int k = 0; k < f.count; ++k) {
          const T beta = dot(s[k], F);
          numbers.set(f.place[k], c, beta);
          F = F - (beta * T(f.inverse[k])) * U[k];
        }
        add_to_parent(slot, offset, c, F);
      });
    });
    Outer parts[kRows];
    for (int k = 0; k < f.count; ++k) parts[k] = {f.inverse[k], f.place[k], f.place[k]};
    add_to_matrix(node, parts, f.count);
  }

  void pass_rows(const ClusterNode& node, const SolvedNode& solved) const {
    using Row = RowBlock<double>;
    const FreeFactorT<T> factor = solved.read_free_factor<T>();
    const Vec3T<T> offset = spread<T>(solved.read(&SolverBlock<double>::offset));
    const Rows rows(solved);
    SpatialT<T> w[kRows];
    double inverse[kRows];
    for (int k = 0; k < rows.count; ++k) {
      w[k] = spread<T>(rows.row[k].read(&Row::wrench));
      inverse[k] = rows.row[k].read(&Row::inverse_pivot);
    }
    for_passing(node, [&](const LoopSlot& slot, const ClosureWork&, const Numbers& numbers) {
      numbers.for_packs([&](int c) {
        const SpatialT<T> response = solve_free(factor, numbers.get_spatial(c));
        numbers.from(rows.response).set_spatial(c, response);
        const T o(0.0);
        SpatialT<T> F{{o, o, o}, {o, o, o}};
        for (int k = 0; k < rows.count; ++k) {
          const T part = dot(w[k], response);
          numbers.set(rows.place[k], c, part);
          F = F + (part * T(inverse[k])) * w[k];
        }
        add_to_parent(slot, offset, c, F);
      });
    });
    Outer parts[kMostOuters];
    int count = 0;
    for (int i = 0; i < SlotRows::kWrenches; ++i) parts[count++] = {1, SlotRows::kWrench + i, rows.response + i};
    for (int k = 0; k < rows.count; ++k) parts[count++] = {-inverse[k], rows.place[k], rows.place[k]};
    add_to_matrix(node, parts, count);
  }

  void pass_loads_by_freedoms(const ClusterNode& node, const SolvedNode& solved, const Freedoms& f, bool biased) const {
    double reply[kRows];
    for (int k = 0; k < f.count; ++k) reply[k] = *f.beta[k] * f.inverse[k];
    const bool moves = biased && solved.get_group().has_joint;
    const Spatial bias = moves ? solved.read(&SolverBlock<double>::bias) : Spatial{{0, 0, 0}, {0, 0, 0}};
    for_passing(node, [&](const LoopSlot&, ClosureWork& work, const Numbers& numbers) {
      numbers.for_packs([&](int c) UNLATCH_INLINE_LAMBDA {
        T target = load<T>(work.target + c);
        for (int k = 0; k < f.count; ++k) target = target - numbers.get(f.place[k], c) * T(reply[k]);
        if (moves) target = target - dot(numbers.get_spatial(c), spread<T>(bias));
        store(work.target + c, target);
      });
    });
  }
  void pass_loads_by_rows(const ClusterNode& node, const SolvedNode& solved) const {
    const Spatial response = solved.get_parts().free().read(&FreeBlock<double>::response);
    const Rows rows(solved);
    for_passing(node, [&](const LoopSlot&, ClosureWork& work, const Numbers& numbers) {
      numbers.for_packs([&](int c) {
        T target = load<T>(work.target + c) - dot(numbers.get_spatial(c), spread<T>(response));
        for (int k = 0; k < rows.count; ++k)
          target = target + numbers.get(rows.place[k], c) * T(rows.row[k].read(&RowBlock<double>::mu));
        store(work.target + c, target);
      });
    });
  }

  void add_to_rows(const ClusterNode& node, const SolvedNode& solved) const {
    const Rows rows(solved);
    for_passing(node, [&](const LoopSlot&, const ClosureWork& c, const Numbers& numbers) {
      solved.get_parts().free().add(&FreeBlock<double>::response, numbers.from(rows.response).combine_columns(c.mu));
      for (int k = 0; k < rows.count; ++k)
        *rows.row[k].find(&RowBlock<double>::mu) +=
            rows.row[k].read(&RowBlock<double>::inverse_pivot) * combine(numbers.row(rows.place[k]), c.mu, c.count);
    });
  }

  // The part of the open loops in the wrench that the joint puts on the child.
  void add_to_joint(const ClusterNode& node) const {
    Spatial sum{{0, 0, 0}, {0, 0, 0}};
    for_passing(node, [&](const LoopSlot&, const ClosureWork& c, const Numbers& numbers) {
      sum = sum + numbers.combine_columns(c.mu);
    });
    const std::int32_t joint = plan_.nodes[at(node.node)].joint;
    const double side = plan_.joints[at(joint)].child == plan_.joints[at(joint)].follower ? 1 : -1;
    const SolvedNode solved = get_solved(node);
    const Mat3 n = solved.read(&SolverBlock<double>::axes), m = solved.get_parts().rotation_axes().read();
    const Vec3 moment = sum.ang - cross(solved.read(&SolverBlock<double>::arm_child), sum.lin);
    for (int r = 0; r < kRows; ++r) {
      if (!solved.holds(r)) continue;
      const double size = r < kRotX ? dot(column(n, r), sum.lin) : dot(column(m, r - kRotX), moment);
      ev_.multipliers.get(at(joint), at(r)) -= side * size;
    }
  }

  const PlanData& plan_;
  Evaluation& ev_;
  LoopClosures<T> closures_;
};

}  // namespace unlatch::UNLATCH_ISA
