// unlatch resample: scattered points as a table over a grid.
#include <charconv>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "hil/scenario/language/scenario_sources.h"
#include "hil/scenario/yaml/scenario_error.h"
#include "tools/common/output.h"
#include "tools/common/text.h"
#include "tools/import/imported.h"
#include "tools/import/resample.h"
#include "tools/program/exit_codes.h"
#include "tools/unlatch/files/verbs.h"

namespace unlatch::tools {
namespace {

using Json = nlohmann::ordered_json;

struct ResampleOptions {
  std::string file, out, radial = "smooth", outside = "error", json;
  std::vector<std::string> axes, columns;
  int neighbours = 0;
  bool force = false;
};

double read_knot(const std::string& text, const std::string& axis) {
  double value = 0;
  const char* const end = text.data() + text.size();
  const auto [last, error] = std::from_chars(text.data(), end, value);
  if (error != std::errc() || last != end || !std::isfinite(value))
    refuse_option("--axis", "'" + axis + "': '" + text + "' is not a number");
  return value;
}

std::vector<std::string> split(const std::string& text, char separator) {
  std::vector<std::string> parts;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find(separator, begin), text.size());
    parts.push_back(text.substr(begin, end - begin));
    begin = end + 1;
  }
  return parts;
}

// NAME=0.5,0.8,1.2 or NAME=FROM:TO:COUNT
GridAxis read_axis(const std::string& text) {
  const std::size_t equals = text.find('=');
  if (equals == 0 || equals == std::string::npos)
    refuse_option("--axis", "'" + text + "' is neither NAME=KNOT,KNOT,… nor NAME=FROM:TO:COUNT");
  GridAxis axis{text.substr(0, equals), {}};
  const std::string knots = text.substr(equals + 1);
  if (const std::vector<std::string> range = split(knots, ':'); range.size() == 3) {
    const double from = read_knot(range[0], text), to = read_knot(range[1], text), number = read_knot(range[2], text);
    if (!(number >= 2 && number <= static_cast<double>(kMostTableKnots)) || number != std::floor(number))
      refuse_option("--axis", "'" + text + "': a whole number of knots from 2 to " + std::to_string(kMostTableKnots));
    const int last = static_cast<int>(number) - 1;
    for (int i = 0; i <= last; ++i) axis.knots.push_back((from * (last - i) + to * i) / last);
  } else {
    for (const std::string& knot : split(knots, ',')) axis.knots.push_back(read_knot(knot, text));
  }
  if (axis.knots.size() < 2) refuse_option("--axis", "'" + text + "': at least two knots");
  for (std::size_t i = 1; i < axis.knots.size(); ++i)
    if (!(axis.knots[i] > axis.knots[i - 1])) refuse_option("--axis", "'" + text + "': each knot above the one before");
  return axis;
}

ResampleRequest read_request(const ResampleOptions& options) {
  ResampleRequest request;
  for (const std::string& text : options.axes) {
    request.axes.push_back(read_axis(text));
    for (std::size_t i = 0; i + 1 < request.axes.size(); ++i)
      if (request.axes[i].name == request.axes.back().name)
        refuse_option("--axis", "'" + request.axes.back().name + "' stands twice");
  }
  if (request.axes.size() > kMostTableAxes)
    refuse_option("--axis", "a table has at most " + std::to_string(kMostTableAxes) + " axes");
  request.columns = options.columns;
  request.radial = options.radial == "smooth" ? Radial::kSmooth : Radial::kLinear;
  request.neighbours = options.neighbours;
  if (request.neighbours > 0 && request.neighbours < static_cast<int>(request.axes.size()) + 2)
    refuse_option("--neighbours", "at least " + std::to_string(request.axes.size() + 2) + ", two more than axes");
  request.nearest = options.outside == "nearest";
  return request;
}

// The text of the points. Throws ImportError.
std::string read_points_text(const std::string& file) {
  try {
    return hil::read_text_file(file, "file of points", kMostScatteredBytes);
  } catch (const hil::ScenarioError& error) {
    throw ImportError(error.mistakes.at(0).what);
  }
}

Json build_json(const PointErrors& errors, const Resampled& result) {
  if (errors.count == 0) return nullptr;
  Json json = {{"points", errors.count}, {"rms", errors.rms}, {"greatest", errors.greatest}};
  if (errors.greatest > 0) {
    json["line"] = errors.line;
    json["at"] = result.places.at(errors.line);
  }
  return json;
}

Json build_json(const Resampled& result) {
  Json columns = Json::object();
  for (const ResampledColumn& column : result.columns)
    columns[column.name] = {{"unit", column.unit},
                            {"least", column.least},
                            {"most", column.most},
                            {"left_out", build_json(column.inside, result)},
                            {"corners_left_out", build_json(column.corners, result)},
                            {"table_linear", build_json(column.linear, result)},
                            {"table_smooth", build_json(column.smooth, result)}};
  return {{"schema", 1},
          {"points", result.points},
          {"entries", result.entries},
          {"neighbours", result.neighbours},
          {"outside", result.outside},
          {"farthest", result.farthest},
          {"undecided", result.undecided},
          {"columns", columns}};
}

