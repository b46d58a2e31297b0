// Tables: inline, or from a CSV file.
#include <algorithm>
#include <stdexcept>

#include "hil/scenario/base/index.h"
#include "hil/scenario/sections/scenario_reader.h"
#include "hil/scenario/text/csv_table.h"
#include "hil/scenario/text/expression.h"

namespace unlatch::hil {
namespace {}  // namespace

// `unit` of a table or of an axis: that of numbers alone. A plain 1 without one.
Quantity ScenarioReader::read_unit(YamlMap& map) {
  const YamlNode* const node = map.find("unit");
  if (node == nullptr) return {1, {}};
  const std::optional<Quantity> unit = find_unit_of(read_text(*node, mistakes_));
  if (!unit) mistakes_.add(node->mark, "'" + node->text + "' is not a unit", "a unit such as deg, kN or kg m2");
  return unit.value_or(Quantity{1, {}});
}

// Appends the numbers of lists in lists. Numbers alone are in the unit; others must be of its dimension, which the
// first of them decides if there is no unit.
void ScenarioReader::read_table_numbers(const YamlNode& node, Quantity& unit, std::vector<double>& to) {
  if (node.is_sequence()) {
    for (const YamlNode& item : node.items) read_table_numbers(item, unit, to);
    return;
  }
  const std::optional<Quantity> number = read_quantity(node, mistakes_);
  if (!number) return;
  const bool alone = number->dimension.is_plain();
  if (!alone && unit.dimension.is_plain() && unit.value == 1) unit.dimension = number->dimension;
  if (!alone && !unit.dimension.takes(number->dimension))
    mistakes_.add(node.mark,
                  "'" + node.text + "' is " + describe_dimension(number->dimension) + ", not " +
                      describe_dimension(unit.dimension),
                  "one unit for all");
  to.push_back(alone ? number->value * unit.value : number->value);
}

void ScenarioReader::read_table_ends(YamlMap& map, TableAxis& axis) {
  static const std::vector<std::string> kEnds{"clamp", "notice", "error"};  // in the order of TableAxis::End
  const auto read = [&](const char* key, TableAxis::End fallback) {
    return static_cast<TableAxis::End>(std::max(0, map.choice(key, "way", kEnds, static_cast<int>(fallback))));
  };
  const TableAxis::End ends = read("ends", TableAxis::End::kClamp);
  axis.below = read("below", ends);
  axis.above = read("above", ends);
}

// An axis of a table, without its knots if these are in a file.
void ScenarioReader::read_table_axis(const std::string& name, const YamlNode& node, bool inline_knots, Table& table,
                                     TableSource& source) {
  TableAxis axis;
  axis.name = name;
  Quantity unit{1, {}};
  const YamlNode* of = nullptr;
  if (node.kind != YamlNode::Kind::kNull) {
    YamlMap map(node, "axis '" + name + "'", mistakes_);
    of = map.find("of");
    read_table_ends(map, axis);
    if (inline_knots) {
      unit = read_unit(map);
      if (const YamlNode* const knots = map.require("at")) read_table_numbers(*knots, unit, axis.knots);
    }
    map.finish();
  }
  source.signature.axes.push_back(unit.dimension.is_plain() ? std::nullopt : std::optional(unit.dimension));
  source.of.push_back(of);
  table.axes.push_back(std::move(axis));
}

// Knots and values from a CSV file. `axes`: names of columns; the table has them already, or gets all others.
void ScenarioReader::read_table_file(YamlMap& map, const YamlNode& file, Table& table, TableSource& source) {
  const YamlNode* const column = map.find("column");
  const std::string name = read_text(file, mistakes_);
  try {
    const std::string path = resolve_include("", name);
    const std::string& text = sources_.read_table(path);
    const auto add = [&](int line, int at, const std::string& what, const std::string& mend) {
      SourceMark mark;
      mark.line = line;
      mark.column = at;
      mark.file = mistakes_.add_file(path);
      mistakes_.add(mark, what, mend);
    };
    try {
      const CsvTable csv = read_csv(text);
      const auto find = [&](const YamlNode& node, const std::string& wanted) -> std::optional<std::size_t> {
        YamlNode named = make_scalar(wanted);
        named.mark = node.mark;
        const int found = read_choice(named, "column of " + path, csv.names, mistakes_);
        return found < 0 ? std::nullopt : std::optional(at(found));
      };
      const std::optional<std::size_t> values =
          column != nullptr ? find(*column, column->text) : std::optional(csv.names.size() - 1);
      if (!values) return;
      if (table.axes.empty())
        for (std::size_t c = 0; c < csv.names.size(); ++c)
          if (c != *values && column == nullptr) read_table_axis(csv.names[c], YamlNode{}, false, table, source);
      std::vector<std::size_t> columns;
      for (const TableAxis& axis : table.axes)
        if (const std::optional<std::size_t> found = find(file, axis.name))
          columns.push_back(*found);
        else
          return;
      if (columns.empty())
        return mistakes_.add(file.mark, "it does not say which columns of " + path + " are its axes",
                             "axes: {mach: {…}, alpha: {…}}, by the names of its columns");
      CsvGrid grid = read_grid(csv, columns, *values);
      const auto scale = [&](std::size_t c, std::vector<double>& numbers) -> Dimension {
        const std::optional<Quantity> unit = find_unit_of(csv.units[c]);
        if (!unit)
          add(csv.headings[c].line, csv.headings[c].column, "'" + csv.units[c] + "' is not a unit",
              "a unit such as deg, kN or kg m2");
        for (double& number : numbers) number *= unit.value_or(Quantity{1, {}}).value;
        return unit.value_or(Quantity{1, {}}).dimension;
      };
      for (std::size_t a = 0; a < columns.size(); ++a) {
        const Dimension dimension = scale(columns[a], grid.knots[a]);
        if (!dimension.is_plain()) source.signature.axes[a] = dimension;
        table.axes[a].knots = std::move(grid.knots[a]);
      }
      source.signature.value = scale(*values, grid.values);
      table.values = std::move(grid.values);
    } catch (const CsvError& error) {
      add(error.line, error.column, error.what(), error.mend);
    }
  } catch (const std::runtime_error& error) {
    mistakes_.add(file.mark, name + ": " + error.what(), "a CSV file in the scenario's folder");
  }
}

void ScenarioReader::read_table(const std::string& name, const YamlNode& node) {
  if (!check_name(name, node, "table", Minus::kRefused)) return;
  Table table;
  table.name = name;
  TableSource source;
  source.signature.table = static_cast<int>(model_.tables.size());
  YamlMap map(node, "table '" + name + "'", mistakes_);
  const YamlNode* const file = map.find("file");
  const YamlNode* const axes = file != nullptr ? map.find("axes") : map.require("axes");
  if (axes != nullptr) {
    YamlMap names(*axes, "axes", mistakes_);
    for (std::size_t i = 0; i < axes->keys.size() && axes->is_mapping(); ++i) {
      names.find(axes->keys[i].text);
      read_table_axis(axes->keys[i].text, axes->items[i], file == nullptr, table, source);
    }
    names.finish();
  }
  if (file != nullptr) {
    read_table_file(map, *file, table, source);
  } else {
    Quantity unit = read_unit(map);
    if (const YamlNode* const values = map.require("values")) read_table_numbers(*values, unit, table.values);
    source.signature.value = unit.dimension;
  }
  const int interpolation = map.choice("interpolation", "interpolation", {"linear", "smooth"}, 0);
  if (interpolation == 1) table.interpolation = Table::Interpolation::kSmooth;
  read_scaling(map, describe_unit(source.signature.value), table);
  map.finish();
  model_.tables.push_back(std::move(table));
  tables_.push_back(std::move(source));
}

void ScenarioReader::read_tables(YamlMap& top) {
  for_each_named(top, "tables", "table",
                 [&](const std::string& name, const YamlNode& node) { read_table(name, node); });
}

}  // namespace unlatch::hil
