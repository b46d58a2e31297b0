// The block LDLᵀ of the KKT matrix [M −Gᵀ; −G 0] over the tree, on lanes, in O(n), for whatever rows hold.
//
// Baraff 1996 (CMU-RI-TR-95-44) eliminates, leaves to root, a body block and then the block of its joint's multipliers.
// The same factorisation in closed form, by whichever side of the joint is smaller. With A the block of a body and all
// beyond it, in world axes at the body's own origin, a joint adds to its parent
//   three rows or more (k ≤ 3 freedoms s):  A − A S (Sᵀ A S)⁻¹ Sᵀ A       k rank-one downdates, one freedom at a time
//   one or two rows w:                       W (Wᵀ A⁻¹ W)⁻¹ Wᵀ            rank-one updates, rows made A⁻¹-orthogonal
//   none:                                    nothing
// shifted to the parent's origin, a translation. The multipliers come back on the way down as the wrench A a − b that
// crosses the joint. About 550 flop per revolute joint and body. Compiled once per instruction set, see pack.h.
#pragma once

#include "kernel/dynamics/flexible.h"
#include "kernel/dynamics/lane_stages.h"
#include "kernel/dynamics/varying.h"
#include "kernel/simd/arctangent_packs.h"
#include "kernel/solver/lane_loops.h"
#include "kernel/solver/lane_node.h"
#include "kernel/solver/lane_parents.h"

