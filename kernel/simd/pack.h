// A pack: one number per lane, so that the arithmetic of math.h and spatial.h works on several bodies at once.
// No lane reads another one: what a lane computes does not depend on the width of the pack, and has the same bits as
// plain doubles.
//
// Packs are copied by constructors of their own, so that vectors and matrices of them are copied pack by pack. g++
// copies a plain aggregate in pieces of 16 bytes: a pack that was stored in two pieces must reach the cache before it
// can be loaded in one, some 20 cycles each time.
//
// Included only by files that are compiled once for each instruction set, which UNLATCH_ISA names: everything is in a
// namespace of that name and is always inlined, so that the linker can never take code of another instruction set.
//
#pragma once

#include <bit>
#include <cstdint>

#if defined(__x86_64__)
#include <immintrin.h>
#endif

#include "kernel/math/spatial.h"
#include "unlatch/math.h"

namespace unlatch::UNLATCH_ISA {
// NOLINTBEGIN(performance-unnecessary-value-param): always inlined, nothing is copied

template <int W>
struct Vector;
template <>
struct Vector<2> {
  typedef double Numbers __attribute__((vector_size(16)));
  typedef double InMemory __attribute__((vector_size(16), aligned(8), may_alias));
  typedef std::int64_t Bits __attribute__((vector_size(16)));
};
template <>
struct Vector<4> {
  typedef double Numbers __attribute__((vector_size(32)));
  typedef double InMemory __attribute__((vector_size(32), aligned(8), may_alias));
  typedef std::int64_t Bits __attribute__((vector_size(32)));
};
template <>
struct Vector<8> {
  typedef double Numbers __attribute__((vector_size(64)));
  typedef double InMemory __attribute__((vector_size(64), aligned(8), may_alias));
  typedef std::int64_t Bits __attribute__((vector_size(64)));
};

template <int W>
struct Pack {
  using Numbers = typename Vector<W>::Numbers;
  using Bits = typename Vector<W>::Bits;
  static constexpr int kWidth = W;
  Numbers v;

  UNLATCH_INLINE Pack() = default;
  UNLATCH_INLINE Pack(const Pack& other) : v(other.v) {}
  UNLATCH_INLINE Pack& operator=(const Pack& other) {
    v = other.v;
    return *this;
  }
  UNLATCH_INLINE Pack(Numbers numbers) : v(numbers) {}
  UNLATCH_INLINE Pack(double all) {
    if constexpr (W == 2) v = Numbers{all, all};
    if constexpr (W == 4) v = Numbers{all, all, all, all};
    if constexpr (W == 8) v = Numbers{all, all, all, all, all, all, all, all};
  }
  friend UNLATCH_INLINE Pack operator+(Pack a, Pack b) { return a.v + b.v; }
  friend UNLATCH_INLINE Pack operator-(Pack a, Pack b) { return a.v - b.v; }
  friend UNLATCH_INLINE Pack operator*(Pack a, Pack b) { return a.v * b.v; }
  friend UNLATCH_INLINE Pack operator/(Pack a, Pack b) { return a.v / b.v; }
  friend UNLATCH_INLINE Pack operator-(Pack a) { return -a.v; }
  // All bits of the lanes where it holds, none elsewhere.
  friend UNLATCH_INLINE Pack operator>(Pack a, Pack b) { return (Numbers)(a.v > b.v); }
  friend UNLATCH_INLINE Pack operator&(Pack a, Pack b) { return (Numbers)((Bits)a.v & (Bits)b.v); }
  friend UNLATCH_INLINE Pack operator|(Pack a, Pack b) { return (Numbers)((Bits)a.v | (Bits)b.v); }
  friend UNLATCH_INLINE Pack operator^(Pack a, Pack b) { return (Numbers)((Bits)a.v ^ (Bits)b.v); }
  friend UNLATCH_INLINE Pack operator~(Pack a) { return (Numbers) ~(Bits)a.v; }
};

// One lane: the same vocabulary over a double.
template <>
struct Pack<1> {
  using Numbers = double;
  static constexpr int kWidth = 1;
  double v;

  UNLATCH_INLINE Pack() = default;
  UNLATCH_INLINE Pack(const Pack& other) : v(other.v) {}
  UNLATCH_INLINE Pack& operator=(const Pack& other) {
    v = other.v;
    return *this;
  }
  UNLATCH_INLINE Pack(double number) : v(number) {}
  friend UNLATCH_INLINE Pack operator+(Pack a, Pack b) { return a.v + b.v; }
  friend UNLATCH_INLINE Pack operator-(Pack a, Pack b) { return a.v - b.v; }
  friend UNLATCH_INLINE Pack operator*(Pack a, Pack b) { return a.v * b.v; }
  friend UNLATCH_INLINE Pack operator/(Pack a, Pack b) { return a.v / b.v; }
  friend UNLATCH_INLINE Pack operator-(Pack a) { return -a.v; }
  friend UNLATCH_INLINE Pack operator>(Pack a, Pack b) { return from_bits(a.v > b.v ? ~std::uint64_t{0} : 0); }
  friend UNLATCH_INLINE Pack operator&(Pack a, Pack b) { return from_bits(to_bits(a) & to_bits(b)); }
  friend UNLATCH_INLINE Pack operator|(Pack a, Pack b) { return from_bits(to_bits(a) | to_bits(b)); }
  friend UNLATCH_INLINE Pack operator^(Pack a, Pack b) { return from_bits(to_bits(a) ^ to_bits(b)); }
  friend UNLATCH_INLINE Pack operator~(Pack a) { return from_bits(~to_bits(a)); }

