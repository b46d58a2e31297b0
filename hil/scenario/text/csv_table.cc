#include "hil/scenario/text/csv_table.h"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "hil/scenario/text/count.h"
#include "hil/scenario/text/expression.h"
#include "hil/scenario/text/number_text.h"

namespace unlatch::hil {
namespace {

constexpr std::size_t kMostColumns = 64, kShown = 40;

std::string quote(std::string_view text) {
  return "'" + std::string(text.substr(0, kShown)) + (text.size() > kShown ? "…'" : "'");
}

bool is_blank(char c) { return c == ' ' || c == '\t'; }

// A cell without the blanks around it, and its column.
struct Cell {
  std::string_view text;
  int column;
};

Cell trim(std::string_view line, std::size_t begin, std::size_t end) {
  while (begin < end && is_blank(line[begin])) ++begin;
  while (begin < end && is_blank(line[end - 1])) --end;
  return {line.substr(begin, end - begin), static_cast<int>(begin) + 1};
}

std::vector<Cell> split(std::string_view line, char separator) {
  std::vector<Cell> cells;
  for (std::size_t begin = 0;;) {
    const std::size_t end = std::min(line.find(separator, begin), line.size());
    cells.push_back(trim(line, begin, end));
    if (end == line.size() || cells.size() > kMostColumns) return cells;
    begin = end + 1;
  }
}

char find_separator(std::string_view heading) {
  for (const char c : {';', '\t'})
    if (heading.find(c) != std::string_view::npos) return c;
  return ',';
}

bool is_plain_name(std::string_view name) {
  const auto fits = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-';
  };
  return !name.empty() && name.size() <= kShown && std::ranges::all_of(name, fits);
}

void read_heading(const std::vector<Cell>& cells, int line, CsvTable& table) {
  for (const Cell& cell : cells) {
    const std::size_t bracket = cell.text.find('[');
    const bool has_unit = bracket != std::string_view::npos && cell.text.back() == ']';
    const std::string_view name = trim(cell.text, 0, std::min(bracket, cell.text.size())).text;
    if (!is_plain_name(name) || has_unit != (bracket != std::string_view::npos))
      throw CsvError(line, cell.column, quote(cell.text) + " is not the heading of a column",
                     "a name of letters, digits, _ and -, its unit in brackets behind it: alpha [deg]");
    if (std::ranges::find(table.names, name) != table.names.end())
      throw CsvError(line, cell.column, "a second column " + quote(name), "give each its own name");
    table.names.emplace_back(name);
    table.units.emplace_back(has_unit ? cell.text.substr(bracket + 1, cell.text.size() - bracket - 2)
                                      : std::string_view());
    table.headings.push_back({line, cell.column});
  }
  if (cells.size() > kMostColumns)
    throw CsvError(line, 1, "more than " + count(kMostColumns, "column"), "fewer columns");
  table.values.resize(cells.size());
  table.places.resize(cells.size());
}

double read_cell(const Cell& cell, int line) {
  double value = 0;
  const char* begin = cell.text.data();
  const char* const end = begin + cell.text.size();
  if (cell.text.size() > 1 && *begin == '+' && begin[1] != '-') ++begin;
  const auto [last, error] = std::from_chars(begin, end, value);
  if (cell.text.empty()) throw CsvError(line, cell.column, "a value is missing", "a number in each column");
  if (error != std::errc() || last != end)
    throw CsvError(line, cell.column, quote(cell.text) + " is not a number", "a number such as -1.5e3");
  if (!std::isfinite(value)) throw CsvError(line, cell.column, quote(cell.text) + " is not finite", "a finite number");
  return value;
}

void read_row(const std::vector<Cell>& cells, int line, CsvTable& table) {
  if (cells.size() != table.names.size())
    throw CsvError(line, cells.back().column,
                   "a row of " + count(cells.size(), "value") + " under " + count(table.names.size(), "heading"),
                   "one value in each column");
  for (std::size_t c = 0; c < cells.size(); ++c) {
    table.values[c].push_back(read_cell(cells[c], line));
    table.places[c].push_back({line, cells[c].column});
  }
}

}  // namespace

