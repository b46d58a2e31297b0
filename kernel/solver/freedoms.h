// Freedoms of a joint eliminated one by one: how lanes held by three rows or more add to their parents. Compiled once
// per instruction set, see kernel/simd/pack.h.
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

// Eliminates freedom r, whose direction is s and whose U = A s. Returns its inverse pivot: zero in lanes where it is no
// freedom, so that they lose nothing.
template <class V, class N, class S, class U, class T>
UNLATCH_INLINE T eliminate_freedom(const V& v, const N& node, const Sweep& sweep, int r, const S& s, const U& u,
                                   SpatialT<T>& load_left, T& bad) {
  auto& own = v.blocks.freedom(r);
  const T mask = load<T>(own.mask), beta = dot(s, load_left);
  T pivot = dot(s, u);
  bad = bad | (mask & ~node.is_pivot(pivot, s));
  if (sweep.gamma_h != 0 && has_row(v.group.compliant, r)) pivot = pivot + load<T>(v.blocks.pivot(r));
  const T inverse = mask & (T(1) / pivot);
  store(own.beta, beta);
  store(own.U, to_spatial(u));
  store(own.inverse_pivot, inverse);
  load_left = load_left - (beta * inverse) * u;
  return inverse;
}
// Out of the node's block; returns what is left of it, which may be sparse.
template <class V, class N, class S, class T>
UNLATCH_INLINE auto eliminate_first(const V& v, const N& node, const Sweep& sweep, int r, const S& s,
                                    SpatialT<T>& load_left, T& bad) {
  const auto u = node.times(s);
  return node.downdated(eliminate_freedom(v, node, sweep, r, s, u, load_left, bad), u);
}
// Out of `rest`, which may be sparse; returns what is left of it, which may be so as well.
template <class V, class N, class A, class S, class T>
UNLATCH_INLINE auto eliminate_freedom_of(const V& v, const N& node, const A& rest, const Sweep& sweep, int r,
                                         const S& s, SpatialT<T>& load_left, T& bad) {
  const auto u = rest * s;
  return downdated(rest, eliminate_freedom(v, node, sweep, r, s, u, load_left, bad), u);
}

// One by one. The first comes out of the node's block and the second out of what the first left, which keep their
// zeros; any further out of a whole block.
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
    const auto rest = eliminate_first(v, node, sweep, first, s, passed.load, bad);
    if (left == 0) {
      passed.A = get_whole(rest);
      return;
    }
    const int second = take_next();
    with_freedom(v, second, [&](const auto& s2) UNLATCH_INLINE_LAMBDA {
      passed.A = get_whole(eliminate_freedom_of(v, node, rest, sweep, second, s2, passed.load, bad));
    });
    while (left != 0) {
      const int r = take_next();
      with_freedom(v, r, [&](const auto& s3) UNLATCH_INLINE_LAMBDA {
        passed.A = eliminate_freedom_of(v, node, passed.A, sweep, r, s3, passed.load, bad);
      });
    }
  });
}
// The same for another load.
template <class V, class T>
UNLATCH_INLINE void reduce_freedoms(const V& v, SpatialT<T>& load_left) {
  for (unsigned left = v.modes.freedoms; left != 0; left &= left - 1) {
    const int r = std::countr_zero(left);
    auto& own = v.blocks.freedom(r);
    const T beta = with_freedom(v, r, [&](const auto& s) UNLATCH_INLINE_LAMBDA { return dot(s, load_left); });
    store(own.beta, beta);
    load_left = load_left - (beta * load<T>(own.inverse_pivot)) * load<T>(own.U);
  }
}

}  // namespace unlatch::UNLATCH_ISA
