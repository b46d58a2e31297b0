#include "library/c/options.h"

#include "library/c/errors.h"

namespace unlatch::library {

bool read_options(const unlatch_options* options, LoadOptions& read) {
  read = {};
  if (options == nullptr) return true;
  const auto refuse = [](const char* text) { return fail(UNLATCH_ERROR_ARGUMENT, text) == UNLATCH_OK; };
  if (options->size < sizeof(unlatch_options))
    return refuse("unlatch_options::size is not set; set it to sizeof(unlatch_options)");
  if ((options->flags & ~static_cast<std::uint32_t>(UNLATCH_JUDGE | UNLATCH_NOTICE)) != 0)
    return refuse("unlatch_options::flags has an unknown bit; UNLATCH_JUDGE and UNLATCH_NOTICE are known");
  if (options->override_count > 0 && options->overrides == nullptr)
    return refuse("unlatch_options::overrides is null, but override_count is not 0");
  for (std::size_t i = 0; i < options->override_count; ++i) {
    if (options->overrides[i] == nullptr) return refuse("one of unlatch_options::overrides is null");
    read.overrides.emplace_back(options->overrides[i]);
  }
  read.flags = options->flags;
  constexpr std::uint32_t kMaxEvents = 1u << 24;
  if (options->event_capacity > kMaxEvents)
    return refuse("unlatch_options::event_capacity is above 16,777,216; that many is the most");
  if (options->event_capacity > 0) read.event_capacity = options->event_capacity;
  return true;
}

}  // namespace unlatch::library
