// The unit in which a file gives a number, for tables that people compare with the file: mm where it says "0.5 mm";
// units of sensors' data sheets: deg/h, deg/√h, µg/√Hz.
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

// The text with units of data sheets (h, hr, µg, mg, Hz, arcsec, mdps, ppm …) written in those of the language.
std::string replace_sheet_units(const std::string& text);
// "0.1 deg / √h" → "(0.1 deg)^2/(h)"; empty if there is no root at the end.
std::string square_root_unit(const std::string& text);

// A number whose unit has the root of a time: "0.05 deg/√h".
struct RootUnit {
  double value = 0;                    // in `unit`
  std::string unit;                    // SI: "rad/√s"
  std::optional<WrittenUnit> shown{};  // as written
};
// Nothing for a text without such a root, or with another dimension under it.
std::optional<RootUnit> read_root_unit(const std::string& text);

}  // namespace unlatch::hil
