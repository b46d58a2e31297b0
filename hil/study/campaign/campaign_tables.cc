// Tables of numbers, and expansion of paths with *.
#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <limits>

#include "hil/scenario/text/count.h"
#include "hil/scenario/text/csv_table.h"
#include "hil/scenario/yaml/yaml_override.h"
#include "hil/study/campaign/campaign_reader.h"

namespace unlatch::hil {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMostMet = 500, kMostTableBytes = std::size_t{256} << 20;

std::vector<std::string> split(const std::string& line, char separator) {
  std::vector<std::string> cells(1);
  bool quoted = false;  // no separator is one
  for (const char c : line)
    if (c == '"')
      quoted = !quoted;
    else if (c == separator && !quoted)
      cells.emplace_back();
    else if (c != '\r')
      cells.back() += c;
  return cells;
}

std::vector<std::string> split_lines(const std::string& text) {
  std::vector<std::string> lines(1);
  for (const char c : text)
    if (c == '\n')
      lines.emplace_back();
    else
      lines.back() += c;
  return lines;
}

std::string trim(const std::string& text) {
  const std::size_t begin = text.find_first_not_of(' '), end = text.find_last_not_of(' ');
  return begin == std::string::npos ? "" : text.substr(begin, end - begin + 1);
}

// Returns the part of `text` that * stands for; nothing if the pattern, with one *, does not match.
std::optional<std::string> match(const std::string& pattern, const std::string& text) {
  const std::size_t star = pattern.find('*'), after = pattern.size() - star - 1;
  if (text.size() < star + after || text.compare(0, star, pattern, 0, star) != 0) return std::nullopt;
  if (text.compare(text.size() - after, after, pattern, star + 1, after) != 0) return std::nullopt;
  return text.substr(star, text.size() - star - after);
}

// Lists the names by which a path reaches the children of a node.
std::vector<std::string> list_children(const YamlNode& node) {
  std::vector<std::string> names;
  for (const YamlKey& key : node.keys) names.push_back(key.text);
  if (!node.is_sequence()) return names;
  for (std::size_t i = 0; i < node.items.size(); ++i) {
    const YamlNode& item = node.items[i];
    const YamlNode *const id = item.find("id"), *const name = item.find("name"), *const subject = item.find("subject");
    if (id != nullptr)
      names.push_back(id->text);
    else if (name != nullptr)
      names.push_back(name->text + (subject != nullptr ? ":" + subject->text : ""));
    else
      names.push_back(std::to_string(i));
  }
  return names;
}

}  // namespace

std::vector<MetPath> expand_path(const std::string& path, const SourceMark& mark, const YamlNode& root) {
  std::vector<MetPath> met{{}};
  for (const std::string& part : split(path, '.')) {
    const bool starred = part.find('*') != std::string::npos;
    if (starred && std::count(part.begin(), part.end(), '*') > 1)
      throw YamlError(mark, "two * in one part of '" + path + "'", "write one");
    std::vector<MetPath> next;
    for (const MetPath& before : met) {
      const std::string dot = before.path.empty() ? "" : before.path + ".";
      if (!starred) {
        next.push_back({dot + part, before.stars, before.parts});
        continue;
      }
      const YamlNode* const node = before.path.empty() ? &root : find_value(before.path, mark, root);
      if (node == nullptr) continue;
      const std::string colon = before.parts.empty() ? "" : ":";
      for (const std::string& name : list_children(*node))
        if (const auto star = match(part, name))
          next.push_back({dot + name, before.stars + colon + *star, before.parts + colon + name});
    }
    met = std::move(next);
    if (met.size() > kMostMet) throw YamlError(mark, "'" + path + "' meets more than 500 values", "write it closer");
  }
  if (met.empty()) throw YamlError(mark, "nothing in the scenario is met by '" + path + "'", "look at the names there");
  return met;
}

NumberTable read_number_table(const std::string& folder, const std::string& name, const SourceMark& mark) {
  std::string text;
  try {
    text = read_text_file((fs::path(folder) / name).string(), "table", kMostTableBytes);
  } catch (const ScenarioError& error) {
    const ScenarioMistake& why = error.mistakes.at(0);
    const bool too_long = why.what.starts_with("it has ");
    throw YamlError(mark, "table '" + name + "': " + why.what,
                    too_long ? why.mend : "a path from this file to a CSV file");
  }
  NumberTable table{name, {}, {}, {}, {}};
  std::size_t number = 0;
  for (const std::string& line : split_lines(text)) {
    ++number;
    if (trim(line).empty()) continue;
    const std::vector<std::string> cells = split(line, ',');
    if (table.names.empty()) {
      for (const std::string& cell : cells) {
        const std::string column = trim(cell.substr(0, cell.find(" [")));
        if (std::find(table.names.begin(), table.names.end(), column) != table.names.end())
          throw YamlError(mark, "table '" + name + "' has two columns '" + column + "'", "give each its own name");
        table.names.push_back(column);
        const std::size_t open = cell.find(" ["), close = cell.rfind(']');
        const bool has_unit = open != std::string::npos && close != std::string::npos && close > open;
        table.units.push_back(has_unit ? cell.substr(open + 2, close - open - 2) : "");
        table.texts.emplace_back();
      }
      continue;
    }
    const std::string where = "table '" + name + "', line " + std::to_string(number);
    if (cells.size() != table.names.size())
      throw YamlError(mark, where + " has " + count(cells.size(), "cell"),
                      "as many as the header: " + std::to_string(table.names.size()));
    std::vector<double>& row = table.rows.emplace_back();
    for (const std::string& cell : cells) {
      const std::string word = trim(cell);
      std::string& first_text = table.texts[row.size()];
      double value = 0;
      const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
      const bool is_number = error == std::errc() && end == word.data() + word.size() && std::isfinite(value);
      if (!is_number && first_text.empty()) first_text = where + ": '" + word + "'";
      row.push_back(is_number ? value : std::numeric_limits<double>::quiet_NaN());
    }
  }
  if (table.names.empty()) throw YamlError(mark, "table '" + name + "' is empty", "a header and a row a sample");
  return table;
}

void require_numbers(const NumberTable& table, std::size_t column, const SourceMark& mark) {
  if (const std::string& text = table.texts[column]; !text.empty())
    throw YamlError(mark, text + " is not a number", "a number in SI units, with a point");
}

Quantity read_unit(const NumberTable& table, std::size_t column, const SourceMark& mark) {
  const auto unit = find_unit_of(table.units[column]);
  if (!unit)
    throw YamlError(
        mark,
        "table '" + table.file + "': '" + table.units[column] + "' of '" + table.names[column] + "' is not a unit",
        "a unit such as deg, kN or kg m2, or none for SI");
  return *unit;
}

double read_factor(const NumberTable& table, std::size_t column, const std::string& unit, const SourceMark& mark) {
  if (table.units[column].empty() || table.units[column] == unit) return 1;
  const Quantity own = read_unit(table, column, mark);
  const auto wanted = find_unit_of(unit);
  if (!wanted || !wanted->dimension.takes(own.dimension))
    throw YamlError(mark,
                    "table '" + table.file + "': '" + table.names[column] + "' in " + table.units[column] +
                        " is of another kind than its values, " + (unit.empty() ? "which have no unit" : "in " + unit),
                    "give it the unit of the value, or none for SI");
  return own.value;
}

}  // namespace unlatch::hil
