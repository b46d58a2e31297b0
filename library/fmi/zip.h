// Writes zip files of stored members (PKWARE's APPNOTE, 4.3). The same members give the same bytes.
#pragma once

#include <cstdint>
#include <initializer_list>
#include <string>

namespace unlatch::fmi {

class Zip {
 public:
  void add(const std::string& name, const std::string& bytes);
  // Returns the whole file.
  [[nodiscard]] std::string finish();

 private:
  static void put(std::string& to, std::initializer_list<std::uint64_t> numbers, int bytes);
  std::string file_, directory_;
  std::uint64_t count_ = 0;
};

}  // namespace unlatch::fmi
