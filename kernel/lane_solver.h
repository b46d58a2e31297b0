// The block LDLᵀ of the KKT matrix [M −Gᵀ; −G 0] over the tree, on lanes, in O(n), for whatever rows hold.
//
// Baraff 1996 (CMU-RI-TR-95-44) eliminates, leaves to root, a body block and then the block of its joint's multipliers.
// The same factorisation in closed form, by whichever side of the joint is smaller. With A the block of a body and all
// beyond it, in world axes at the body's own origin, a joint adds to its parent
//   three rows or more (k ≤ 3 freedoms s):  A − A S (Sᵀ A S)⁻¹ Sᵀ A       k rank-one downdates, one freedom at a time
//   one or two rows w:                       W (Wᵀ A⁻¹ W)⁻¹ Wᵀ            rank-one updates, rows made A⁻¹-orthogonal
//   none:                                    nothing
// shifted to the parent's origin, a translation. An implicit spring along a freedom adds κ to sᵀ A s: a row with
// compliance, without fill. The multipliers come back on the way down as the wrench A a − b that crosses the joint.
// About 550 flop per revolute joint and body. Compiled once per instruction set, see pack.h.
#pragma once

#include "kernel/lane_motion.h"

namespace unlatch::UNLATCH_ISA {

// A pivot this small beside what it was before the joint's other freedoms were taken out is rounding noise.
inline constexpr double kSingular = 1e-13;

template <class T>
UNLATCH_INLINE const Vec3T<T>& get_axis(const Mat3T<T>& axes, int r) {
  return r % 3 == 0 ? axes.x : (r % 3 == 1 ? axes.y : axes.z);
}

// The body's block and load, with what its children have added.
template <class T, bool kLeaf>
struct Node {
  T mass;  // kLeaf: A is diag(mass, I)
  ArticulatedT<T> A;
  SpatialT<T> load;

