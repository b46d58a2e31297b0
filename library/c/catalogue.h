// Lists of a scenario for the C library: names, units, places, limits.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "hil/scenario/scenario.h"
#include "library/include/unlatch.h"

namespace unlatch::library {

class Catalogue {
 public:
  static constexpr std::int32_t kKinds = UNLATCH_NUMBER + 1;

  explicit Catalogue(const hil::Scenario& scenario);
  Catalogue(const Catalogue&) = delete;
  Catalogue& operator=(const Catalogue&) = delete;

  [[nodiscard]] static bool is_kind(std::int32_t kind) { return kind >= 0 && kind < kKinds; }
  [[nodiscard]] const std::vector<unlatch_item>& get(std::int32_t kind) const {
    return items_[static_cast<std::size_t>(kind)];
  }
  // Index of the item of a name, or of "name:text" (events); -1 if there is none, -2 if there are several.
  [[nodiscard]] int find(std::int32_t kind, const std::string& name) const;
  // Modes of a joint.
  [[nodiscard]] const std::vector<std::string>& get_modes(std::size_t joint) const { return modes_[joint]; }

  // The functions of the C library that use these lists.
  unlatch_status count(std::int32_t kind, std::size_t* count) const;
  unlatch_status describe(std::int32_t kind, std::size_t index, unlatch_item* item) const;

 private:
  struct Texts {
    std::string name, unit, text;
  };
  unlatch_item& add(std::int32_t kind, std::string name, std::string unit, std::string text);

  std::array<std::vector<unlatch_item>, kKinds> items_;
  std::vector<std::unique_ptr<Texts>> texts_;
  std::vector<std::vector<std::string>> modes_;
};

}  // namespace unlatch::library
