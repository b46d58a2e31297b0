#include "tools/import/resample.h"

#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <optional>

#include "hil/scenario/language/scenario_sources.h"
#include "hil/scenario/text/count.h"
#include "hil/scenario/text/csv_table.h"
#include "hil/scenario/text/number_text.h"
#include "tools/import/hull.h"
#include "tools/import/imported.h"
#include "unlatch/model/law_courses.h"
#include "unlatch/plan.h"

namespace unlatch::tools {
namespace {

using hil::count;
using hil::write_number;
using hil::write_short;

constexpr double kOnHull = 1e-9;    // in ranges of the axes: a knot this far from the hull is on it
constexpr double kTogether = 1e-9;  // likewise: points this near to one another are the same
constexpr double kFlat = 1e-9;      // of the greatest extent: points that extend less in some direction lie in a plane

[[noreturn]] void refuse(const hil::CsvTable::Place& place, const std::string& what, const std::string& mend) {
  throw ImportError("line " + std::to_string(place.line) + ", column " + std::to_string(place.column) + ": " + what +
                    "; " + mend);
}

// --- The points ------------------------------------------------------------------------------------------------------

// The file, and which of its columns are axes and values.
struct Points {
  hil::CsvTable table;
  std::vector<std::size_t> axes, columns;
  Eigen::VectorXd least, range;  // of the axes
  ScatteredValues scaled;        // axes from 0 to 1