  UNLATCH_INLINE SpatialT<T> times(const SpatialT<T>& a) const {
    if constexpr (kLeaf) return {mass * a.lin, A.I * a.ang};
    return A * a;
  }
};

template <class T>
UNLATCH_INLINE SpatialT<T> get_zero() {
  const T o(0.0);
  return {{o, o, o}, {o, o, o}};
}

template <class T>
UNLATCH_INLINE SpatialT<T> get_source(const View<T>& v, Source source) {
  if (source == Source::kForces) return v.get_spatial(kForce);
  if (source == Source::kGiven) return v.get_spatial(kAcceleration);
  return get_zero<T>();
}

template <class T>
UNLATCH_INLINE ArticulatedT<T> get_block(const View<T>& v) {
  return {v.get_sym(0), v.get_mat(6), v.get_sym(15)};
}
template <class T>
UNLATCH_INLINE void set_block(const View<T>& v, const ArticulatedT<T>& A) {
  v.set(0, A.M);
  v.set(6, A.H);
  v.set(15, A.I);
}

template <bool kLeaf, class T>
UNLATCH_INLINE Node<T, kLeaf> get_node(const View<T>& v, const View<T, const double>& c, Source source) {
  Node<T, kLeaf> node;
  if constexpr (kLeaf) {
    node.mass = c.get(kMass);
    node.A.I = v.get_sym(kInertia);
    node.load = get_source(v, source);
  } else {
    node.A = get_block(v.from(kBlock));
    node.load = v.get_spatial(kBlock + 21);
  }
  return node;
}

template <class T>
UNLATCH_INLINE ArticulatedT<T> get_body_block(const T& mass, const Sym3T<T>& inertia) {
  const T o(0.0);
  return {{mass, mass, mass, o, o, o}, {{o, o, o}, {o, o, o}, {o, o, o}}, inertia};
}

// Direction of freedom r at the child's origin.
template <class T>
UNLATCH_INLINE SpatialT<T> get_freedom(int r, const Mat3T<T>& axes, const Vec3T<T>& arm) {
  const Vec3T<T>& axis = get_axis(axes, r);
  if (r < kRotX) return {axis, {T(0.0), T(0.0), T(0.0)}};
  return {cross(arm, axis), axis};
}

// Wrench of row r on the child, at its origin.
template <class T>
UNLATCH_INLINE SpatialT<T> get_wrench(int r, const Mat3T<T>& axes, const Vec3T<T>& arm) {
  const Vec3T<T>& axis = get_axis(axes, r);
  if (r < kRotX) return {axis, cross(arm, axis)};
  return {{T(0.0), T(0.0), T(0.0)}, axis};
}

template <class T>
UNLATCH_INLINE Mat3T<T> get_axes(const LaneGroup& group, const View<T>& v, int r) {
  return v.get_mat(r < kRotX ? static_cast<int>(kAxes) : group.rotation_axes);
}
template <class T>
UNLATCH_INLINE Vec3T<T> get_arm(const LaneGroup& group, const View<T>& v) {
  return v.get_vec(group.child_is_base ? kArmBase : kArmFollower);
}

// --- The block of a body that nothing, or little, holds -------------------------------------------------------------

// LDLᵀ of a symmetric 3×3 by its leading minors, whose three divisions do not wait for each other. `bad`: lanes where a
// pivot vanished beside the diagonal entry that it came from.
template <class T>
UNLATCH_INLINE Factor3T<T> factor3(const Sym3T<T>& s, const Sym3T<T>& whole, T& bad) {
  const T d2 = s.xx * s.yy - s.xy * s.xy, e = s.xx * s.yz - s.xz * s.xy;
  const T d3 = (s.zz * d2 - s.yz * e) - s.xz * (s.yy * s.xz - s.xy * s.yz);
  const T tiny(kSingular);
  bad = bad | ~(s.xx > tiny * whole.xx) | ~(d2 > (tiny * s.xx) * whole.yy) | ~(d3 > (tiny * d2) * whole.zz);
  const T i0 = T(1) / s.xx, r2 = T(1) / d2, r3 = T(1) / d3;
  return {s.xy * i0, s.xz * i0, e * r2, i0, s.xx * r2, d2 * r3};
}

template <class T>
UNLATCH_INLINE void set_factor(const View<T>& v, const FreeFactorT<T>& f) {
  v.set(0, Vec3T<T>{f.M.l10, f.M.l20, f.M.l21});
  v.set(3, Vec3T<T>{f.M.i0, f.M.i1, f.M.i2});
  v.set(6, f.W);
  v.set(15, Vec3T<T>{f.K.l10, f.K.l20, f.K.l21});
  v.set(18, Vec3T<T>{f.K.i0, f.K.i1, f.K.i2});
}
template <class T>
UNLATCH_INLINE FreeFactorT<T> get_factor(const View<T>& v) {
  return {{v.get(0), v.get(1), v.get(2), v.get(3), v.get(4), v.get(5)},
          v.get_mat(6),
          {v.get(15), v.get(16), v.get(17), v.get(18), v.get(19), v.get(20)}};
}

template <class T>
UNLATCH_INLINE FreeFactorT<T> factor_free(const ArticulatedT<T>& A, T& bad) {
  FreeFactorT<T> f;
  f.M = factor3(A.M, A.M, bad);
  f.W = {solve(f.M, A.H.x), solve(f.M, A.H.y), solve(f.M, A.H.z)};
  const Mat3T<T>& W = f.W;
  const Sym3T<T> K{A.I.xx - dot(A.H.x, W.x), A.I.yy - dot(A.H.y, W.y), A.I.zz - dot(A.H.z, W.z),
                   A.I.xy - dot(A.H.x, W.y), A.I.xz - dot(A.H.x, W.z), A.I.yz - dot(A.H.y, W.z)};
  f.K = factor3(K, A.I, bad);
  return f;
}

// A⁻¹ b = (y − W α, α) with α = K⁻¹ (b.ang − Wᵀ b.lin), y = M⁻¹ b.lin.
template <class T>
UNLATCH_INLINE SpatialT<T> solve_free(const FreeFactorT<T>& f, const SpatialT<T>& b) {
  const Vec3T<T> ang = solve(f.K, b.ang - transpose_times(f.W, b.lin));
  return {solve(f.M, b.lin) - f.W * ang, ang};
}

// What a joint passes to its parent, at the child's origin.
template <class T>
struct Passed {
  ArticulatedT<T> A;
  SpatialT<T> load;
};

// A + k w wᵀ
template <class T>
UNLATCH_INLINE void update(ArticulatedT<T>& A, const T& k, const SpatialT<T>& w) {
  downdate(A, -k, w);
}

// Lanes held by one or two rows or by none: factors A itself; each row in turn, made A⁻¹-orthogonal to those before it,
// is an update of rank one. Adds what the rows pass on.
template <bool kFactor, class T>
UNLATCH_INLINE void eliminate_rows(const LaneGroup& group, const LanePhase& phase, const View<T>& v,
                                   const ArticulatedT<T>& A, const SpatialT<T>& load, const SpatialT<T>& bias,
                                   Passed<T>& passed, T& bad) {
  FreeFactorT<T> f;
  if constexpr (kFactor) {
    T singular(0.0);
    f = factor_free(A, singular);
    bad = bad | (group.has_joint ? ~v.get(kHeld) & singular : singular);
    set_factor(v.from(group.free), f);
  } else {
    f = get_factor(v.from(group.free));
  }
  const SpatialT<T> free = solve_free(f, load);
  v.set(group.free + 21, free);
  if (phase.rows == 0) return;
  const Vec3T<T> arm = get_arm(group, v);
  int part = group.row_parts;
  for (int r = 0; r < kRows; ++r) {
    if (!has_row(group.rows, r)) continue;
    const View<T> own = v.from(part);
    part += kRowEnd;
    if (!has_row(phase.rows, r)) continue;
    if constexpr (kFactor) {
      const T mask = own.get(kRowMask);
      SpatialT<T> w = get_wrench(r, get_axes(group, v, r), arm), y = solve_free(f, w);
      for (int before = group.row_parts, p = 0; p < r; ++p) {
        if (!has_row(group.rows, p)) continue;
        if (has_row(phase.rows, p)) {
          const View<T> other = v.from(before);
          const T k = dot(other.get_spatial(kReply), w) * other.get(kRowInverse);
          w = w - k * other.get_spatial(kWrench);
          y = y - k * other.get_spatial(kReply);
        }
        before += kRowEnd;
      }
      w = mask & w;
      y = mask & y;
      const T pivot = dot(w, y);
      bad = bad | (mask & ~(pivot > T(0.0)));
      const T inverse = mask & (T(1) / pivot);
      own.set(kWrench, w);
      own.set(kReply, y);
      own.set(kRowInverse, inverse);
      update(passed.A, inverse, w);
    }
    const SpatialT<T> w = own.get_spatial(kWrench);
    const T mu = own.get(kRowInverse) * dot(w, free - bias);
    own.set(kMu, mu);
    passed.load = passed.load + mu * w;
  }
}

// Lanes held by three rows or more: takes their freedoms out one by one.
template <bool kLeaf, bool kFactor, class T>
UNLATCH_INLINE Passed<T> eliminate_freedoms(const LaneGroup& group, const LanePhase& phase, const View<T>& v,
                                            const Node<T, kLeaf>& node, const SpatialT<T>& load, T& bad) {
  Passed<T> passed;
  passed.load = load;
  bool whole = true;  // nothing has been taken out yet
  if constexpr (kFactor) passed.A = kLeaf ? get_body_block(node.mass, node.A.I) : node.A;
  const ArticulatedT<T> before = passed.A;
  const Vec3T<T> arm = get_arm(group, v);
  int part = group.freedom_parts;
  for (int r = 0; r < kRows; ++r) {
    if (!has_row(group.freedoms, r)) continue;
    const View<T> own = v.from(part);
    part += kFreedomEnd;
    if (!has_row(phase.freedoms, r)) continue;
    const SpatialT<T> s = get_freedom(r, get_axes(group, v, r), arm);
    SpatialT<T> U;
    T inverse;
    if constexpr (kFactor) {
      const T mask = own.get(kMask);
      U = whole ? node.times(s) : passed.A * s;
      whole = false;
      const T pivot = dot(s, U);
      bad = bad | (mask & ~(pivot > T(kSingular) * calc_pivot_scale(before, s)));
      inverse = mask & (T(1) / (pivot + own.get(kKappa)));
      U = mask & U;
      own.set(kU, U);
      own.set(kInverse, inverse);
      downdate(passed.A, inverse, U);
    } else {
      U = own.get_spatial(kU);
      inverse = own.get(kInverse);
    }
    const T beta = dot(s, passed.load);
    own.set(kBeta, beta);
    passed.load = passed.load - (beta * inverse) * U;
  }
  return passed;
}

// --- To the parents -------------------------------------------------------------------------------------------------

// Sums over the children of one parent: eight partial sums, child k in the (k mod 8)-th, then a fixed tree.
struct FanSums {
  double numbers[kBlockFields * 8];
};

template <class T>
UNLATCH_INLINE void add_row(const LaneGroup& group, int lane, double* lanes, const LaneSlot* slots, int row, const T& a,
                            FanSums& fan) {
  if (group.link == LaneLink::kFan) {
    double* sum = fan.numbers + row * 8 + lane;
    store(sum, load<T>(sum) + a);
  } else if (group.link == LaneLink::kContiguous) {
    double* sum = lanes + slots[0].offset + (kBlock + row) * slots[0].stride;
    store(sum, load<T>(sum) + a);
  } else {
    double each[T::kWidth];
    store(each, a);
    for (int i = 0; i < T::kWidth; ++i) lanes[slots[i].offset + (kBlock + row) * slots[i].stride] += each[i];
  }
}

template <class T>
UNLATCH_INLINE void add_spatial(const LaneGroup& group, int lane, double* lanes, const LaneSlot* slots,
                                const SpatialT<T>& a, FanSums& fan) {
  const T values[6] = {a.lin.x, a.lin.y, a.lin.z, a.ang.x, a.ang.y, a.ang.z};
  for (int i = 0; i < 6; ++i) add_row(group, lane, lanes, slots, 21 + i, values[i], fan);
}

template <class T>
UNLATCH_INLINE void add_block(const LaneGroup& group, int lane, double* lanes, const LaneSlot* slots,
                              const ArticulatedT<T>& A, FanSums& fan) {
  const T values[21] = {A.M.xx,  A.M.yy,  A.M.zz,  A.M.xy,  A.M.xz, A.M.yz, A.H.x.x, A.H.x.y, A.H.x.z, A.H.y.x, A.H.y.y,
                        A.H.y.z, A.H.z.x, A.H.z.y, A.H.z.z, A.I.xx, A.I.yy, A.I.zz,  A.I.xy,  A.I.xz,  A.I.yz};
  for (int i = 0; i < 21; ++i) add_row(group, lane, lanes, slots, i, values[i], fan);
}

UNLATCH_INLINE void close_fan(double* lanes, const LaneSlot& parent, int first_row, const FanSums& fan) {
  for (int row = first_row; row < kBlockFields; ++row) {
    const double* s = fan.numbers + row * 8;
    lanes[parent.offset + (kBlock + row) * parent.stride] +=
        ((s[0] + s[1]) + (s[2] + s[3])) + ((s[4] + s[5]) + (s[6] + s[7]));
  }
}

// --- Leaves to root -------------------------------------------------------------------------------------------------

template <bool kLeaf, bool kFactor, class T>
UNLATCH_INLINE void eliminate(const Plan& plan, Workspace& ws, const Sweep& sweep, const LaneGroup& group,
                              const LanePhase& phase, int lane, FanSums& fan, T& bad) {
  double* lanes = ws.lanes.data();
  const View<T> v{lanes + group.data + lane, group.width};
  const View<T, const double> c{plan.lane_constants.data() + group.constants + lane, group.width};
  const Node<T, kLeaf> node = get_node<kLeaf>(v, c, sweep.source);
  const SpatialT<T> bias = group.has_joint && sweep.biased ? v.get_spatial(kBias) : get_zero<T>();
  Passed<T> passed;
  if (phase.held) {
    const SpatialT<T> load = sweep.biased ? node.load - node.times(bias) : node.load;
    passed = eliminate_freedoms<kLeaf, kFactor>(group, phase, v, node, load, bad);
    if (group.may_be_loose) {
      const T held = v.get(kHeld);
      passed.load = held & passed.load;
      if constexpr (kFactor) {
        passed.A.M = {held & passed.A.M.xx, held & passed.A.M.yy, held & passed.A.M.zz,
                      held & passed.A.M.xy, held & passed.A.M.xz, held & passed.A.M.yz};
        passed.A.H = {held & passed.A.H.x, held & passed.A.H.y, held & passed.A.H.z};
        passed.A.I = {held & passed.A.I.xx, held & passed.A.I.yy, held & passed.A.I.zz,
                      held & passed.A.I.xy, held & passed.A.I.xz, held & passed.A.I.yz};
      }
    }
  } else {
    const T o(0.0);
    passed.load = get_zero<T>();
    passed.A = get_body_block(o, Sym3T<T>{o, o, o, o, o, o});
  }
  if (phase.loose)
    eliminate_rows<kFactor>(group, phase, v, kLeaf ? get_body_block(node.mass, node.A.I) : node.A, node.load, bias,
                            passed, bad);
  if (group.link == LaneLink::kRoot || (!phase.held && phase.rows == 0)) return;
  const Vec3T<T> offset = v.get_vec(kOffset);
  const LaneSlot* slots = plan.lane_parents.data() + group.first + lane;
  if constexpr (kFactor) add_block(group, lane, lanes, slots, shift(passed.A, offset), fan);
  add_spatial(group, lane, lanes, slots, SpatialT<T>{passed.load.lin, passed.load.ang + cross(offset, passed.load.lin)},
              fan);
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

template <bool kLeaf, bool kFactor, class T>
inline int eliminate_group(const Plan& plan, Workspace& ws, const Sweep& sweep, const LaneGroup& group,
                           const LanePhase& phase, FanSums& fan) {
  for (int lane = 0; lane < group.width; lane += T::kWidth) {
    T bad(0.0);
    eliminate<kLeaf, kFactor, T>(plan, ws, sweep, group, phase, lane, fan, bad);
    if (kFactor && any(bad)) return find_bad_node(plan, group, lane, bad);
  }
  return kNone;
}

template <int kWidest, bool kLeaf, bool kFactor>
inline int eliminate_group(const Plan& plan, Workspace& ws, const Sweep& sweep, const LaneGroup& group,
                           const LanePhase& phase, FanSums& fan) {
  if constexpr (kWidest >= 8)
    if (group.width == 8) return eliminate_group<kLeaf, kFactor, Pack<8>>(plan, ws, sweep, group, phase, fan);
  if constexpr (kWidest >= 4)
    if (group.width >= 4) return eliminate_group<kLeaf, kFactor, Pack<4>>(plan, ws, sweep, group, phase, fan);
  if constexpr (kWidest >= 2)
    if (group.width >= 2) return eliminate_group<kLeaf, kFactor, Pack<2>>(plan, ws, sweep, group, phase, fan);
  return eliminate_group<kLeaf, kFactor, Pack<1>>(plan, ws, sweep, group, phase, fan);
}

// Bodies with something beyond them begin with what is their own.
template <int kWidest, bool kFactor>
inline void init_blocks(const Plan& plan, Workspace& ws, const Sweep& sweep) {
  for_groups<kWidest>(plan, ws, [&]<class T>(const LaneGroup& group, const View<T>& v, const auto& c, const auto&) {
    if (group.leaf) return;
    if (kFactor) set_block(v.from(kBlock), get_body_block(c.get(kMass), v.get_sym(kInertia)));
    v.set(kBlock + 21, get_source(v, sweep.source));
  });
}

template <int kWidest, bool kFactor>
int sweep_up(const Plan& plan, Workspace& ws, const Sweep& sweep) {
  FanSums fan;
  init_blocks<kWidest, kFactor>(plan, ws, sweep);
  for (std::size_t g = plan.groups.size(); g-- > 0;) {
    const LaneGroup& group = plan.groups[g];
    if (group.fan_begins)
      for (double& sum : fan.numbers) sum = 0;
    const int node = group.leaf ? eliminate_group<kWidest, true, kFactor>(plan, ws, sweep, group, ws.phases[g], fan)
                                : eliminate_group<kWidest, false, kFactor>(plan, ws, sweep, group, ws.phases[g], fan);
    if (kFactor && node != kNone) return node;
    if (group.fan_ends)
      close_fan(ws.lanes.data(), plan.lane_parents[static_cast<std::size_t>(group.first)], kFactor ? 0 : 21, fan);
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

// Which lanes hold row r.
template <class T>
UNLATCH_INLINE T get_row_mask(const LaneGroup& group, const View<T>& v, int r, int freedom_part, int row_part) {
  T mask = v.get(kHeld);
  if (has_row(group.freedoms, r)) mask = mask & ~v.get(freedom_part + kMask);
  if (has_row(group.rows, r)) mask = mask | v.get(row_part + kRowMask);
  return mask;
}

// The wrench A a − b that the joint puts on the child, as multipliers on its follower.
template <class T>
UNLATCH_INLINE void set_multipliers(const LaneGroup& group, const View<T>& v, const SpatialT<T>& wrench) {
  const SpatialT<T> on_follower = group.child_is_base ? SpatialT<T>{-wrench.lin, -wrench.ang} : wrench;
  const Vec3T<T> moment = on_follower.ang - cross(get_arm(group, v), on_follower.lin);
  const Vec3T<T> along_n = transpose_times(get_axes(group, v, kX), on_follower.lin);
  const Vec3T<T> about_m = transpose_times(get_axes(group, v, kRotX), moment);
  const T values[kRows] = {along_n.x, along_n.y, along_n.z, about_m.x, about_m.y, about_m.z};
  int freedom_part = group.freedom_parts, row_part = group.row_parts;
  for (int r = 0; r < kRows; ++r) {
    v.set(kMultipliers + r, get_row_mask(group, v, r, freedom_part, row_part) & values[r]);
    if (has_row(group.freedoms, r)) freedom_part += kFreedomEnd;
    if (has_row(group.rows, r)) row_part += kRowEnd;
  }
}

// Through the freedoms: a = X a_parent + Σ s q + bias.
template <class T>
UNLATCH_INLINE SpatialT<T> substitute_freedoms(const LaneGroup& group, const LanePhase& phase, const View<T>& v,
                                               const SpatialT<T>& carried, const SpatialT<T>& bias) {
  SpatialT<T> a = carried;
  const Vec3T<T> arm = get_arm(group, v);
  int part = group.freedom_parts;
  for (int r = 0; r < kRows; ++r)
    if (has_row(group.freedoms, r)) part += kFreedomEnd;
  for (int r = kRows - 1; r >= 0; --r) {
    if (!has_row(group.freedoms, r)) continue;
    part -= kFreedomEnd;
    if (!has_row(phase.freedoms, r)) continue;
    const View<T> own = v.from(part);
    const SpatialT<T> s = get_freedom(r, get_axes(group, v, r), arm);
    const T q = (dot(own.get_spatial(kU), a) - own.get(kBeta)) * own.get(kInverse);
    own.set(kBeta, -q);
    a = a - (own.get(kMask) & q) * s;
  }
  return a + bias;
}

// Through the rows: a = A⁻¹ b + Σ y μ, with the rows' reaction μ once the parent's acceleration is known.
template <class T>
UNLATCH_INLINE SpatialT<T> substitute_rows(const LaneGroup& group, const LanePhase& phase, const View<T>& v,
                                           const SpatialT<T>& carried) {
  SpatialT<T> a = v.get_spatial(group.free + 21);
  int part = group.row_parts;
  for (int r = 0; r < kRows; ++r) {
    if (!has_row(group.rows, r)) continue;
    const View<T> own = v.from(part);
    part += kRowEnd;
    if (!has_row(phase.rows, r)) continue;
    const T mu = own.get(kRowInverse) * dot(own.get_spatial(kWrench), carried) - own.get(kMu);
    a = a + mu * own.get_spatial(kReply);
  }
  return a;
}

template <bool kLeaf, class T>
UNLATCH_INLINE void substitute_part(const Plan& plan, Workspace& ws, const Sweep& sweep, const LaneGroup& group,
                                    const LanePhase& phase, int lane) {
  const View<T> v{ws.lanes.data() + group.data + lane, group.width};
  const View<T, const double> c{plan.lane_constants.data() + group.constants + lane, group.width};
  const Parents<T> parents{group.link, ws.lanes.data(), plan.lane_parents.data() + group.first + lane};
  SpatialT<T> carried = get_zero<T>();
  if (group.link != LaneLink::kRoot) {
    carried = parents.get_spatial(kAcceleration);
    carried.lin += cross(carried.ang, v.get_vec(kOffset));
  }
  SpatialT<T> a;
  if (phase.held) {
    a = substitute_freedoms(group, phase, v, carried, sweep.biased ? v.get_spatial(kBias) : get_zero<T>());
    if (phase.loose) {
      const SpatialT<T> loose = substitute_rows(group, phase, v, carried);
      const T held = v.get(kHeld);
      a = {select(held, a.lin, loose.lin), select(held, a.ang, loose.ang)};
    }
  } else {
    a = substitute_rows(group, phase, v, carried);
  }
  const Node<T, kLeaf> node = get_node<kLeaf>(v, c, sweep.source);  // the source may lie where the result goes
  v.set(kAcceleration, a);
  if (!sweep.multipliers || !group.has_joint) return;
  set_multipliers(group, v, node.times(a) - node.load);
}

template <int kWidest>
void substitute(const Plan& plan, Workspace& ws, const Sweep& sweep) {
  for (std::size_t g = 0; g < plan.groups.size(); ++g) {
    const LaneGroup& group = plan.groups[g];
    const LanePhase& phase = ws.phases[g];
    const auto run = [&]<class T>(const T*) {
      for (int lane = 0; lane < group.width; lane += T::kWidth)
        if (group.leaf)
          substitute_part<true, T>(plan, ws, sweep, group, phase, lane);
        else
          substitute_part<false, T>(plan, ws, sweep, group, phase, lane);
    };
    if constexpr (kWidest >= 8)
      if (group.width == 8) {
        run(static_cast<const Pack<8>*>(nullptr));
        continue;
      }
    if constexpr (kWidest >= 4)
      if (group.width >= 4) {
        run(static_cast<const Pack<4>*>(nullptr));
        continue;
      }
    if constexpr (kWidest >= 2)
      if (group.width >= 2) {
        run(static_cast<const Pack<2>*>(nullptr));
        continue;
      }
    run(static_cast<const Pack<1>*>(nullptr));
  }
}

template <int kWidest>
constexpr LaneKernels build_kernels(Lanes lanes) {
  return {lanes,
          update_kinematics<kWidest>,
          init_forces<kWidest>,
          update_joints<kWidest>,
          factor_and_reduce<kWidest>,
          reduce<kWidest>,
          substitute<kWidest>,
          keep_start<kWidest>,
          begin_stages<kWidest>,
          advance_stage<kWidest>,
          finish_stages<kWidest>,
          add_displacements<kWidest>,
          add_velocities<kWidest>};
}

}  // namespace unlatch::UNLATCH_ISA
