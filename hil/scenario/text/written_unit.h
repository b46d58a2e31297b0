// The unit in which a file gives a number, for tables that people compare with the file: mm where it says "0.5 mm".
#pragma once

#include <optional>
#include <string>

namespace unlatch::hil {

struct WrittenUnit {
  std::string name;   // as written: "deg/s"
  double factor = 1;  // SI value of one of it

  bool operator==(const WrittenUnit&) const = default;
};

// Unit of a single number with a unit behind it; nothing for a plain number, and for arithmetic.
std::optional<WrittenUnit> find_written_unit(const std::string& text);

}  // namespace unlatch::hil
