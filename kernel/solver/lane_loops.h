// The rows of joints that close loops, on lanes: one row each. Their unit wrenches go from the leaves to the root
// through the factor of the tree, H = L D Lᵀ, and leave at every pivot they meet what they give to
//   Λ = W H⁻¹ Wᵀ = Σ over pivots d of  β βᵀ / d,   β the row of L⁻¹ Wᵀ:
// half a solve for all rows at once, and a sum of squares, which keeps Λ symmetric and its small entries true. Compiled
// once per instruction set, see pack.h.
#pragma once

#include <bit>

#include "kernel/dynamics/flexible.h"
#include "kernel/plan/lane_access.h"
#include "kernel/plan/loop_nodes.h"
#include "kernel/solver/lane_node.h"

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

// Lower triangle of a matrix, row by row, += scale x yᵀ. What is right of the diagonal is lost.
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

// What one node of the tree does to the columns.
template <class T>
class LoopPass {
 public:
  LoopPass(const Plan& plan, Workspace& ws)
      : plan_(plan), ws_(ws), stride_(plan.loop_columns), replies_(get_columns(plan.loop_load_rows)) {}

  void run() const {
    for (int r = 0; r < ws_.loop_count; ++r)
      for (int c = 0; c < plan_.loop_columns; ++c) ws_.loop_matrix[static_cast<std::size_t>(r * stride_ + c)] = 0;
    clear(get_columns(0), plan_.loop_modal_rows);
    for (const LoopNode& node : plan_.loop_nodes) {
      const Columns<T> loads = get_columns(node.loads);
      if (node.opens) clear(loads, 6);
      add_wrenches(node, loads);
      const LaneGroup& group = plan_.groups[static_cast<std::size_t>(node.group)];
      if (group.special == LaneSpecial::kOrdinary)
        pass_body(node, group, loads);
      else if (group.special == LaneSpecial::kFlexible)
        pass_flexible(node, loads);
      else
        pass_marker(node, loads);
    }
  }

 private:
  Columns<T> get_columns(std::int32_t row) const {
    return {ws_.loop_loads.data() + static_cast<std::ptrdiff_t>(row) * stride_, stride_, ws_.loop_count};
  }
  static void clear(const Columns<T>& rows, int count) {
    for (int r = 0; r < count; ++r) rows.for_packs([&](int c) { rows.set(r, c, T(0.0)); });
  }
  // x yᵀ / d of one pivot, or a part of that.
  void give(double scale, const double* x, const double* y) const {
    add_outer<T>(ws_.loop_matrix.data(), stride_, 0, ws_.loop_count, scale, x, y);
  }

  // The unit wrenches that rows put on the node's body.
  void add_wrenches(const LoopNode& node, const Columns<T>& loads) const {
    for (int e = node.first_end; e < node.first_end + node.ends; ++e) {
      const LoopEnd& end = plan_.loop_ends[static_cast<std::size_t>(e)];
      const std::int32_t* range = ws_.loop_ranges.data() + end.loop;
      for (int r = range[0]; r < range[1]; ++r) {
        const LoopRow& row = ws_.loop_rows[static_cast<std::size_t>(r)];
        const Spatial& w = end.follower ? row.on_follower : row.on_base;
        const double numbers[6] = {w.lin.x, w.lin.y, w.lin.z, w.ang.x, w.ang.y, w.ang.z};
        for (int i = 0; i < 6; ++i) loads.row(i)[r] += numbers[i];
      }
    }
  }

  double read(const LoopNode& node, int row) const { return get_number(ws_.lanes.data(), node.slot, row); }
  Spatial read_six(const LoopNode& node, int row) const { return read_spatial(ws_.lanes.data(), node.slot, row); }
  static bool is_set(double mask) { return __builtin_bit_cast(std::uint64_t, mask) != 0; }

