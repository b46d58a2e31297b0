// Cyclone DDS 0.10.2 turns a sample of the other byte order round in place, and for a single 64-bit number takes four
// times its offset: it writes outside the buffer, for any sender of such bytes (found by tests/fuzz/dds_fuzz.cc).
// Its calls to its own exported function go through the dynamic linker, which prefers ours: samples of the other
// byte order are refused, and counted as what cannot be read; the rest is Cyclone's.
#include "bridge/dds/dds_byte_order.h"

#include <dds/dds.h>
#include <dds/ddsi/ddsi_cdrstream.h>
#include <dds/version.h>
#include <dlfcn.h>

#include <cstdint>

#if DDS_VERSION_MAJOR == 0 && DDS_VERSION_MINOR == 10 && DDS_VERSION_PATCH <= 2

namespace {
// Cyclone's own function, from the library itself: this code may be in the program or in a module, and "the next one"
// of a module's is not looked for in what only that module needs.
void* find_own_normalize() {
  Dl_info library{};
  if (dladdr(reinterpret_cast<void*>(&dds_create_participant), &library) == 0) return nullptr;
  void* const handle = dlopen(library.dli_fname, RTLD_LAZY | RTLD_NOLOAD);
  return handle != nullptr ? dlsym(handle, "dds_stream_normalize") : nullptr;
}
}  // namespace

extern "C" bool dds_stream_normalize(void* data, std::uint32_t size, bool swap, std::uint32_t xcdr_version,
                                     const ddsi_sertype_default* type, bool only_key, std::uint32_t* actual_size) {
  using Normalize = decltype(&dds_stream_normalize);
  static const auto normalize = reinterpret_cast<Normalize>(find_own_normalize());
  if (swap || normalize == nullptr) return false;
  return normalize(data, size, swap, xcdr_version, type, only_key, actual_size);
}

namespace unlatch::bridge {
// Cyclone's own function is taken when the linker did not see that ours is meant for the library as well.
bool is_byte_order_checked() noexcept {
  return dlsym(RTLD_DEFAULT, "dds_stream_normalize") == reinterpret_cast<void*>(&dds_stream_normalize);
}
}  // namespace unlatch::bridge

#else

namespace unlatch::bridge {
bool is_byte_order_checked() noexcept { return true; }
}  // namespace unlatch::bridge

#endif