std::optional<Quantity> find_unit_of(const std::string& unit) {
  if (unit.empty()) return Quantity{1, {}};
  try {
    return evaluate_expression("1 " + unit, {});
  } catch (const ExpressionError&) {
    return std::nullopt;
  }
}

CsvTable read_csv(std::string_view text) {
  constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
  if (text.starts_with(kByteOrderMark)) text.remove_prefix(kByteOrderMark.size());
  CsvTable table;
  char separator = ',';
  int number = 0;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    std::string_view line = text.substr(begin, end - begin);
    begin = end + 1;
    ++number;
    if (line.ends_with('\r')) line.remove_suffix(1);
    const std::string_view content = trim(line, 0, line.size()).text;
    if (content.empty() || content[0] == '#') continue;
    if (table.names.empty()) {
      separator = find_separator(line);
      read_heading(split(line, separator), number, table);
    } else {
      read_row(split(line, separator), number, table);
    }
  }
  if (table.names.empty()) throw CsvError(1, 1, "there is no heading", "a first line with the names of the columns");
  if (table.values[0].empty()) throw CsvError(number, 1, "there are no rows", "one row per combination of knots");
  return table;
}

CsvGrid read_grid(const CsvTable& table, const std::vector<std::size_t>& axes, std::size_t column) {
  CsvGrid grid;
  grid.knots.resize(axes.size());
  const std::size_t rows = table.values[column].size();
  // The knots of an axis: the values in every `stride` rows, as long as they rise.
  std::size_t stride = 1;
  for (std::size_t a = axes.size(); a-- > 0;) {
    const std::vector<double>& values = table.values[axes[a]];
    std::vector<double>& knots = grid.knots[a];
    for (std::size_t r = 0; r < rows && (knots.empty() || values[r] > knots.back()); r += stride)
      knots.push_back(values[r]);
    if (knots.size() < 2) {
      const std::size_t next = std::min(stride, rows - 1);
      const CsvTable::Place place = table.places[axes[a]][next];
      throw CsvError(place.line, place.column,
                     "'" + table.names[axes[a]] + "' does not rise: " + write_short(values[next]) + " after " +
                         write_short(knots[0]),
                     "rows go through all combinations, each axis rising, the last one fastest");
    }
    stride *= knots.size();
  }
  // `stride` is the number of combinations now.
  for (std::size_t r = 0; r < rows; ++r) {
    std::size_t rest = r;
    for (std::size_t a = axes.size(); a-- > 0; rest /= grid.knots[a].size()) {
      const std::size_t count = grid.knots[a].size();
      const bool beyond = a == 0 && rest >= count;
      const double is = table.values[axes[a]][r];
      const CsvTable::Place place = table.places[axes[a]][r];
      if (beyond)
        throw CsvError(place.line, place.column,
                       "'" + table.names[axes[a]] + "' does not rise: " + write_short(is) + " after " +
                           write_short(grid.knots[a].back()),
                       "rows go through all combinations, each axis rising, the last one fastest");
      if (const double wanted = grid.knots[a][rest % count]; is != wanted)
        throw CsvError(
            place.line, place.column,
            "'" + table.names[axes[a]] + "' is " + write_short(is) + " where " + write_short(wanted) + " is expected",
            "rows go through all combinations, each axis rising, the last one fastest");
    }
  }
  if (rows != stride) {
    const CsvTable::Place last = table.places[column].back();
    throw CsvError(last.line, last.column,
                   "the table ends here, with " + count(rows, "row") + " of " + std::to_string(stride),
                   "one row per combination of knots");
  }
  grid.values = table.values[column];
  return grid;
}

}  // namespace unlatch::hil