  void pass_body(const LoopNode& node, const LaneGroup& group, const Columns<T>& loads) const {
    const LanePhase& phase = ws_.phases[static_cast<std::size_t>(node.group)];
    if (phase.hinged && node.parent_loads != kNone) return pass_hinge(node, group, phase.freedoms, loads);
    if (phase.held && (!group.may_be_loose || is_set(read(node, kHeld))))
      take_freedoms(node, group, phase.freedoms, loads);
    else
      take_rows(node, group, phase.rows, loads);
    if (node.parent_loads == kNone) return;
    move(read_vec(ws_.lanes.data(), node.slot, kOffset), loads);
    hand_on(node, loads);
  }

  // Direction of freedom r at the child's origin.
  Spatial read_freedom(const LoopNode& node, const LaneGroup& group, int r) const {
    const double* lanes = ws_.lanes.data();
    if (r < kRotX) return {read_vec(lanes, node.slot, kAxes + 3 * r), {0, 0, 0}};
    const Vec3 axis = read_vec(lanes, node.slot, group.rotation_axes + 3 * (r - kRotX));
    return {cross(read_vec(lanes, node.slot, kArmChild), axis), axis};
  }

  // The common case in one go: takes its one freedom and moves on, the same sums in the same order.
  void pass_hinge(const LoopNode& node, const LaneGroup& group, RowSet freedoms, const Columns<T>& loads) const {
    const int r = std::countr_zero(freedoms), part = group.freedom_parts[r];
    const double inverse = read(node, part + kInverse);
    const SpatialT<T> s = spread<T>(read_freedom(node, group, r)), U = spread<T>(read_six(node, part + kU));
    const Vec3T<T> offset = spread<T>(read_vec(ws_.lanes.data(), node.slot, kOffset));
    loads.for_packs([&](int c) {
      SpatialT<T> load = loads.get_spatial(c);
      const T beta = dot(s, load);
      replies_.set(0, c, beta);
      load = load - (beta * T(inverse)) * U;
      load.ang += cross(offset, load.lin);
      loads.set_spatial(c, load);
    });
    give(inverse, replies_.row(0), replies_.row(0));
    hand_on(node, loads);
  }