  [[nodiscard]] int get_line(std::size_t point) const { return table.places[0][point].line; }
  [[nodiscard]] Eigen::VectorXd scale(const Eigen::VectorXd& at) const { return (at - least).cwiseQuotient(range); }
};

std::size_t find_column(const hil::CsvTable& table, const std::string& name) {
  const auto found = std::ranges::find(table.names, name);
  if (found != table.names.end()) return static_cast<std::size_t>(found - table.names.begin());
  std::string list;
  for (const std::string& own : table.names) list += (list.empty() ? "" : ", ") + own;
  throw ImportError("there is no column '" + name + "'; it has " + list);
}

void choose_columns(const ResampleRequest& request, Points& points) {
  for (const GridAxis& axis : request.axes) points.axes.push_back(find_column(points.table, axis.name));
  const auto is_axis = [&](std::size_t c) { return std::ranges::find(points.axes, c) != points.axes.end(); };
  for (const std::string& name : request.columns) points.columns.push_back(find_column(points.table, name));
  if (points.columns.empty())
    for (std::size_t c = 0; c < points.table.names.size(); ++c)
      if (!is_axis(c)) points.columns.push_back(c);
  if (points.columns.empty()) throw ImportError("all its columns are axes; one more has the values");
  for (const std::size_t c : points.columns)
    if (is_axis(c)) throw ImportError("column '" + points.table.names[c] + "' is an axis, and has no values");
}

void scale_points(Points& points) {
  const hil::CsvTable& table = points.table;
  const std::size_t rows = table.values[0].size();
  const auto axes = static_cast<Eigen::Index>(points.axes.size());
  points.least.resize(axes);
  points.range.resize(axes);
  points.scaled.points.resize(axes, static_cast<Eigen::Index>(rows));
  points.scaled.values.resize(static_cast<Eigen::Index>(rows), std::ssize(points.columns));
  for (Eigen::Index a = 0; a < axes; ++a) {
    const std::size_t column = points.axes[static_cast<std::size_t>(a)];
    const auto [least, most] = std::ranges::minmax(table.values[column]);
    if (!(most > least) || !std::isfinite(most - least))
      refuse(table.places[column][0], "'" + table.names[column] + "' is " + write_short(least) + " at all points",
             "leave this axis out, or add points");
    points.least[a] = least;
    points.range[a] = most - least;
    for (std::size_t r = 0; r < rows; ++r)
      points.scaled.points(a, static_cast<Eigen::Index>(r)) = (table.values[column][r] - least) / (most - least);
  }
  for (std::size_t c = 0; c < points.columns.size(); ++c)
    for (std::size_t r = 0; r < rows; ++r)
      points.scaled.values(static_cast<Eigen::Index>(r), static_cast<Eigen::Index>(c)) =
          table.values[points.columns[c]][r];
}

void check_apart(const Points& points) {
  const Eigen::MatrixXd& at = points.scaled.points;
  for (Eigen::Index i = 1; i < at.cols(); ++i) {
    Eigen::Index nearest = 0;
    const double distance = (at.leftCols(i).colwise() - at.col(i)).colwise().squaredNorm().minCoeff(&nearest);
    if (distance <= kTogether * kTogether)
      refuse(points.table.places[points.axes[0]][static_cast<std::size_t>(i)],
             "this point stands in line " + std::to_string(points.get_line(static_cast<std::size_t>(nearest))) +
                 " already",
             "keep one of them, or their mean");
  }
}

void check_extent(const Points& points) {
  const Eigen::MatrixXd& at = points.scaled.points;
  const Eigen::VectorXd extents = (at.colwise() - at.rowwise().mean()).jacobiSvd().singularValues();
  if (extents.minCoeff() > kFlat * extents.maxCoeff()) return;
  throw ImportError(at.rows() == 2
                        ? "all its points lie on one line of the axes; use one axis, or add points beside it"
                        : "all its points lie in one plane of the axes; use fewer axes, or add points beside it");
}

Points read_points(const std::string& text, const ResampleRequest& request) {
  Points points;
  try {
    points.table = hil::read_csv(text);
  } catch (const hil::CsvError& error) {
    refuse({error.line, error.column}, error.what(), error.mend);
  }
  choose_columns(request, points);
  const std::size_t rows = points.table.values[0].size(), fewest = points.axes.size() + 2;
  if (rows < fewest)
    throw ImportError("it has " + count(rows, "point") + "; over these axes at least " + std::to_string(fewest) +
                      " are needed");
  if (rows > kMostScattered)
    throw ImportError("it has " + count(rows, "point") + "; at most " + std::to_string(kMostScattered) +
                      " are taken: thin them out where the values change little");
  scale_points(points);
  check_apart(points);
  check_extent(points);
  return points;
}

// --- The grid --------------------------------------------------------------------------------------------------------

// Calls `act` with the indices of the knots of each entry, the last axis fastest.
template <class Act>
void for_each_entry(const std::vector<GridAxis>& axes, const Act& act) {
  std::vector<std::size_t> knots(axes.size());
  for (std::size_t axis = axes.size(); axis > 0;) {
    act(knots);
    for (axis = axes.size(); axis > 0; --axis) {
      if (++knots[axis - 1] < axes[axis - 1].knots.size()) break;
      knots[axis - 1] = 0;
    }
  }
}

Eigen::VectorXd get_place(const std::vector<GridAxis>& axes, const std::vector<std::size_t>& knots) {
  Eigen::VectorXd at(std::ssize(axes));
  for (std::size_t a = 0; a < axes.size(); ++a) at[static_cast<Eigen::Index>(a)] = axes[a].knots[knots[a]];
  return at;
}

std::string describe(const std::vector<GridAxis>& axes, const Eigen::VectorXd& at) {
  std::string text;
  for (std::size_t a = 0; a < axes.size(); ++a)
    text += (a > 0 ? ", " : "") + axes[a].name + " " + write_short(at[static_cast<Eigen::Index>(a)]);
  return text;
}

// Values of all columns at the entries; counts those outside of the hull.
Eigen::MatrixXd calc_entries(const ResampleRequest& request, const Points& points,
                             const ScatteredInterpolant& interpolant, Resampled& result) {
  std::vector<Eigen::RowVectorXd> rows;
  std::string first;
  for_each_entry(request.axes, [&](const std::vector<std::size_t>& knots) {
    const Eigen::VectorXd at = get_place(request.axes, knots);
    Eigen::VectorXd scaled = points.scale(at);
    const NearestInHull nearest = find_nearest_in_hull(points.scaled.points, scaled);
    if (nearest.distance > kOnHull) {
      if (result.outside++ == 0) first = describe(request.axes, at);
      result.farthest = std::max(result.farthest, nearest.distance);
      scaled = nearest.point;
      if (!request.nearest) return;
    }
    const std::optional<Eigen::RowVectorXd> value = interpolant.calc(scaled);
    if (!value)
      throw ImportError("the nearest " + count(result.neighbours, "point") + " to " + describe(request.axes, at) +
                        " lie in one plane of the axes, and decide no value there; take more: --neighbours");
    rows.push_back(*value);
  });
  if (result.outside > 0 && !request.nearest)
    throw ImportError("outside of the points' hull: " + count(result.outside, "entry") +
                      " of the table, the first at " + first + ", the farthest by " + write_short(result.farthest) +
                      " of the axes' ranges; values there would be extrapolated: make the grid smaller, add points, or "
                      "take the value of the hull's nearest point (--outside nearest)");
  Eigen::MatrixXd values(std::ssize(rows), points.scaled.values.cols());
  for (std::size_t r = 0; r < rows.size(); ++r) values.row(static_cast<Eigen::Index>(r)) = rows[r];
  return values;
}

// --- Errors ----------------------------------------------------------------------------------------------------------

void add(PointErrors& errors, double error, int line) {
  ++errors.count;
  errors.rms += error * error;
  if (!(std::abs(error) > errors.greatest)) return;
  errors.greatest = std::abs(error);
  errors.line = line;
}

void close(PointErrors& errors) {
  if (errors.count > 0) errors.rms = std::sqrt(errors.rms / static_cast<double>(errors.count));
}

void leave_out(const Points& points, const ScatteredInterpolant& interpolant, Resampled& result) {
  const std::vector<std::optional<Eigen::RowVectorXd>> errors = interpolant.calc_left_out();
  const Eigen::MatrixXd& at = points.scaled.points;
  for (std::size_t i = 0; i < errors.size(); ++i) {
    if (!errors[i]) {
      ++result.undecided;
      continue;
    }
    const bool corner =
        find_nearest_in_hull(at, at.col(static_cast<Eigen::Index>(i)), static_cast<int>(i)).distance > kOnHull;
    for (std::size_t c = 0; c < result.columns.size(); ++c) {
      ResampledColumn& column = result.columns[c];
      add(corner ? column.corners : column.inside, (*errors[i])[static_cast<Eigen::Index>(c)], points.get_line(i));
    }
  }
}

// A model whose only law looks a table up at the commands of its channels.
Model build_table_model(const std::vector<GridAxis>& axes, const Eigen::VectorXd& values,
                        Table::Interpolation interpolation) {
  Model model;
  Body& body = model.bodies.emplace_back();
  body.name = "body";
  body.mass = 1;
  body.inertia.setIdentity();
  Table& table = model.tables.emplace_back();
  table.name = "table";
  table.interpolation = interpolation;
  table.values.assign(values.data(), values.data() + values.size());
  Law& law = model.laws.emplace_back();
  law.name = "law";
  for (std::size_t a = 0; a < axes.size(); ++a) {
    table.axes.push_back({.name = axes[a].name, .knots = axes[a].knots});
    const std::vector<double>& knots = axes[a].knots;
    model.channels.push_back({axes[a].name, knots[0], knots.front(), knots.back(), knots[0], "1"});
    law.steps.push_back({LawStep::Kind::kCommand, static_cast<int>(a)});
  }
  law.steps.push_back({LawStep::Kind::kTable, 0});
  return model;
}

// What the table gives at the points that its axes span.
void compare_table(const Points& points, const ResampleRequest& request, const Eigen::VectorXd& values, std::size_t c,
                   Table::Interpolation interpolation, PointErrors& errors) {
  const Model model = build_table_model(request.axes, values, interpolation);
  const PlanResult compiled = compile_plan(model, {});
  if (!compiled.plan) throw ImportError(compiled.errors.at(0).where + ": " + compiled.errors.at(0).what);
  LawCourses courses(model, *compiled.plan);
  const int law = 0;
  std::vector<double> at(request.axes.size());
  for (std::size_t i = 0; i < points.table.values[0].size(); ++i) {
    bool spanned = true;
    for (std::size_t a = 0; a < at.size(); ++a) {
      at[a] = points.table.values[points.axes[a]][i];
      spanned = spanned && at[a] >= request.axes[a].knots.front() && at[a] <= request.axes[a].knots.back();
    }
    if (!spanned) continue;
    courses.update({&law, 1}, at, {});
    add(errors, courses.get(law).middle - points.table.values[points.columns[c]][i], points.get_line(i));
  }
  close(errors);
}

// --- The file --------------------------------------------------------------------------------------------------------

std::string describe(const PointErrors& errors, const Resampled& result) {
  return "RMS " + write_short(errors.rms) + ", greatest " + write_short(errors.greatest) +
         (errors.greatest > 0 ? " at " + result.places.at(errors.line) : "");
}

std::string write_csv(const ResampleRequest& request, const Points& points, const Eigen::MatrixXd& values,
                      const Resampled& result) {
  std::string text = "# Resampled by unlatch from " + count(result.points, "scattered point") +
                     ", by radial functions " + (request.radial == Radial::kSmooth ? "r^3" : "r") +
                     (result.neighbours > 0 ? " about the nearest " + std::to_string(result.neighbours) : "") + ".\n";
  if (result.outside > 0)
    text += "# Outside of the points' hull: " + count(result.outside, "entry") + " of " +
            std::to_string(result.entries) + ", with the value of its nearest point, at most " +
            write_short(result.farthest) + " of the axes' ranges away.\n";
  for (const ResampledColumn& column : result.columns) {
    text += "# Errors of " + column.name + ", which is from " + write_short(column.least) + " to " +
            write_short(column.most) + ":\n";
    if (column.inside.count > 0) text += "#   a point left out: " + describe(column.inside, result) + "\n";
    if (column.corners.count > 0)
      text += "#   a corner of the hull left out: " + describe(column.corners, result) + "\n";
    if (column.linear.count > 0) {
      text += "#   this table at the points, linear: " + describe(column.linear, result) + "\n";
      text += "#   this table at the points, smooth: " + describe(column.smooth, result) + "\n";
    }
  }
  const auto write_heading = [&](std::size_t c) {
    const std::string& unit = points.table.units[c];
    return points.table.names[c] + (unit.empty() ? "" : " [" + unit + "]");
  };
  std::string heading;
  for (const std::vector<std::size_t>& columns : {points.axes, points.columns})
    for (const std::size_t c : columns) heading += (heading.empty() ? "" : ", ") + write_heading(c);
  text += heading + "\n";
  Eigen::Index row = 0;
  for_each_entry(request.axes, [&](const std::vector<std::size_t>& knots) {
    for (std::size_t a = 0; a < knots.size(); ++a)
      text += (a > 0 ? "," : "") + write_number(request.axes[a].knots[knots[a]]);
    for (Eigen::Index c = 0; c < values.cols(); ++c) text += "," + write_number(values(row, c));
    text += "\n";
    ++row;
  });
  return text;
}

void check_grid(const ResampleRequest& request) {
  double entries = 1;
  for (const GridAxis& axis : request.axes) entries *= static_cast<double>(axis.knots.size());
  if (entries > static_cast<double>(kMostTableValues))
    throw ImportError("the grid has more than " + std::to_string(kMostTableValues) + " entries; fewer knots");
}

}  // namespace

Resampled resample(const std::string& text, const ResampleRequest& request) {
  check_grid(request);
  const Points points = read_points(text, request);
  Resampled result;
  result.points = points.table.values[0].size();
  const int wanted = request.neighbours > 0                                    ? request.neighbours
                     : result.points > static_cast<std::size_t>(kFewScattered) ? kNeighbours
                                                                               : 0;
  result.neighbours = static_cast<std::size_t>(wanted) < result.points ? wanted : 0;
  for (const std::size_t c : points.columns) {
    const auto [least, most] = std::ranges::minmax(points.table.values[c]);
    result.columns.push_back(
        {.name = points.table.names[c], .unit = points.table.units[c], .least = least, .most = most});
  }
  for (std::size_t i = 0; i < result.points; ++i) {
    Eigen::VectorXd at(std::ssize(points.axes));
    for (std::size_t a = 0; a < points.axes.size(); ++a)
      at[static_cast<Eigen::Index>(a)] = points.table.values[points.axes[a]][i];
    result.places[points.get_line(i)] = describe(request.axes, at);
  }
  const ScatteredInterpolant interpolant(points.scaled, request.radial, result.neighbours);
  const Eigen::MatrixXd values = calc_entries(request, points, interpolant, result);
  if (!values.allFinite()) throw ImportError("the values are too large to be interpolated");
  result.entries = static_cast<std::size_t>(values.rows());
  leave_out(points, interpolant, result);
  for (std::size_t c = 0; c < result.columns.size(); ++c) {
    ResampledColumn& column = result.columns[c];
    close(column.inside);
    close(column.corners);
    const Eigen::VectorXd own = values.col(static_cast<Eigen::Index>(c));
    compare_table(points, request, own, c, Table::Interpolation::kLinear, column.linear);
    compare_table(points, request, own, c, Table::Interpolation::kSmooth, column.smooth);
  }
  result.csv = write_csv(request, points, values, result);
  if (result.csv.size() > hil::kMaxTableBytes)
    throw ImportError("the table has " + count(result.csv.size(), "byte") + ", and the tables of a scenario at most " +
                      std::to_string(hil::kMaxTableBytes) + "; fewer knots");
  return result;
}

}  // namespace unlatch::tools
