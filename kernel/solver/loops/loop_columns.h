// Λ of the joints that close loops (loop_rows.h): their rows are columns side by side, one per lane. The unit wrenches
// go from the leaves to the root through the factor of the tree, H = L D Lᵀ, and add at every pivot d that they meet
//   Λ = W H⁻¹ Wᵀ = Σ over pivots d of  β βᵀ / d,   β the row of L⁻¹ Wᵀ:
// half a solve for all rows at once, and a sum of squares, which keeps Λ symmetric and its small entries true. Compiled
// once per instruction set, see kernel/simd/pack.h.
#pragma once

#include "kernel/dynamics/flexible.h"
#include "kernel/solver/flexible_solver.h"
#include "kernel/solver/loops/columns.h"
#include "kernel/solver/loops/loop_rows.h"
#include "kernel/solver/loops/solved_node.h"

namespace unlatch::UNLATCH_ISA {

// Lower triangle of a matrix, row by row, += scale x yᵀ. Numbers right of the diagonal are lost.
template <class T>
UNLATCH_INLINE void add_outer(double* matrix, std::int32_t stride, int first, int count, double scale, const double* x,
                              const double* y) {
  for (int r = first; r < count; ++r) {
    const T k(scale * x[r]);
    double* row = matrix + r * stride;
    for (int c = first / 8 * 8; c <= r; c += T::kWidth)  // every width touches the same: zeros keep their signs
      store(row + c, load<T>(row + c) + k * load<T>(y + c));
  }
}

// The way of the columns through the nodes of the tree.
template <class T>
class LoopPass {
 public:
  LoopPass(const PlanData& plan, Evaluation& ev)
      : plan_(plan),
        ev_(ev),
        stride_(plan.loop_columns),
        replies_{ev.loop_replies.data(), plan.loop_columns, ev.loop_count} {}

  void run() const {
    for (int r = 0; r < ev_.loop_count; ++r)
      for (int c = 0; c < plan_.loop_columns; ++c) ev_.loop_matrix[at(r * stride_ + c)] = 0;
    clear(get_columns(0), plan_.loop_modal_rows);
    for (const LoopNode& node : plan_.loop_nodes) {
      const Columns<T> loads = get_columns(node.loads);
      if (node.opens) clear(loads, 6);
      add_wrenches(node, loads);
      const Group& group = plan_.groups[at(node.group)];
      if (group.kind == BodyKind::kRigid)
        pass_body(node, loads);
      else if (group.kind == BodyKind::kFlexible)
        pass_flexible(node, loads);
      else
        pass_marker(node, loads);
    }
  }

 private:
  Columns<T> get_columns(std::int32_t row) const {
    return {ev_.loop_loads.data() + static_cast<std::ptrdiff_t>(row) * stride_, stride_, ev_.loop_count};
  }
  static void clear(const Columns<T>& rows, int count) {
    for (int r = 0; r < count; ++r) rows.for_packs([&](int c) { rows.set(r, c, T(0.0)); });
  }
  // x yᵀ / d of one pivot, or a part of that.
  void add_to_matrix(double scale, const double* x, const double* y) const {
    add_outer<T>(ev_.loop_matrix.data(), stride_, 0, ev_.loop_count, scale, x, y);
  }

  // The unit wrenches that rows put on the node's body.
  void add_wrenches(const LoopNode& node, const Columns<T>& loads) const {
    for (int e = node.first_end; e < node.first_end + node.ends; ++e) {
      const LoopEnd& end = plan_.loop_ends[at(e)];
      const std::int32_t* range = ev_.loop_ranges.data() + end.loop;
      for (int r = range[0]; r < range[1]; ++r) {
        const LoopRow& row = ev_.loop_rows[at(r)];
        const Spatial& w = end.follower ? row.on_follower : row.on_base;
        loads.set_column(r, loads.get_column(r) + w);
      }
    }
  }

  void pass_body(const LoopNode& node, const Columns<T>& loads) const {
    const SolvedNode solved(plan_, ev_, node.group, node.place);
    if (solved.is_by_freedoms())
      eliminate_freedoms(solved, loads);
    else
      eliminate_rows(solved, loads);
    if (node.parent_loads == kNone) return;
    move(solved.read(&SolverBlock<double>::offset), loads);
    add_to_parent(node, loads);
  }

  void eliminate_freedoms(const SolvedNode& node, const Columns<T>& loads) const {
    using Freedom = FreedomBlock<double>;
    node.for_freedoms([&](int r, const SolvedNode::Freedom& own) {
      const double inverse = own.read(&Freedom::inverse_pivot);
      const SpatialT<T> s = spread<T>(node.read_freedom(r)), U = spread<T>(own.read(&Freedom::U));
      loads.for_packs([&](int c) {
        const SpatialT<T> load = loads.get_spatial(c);
        const T beta = dot(s, load);
        replies_.set(0, c, beta);
        loads.set_spatial(c, load - (beta * T(inverse)) * U);
      });
      add_to_matrix(inverse, replies_.row(0), replies_.row(0));
    });
  }

  // A body that one or two rows hold, or none: all its freedoms go at once, then each row takes its part back.
  void eliminate_rows(const SolvedNode& node, const Columns<T>& loads) const {
    using Row = RowBlock<double>;
    const FreeFactorT<T> f = node.read_free_factor<T>();
    loads.for_packs([&](int c) { replies_.set_spatial(c, solve_free(f, loads.get_spatial(c))); });
    for (int i = 0; i < 6; ++i) add_to_matrix(1, loads.row(i), replies_.row(i));
    clear(loads, 6);
    const Columns<T> reaction = replies_.from(6);
    node.for_rows([&](int, const SolvedNode::Row& own) {
      const double inverse = own.read(&Row::inverse_pivot);
      const SpatialT<T> w = spread<T>(own.read(&Row::wrench));
      loads.for_packs([&](int c) {
        const T along = dot(w, replies_.get_spatial(c));
        reaction.set(0, c, along);
        loads.set_spatial(c, loads.get_spatial(c) + (along * T(inverse)) * w);
      });
      add_to_matrix(-inverse, reaction.row(0), reaction.row(0));
    });
  }