  void take_freedoms(const LoopNode& node, const LaneGroup& group, RowSet freedoms, const Columns<T>& loads) const {
    for (int r = 0; r < kRows; ++r) {
      if (!has_row(freedoms, r)) continue;
      const int part = group.freedom_parts[r];
      if (!is_set(read(node, part + kMask))) continue;
      const double inverse = read(node, part + kInverse);
      const SpatialT<T> s = spread<T>(read_freedom(node, group, r)), U = spread<T>(read_six(node, part + kU));
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
  void take_rows(const LoopNode& node, const LaneGroup& group, RowSet rows, const Columns<T>& loads) const {
    const double* lanes = ws_.lanes.data();
    const auto factor3 = [&](int row) {
      const Vec3T<T> l = spread<T>(read_vec(lanes, node.slot, row)), i = spread<T>(read_vec(lanes, node.slot, row + 3));
      return Factor3T<T>{l.x, l.y, l.z, i.x, i.y, i.z};
    };
    const Mat3 W = read_mat(lanes, node.slot, group.free + 6);
    const FreeFactorT<T> f{
        factor3(group.free), {spread<T>(W.x), spread<T>(W.y), spread<T>(W.z)}, factor3(group.free + 15)};
    loads.for_packs([&](int c) { replies_.set_spatial(c, solve_free(f, loads.get_spatial(c))); });
    for (int i = 0; i < 6; ++i) give(1, loads.row(i), replies_.row(i));
    clear(loads, 6);
    const Columns<T> reaction = replies_.from(6);
    for (int r = 0; r < kRows; ++r) {
      if (!has_row(rows, r)) continue;
      const int part = group.row_parts[r];
      if (!is_set(read(node, part + kRowMask))) continue;
      const double inverse = read(node, part + kRowInverse);
      const SpatialT<T> w = spread<T>(read_six(node, part + kWrench));
      loads.for_packs([&](int c) {
        const T along = dot(w, replies_.get_spatial(c));
        reaction.set(0, c, along);
        loads.set_spatial(c, loads.get_spatial(c) + (along * T(inverse)) * w);
      });
      give(-inverse, reaction.row(0), reaction.row(0));
    }
  }

  // A marker beyond its body: its wrench on the body's frame and on the modal coordinates.
  void pass_marker(const LoopNode& node, const Columns<T>& loads) const {
    const PlanFlexible& body = get_flexible(node);
    const MarkerWork marker = get_marker(plan_, body, node.marker, ws_);
    const Columns<T> modal = get_columns(node.modal);
    for (int k = 0; k < body.modes; ++k) {
      const SpatialT<T> column = spread<T>(to_spatial(marker.columns + 6 * k));
      modal.for_packs([&](int c) { modal.set(k, c, modal.get(k, c) + dot(column, loads.get_spatial(c))); });
    }
    move({marker.arm[0], marker.arm[1], marker.arm[2]}, loads);
    hand_on(node, loads);
  }

  // In flexible_solver.cc's terms: f' = f − Dᵀ b, b' = Yᵀ b, b'' = b' − Wᵀ f', with E' = L D Lᵀ.
  void pass_flexible(const LoopNode& node, const Columns<T>& loads) const {
    const PlanFlexible& body = get_flexible(node);
    const ModalWork work = get_work(plan_, body, ws_);
    const Columns<T> modal = get_columns(node.modal);
    const bool held = body.inboard != kNone;
    for (int k = 0; k < body.modes && held; ++k) {
      const SpatialT<T> D = spread<T>(to_spatial(work.D + 6 * k));
      modal.for_packs([&](int c) { modal.set(k, c, modal.get(k, c) - dot(D, loads.get_spatial(c))); });
    }
    if (held) {
      const double* arm = get_marker(plan_, body, body.inboard, ws_).arm;
      move({-arm[0], -arm[1], -arm[2]}, loads);
    }
    for (int k = 0; k < body.modes; ++k) {
      const SpatialT<T> W = spread<T>(to_spatial(work.W + 6 * k));
      loads.for_packs([&](int c) { loads.set_spatial(c, loads.get_spatial(c) - modal.get(k, c) * W); });
    }
    eliminate(work.E, body.modes, modal);
    if (held)
      hand_on(node, loads);
    else
      eliminate(work.root, 6, loads);
  }

  // By the factor of a dense block: forward through its unit triangle, and each row gives.
  void eliminate(const double* factor, int size, const Columns<T>& loads) const {
    for (int r = 0; r < size; ++r) {
      for (int k = 0; k < r; ++k) {
        const T l(factor[size * r + k]);
        loads.for_packs([&](int c) { loads.set(r, c, loads.get(r, c) - l * loads.get(k, c)); });
      }
      give(1 / factor[size * r + r], loads.row(r), loads.row(r));
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
    const std::int32_t body = plan_.nodes[static_cast<std::size_t>(node.node)].body;
    return plan_.flexible[static_cast<std::size_t>(plan_.bodies[static_cast<std::size_t>(body)].flexible)];
  }
  static Spatial to_spatial(const double* six) { return {{six[0], six[1], six[2]}, {six[3], six[4], six[5]}}; }

  const Plan& plan_;
  Workspace& ws_;
  std::int32_t stride_;
  Columns<T> replies_;  // 7 rows of scratch behind the loads
};

template <int kWidest>
void reduce_loops(const Plan& plan, Workspace& ws) {
  LoopPass<Pack<kWidest>>(plan, ws).run();
}

// Takes what the row that was eliminated as number `pivot` explains out of the rows after it.
template <int kWidest>
void downdate_loops(const Plan& plan, Workspace& ws, int pivot) {
  const std::int32_t stride = plan.loop_columns;
  double* matrix = ws.loop_matrix.data();
  double* column = ws.loop_loads.data();  // free by now
  const double d = matrix[pivot * stride + pivot];
  for (int r = 0; r < stride; ++r) column[r] = r > pivot && r < ws.loop_count ? matrix[r * stride + pivot] : 0;
  add_outer<Pack<kWidest>>(matrix, stride, pivot + 1, ws.loop_count, -1 / d, column, column);
  for (int r = pivot + 1; r < ws.loop_count; ++r) matrix[r * stride + pivot] = column[r] / d;
}

}  // namespace unlatch::UNLATCH_ISA
