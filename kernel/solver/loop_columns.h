// Λ of the joints that close loops (loop_rows.h): their rows are columns side by side, one per lane. The unit wrenches
// go from the leaves to the root through the factor of the tree, H = L D Lᵀ, and add at every pivot d that they meet
//   Λ = W H⁻¹ Wᵀ = Σ over pivots d of  β βᵀ / d,   β the row of L⁻¹ Wᵀ:
// half a solve for all rows at once, and a sum of squares, which keeps Λ symmetric and its small entries true. Compiled
// once per instruction set, see kernel/simd/pack.h.
#pragma once

#include <bit>

#include "kernel/dynamics/flexible.h"
#include "kernel/solver/flexible_solver.h"
#include "kernel/solver/loop_rows.h"
#include "kernel/solver/node.h"

namespace unlatch::UNLATCH_ISA {

// Numbers of all columns: one row of them each, `stride` apart.
template <class T>
struct Columns {
  double* rows;
  std::int32_t stride, count;  // count: columns in use

  UNLATCH_INLINE double* row(int r) const { return rows + r * stride; }
  UNLATCH_INLINE T get(int r, int c) const { return load<T>(row(r) + c); }
  UNLATCH_INLINE void set(int r, int c, const T& a) const { store(row(r) + c, a); }
  UNLATCH_INLINE SpatialT<T> get_spatial(int c) const {
    return {{get(0, c), get(1, c), get(2, c)}, {get(3, c), get(4, c), get(5, c)}};
  }
  UNLATCH_INLINE void set_spatial(int c, const SpatialT<T>& a) const {
    set(0, c, a.lin.x);
    set(1, c, a.lin.y);
    set(2, c, a.lin.z);
    set(3, c, a.ang.x);
    set(4, c, a.ang.y);
    set(5, c, a.ang.z);
  }
  UNLATCH_INLINE Columns from(int r) const { return {row(r), stride, count}; }
  // Calls run(c) for every pack of columns.
  template <class Run>
  UNLATCH_INLINE void for_packs(const Run& run) const {
    for (int c = 0; c < count; c += T::kWidth) run(c);
  }
};

template <class T>
UNLATCH_INLINE Vec3T<T> spread(const Vec3& a) {
  return {T(a.x), T(a.y), T(a.z)};
}
template <class T>
UNLATCH_INLINE SpatialT<T> spread(const Spatial& a) {
  return {spread<T>(a.lin), spread<T>(a.ang)};
}

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
        pass_body(node, group, loads);
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
  void give(double scale, const double* x, const double* y) const {
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
        const double numbers[6] = {w.lin.x, w.lin.y, w.lin.z, w.ang.x, w.ang.y, w.ang.z};
        for (int i = 0; i < 6; ++i) loads.row(i)[r] += numbers[i];
      }
    }
  }

  static bool is_set(double mask) { return __builtin_bit_cast(std::uint64_t, mask) != 0; }
  template <class M>
  M read_solver(const LoopNode& node, M SolverBlock<double>::*member) const {
    return read(ev_.blocks.data(), node.place, member);
  }
  LaneParts get_parts(const LoopNode& node) const {
    return {plan_.groups[at(node.group)], ev_.blocks.data(), node.place};
  }

  void pass_body(const LoopNode& node, const Group& group, const Columns<T>& loads) const {
    const GroupModes& modes = ev_.modes[at(node.group)];
    if (modes.by_freedoms && (!group.may_be_by_rows || is_set(read_solver(node, &SolverBlock<double>::by_freedoms))))
      eliminate_freedoms(node, modes.freedoms, loads);
    else
      eliminate_rows(node, modes.rows, loads);
    if (node.parent_loads == kNone) return;
    move(read_solver(node, &SolverBlock<double>::offset), loads);
    hand_on(node, loads);
  }

  // Direction of freedom r at the child's origin.
  Spatial read_freedom(const LoopNode& node, int r) const {
    if (r < kRotX) return {column(read_solver(node, &SolverBlock<double>::axes), r), {0, 0, 0}};
    const Vec3 axis = column(get_parts(node).rotation_axes().read(), r - kRotX);
    return {cross(read_solver(node, &SolverBlock<double>::arm_child), axis), axis};
  }

  void eliminate_freedoms(const LoopNode& node, RowSet freedoms, const Columns<T>& loads) const {
    using Freedom = FreedomBlock<double>;
    for (unsigned left = freedoms; left != 0; left &= left - 1) {
      const int r = std::countr_zero(left);
      const LaneOf<Freedom> own = get_parts(node).freedom(r);
      if (!is_set(own.read(&Freedom::mask))) continue;
      const double inverse = own.read(&Freedom::inverse_pivot);
      const SpatialT<T> s = spread<T>(read_freedom(node, r)), U = spread<T>(own.read(&Freedom::U));
      loads.for_packs([&](int c) {
        const SpatialT<T> load = loads.get_spatial(c);
        const T beta = dot(s, load);
        replies_.set(0, c, beta);
        loads.set_spatial(c, load - (beta * T(inverse)) * U);
      });
      give(inverse, replies_.row(0), replies_.row(0));
    }
  }

  // A body that one or two rows hold, or none: all its freedoms go at once, then each row takes its part back.
  void eliminate_rows(const LoopNode& node, RowSet rows, const Columns<T>& loads) const {
    using Row = RowBlock<double>;
    const FreeFactor free = get_parts(node).free().read(&FreeBlock<double>::factor);
    const auto spread3 = [](const Factor3T<double>& f) {
      return Factor3T<T>{T(f.l10), T(f.n20), T(f.l21), T(f.i0), T(f.i1), T(f.i2)};
    };
    const FreeFactorT<T> f{
        spread3(free.M), {spread<T>(free.W.x), spread<T>(free.W.y), spread<T>(free.W.z)}, spread3(free.K)};
    loads.for_packs([&](int c) { replies_.set_spatial(c, solve_free(f, loads.get_spatial(c))); });
    for (int i = 0; i < 6; ++i) give(1, loads.row(i), replies_.row(i));
    clear(loads, 6);
    const Columns<T> reaction = replies_.from(6);
    for (int r = 0; r < kRows; ++r) {
      if (!has_row(rows, r)) continue;
      const LaneOf<Row> own = get_parts(node).row(r);
      if (!is_set(own.read(&Row::mask))) continue;
      const double inverse = own.read(&Row::inverse_pivot);
      const SpatialT<T> w = spread<T>(own.read(&Row::wrench));
      loads.for_packs([&](int c) {
        const T along = dot(w, replies_.get_spatial(c));
        reaction.set(0, c, along);
        loads.set_spatial(c, loads.get_spatial(c) + (along * T(inverse)) * w);
      });
      give(-inverse, reaction.row(0), reaction.row(0));
    }
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
    hand_on(node, loads);
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
      hand_on(node, loads);
    else
      eliminate(work.root->get_lower(), 6, loads);
  }

  // By the factor of a dense block: forward through its unit triangle, and each row gives.
  void eliminate(const LowerTriangle& factor, int size, const Columns<T>& loads) const {
    for (int r = 0; r < size; ++r) {
      for (int k = 0; k < r; ++k) {
        const T l(factor(r, k));
        loads.for_packs([&](int c) { loads.set(r, c, loads.get(r, c) - l * loads.get(k, c)); });
      }
      give(1 / factor(r, r), loads.row(r), loads.row(r));
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
  void hand_on(const LoopNode& node, const Columns<T>& loads) const {
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
    for (int r = rank + 1; r < ev.loop_count; ++r) matrix(r, rank) = column[r] / d;
  }
  ev.loop_redundant = ev.loop_count - rank;
}

}  // namespace unlatch::UNLATCH_ISA