  // A marker outboard of its body: its wrench on the body's frame and on the modal coordinates.
  void pass_marker(const LoopNode& node, const Columns<T>& loads) const {
    const PlanFlexible& body = get_flexible(node);
    const MarkerWork marker = get_marker(body, node.marker, ev_);
    const Columns<T> modal = get_columns(node.modal);
    for (int k = 0; k < body.modes; ++k) {
      const SpatialT<T> column = spread<T>(marker.columns[at(k)]);
      modal.for_packs([&](int c) { modal.set(k, c, modal.get(k, c) + dot(column, loads.get_spatial(c))); });
    }
    move(*marker.arm, loads);
    add_to_parent(node, loads);
  }

  // In the terms of flexible_solver.cc: f' = f − Dᵀ b, b' = Yᵀ b, b'' = b' − Wᵀ f', with E' = L D Lᵀ.
  void pass_flexible(const LoopNode& node, const Columns<T>& loads) const {
    const PlanFlexible& body = get_flexible(node);
    const ModalWork work = get_work(body, ev_);
    const Columns<T> modal = get_columns(node.modal);
    const bool held = body.inboard != kNone;
    for (int k = 0; k < body.modes && held; ++k) {
      const SpatialT<T> D = spread<T>(work.D[at(k)]);
      modal.for_packs([&](int c) { modal.set(k, c, modal.get(k, c) - dot(D, loads.get_spatial(c))); });
    }
    if (held) move(-*get_marker(body, body.inboard, ev_).arm, loads);
    for (int k = 0; k < body.modes; ++k) {
      const SpatialT<T> W = spread<T>(work.W[at(k)]);
      loads.for_packs([&](int c) { loads.set_spatial(c, loads.get_spatial(c) - modal.get(k, c) * W); });
    }
    eliminate(work.E, body.modes, modal);
    if (held)
      add_to_parent(node, loads);
    else
      eliminate(work.root->get_lower(), 6, loads);
  }

  // By the factor of a dense block: forward through its unit triangle, and each row adds to Λ.
  void eliminate(const LowerTriangle& factor, int size, const Columns<T>& loads) const {
    for (int r = 0; r < size; ++r) {
      for (int k = 0; k < r; ++k) {
        const T l(factor(r, k));
        loads.for_packs([&](int c) { loads.set(r, c, loads.get(r, c) - l * loads.get(k, c)); });
      }
      add_to_matrix(1 / factor(r, r), loads.row(r), loads.row(r));
    }
  }

  // Wrenches at a point, as seen from the one that is `arm` before it.
  static void move(const Vec3& arm, const Columns<T>& loads) {
    const Vec3T<T> r = spread<T>(arm);
    loads.for_packs([&](int c) {
      SpatialT<T> a = loads.get_spatial(c);
      a.ang += cross(r, a.lin);
      loads.set_spatial(c, a);
    });
  }

  // To the parent, unless they are there: the first that comes shares the parent's place.
  void add_to_parent(const LoopNode& node, const Columns<T>& loads) const {
    if (node.parent_loads == node.loads) return;
    const Columns<T> to = get_columns(node.parent_loads);
    loads.for_packs([&](int c) { to.set_spatial(c, to.get_spatial(c) + loads.get_spatial(c)); });
  }

  const PlanFlexible& get_flexible(const LoopNode& node) const {
    const std::int32_t body = plan_.nodes[at(node.node)].body;
    return plan_.flexible[at(plan_.bodies[at(body)].flexible)];
  }

  const PlanData& plan_;
  Evaluation& ev_;
  std::int32_t stride_;
  Columns<T> replies_;
};

// Λ of the present rows.
template <int kWidest>
void update_loop_matrix(const PlanData& plan, Evaluation& ev) {
  LoopPass<Pack<kWidest>>(plan, ev).run();
}

// LDLᵀ of Λ in place, the most independent rows first, at most `most` of them. Rows that follow from the others come
// last and get no pivot.
template <int kWidest>
void factor_loop_matrix(const PlanData& plan, Evaluation& ev, int most) {
  const LowerTriangle matrix = get_loop_matrix(plan, ev);
  double* column = ev.loop_column.data();
  begin_pivots(plan, ev);
  int rank = 0;
  for (; rank < ev.loop_count && rank < most; ++rank) {
    const int best = find_pivot(plan, ev, rank);
    if (best == kNone) break;
    take_pivot(plan, ev, rank, best);
    const double d = matrix(rank, rank);
    for (int r = 0; r < matrix.stride; ++r) column[r] = r > rank && r < ev.loop_count ? matrix(r, rank) : 0;
    add_outer<Pack<kWidest>>(matrix.entries, matrix.stride, rank + 1, ev.loop_count, -1 / d, column, column);
    for (int r = rank + 1; r < ev.loop_count; ++r) {
      const double part = column[r] / d;
      matrix(r, rank) = part;
      find_pivot_row(ev, r).entry.lost += part * part * get_pivot_row(ev, rank).entry.own;
    }
  }
  ev.loop_redundant = ev.loop_count - rank;
}

}  // namespace unlatch::UNLATCH_ISA
