// Scattered points, such as a database of CFD, as a table over a grid, with the error that this brings.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "tools/import/scattered.h"

namespace unlatch::tools {

inline constexpr std::size_t kMostScattered = 20000;          // points
inline constexpr std::size_t kMostScatteredBytes = 16 << 20;  // of their file
inline constexpr int kFewScattered = 1000;                    // up to here all points count everywhere
inline constexpr int kNeighbours = 60;                        // of more points, those that count at a place

// An axis of the table; knots in the unit of the file's column.
struct GridAxis {
  std::string name;
  std::vector<double> knots;
};

struct ResampleRequest {
  std::vector<GridAxis> axes;        // columns, in the order of the table's axes
  std::vector<std::string> columns;  // of values; none: all others
  Radial radial = Radial::kSmooth;
  int neighbours = 0;    // that count at a place; 0: kNeighbours where there are more than kFewScattered
  bool nearest = false;  // knots outside of the points' hull take the value of its nearest point; else they are refused
};

// Errors of one column at the points.
struct PointErrors {
  double rms = 0, greatest = 0;  // absolute
  int line = 0;                  // of the point with the greatest
  std::size_t count = 0;         // points
};

struct ResampledColumn {
  std::string name, unit;
  double least = 0, most = 0;  // of the points
  // What the other points give, less the point's value: of points that the others surround, and of those at corners
  // of the hull, where the others are extrapolated.
  PointErrors inside = {}, corners = {};
  // What the table gives, less the point's value: of points within the table's axes.
  PointErrors linear = {}, smooth = {};
};

struct Resampled {
  std::string csv;  // the table
  std::size_t points = 0, entries = 0;
  int neighbours = 0;  // that count at a place; 0: all
  std::vector<ResampledColumn> columns;
  std::size_t outside = 0;            // entries outside of the hull
  double farthest = 0;                // of them, in ranges of the axes
  std::size_t undecided = 0;          // points whose neighbours do not decide a value there
  std::map<int, std::string> places;  // by line: "mach 1.2, alpha 4"
};

// `text`: a CSV file with a heading (hil/scenario/text/csv_table.h). Throws ImportError.
Resampled resample(const std::string& text, const ResampleRequest& request);

}  // namespace unlatch::tools
