// memcpy() and memcmp() of x86-64, for the ports x86-64 and counted.
#include <cstddef>
#include <cstdint>

// A word, and sixteen bytes, wherever they lie: not with `auto`, which drops the alignment.
typedef std::uint64_t Word __attribute__((aligned(1), may_alias));
typedef char Part __attribute__((vector_size(16), aligned(1), may_alias));

// Blocks of 64 bytes by SSE2, as a C library does; support.cc has them word by word. Loops that the compiler must not
// turn into calls of themselves.
#define UNLATCH_NO_CALLS __attribute__((optimize("no-tree-loop-distribute-patterns")))

extern "C" UNLATCH_NO_CALLS void* memcpy(void* to, const void* from, std::size_t size) {
  auto* t = static_cast<char*>(to);
  const auto* f = static_cast<const char*>(from);
  for (; size >= 64; size -= 64, t += 64, f += 64) {
    const Part* const all = reinterpret_cast<const Part*>(f);
    Part* const out = reinterpret_cast<Part*>(t);
    const Part a = all[0], b = all[1], c = all[2], d = all[3];
    out[0] = a;
    out[1] = b;
    out[2] = c;
    out[3] = d;
  }
  for (; size >= 8; size -= 8, t += 8, f += 8) *reinterpret_cast<Word*>(t) = *reinterpret_cast<const Word*>(f);
  for (; size > 0; --size) *t++ = *f++;
  return to;
}

extern "C" UNLATCH_NO_CALLS int memcmp(const void* a, const void* b, std::size_t size) {
  const auto *x = static_cast<const unsigned char*>(a), *y = static_cast<const unsigned char*>(b);
  for (; size >= 8; size -= 8, x += 8, y += 8)
    if (*reinterpret_cast<const Word*>(x) != *reinterpret_cast<const Word*>(y)) break;
  for (; size > 0; --size, ++x, ++y)
    if (*x != *y) return *x < *y ? -1 : 1;
  return 0;
}
