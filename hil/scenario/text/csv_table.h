// CSV files of numbers, and the grids that they describe.
//
//   # drag of the capsule          lines that begin with # and empty lines do not count
//   mach, alpha [deg], cx, cz      a heading: names, each with its unit in brackets if it has one
//   0.5, 0, 0.81, 0                rows of numbers; separated by commas, semicolons or tabs
//
// The text comes from outside: at most 64 columns, every cell a finite number, every row complete. In a grid the rows
// go through all combinations of the axes' knots, each rising, the last axis fastest.
#pragma once

#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "hil/scenario/text/quantity.h"

namespace unlatch::hil {

// A mistake in such a text; line and column count from 1.
class CsvError : public std::runtime_error {
 public:
  CsvError(int line_in, int column_in, const std::string& what_in, std::string mend_in)
      : std::runtime_error(what_in), line(line_in), column(column_in), mend(std::move(mend_in)) {}
  int line, column;
  std::string mend;
};

struct CsvTable {
  struct Place {
    int line, column;
  };
  std::vector<std::string> names, units;    // of the columns; "" without a unit
  std::vector<Place> headings;              // where they stand
  std::vector<std::vector<double>> values;  // by column
  std::vector<std::vector<Place>> places;   // likewise
};

// What the unit of a heading means: `1 deg`; "" is a plain 1. Nothing for what is no unit.
std::optional<Quantity> find_unit_of(const std::string& unit);

// Throws CsvError.
CsvTable read_csv(std::string_view text);

// The knots of each axis, and the values of one column over them, the last axis fastest.
struct CsvGrid {
  std::vector<std::vector<double>> knots;
  std::vector<double> values;
};

// `axes` and `column`: indices of columns. Throws CsvError where a combination lacks, stands twice or out of order.
CsvGrid read_grid(const CsvTable& table, const std::vector<std::size_t>& axes, std::size_t column);

}  // namespace unlatch::hil