void print_errors(std::FILE* to, const char* what, const PointErrors& errors, const Resampled& result) {
  if (errors.count == 0) return;
  std::fprintf(to, "  %-34s %-12s %-12s", what, to_short_text(errors.rms).c_str(),
               to_short_text(errors.greatest).c_str());
  if (errors.greatest > 0) std::fprintf(to, " %s (line %d)", result.places.at(errors.line).c_str(), errors.line);
  std::fprintf(to, "\n");
}

void print(std::FILE* to, const ResampleOptions& options, const Resampled& result) {
  std::fprintf(to, "%s: %s of %s\n", options.out.c_str(), count(result.entries, "entry").c_str(),
               count(result.points, "point").c_str());
  if (result.outside > 0)
    std::fprintf(to,
                 "outside of the points' hull: %s, with the value of its nearest point, at most %s of the axes' "
                 "ranges away\n",
                 count(result.outside, "entry").c_str(), to_short_text(result.farthest).c_str());
  for (const ResampledColumn& column : result.columns) {
    std::fprintf(to, "%s%s, from %s to %s\n", column.name.c_str(),
                 column.unit.empty() ? "" : (" [" + column.unit + "]").c_str(), to_short_text(column.least).c_str(),
                 to_short_text(column.most).c_str());
    std::fprintf(to, "  %-34s %-12s %-12s %s\n", "error", "RMS", "greatest", "at");
    print_errors(to, "a point left out", column.inside, result);
    print_errors(to, "a corner of the hull left out", column.corners, result);
    print_errors(to, "the table at the points, linear", column.linear, result);
    print_errors(to, "the table at the points, smooth", column.smooth, result);
  }
  if (result.undecided > 0)
    std::fprintf(to, "left out without an error, since the others lie in one plane: %s\n",
                 count(result.undecided, "point").c_str());
}

int run(const ResampleOptions& options) {
  const ResampleRequest request = read_request(options);
  if (!options.force && options.out != "-" && std::filesystem::exists(options.out))
    refuse_option("--out", options.out + " exists; --force replaces it");
  check_output(options.out);
  const Resampled result = resample(read_points_text(options.file), request);
  write_text(result.csv, options.out);
  print(options.out == "-" || options.json == "-" ? stderr : stdout, options, result);
  write_json(build_json(result), options.json);
  return kExitDone;
}

}  // namespace

void add_resample(Command app, int& exit_code) {
  auto options = std::make_shared<ResampleOptions>();
  Command command = app.add_verb(
      "resample",
      "Makes a table over a grid from values at scattered points, such as a database of CFD, and prints its error. The "
      "file is CSV: a heading with names and units, a point in each row. Radial functions pass through all points; "
      "distances are in parts of each axis's range. Errors: what the other points give where one is left out, of "
      "points "
      "that others surround and of corners of the hull, where that extrapolates; and what the table gives at the "
      "points, "
      "linear and smooth, which is the error of its grid. Refused, with their line: points that stand twice, what is "
      "no "
      "finite number, points in one plane. The first lines of the table have the errors too.",
      "unlatch resample cfd.csv --axis mach=0.5,0.9,1.1,2 --axis alpha=-10:10:21 --out aero.csv\n"
      "unlatch resample cfd.csv --axis mach=0.5:2:16 --axis alpha=-10:10:21 --column cx --outside nearest --out "
      "cx.csv");
  command.add_option("FILE", options->file, "points (.csv)").required();
  command
      .add_option("--axis", options->axes,
                  "a column, and the table's knots in its unit: NAME=KNOT,KNOT,… or NAME=FROM:TO:COUNT; once for each "
                  "axis, in their order")
      .required()
      .repeatable()
      .type_name("AXIS");
  command.add_option("--column", options->columns, "a column of values (default: all that are no axes)")
      .repeatable()
      .type_name("NAME");
  command.add_option("--out", options->out, "table to write (.csv); - for standard output")
      .required()
      .type_name("FILE");
  command
      .add_option("--radial", options->radial,
                  "radial function: smooth is r^3; linear is r, which swings less beside jumps")
      .one_of({"smooth", "linear"})
      .default_shown();
  command
      .add_option("--neighbours", options->neighbours,
                  "points that count at a place, the nearest ones (default: all up to 1000 points, else 60)")
      .within(1, static_cast<int>(kMostScattered));
  command
      .add_option("--outside", options->outside,
                  "entries outside of the points' convex hull: an error, or the value of its nearest point")
      .one_of({"error", "nearest"})
      .default_shown();
  command.add_flag("--force", options->force, "overwrites an existing file");
  command.add_json_option(options->json);
  command.callback([options, &exit_code] {
    try {
      exit_code = run(*options);
    } catch (const ImportError& error) {
      std::fprintf(stderr, "%s: %s\n", options->file.c_str(), error.what());
      exit_code = kExitUsage;
    }
  });
}

}  // namespace unlatch::tools