namespace unlatch::UNLATCH_ISA {

// Whether the lanes are more than caches hold, 32 MiB: within them asking costs more than waiting.
inline bool is_far(const Plan& plan) { return plan.lane_numbers > (32 << 20) / 8; }

// Asks for a block of the solver's before its turn, in the direction in which the sweep goes through the memory: a
// processor foresees a stream of lines that rise or fall one by one, and of no others.
template <int kDirection>
UNLATCH_INLINE void prefetch_block(const Plan& plan, const Workspace& ws, std::size_t g) {
  const LaneGroup& group = plan.groups[g];
  const double* block = ws.lanes.data() + group.data;
  // The first group of an octet has what they share with the bodies before its own.
  const bool first_of_octet = group.shared % kOctet == 0;
  const int first = (group.leaf ? 0 : kBlock * group.width) - (first_of_octet ? kSharedEnd * kOctet : 0);
  const int end = group.size * group.width;
  for (int i = first; i < end; i += 8) __builtin_prefetch(block + (kDirection > 0 ? i : first + end - 1 - i), 1);
}

// What nothing holds, or what one or two rows are to hold: factors A itself, and keeps A⁻¹ b.
template <bool kFactor, class P, class N, class T>
UNLATCH_INLINE FreeFactorT<T> eliminate_free(const P& part, const N& node, T& bad) {
  const auto own = part.v.from(part.group.free);
  FreeFactorT<T> f;
  if constexpr (kFactor) {
    f = node.factor(bad);
    set_factor(own, f);
  } else {
    f = get_factor(own);
  }
  own.set(21, node.solve(f, node.load));
  return f;
}

// Lanes held by one or two rows or by none: each row in turn, made A⁻¹-orthogonal to those before it, is an update of
// rank one. Adds what the rows pass on.
template <bool kFactor, class P, class N, class T>
UNLATCH_INLINE void eliminate_rows(const P& part, const N& node, const SpatialT<T>& bias, Passed<T>& passed, T& bad) {
  const auto& v = part.v;
  T singular(0.0);
  const FreeFactorT<T> f = eliminate_free<kFactor>(part, node, singular);
  if (kFactor) bad = bad | (~v.get(kHeld) & singular);
  const SpatialT<T> free = v.get_spatial(part.group.free + 21);
  for (int r = 0; r < kRows; ++r) {
    if (!has_row(part.phase.rows, r)) continue;
    const auto own = v.from(part.group.row_parts[r]);
    if constexpr (kFactor) {
      const T mask = own.get(kRowMask);
      SpatialT<T> w = part.get_wrench(r), y = node.solve(f, w);
      for (int p = 0; p < r; ++p) {
        if (!has_row(part.phase.rows, p)) continue;
        const auto other = v.from(part.group.row_parts[p]);
        const T k = dot(other.get_spatial(kReply), w) * other.get(kRowInverse);
        w = w - k * other.get_spatial(kWrench);
        y = y - k * other.get_spatial(kReply);
      }
      w = mask & w;
      y = mask & y;
      const T pivot = dot(w, y);
      bad = bad | (mask & ~(pivot > T(0.0)));
      const T inverse = mask & (T(1) / pivot);
      own.set(kWrench, w);
      own.set(kReply, y);
      own.set(kRowInverse, inverse);
      passed.A = downdated(passed.A, -inverse, w);
    }
    const SpatialT<T> w = own.get_spatial(kWrench);
    const T mu = own.get(kRowInverse) * dot(w, free - bias);
    own.set(kMu, mu);
    passed.load = passed.load + mu * w;
  }
}

template <class T>
UNLATCH_INLINE SpatialT<T> to_spatial(const SlideT<T>& a) {
  const T o(0.0);
  return {a.lin, {o, o, o}};
}
template <class T>
UNLATCH_INLINE const SpatialT<T>& to_spatial(const SpatialT<T>& a) {
  return a;
}

// Takes freedom r out, whose direction is s and whose U = A s. Returns its inverse pivot: zero in lanes where it is no
// freedom, so that they lose nothing.
template <class P, class N, class S, class U, class T>
UNLATCH_INLINE T take_freedom(const P& part, const N& node, int r, const S& s, const U& u, SpatialT<T>& load, T& bad) {
  const auto own = part.v.from(part.group.freedom_parts[r]);
  const T mask = own.get(kMask), beta = dot(s, load);
  T pivot = dot(s, u);
  bad = bad | (mask & ~node.is_pivot(pivot, s));
  if (has_row(part.group.compliant, r)) pivot = pivot + part.v.get(part.group.pivots[r]);
  const T inverse = mask & (T(1) / pivot);
  own.set(kBeta, beta);
  own.set(kU, to_spatial(u));
  own.set(kInverse, inverse);
  load = load - (beta * inverse) * u;
  return inverse;
}
// Out of a whole block, which may be sparse; returns what is left of it, which may be so as well.
template <class P, class N, class S, class T>
UNLATCH_INLINE auto take_first(const P& part, const N& node, int r, const S& s, SpatialT<T>& load, T& bad) {
  const auto u = node.times(s);
  return node.downdated(take_freedom(part, node, r, s, u, load, bad), u);
}
// Out of what others have left, and those after it in turn, until none is left.
template <class P, class N, class A, class T>
UNLATCH_INLINE void take_others(const P& part, const N& node, unsigned left, const A& rest, Passed<T>& passed, T& bad) {
  if (left == 0) {
    passed.A = get_whole(rest);
    return;
  }
  const int r = std::countr_zero(left);
  part.with_freedom(r, [&](const auto& s) UNLATCH_INLINE_LAMBDA {
    const auto u = rest * s;
    const T inverse = take_freedom(part, node, r, s, u, passed.load, bad);
    passed.A = get_whole(downdated(rest, inverse, u));
  });
  while ((left &= left - 1) != 0) {
    const int next = std::countr_zero(left);
    part.with_freedom(next, [&](const auto& s) UNLATCH_INLINE_LAMBDA {
      const auto u = passed.A * s;
      const T inverse = take_freedom(part, node, next, s, u, passed.load, bad);
      passed.A = downdated(passed.A, inverse, u);
    });
  }
}

// Lanes held by three rows or more: takes their freedoms out one by one.
template <class P, class N, class T>
UNLATCH_INLINE void factor_freedoms(const P& part, const N& node, Passed<T>& passed, T& bad) {
  const unsigned left = part.phase.freedoms;
  if (left == 0) {
    passed.A = node.get_block();
    return;
  }
  const int r = std::countr_zero(left);
  part.with_freedom(r, [&](const auto& s) UNLATCH_INLINE_LAMBDA {
    const auto rest = take_first(part, node, r, s, passed.load, bad);
    take_others(part, node, left & (left - 1), rest, passed, bad);
  });
}
// The same for another load.
template <class P, class T>
UNLATCH_INLINE void reduce_freedoms(const P& part, SpatialT<T>& load) {
  for (unsigned left = part.phase.freedoms; left != 0; left &= left - 1) {
    const int r = std::countr_zero(left);
    const auto own = part.v.from(part.group.freedom_parts[r]);
    const T beta = part.with_freedom(r, [&](const auto& s) UNLATCH_INLINE_LAMBDA { return dot(s, load); });
    own.set(kBeta, beta);
    load = load - (beta * own.get(kInverse)) * own.get_spatial(kU);
  }
}

// --- Leaves to root -------------------------------------------------------------------------------------------------

template <class T>
UNLATCH_INLINE ArticulatedT<T> operator&(const T& mask, const ArticulatedT<T>& A) {
  return {{mask & A.M.xx, mask & A.M.yy, mask & A.M.zz, mask & A.M.xy, mask & A.M.xz, mask & A.M.yz},
          {mask & A.H.x, mask & A.H.y, mask & A.H.z},
          {mask & A.I.xx, mask & A.I.yy, mask & A.I.zz, mask & A.I.xy, mask & A.I.xz, mask & A.I.yz}};
}

template <bool kLeaf, bool kFactor, class T, int kWidth>
UNLATCH_INLINE void eliminate(const Part<T, kWidth>& part, const Sweep& sweep, FanSums& fan, T& bad) {
  const Node<T, kLeaf> node(part, sweep.source);
  const SpatialT<T> bias = part.get_bias(sweep.biased);
  Passed<T> passed;
  if (part.phase.held) {
    passed.load = node.load - node.times(bias);
    if constexpr (kFactor)
      factor_freedoms(part, node, passed, bad);
    else
      reduce_freedoms(part, passed.load);
    if (part.phase.loose) {
      const T held = part.v.get(kHeld);
      passed.load = held & passed.load;
      if constexpr (kFactor) passed.A = held & passed.A;
    }
  } else {
    const T o(0.0);
    passed = {get_body_block(o, Sym3T<T>{o, o, o, o, o, o}), {{o, o, o}, {o, o, o}}};
  }
  if (part.phase.loose) eliminate_rows<kFactor>(part, node, bias, passed, bad);
  if (part.group.link == LaneLink::kRoot) return;
  if (part.phase.held || part.phase.rows != 0)
    add_to_parents<kFactor>(part, passed, sweep.source, fan);
  else
    add_nothing<kFactor>(part, sweep.source, fan);
}

// The first lane whose pivot vanished, as a node.
template <class T>
inline int find_bad_node(const Plan& plan, const LaneGroup& group, int lane, const T& bad) {
  std::int64_t bits[T::kWidth];
  __builtin_memcpy(bits, &bad.v, sizeof(bits));
  for (int i = 0; i < T::kWidth; ++i)
    if (bits[i] != 0) return plan.lane_nodes[static_cast<std::size_t>(group.first + lane + i)];
  return kNone;
}

// The common case by itself, the same sums in the same order, without branches between them: LanePhase::hinged.
template <bool kLeaf, class T, int kWidth>
[[gnu::noinline]] int factor_hinges(const Plan& plan, Workspace& ws, const Sweep& sweep, std::size_t g, FanSums& fan) {
  const int r = std::countr_zero(ws.phases[g].freedoms);
  for (int lane = 0; lane < kWidth; lane += T::kWidth) {
    const Part<T, kWidth> part(plan, ws, g, lane);
    const Node<T, kLeaf> node(part, sweep.source);
    T bad(0.0);
    Passed<T> passed;
    passed.load = node.load - node.times(part.get_bias(sweep.biased));
    part.with_freedom(r, [&](const auto& s) UNLATCH_INLINE_LAMBDA {
      passed.A = get_whole(take_first(part, node, r, s, passed.load, bad));
    });
    if (any(bad)) return find_bad_node(plan, part.group, lane, bad);
    if (part.group.link != LaneLink::kRoot) add_to_parents<true>(part, passed, sweep.source, fan);
  }
  return kNone;
}

template <bool kLeaf, bool kFactor, class T, int kWidth>
[[gnu::noinline]] int eliminate_group(const Plan& plan, Workspace& ws, const Sweep& sweep, std::size_t g,
                                      FanSums& fan) {
  for (int lane = 0; lane < kWidth; lane += T::kWidth) {
    const Part<T, kWidth> part(plan, ws, g, lane);
    T bad(0.0);
    if (part.group.has_joint)
      eliminate<kLeaf, kFactor>(part, sweep, fan, bad);
    else
      (void)eliminate_free<kFactor>(part, Node<T, kLeaf>(part, sweep.source), bad);
    if (kFactor && any(bad)) return find_bad_node(plan, part.group, lane, bad);
  }
  return kNone;
}

template <int kWidest, bool kFactor>
UNLATCH_INLINE int sweep_up(const Plan& plan, Workspace& ws, const Sweep& sweep) {
  FanSums fan;
  begin_blocks<kWidest, kFactor>(plan, ws, sweep);
  if (kFactor && !plan.rigid) add_varying_blocks(plan, ws);
  const bool far = is_far(plan);
  for (std::size_t g = plan.groups.size(); g-- > 0;) {
    const LaneGroup& group = plan.groups[g];
    if (far && g > 0) prefetch_block<-1>(plan, ws, g - 1);
    int node = kNone;
    if (group.special != LaneSpecial::kOrdinary) {
      node = eliminate_special(plan, ws, sweep, group, kFactor);
      if (node != kNone) return node;
      continue;
    }
    for_width<kWidest>(group, [&]<class T, int kWidth>() {
      if (kFactor && ws.phases[g].hinged)
        node = group.leaf ? factor_hinges<true, T, kWidth>(plan, ws, sweep, g, fan)
                          : factor_hinges<false, T, kWidth>(plan, ws, sweep, g, fan);
      else
        node = group.leaf ? eliminate_group<true, kFactor, T, kWidth>(plan, ws, sweep, g, fan)
                          : eliminate_group<false, kFactor, T, kWidth>(plan, ws, sweep, g, fan);
    });
    if (kFactor && node != kNone) return node;
    if (group.fan_ends && !is_four<kWidest>(group)) close_fan<kWidest, kFactor>(plan, ws, group, sweep.source, fan);
  }
  return kNone;
}

template <int kWidest>
int factor_and_reduce(const Plan& plan, Workspace& ws, const Sweep& sweep) {
  return sweep_up<kWidest, true>(plan, ws, sweep);
}
template <int kWidest>
void reduce(const Plan& plan, Workspace& ws, const Sweep& sweep) {
  (void)sweep_up<kWidest, false>(plan, ws, sweep);
}

// --- Root to leaves -------------------------------------------------------------------------------------------------

// The wrench A a − b that the joint puts on the child, as multipliers on its follower: 0 for rows that do not hold.
template <class P, class T>
UNLATCH_INLINE void set_multipliers(const P& part, const SpatialT<T>& on_child) {
  const auto& v = part.v;
  const SpatialT<T> wrench = part.c.get(kSide) * on_child;
  const Vec3T<T> moment = wrench.ang - cross(v.get_vec(kArmChild), wrench.lin);
  const Mat3T<T> n = v.get_mat(kAxes);
  const Vec3T<T> along_n = transpose_times(n, wrench.lin);
  const Vec3T<T> about_m = transpose_times(part.group.shared_axes ? n : v.get_mat(part.group.rotation_axes), moment);
  v.set(kMultipliers, along_n);
  v.set(kMultipliers + 3, about_m);
  if (part.phase.hinged) {
    const int r = std::countr_zero(part.phase.freedoms);
    return v.set(kMultipliers + r, ~v.get(part.group.freedom_parts[r] + kMask) & v.get(kMultipliers + r));
  }
  for (int r = 0; r < kRows; ++r) {
    const bool may_be_free = has_row(part.group.freedoms, r);
    if (!may_be_free && !part.group.may_be_loose) continue;
    T holds = v.get(kHeld);
    if (may_be_free) holds = holds & ~v.get(part.group.freedom_parts[r] + kMask);
    if (has_row(part.group.rows, r)) holds = holds | v.get(part.group.row_parts[r] + kRowMask);
    v.set(kMultipliers + r, holds & v.get(kMultipliers + r));
  }
}

// Through the freedoms: a = X a_parent + Σ s q + bias.
template <class P, class T>
UNLATCH_INLINE SpatialT<T> substitute_freedom(const P& part, int r, const SpatialT<T>& a) {
  const auto own = part.v.from(part.group.freedom_parts[r]);
  const T q = own.get(kInverse) * (own.get(kBeta) - dot(own.get_spatial(kU), a));
  own.set(kBeta, q);
  return part.with_freedom(r, [&](const auto& s) UNLATCH_INLINE_LAMBDA { return a + q * s; });
}
template <class P, class T>
UNLATCH_INLINE SpatialT<T> substitute_freedoms(const P& part, const SpatialT<T>& carried, bool biased) {
  SpatialT<T> a = carried;
  if (part.phase.hinged) {
    a = substitute_freedom(part, std::countr_zero(part.phase.freedoms), a);
  } else {
    for (int r = kRows - 1; r >= 0; --r)
      if (has_row(part.phase.freedoms, r)) a = substitute_freedom(part, r, a);
  }
  return biased ? a + part.v.get_spatial(kBias) : a;
}

// Through the rows: a = A⁻¹ b + Σ y μ, with the rows' reaction μ once the parent's acceleration is known.
template <class P, class T>
UNLATCH_INLINE SpatialT<T> substitute_rows(const P& part, const SpatialT<T>& carried) {
  SpatialT<T> a = part.v.get_spatial(part.group.free + 21);
  for (int r = 0; r < kRows; ++r) {
    if (!has_row(part.phase.rows, r)) continue;
    const auto own = part.v.from(part.group.row_parts[r]);
    const T mu = own.get(kRowInverse) * dot(own.get_spatial(kWrench), carried) - own.get(kMu);
    a = a + mu * own.get_spatial(kReply);
  }
  return a;
}

template <bool kLeaf, class T, int kWidth>
UNLATCH_INLINE void substitute_part(const Part<T, kWidth>& part, const Sweep& sweep) {
  const T o(0.0);
  SpatialT<T> carried{{o, o, o}, {o, o, o}};
  if (part.group.link != LaneLink::kRoot) {
    carried = Parents<T>{part.group.link, part.lanes, part.parents}.visit(
        [](const auto& from) { return get_spatial(from, kAcceleration); });
    carried.lin += cross(carried.ang, part.v.get_vec(kOffset));
  }
  SpatialT<T> a;
  if (part.phase.held) {
    a = substitute_freedoms(part, carried, sweep.biased);
    if (part.phase.loose) {
      const SpatialT<T> loose = substitute_rows(part, carried);
      const T held = part.v.get(kHeld);
      a = {select(held, a.lin, loose.lin), select(held, a.ang, loose.ang)};
    }
  } else {
    a = substitute_rows(part, carried);
  }
  if (!sweep.multipliers || !part.group.has_joint) return part.v.set(kAcceleration, a);
  const Node<T, kLeaf> node(part, sweep.source);  // the source may lie where the result goes
  part.v.set(kAcceleration, a);
  set_multipliers(part, node.times(a) - node.load);
}

template <bool kLeaf, class T, int kWidth>
[[gnu::noinline]] void substitute_group(const Plan& plan, Workspace& ws, const Sweep& sweep, std::size_t g) {
  for (int lane = 0; lane < kWidth; lane += T::kWidth)
    substitute_part<kLeaf>(Part<T, kWidth>(plan, ws, g, lane), sweep);
}

template <int kWidest>
void substitute(const Plan& plan, Workspace& ws, const Sweep& sweep) {
  const bool far = is_far(plan);
  for (std::size_t g = 0; g < plan.groups.size(); ++g) {
    const LaneGroup& group = plan.groups[g];
    if (far && g + 1 < plan.groups.size()) prefetch_block<+1>(plan, ws, g + 1);
    if (group.special != LaneSpecial::kOrdinary) {
      substitute_special(plan, ws, sweep, group);
      continue;
    }
    for_width<kWidest>(group, [&]<class T, int kWidth>() {
      if (group.leaf)
        substitute_group<true, T, kWidth>(plan, ws, sweep, g);
      else
        substitute_group<false, T, kWidth>(plan, ws, sweep, g);
    });
  }
}

template <int kWidest>
constexpr LaneKernels build_kernels(Lanes lanes) {
  return {lanes,
          update_kinematics<kWidest>,
          update_rates<kWidest>,
          init_forces<kWidest>,
          update_joints<kWidest>,
          renew_joints<kWidest>,
          calc_angles<kWidest>,
          factor_and_reduce<kWidest>,
          reduce<kWidest>,
          substitute<kWidest>,
          reduce_loops<kWidest>,
          downdate_loops<kWidest>,
          keep_start<kWidest>,
          begin_stages<kWidest>,
          advance_stage<kWidest>,
          finish_stages<kWidest>,
          restart<kWidest>,
          finish_first_stage<kWidest>,
          finish_second_stage<kWidest>,
          add_displacements<kWidest>,
          add_velocities<kWidest>};
}

}  // namespace unlatch::UNLATCH_ISA
