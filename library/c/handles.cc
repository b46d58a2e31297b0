#include "library/c/handles.h"

#include <mutex>

namespace unlatch::library {

constinit HandleSlot handle_slots[kHandleSlots];

namespace {

// Guards opening and closing only.
constinit std::mutex table_mutex;
constinit std::uint64_t slots_used = 0;                            // slots that were ever used
constinit std::uint64_t free_slots[kHandleSlots], free_count = 0;  // free slots
constinit std::uint64_t uses[kHandleSlots];                        // number of handles that each slot has issued

}  // namespace

void* open_handle(HandleKind kind, void* object) noexcept {
  const std::lock_guard lock(table_mutex);
  if (free_count == 0 && slots_used == kHandleSlots) return nullptr;
  const std::uint64_t place = free_count > 0 ? free_slots[--free_count] : slots_used++;
  const std::uint64_t upper = (++uses[place] << 4) | static_cast<std::uint64_t>(kind);
  HandleSlot& slot = handle_slots[place];
  slot.object = object;
  slot.interrupted.store(false, std::memory_order_relaxed);
  slot.tag.store(upper << 1, std::memory_order_release);
  return reinterpret_cast<void*>(static_cast<std::uintptr_t>((upper << 16) | place));
}

bool interrupt_handle(const void* handle) noexcept {
  const auto bits = reinterpret_cast<std::uintptr_t>(handle);
  const std::uint64_t place = bits & 0xFFFF, tag = (bits >> 16) << 1;
  if (place >= kHandleSlots || tag == 0) return false;
  if ((handle_slots[place].tag.load(std::memory_order_acquire) & ~std::uint64_t{1}) != tag) return false;
  handle_slots[place].interrupted.store(true, std::memory_order_relaxed);
  return true;
}

void Access::close() noexcept {
  const std::lock_guard lock(table_mutex);
  slot_->object = nullptr;
  slot_->tag.store(0, std::memory_order_release);
  free_slots[free_count++] = static_cast<std::uint64_t>(slot_ - handle_slots);
  slot_ = nullptr;
}

}  // namespace unlatch::library
