// The elimination of a joint's freedoms, one by one, in lanes that are held by three rows or more. Compiled once per
// instruction set, see kernel/simd/pack.h.
#pragma once

#include <bit>

#include "kernel/solver/parents.h"

namespace unlatch::UNLATCH_ISA {

template <class T>
UNLATCH_INLINE SpatialT<T> to_spatial(const SlideT<T>& a) {
  const T o(0.0);
  return {a.lin, {o, o, o}};
}
template <class T>
UNLATCH_INLINE const SpatialT<T>& to_spatial(const SpatialT<T>& a) {
  return a;
}

// Eliminates freedom r, whose direction is s and whose U = A s. Returns its inverse pivot, which is zero in lanes where
// r is no freedom, so that they stay as they are.
template <class V, class N, class S, class U, class T>
UNLATCH_INLINE T eliminate_freedom(const V& v, const N& node, const Sweep& sweep, int r, const S& s, const U& u,
                                   SpatialT<T>& wrench_left, T& bad) {
  auto& own = v.blocks.freedom(r);
  const T mask = load<T>(own.mask), beta = dot(s, wrench_left);
  T pivot = dot(s, u);
  bad = bad | (mask & ~node.is_pivot(pivot, s));
  if (sweep.gamma_h != 0 && has_row(v.group.compliant, r)) pivot = pivot + load<T>(v.blocks.pivot(r));
  const T inverse = mask & (T(1) / pivot);
  store(own.beta, beta);
  store(own.U, to_spatial(u));
  store(own.inverse_pivot, inverse);
  wrench_left = wrench_left - (beta * inverse) * u;
  return inverse;
}
// Eliminates a freedom from the node's block. Returns the rest, which may be sparse.
template <class V, class N, class S, class T>
UNLATCH_INLINE auto eliminate_first(const V& v, const N& node, const Sweep& sweep, int r, const S& s,
                                    SpatialT<T>& wrench_left, T& bad) {
  const auto u = node.times(s);
  return node.downdated(eliminate_freedom(v, node, sweep, r, s, u, wrench_left, bad), u);
}
// Eliminates a freedom from `rest`, which may be sparse. Returns the rest of it, which may be sparse as well.
template <class V, class N, class A, class S, class T>
UNLATCH_INLINE auto eliminate_freedom_of(const V& v, const N& node, const A& rest, const Sweep& sweep, int r,
                                         const S& s, SpatialT<T>& wrench_left, T& bad) {
  const auto u = rest * s;
  return downdated(rest, eliminate_freedom(v, node, sweep, r, s, u, wrench_left, bad), u);
}

// Eliminates all freedoms: the first from the node's block and the second from the rest of the first, whose zeros are
// used; any further one from a full block.
template <class V, class N, class T>
UNLATCH_INLINE void factor_freedoms(const V& v, const N& node, const Sweep& sweep, Passed<T>& passed, T& bad) {
  unsigned left = v.modes.freedoms;
  if (left == 0) {
    passed.A = node.get_block();
    return;
  }
  const auto take_next = [&] {
    const int r = std::countr_zero(left);
    left &= left - 1;
    return r;
  };
  const int first = take_next();
  with_freedom(v, first, [&](const auto& s) UNLATCH_INLINE_LAMBDA {
    const auto rest = eliminate_first(v, node, sweep, first, s, passed.wrench, bad);
    if (left == 0) {
      passed.A = get_whole(rest);
      return;
    }
    const int second = take_next();
    with_freedom(v, second, [&](const auto& s2) UNLATCH_INLINE_LAMBDA {
      passed.A = get_whole(eliminate_freedom_of(v, node, rest, sweep, second, s2, passed.wrench, bad));
    });
    while (left != 0) {
      const int r = take_next();
      with_freedom(v, r, [&](const auto& s3) UNLATCH_INLINE_LAMBDA {
        passed.A = eliminate_freedom_of(v, node, passed.A, sweep, r, s3, passed.wrench, bad);
      });
    }
  });
}
// The same for another wrench.
template <class V, class T>
UNLATCH_INLINE void reduce_freedoms(const V& v, SpatialT<T>& wrench_left) {
  for (unsigned left = v.modes.freedoms; left != 0; left &= left - 1) {
    const int r = std::countr_zero(left);
    auto& own = v.blocks.freedom(r);
    const T beta = with_freedom(v, r, [&](const auto& s) UNLATCH_INLINE_LAMBDA { return dot(s, wrench_left); });
    store(own.beta, beta);
    wrench_left = wrench_left - (beta * load<T>(own.inverse_pivot)) * load<T>(own.U);
  }
}

}  // namespace unlatch::UNLATCH_ISA
