// Handles of the C library for tests: closed at the end of their scope, failures as failures of the test.
#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstring>
#include <filesystem>
#include <string>
#include <vector>

#include "unlatch.h"

namespace unlatch::test {

inline const char* const kReference = UNLATCH_SOURCE_DIR "/hil/scenarios/boosters/reference.yaml";
inline const char* const kScenario = UNLATCH_SOURCE_DIR "/hil/scenarios/boosters/scenario.yaml";

class Loaded {
 public:
  explicit Loaded(unlatch_simulation* handle) : handle_(handle) {}
  explicit Loaded(const char* path, const unlatch_options* options = nullptr) {
    EXPECT_EQ(unlatch_load(path, options, &handle_), UNLATCH_OK) << unlatch_get_error(0)->text;
  }
  ~Loaded() { EXPECT_EQ(unlatch_close(handle_), UNLATCH_OK); }
  Loaded(const Loaded&) = delete;
  Loaded& operator=(const Loaded&) = delete;

  [[nodiscard]] unlatch_simulation* get() const { return handle_; }
  [[nodiscard]] std::uint64_t get_hash() const {
    std::uint64_t hash = 0;
    EXPECT_EQ(unlatch_get_hash(handle_, &hash), UNLATCH_OK);
    return hash;
  }
  [[nodiscard]] std::size_t count(std::int32_t kind) const {
    std::size_t number = 0;
    EXPECT_EQ(unlatch_count(handle_, kind, &number), UNLATCH_OK);
    return number;
  }
  [[nodiscard]] std::size_t find(std::int32_t kind, const char* name) const {
    std::size_t index = 0;
    EXPECT_EQ(unlatch_find(handle_, kind, name, &index), UNLATCH_OK) << name;
    return index;
  }
  [[nodiscard]] unlatch_item describe(std::int32_t kind, std::size_t index) const {
    unlatch_item item{};
    item.size = sizeof item;
    EXPECT_EQ(unlatch_describe(handle_, kind, index, &item), UNLATCH_OK);
    return item;
  }
  [[nodiscard]] unlatch_array get_array(std::int32_t which, std::size_t index = 0) const {
    unlatch_array array{};
    array.size = sizeof array;
    EXPECT_EQ(unlatch_get_array(handle_, which, index, &array), UNLATCH_OK) << unlatch_get_error(0)->text;
    return array;
  }
  [[nodiscard]] std::vector<double> get_numbers(std::int32_t which, std::size_t index = 0) const {
    const unlatch_array array = get_array(which, index);
    std::vector<double> numbers;
    for (std::size_t row = 0; row < array.rows; ++row)
      for (std::size_t column = 0; column < array.columns; ++column)
        numbers.push_back(unlatch_get_number(&array, row, column));
    return numbers;
  }
  [[nodiscard]] std::size_t count_events() const {
    const unlatch_event* events = nullptr;
    std::size_t number = 0;
    EXPECT_EQ(unlatch_get_events(handle_, &events, &number, nullptr), UNLATCH_OK);
    return number;
  }
  [[nodiscard]] std::vector<std::byte> save() const {
    std::size_t needed = 0;
    EXPECT_EQ(unlatch_save(handle_, nullptr, 0, &needed), UNLATCH_OK);
    std::vector<std::byte> bytes(needed);
    EXPECT_EQ(unlatch_save(handle_, bytes.data(), bytes.size(), &needed), UNLATCH_OK);
    return bytes;
  }

 private:
  unlatch_simulation* handle_ = nullptr;
};

// Options with one override.
class Override {
 public:
  explicit Override(const char* text) : text_(text) {
    options_.size = sizeof options_;
    options_.overrides = &text_;
    options_.override_count = 1;
  }
  Override(const Override&) = delete;
  Override& operator=(const Override&) = delete;
  [[nodiscard]] const unlatch_options* get() const { return &options_; }

 private:
  const char* text_;
  unlatch_options options_{};
};

// Folder that is removed at the end.
class Scratch {
 public:
  Scratch() {
    std::string name = (std::filesystem::temp_directory_path() / "unlatch_library_XXXXXX").string();
    path_ = mkdtemp(name.data());
  }
  ~Scratch() { std::filesystem::remove_all(path_); }
  Scratch(const Scratch&) = delete;
  Scratch& operator=(const Scratch&) = delete;
  std::string operator/(const char* name) const { return (path_ / name).string(); }

 private:
  std::filesystem::path path_;
};

}  // namespace unlatch::test
