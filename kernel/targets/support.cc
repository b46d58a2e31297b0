// The few functions of the C library that compilers call on their own. With -nostdlib nothing else is linked, above all
// no heap. A port may have faster ones for memory.
#include <cstddef>
#include <cstdint>

extern "C" {

// Loops over bytes that the compiler must not turn into calls of themselves: -fno-tree-loop-distribute-patterns.
[[gnu::weak]] void* memcpy(void* to, const void* from, std::size_t size) {
  auto* t = static_cast<unsigned char*>(to);
  const auto* f = static_cast<const unsigned char*>(from);
  if ((reinterpret_cast<std::uintptr_t>(t) | reinterpret_cast<std::uintptr_t>(f)) % 4 == 0)
    for (; size >= 4; size -= 4, t += 4, f += 4)
      *reinterpret_cast<std::uint32_t*>(t) = *reinterpret_cast<const std::uint32_t*>(f);
  for (; size > 0; --size) *t++ = *f++;
  return to;
}

[[gnu::weak]] void* memmove(void* to, const void* from, std::size_t size) {
  auto* t = static_cast<unsigned char*>(to);
  const auto* f = static_cast<const unsigned char*>(from);
  if (t <= f || t >= f + size) return memcpy(to, from, size);
  while (size-- > 0) t[size] = f[size];
  return to;
}

[[gnu::weak]] void* memset(void* to, int value, std::size_t size) {
  auto* t = static_cast<unsigned char*>(to);
  while (size-- > 0) *t++ = static_cast<unsigned char>(value);
  return to;
}

[[gnu::weak]] int memcmp(const void* a, const void* b, std::size_t size) {
  const auto *x = static_cast<const unsigned char*>(a), *y = static_cast<const unsigned char*>(b);
  for (std::size_t i = 0; i < size; ++i)
    if (x[i] != y[i]) return x[i] < y[i] ? -1 : 1;
  return 0;
}

int strcmp(const char* a, const char* b) {
  for (; *a != 0 && *a == *b; ++a) ++b;
  return static_cast<unsigned char>(*a) - static_cast<unsigned char>(*b);
}

std::size_t strlen(const char* text) {
  std::size_t length = 0;
  while (text[length] != 0) ++length;
  return length;
}

// Correctly rounded by IEEE 754, one instruction; called where the compiler does not know that errno does not count.
double sqrt(double x) { return __builtin_sqrt(x); }

// Where the processor has no instruction for it. Numbers from 2^52 on are whole, or none.
double floor(double x) {
  constexpr double kWhole = 0x1p52;
  if (!(x < kWhole && x > -kWhole)) return x;
  const double towards_zero = static_cast<double>(static_cast<long long>(x));
  return __builtin_copysign(towards_zero > x ? towards_zero - 1 : towards_zero, x);
}
double ceil(double x) { return -floor(-x); }
// To the nearest whole number, ties to even, for processors without an instruction: adding 2^52 rounds there.
double nearbyint(double x) {
  constexpr double kWhole = 4503599627370496.0;
  const double size = __builtin_fabs(x);
  if (!(size < kWhole)) return x;
  volatile double sum = size + kWhole;
  return __builtin_copysign(sum - kWhole, x);
}

// Of std::shared_ptr: one thread, and plans that open_plan() makes share nothing.
char __libc_single_threaded = 1;

// Of objects with static lifetime, which a program that never ends does not destroy; of pure functions, never called.
void* __dso_handle = nullptr;
int __cxa_atexit(void (*)(void*), void*, void*) { return 0; }
[[noreturn]] void __cxa_pure_virtual() {
  for (;;) {
  }
}
[[noreturn]] void abort() {
  for (;;) {
  }
}
}  // extern "C"

namespace __gnu_cxx {
int __exchange_and_add(volatile int* at, int change) noexcept {
  const int before = *at;
  *at = before + change;
  return before;
}
}  // namespace __gnu_cxx
