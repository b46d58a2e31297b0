// The block LDLᵀ of the KKT matrix [M −Gᵀ; −G 0] over the tree, in groups, in O(n), for any set of rows that hold.
// tests/support/scalar_solver.h has the same recursion one body at a time, with its derivation.
// Baraff 1996 (CMU-RI-TR-95-44) eliminates, leaves to root, a body block and then the block of its joint's multipliers.
// This is the same factorisation in closed form, by the rows or the freedoms of a joint, whichever are fewer. With A
// the block of a body and all outboard of it, in world axes at the body's own origin, a joint adds to its parent
//   three rows or more (k ≤ 3 freedoms s):  A − A S (Sᵀ A S)⁻¹ Sᵀ A       k rank-one downdates, one freedom at a time
//   one or two rows w:                       W (Wᵀ A⁻¹ W)⁻¹ Wᵀ            rank-one updates, rows made A⁻¹-orthogonal
//   none:                                    nothing
// shifted to the parent's origin, a translation. The multipliers come back in the forward pass as the wrench A a − b
// that crosses the joint. About 550 flop per revolute joint and body. Compiled once per instruction set, see
// kernel/simd/pack.h.
#pragma once

#include <bit>

#include "kernel/dynamics/varying.h"
#include "kernel/solver/flexible_solver.h"
#include "kernel/solver/prefetch.h"
#include "kernel/solver/single_freedom.h"

