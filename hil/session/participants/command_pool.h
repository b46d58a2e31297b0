// Memory for the nodes of the command queue's ordered sets: allocated at once, handed out and taken back without a
// system call.
#pragma once

#include <cstddef>
#include <memory_resource>
#include <new>
#include <vector>

namespace unlatch::hil {

class CommandPool final : public std::pmr::memory_resource {
 public:
  // `count` nodes of at most `bytes` each.
  CommandPool(std::size_t count, std::size_t bytes)
      : stride_((bytes + kAlignment - 1) / kAlignment * kAlignment), memory_(count * stride_) {
    for (std::size_t i = count; i-- > 0;) give_back(memory_.data() + i * stride_);
  }

 private:
  static constexpr std::size_t kAlignment = alignof(std::max_align_t);
  struct Free {
    Free* next;
  };

  void give_back(void* node) noexcept { free_ = ::new (node) Free{free_}; }

  // The owner counts its nodes and never asks for more than there are.
  void* do_allocate(std::size_t bytes, std::size_t) override {
    if (free_ == nullptr || bytes > stride_) throw std::bad_alloc();
    Free* const node = free_;
    free_ = node->next;
    return node;
  }
  void do_deallocate(void* node, std::size_t, std::size_t) override { give_back(node); }
  [[nodiscard]] bool do_is_equal(const std::pmr::memory_resource& other) const noexcept override {
    return this == &other;
  }

  const std::size_t stride_;
  std::vector<std::byte> memory_;
  Free* free_ = nullptr;
};

}  // namespace unlatch::hil
