// What a session announces, in flash: the frames of a Hello and of the whole catalog, as `unlatch compile --session`
// writes them. Session and sequence numbers in them are 0. Read in place; no heap.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "bridge/schema/unlatch_frame.h"

namespace unlatch::target {

class SessionImage {
 public:
  // The text says what is wrong with the bytes; null: nothing.
  const char* open(std::span<const std::uint8_t> bytes);

  [[nodiscard]] const unlatch_wire_hello& get_hello() const { return hello_; }
  [[nodiscard]] std::size_t get_count() const { return count_; }
  // Item `i` of the catalog.
  [[nodiscard]] unlatch_wire_catalog get_item(std::size_t i) const;

 private:
  std::span<const std::uint8_t> items_;
  unlatch_wire_hello hello_{};
  std::size_t count_ = 0;
};

}  // namespace unlatch::target
