// Handles of the C library. A handle is not an address but a number in the form of a pointer: the slot in a table, the
// kind of object, and the number of the slot's uses. So a closed or foreign handle is detected without access to memory
// that may be freed. Access to a handle costs one atomic exchange and takes no lock.
//
//   bits 0 … 15: slot   16 … 19: kind   20 … 63: use, from 1
#pragma once

#include <atomic>
#include <cstdint>

#include "library/include/unlatch.h"

namespace unlatch::library {

enum class HandleKind : std::uint64_t { kSimulation = 1, kBatch = 2 };

struct HandleSlot {
  std::atomic<std::uint64_t> tag{0};  // (handle >> 16) << 1, and 1 while a thread is at work; 0: free
  std::atomic<bool> interrupted{false};
  void* object = nullptr;
};

inline constexpr std::uint64_t kHandleSlots = 16'384;
extern HandleSlot handle_slots[kHandleSlots];

// Opens a handle; null if no slot is free.
void* open_handle(HandleKind kind, void* object) noexcept;
// Sets `interrupted` of an open handle of any kind, also of one in use.
[[nodiscard]] bool interrupt_handle(const void* handle) noexcept;

// Exclusive access of this thread to the object of a handle, for the lifetime of this instance.
class Access {
 public:
  Access(HandleKind kind, const void* handle) noexcept {
    const auto bits = reinterpret_cast<std::uintptr_t>(handle);
    const std::uint64_t place = bits & 0xFFFF;
    if (place >= kHandleSlots || ((bits >> 16) & 0xF) != static_cast<std::uint64_t>(kind)) return;
    std::uint64_t seen = (bits >> 16) << 1;
    tag_ = seen;
    if (handle_slots[place].tag.compare_exchange_strong(seen, tag_ | 1, std::memory_order_acquire)) {
      slot_ = &handle_slots[place];
    } else if (seen == (tag_ | 1)) {
      status_ = UNLATCH_ERROR_BUSY;
    }
  }
  ~Access() {
    if (slot_ != nullptr) slot_->tag.store(tag_, std::memory_order_release);
  }
  Access(const Access&) = delete;
  Access& operator=(const Access&) = delete;

  explicit operator bool() const noexcept { return slot_ != nullptr; }
  // Status of a refused handle.
  [[nodiscard]] unlatch_status get_status() const noexcept { return status_; }
  template <class Object>
  [[nodiscard]] Object& get() const noexcept {
    return *static_cast<Object*>(slot_->object);
  }
  [[nodiscard]] std::atomic<bool>& interrupted() const noexcept { return slot_->interrupted; }
  // Marks the handle for closing at the end of this instance; the caller then owns the object.
  void close() noexcept;

 private:
  HandleSlot* slot_ = nullptr;
  std::uint64_t tag_ = 0;
  unlatch_status status_ = UNLATCH_ERROR_HANDLE;
};

}  // namespace unlatch::library