namespace unlatch::UNLATCH_ISA {

// --- Lanes held by one or two rows, or by none -----------------------------------------------------------------------

// Factors A itself, and keeps A⁻¹ b.
template <bool kFactor, class V, class N, class T>
UNLATCH_INLINE FreeFactorT<T> eliminate_free(const V& v, const N& node, T& bad) {
  auto& own = v.blocks.free();
  FreeFactorT<T> f;
  if constexpr (kFactor) {
    f = node.factor(bad);
    store(own.factor, f);
  } else {
    f = load<T>(own.factor);
  }
  store(own.response, node.solve(f, node.wrench));
  return f;
}

// Adds to `passed` what the rows pass on: each row, made A⁻¹-orthogonal to those before it, is an update of rank one.
template <bool kFactor, class V, class N, class T>
UNLATCH_INLINE void eliminate_rows(const V& v, const N& node, const SpatialT<T>& bias, Passed<T>& passed, T& bad) {
  T singular(0.0);
  const FreeFactorT<T> f = eliminate_free<kFactor>(v, node, singular);
  if (kFactor) bad = bad | (~load<T>(v.blocks.solver().by_freedoms) & singular);
  const SpatialT<T> free = load<T>(v.blocks.free().response);
  for (int r = 0; r < kRows; ++r) {
    if (!has_row(v.modes.rows, r)) continue;
    auto& own = v.blocks.row(r);
    if constexpr (kFactor) {
      const T mask = load<T>(own.mask);
      SpatialT<T> w = get_row_wrench(v, r), y = node.solve(f, w);
      for (int p = 0; p < r; ++p) {
        if (!has_row(v.modes.rows, p)) continue;
        const auto& other = v.blocks.row(p);
        const T k = dot(load<T>(other.response), w) * load<T>(other.inverse_pivot);
        w = w - k * load<T>(other.wrench);
        y = y - k * load<T>(other.response);
      }
      w = mask & w;
      y = mask & y;
      const T pivot = dot(w, y);
      bad = bad | (mask & ~(pivot > T(0.0)));
      const T inverse = mask & (T(1) / pivot);
      store(own.wrench, w);
      store(own.response, y);
      store(own.inverse_pivot, inverse);
      passed.A = downdated(passed.A, -inverse, w);
    }
    const SpatialT<T> w = load<T>(own.wrench);
    const T mu = load<T>(own.inverse_pivot) * dot(w, free - bias);
    store(own.mu, mu);
    passed.wrench = passed.wrench + mu * w;
  }
}

// --- Backward pass, leaves to root -----------------------------------------------------------------------------------

template <class T>
UNLATCH_INLINE ArticulatedT<T> operator&(const T& mask, const ArticulatedT<T>& A) {
  return {{mask & A.M.xx, mask & A.M.yy, mask & A.M.zz, mask & A.M.xy, mask & A.M.xz, mask & A.M.yz},
          {mask & A.H.x, mask & A.H.y, mask & A.H.z},
          {mask & A.I.xx, mask & A.I.yy, mask & A.I.zz, mask & A.I.xy, mask & A.I.xz, mask & A.I.yz}};
}

template <bool kLeaf, bool kFactor, class V, class T = typename V::T>
UNLATCH_INLINE void eliminate(const V& v, const Sweep& sweep, SiblingSums& sums, T& bad) {
  const Node<T, kLeaf> node(v, sweep.source);
  const SpatialT<T> bias = get_bias(v, sweep.biased);
  Passed<T> passed;
  if (v.modes.by_freedoms) {
    passed.wrench = node.wrench - node.times(bias);
    if constexpr (kFactor)
      factor_freedoms(v, node, sweep, passed, bad);
    else
      reduce_freedoms(v, passed.wrench);
    if (v.modes.by_rows) {
      const T mask = load<T>(v.blocks.solver().by_freedoms);
      passed.wrench = mask & passed.wrench;
      if constexpr (kFactor) passed.A = mask & passed.A;
    }
  } else {
    passed = get_nothing<T>();
  }
  if (v.modes.by_rows) eliminate_rows<kFactor>(v, node, bias, passed, bad);
  if (v.group.link == ParentLink::kRoot) return;
  if (v.modes.by_freedoms || v.modes.rows != 0)
    pass_to_parents<kFactor>(v, move<kFactor>(passed, load<T>(v.blocks.solver().offset)), sweep.source, sums);
  else if (v.group.siblings_begin || v.group.begins != kNone)  // begins the sums, with zero
    pass_to_parents<kFactor>(v, get_nothing<T>(), sweep.source, sums);
}

template <bool kLeaf, bool kFactor, class T, int kWidth>
[[gnu::noinline]] int eliminate_group(const PlanData& plan, Evaluation& ev, const Sweep& sweep, std::size_t g,
                                      SiblingSums& sums) {
  for (int lane = 0; lane < kWidth; lane += T::kWidth) {
    const GroupView<T, kWidth> v(plan, ev, g, lane);
    T bad(0.0);
    if (v.group.has_joint)
      eliminate<kLeaf, kFactor>(v, sweep, sums, bad);
    else
      (void)eliminate_free<kFactor>(v, Node<T, kLeaf>(v, sweep.source), bad);
    if (kFactor && any(bad)) return find_bad_node(plan, v.group, lane, bad);
  }
  return kNone;
}

// Actions of a sweep before and after each group, other than those on the tree: none.
struct NothingElse {
  UNLATCH_INLINE void before(std::size_t) const {}
  UNLATCH_INLINE void after(std::size_t) const {}
};

// Returns kNone, or the node whose pivot vanished.
template <int kWidest, bool kFactor, class Else = NothingElse>
UNLATCH_INLINE int sweep_back(const PlanData& plan, Evaluation& ev, const Sweep& sweep, const Else& other = {}) {
  SiblingSums sums;
  for (const std::int32_t g : plan.inner_groups) begin_block<kWidest, kFactor>(plan, ev, g, sweep.source);
  if (kFactor && !plan.rigid) add_varying_blocks(plan, ev);
  const bool far = is_far(plan);
  const std::span<const Group> groups = plan.groups;
  for (std::size_t g = groups.size(); g-- > 0;) {
    const Group& group = groups[g];
    if (far && g > 0) prefetch_block<-1>(plan, ev, g - 1);
    int node = kNone;
    other.before(g);
    if (group.kind != BodyKind::kRigid) {
      node = eliminate_flexible(plan, ev, sweep, group, kFactor);
      if (node != kNone) return node;
      continue;
    }
    for_width<kWidest>(group, [&]<class T, int kWidth>() {
      if (kFactor && group.has_joint && has_single_freedom(ev.modes[g]))
        node = group.leaf ? factor_single_freedom<true, T, kWidth>(plan, ev, sweep, g, sums)
                          : factor_single_freedom<false, T, kWidth>(plan, ev, sweep, g, sums);
      else
        node = group.leaf ? eliminate_group<true, kFactor, T, kWidth>(plan, ev, sweep, g, sums)
                          : eliminate_group<false, kFactor, T, kWidth>(plan, ev, sweep, g, sums);
    });
    if (kFactor && node != kNone) return node;
    if (group.siblings_end && !sums_in_registers<kWidest>(group))
      close_siblings<kWidest, kFactor>(plan, ev, group, sweep.source, sums);
    other.after(g);
  }
  return kNone;
}

// --- Forward pass, root to leaves ------------------------------------------------------------------------------------

// The wrench A a − b that the joint exerts on the child, as multipliers on its follower: 0 for rows that do not hold.
template <class V, class T>
UNLATCH_INLINE void store_multipliers(const V& v, const SpatialT<T>& on_child) {
  auto& solver = v.blocks.solver();
  const SpatialT<T> wrench = load<T>(v.constants.solver().side) * on_child;
  const Vec3T<T> moment = wrench.ang - cross(load<T>(solver.arm_child), wrench.lin);
  const Mat3T<T> n = load<T>(solver.axes);
  const Vec3T<T> along_n = transpose_times(n, wrench.lin);
  const Vec3T<T> about_m = transpose_times(v.group.shared_axes ? n : load<T>(v.blocks.rotation_axes()), moment);
  const T size[kRows] = {along_n.x, along_n.y, along_n.z, about_m.x, about_m.y, about_m.z};
  for (int r = 0; r < kRows; ++r) store(solver.multipliers[r], size[r]);
  const unsigned may_not_hold = v.modes.by_rows ? (1u << kRows) - 1 : v.modes.freedoms;
  for (unsigned left = may_not_hold; left != 0; left &= left - 1) {
    const int r = std::countr_zero(left);
    T holds = load<T>(solver.by_freedoms);
    if (has_row(v.group.freedoms, r)) holds = holds & ~load<T>(v.blocks.freedom(r).mask);
    if (has_row(v.group.rows, r)) holds = holds | load<T>(v.blocks.row(r).mask);
    store(solver.multipliers[r], holds & load<T>(solver.multipliers[r]));
  }
}

// Through the freedoms: a = X a_parent + Σ s q + bias.
template <class V, class T>
UNLATCH_INLINE SpatialT<T> substitute_freedoms(const V& v, const SpatialT<T>& carried, bool biased) {
  SpatialT<T> a = carried;
  for (unsigned left = v.modes.freedoms; left != 0;) {
    const int r = static_cast<int>(std::bit_width(left)) - 1;  // the last to be eliminated comes first
    left ^= 1u << r;
    auto& own = v.blocks.freedom(r);
    const T q = load<T>(own.inverse_pivot) * (load<T>(own.beta) - dot(load<T>(own.U), a));
    store(own.acceleration, q);
    a = with_freedom(v, r, [&](const auto& s) UNLATCH_INLINE_LAMBDA { return a + q * s; });
  }
  return biased ? a + load<T>(v.blocks.solver().bias) : a;
}

// Through the rows: a = A⁻¹ b + Σ y μ, with the rows' reaction μ once the parent's acceleration is known.
template <class V, class T>
UNLATCH_INLINE SpatialT<T> substitute_rows(const V& v, const SpatialT<T>& carried) {
  SpatialT<T> a = load<T>(v.blocks.free().response);
  for (int r = 0; r < kRows; ++r) {
    if (!has_row(v.modes.rows, r)) continue;
    const auto& own = v.blocks.row(r);
    const T mu = load<T>(own.inverse_pivot) * dot(load<T>(own.wrench), carried) - load<T>(own.mu);
    a = a + mu * load<T>(own.response);
  }
  return a;
}

template <bool kLeaf, class V, class T = typename V::T>
UNLATCH_INLINE void substitute_lanes(const V& v, const Sweep& sweep) {
  const T o(0.0);
  SpatialT<T> carried{{o, o, o}, {o, o, o}};
  if (v.group.link != ParentLink::kRoot) {
    carried = visit_parents(v, [](const auto& parents) { return load(parents, &SharedBlock<double>::acceleration); });
    carried = shift_motion(carried, load<T>(v.blocks.solver().offset));
  }
  SpatialT<T> a;
  if (v.modes.by_freedoms) {
    a = substitute_freedoms(v, carried, sweep.biased);
    if (v.modes.by_rows) {
      const SpatialT<T> others = substitute_rows(v, carried);
      const T mask = load<T>(v.blocks.solver().by_freedoms);
      a = {select(mask, a.lin, others.lin), select(mask, a.ang, others.ang)};
    }
  } else {
    a = substitute_rows(v, carried);
  }
  store(v.blocks.shared().acceleration, a);
  if (!sweep.multipliers || !v.group.has_joint) return;
  const Node<T, kLeaf> node(v, sweep.source);
  store_multipliers(v, node.times(a) - node.wrench);
}

template <bool kLeaf, class T, int kWidth>
[[gnu::noinline]] void substitute_group(const PlanData& plan, Evaluation& ev, const Sweep& sweep, std::size_t g) {
  for (int lane = 0; lane < kWidth; lane += T::kWidth)
    substitute_lanes<kLeaf>(GroupView<T, kWidth>(plan, ev, g, lane), sweep);
}

template <int kWidest, class Else = NothingElse>
UNLATCH_INLINE void sweep_forth(const PlanData& plan, Evaluation& ev, const Sweep& sweep, const Else& other = {}) {
  const bool far = is_far(plan);
  const std::span<const Group> groups = plan.groups;
  for (std::size_t g = 0; g < groups.size(); ++g) {
    const Group& group = groups[g];
    if (far && g + 1 < groups.size()) prefetch_block<+1>(plan, ev, g + 1);
    other.before(g);
    if (group.kind != BodyKind::kRigid) {
      substitute_flexible(plan, ev, sweep, group);
      continue;
    }
    for_width<kWidest>(group, [&]<class T, int kWidth>() {
      if (group.leaf)
        substitute_group<true, T, kWidth>(plan, ev, sweep, g);
      else
        substitute_group<false, T, kWidth>(plan, ev, sweep, g);
    });
    other.after(g);
  }
}

}  // namespace unlatch::UNLATCH_ISA