 private:
  static UNLATCH_INLINE std::uint64_t to_bits(Pack a) { return __builtin_bit_cast(std::uint64_t, a.v); }
  static UNLATCH_INLINE Pack from_bits(std::uint64_t bits) { return __builtin_bit_cast(double, bits); }
};

template <class T>
UNLATCH_INLINE T load(const double* from) {
  if constexpr (T::kWidth == 1)
    return *from;
  else
    return typename T::Numbers(*reinterpret_cast<const typename Vector<T::kWidth>::InMemory*>(from));
}
template <class T>
UNLATCH_INLINE void store(double* to, const T& a) {
  if constexpr (T::kWidth == 1)
    *to = a.v;
  else
    *reinterpret_cast<typename Vector<T::kWidth>::InMemory*>(to) = a.v;
}

// A number for each lane, without a detour through memory: what is stored in parts cannot be loaded whole at once.
template <class T, class Number>
UNLATCH_INLINE T gather(const Number& number) {
  using Numbers = typename T::Numbers;
  if constexpr (T::kWidth == 1) return number(0);
  if constexpr (T::kWidth == 2) return Numbers{number(0), number(1)};
  if constexpr (T::kWidth == 4) return Numbers{number(0), number(1), number(2), number(3)};
  if constexpr (T::kWidth == 8)
    return Numbers{number(0), number(1), number(2), number(3), number(4), number(5), number(6), number(7)};
}

template <class T>
UNLATCH_INLINE bool any(const T& mask) {
#if defined(__AVX__)
  if constexpr (T::kWidth == 4) return _mm256_movemask_pd(mask.v) != 0;
#endif
#if defined(__x86_64__)
  if constexpr (T::kWidth == 2) return _mm_movemask_pd(mask.v) != 0;
#endif
  std::int64_t bits[T::kWidth];
  __builtin_memcpy(bits, &mask.v, sizeof(bits));
  std::int64_t all = 0;
  for (const std::int64_t b : bits) all |= b;
  return all != 0;
}

// `a` where the mask holds, else `b`.
template <class T>
UNLATCH_INLINE T select(const T& mask, const T& a, const T& b) {
#if defined(__AVX512DQ__)
  if constexpr (T::kWidth == 8) return T(_mm512_mask_blend_pd(_mm512_movepi64_mask((__m512i)mask.v), b.v, a.v));
#endif
#if defined(__AVX__)
  if constexpr (T::kWidth == 4) return T(_mm256_blendv_pd(b.v, a.v, mask.v));
  if constexpr (T::kWidth == 2) return T(_mm_blendv_pd(b.v, a.v, mask.v));
#endif
  return (mask & a) | (~mask & b);
}

// The lesser; `b` where one of them is no number.
UNLATCH_INLINE Pack<1> min(Pack<1> a, Pack<1> b) { return a.v < b.v ? a.v : b.v; }
template <int W>
UNLATCH_INLINE Pack<W> min(Pack<W> a, Pack<W> b) {
#if defined(__AVX512F__)
  if constexpr (W == 8) return Pack<W>(_mm512_min_pd(a.v, b.v));
#endif
#if defined(__AVX__)
  if constexpr (W == 4) return Pack<W>(_mm256_min_pd(a.v, b.v));
#endif
#if defined(__x86_64__)
  if constexpr (W == 2) return Pack<W>(_mm_min_pd(a.v, b.v));
#endif
  for (int i = 0; i < W; ++i) a.v[i] = a.v[i] < b.v[i] ? a.v[i] : b.v[i];
  return a;
}

// IEEE 754 rounds a root correctly, whichever instruction takes it.
UNLATCH_INLINE Pack<1> sqrt(Pack<1> a) { return __builtin_sqrt(a.v); }
template <int W>
UNLATCH_INLINE Pack<W> sqrt(Pack<W> a) {
#if defined(__AVX512F__)
  if constexpr (W == 8) return Pack<W>(_mm512_sqrt_pd(a.v));
#endif
#if defined(__AVX__)
  if constexpr (W == 4) return Pack<W>(_mm256_sqrt_pd(a.v));
#endif
#if defined(__x86_64__)
  if constexpr (W == 2) return Pack<W>(_mm_sqrt_pd(a.v));
#endif
  for (int i = 0; i < W; ++i) a.v[i] = __builtin_sqrt(a.v[i]);
  return a;
}

template <class T>
UNLATCH_INLINE Vec3T<T> operator&(const T& mask, const Vec3T<T>& a) {
  return {mask & a.x, mask & a.y, mask & a.z};
}
template <class T>
UNLATCH_INLINE SpatialT<T> operator&(const T& mask, const SpatialT<T>& a) {
  return {mask & a.lin, mask & a.ang};
}
template <class T>
UNLATCH_INLINE SlideT<T> operator&(const T& mask, const SlideT<T>& a) {
  return {mask & a.lin};
}
template <class T>
UNLATCH_INLINE Vec3T<T> select(const T& mask, const Vec3T<T>& a, const Vec3T<T>& b) {
  return {select(mask, a.x, b.x), select(mask, a.y, b.y), select(mask, a.z, b.z)};
}

// NOLINTEND(performance-unnecessary-value-param)
}  // namespace unlatch::UNLATCH_ISA
