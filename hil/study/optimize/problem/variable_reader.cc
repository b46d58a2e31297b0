#include "hil/study/optimize/problem/variable_reader.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "hil/scenario/text/count.h"
#include "hil/scenario/text/expression.h"

namespace unlatch::hil {
namespace {

constexpr std::size_t kMaxVariables = 64, kMaxCatalogue = 1000;

class VariableReader {
 public:
  VariableReader(OptimizeProblem& problem, Mistakes& mistakes) : problem_(problem), mistakes_(mistakes) {}

  void read(YamlMap& top) {
    const YamlNode* const node = top.require("variables");
    if (node == nullptr) return;
    YamlMap map(*node, "variables", mistakes_);
    if (!node->is_mapping()) return;
    if (node->keys.empty() || node->keys.size() > kMaxVariables)
      mistakes_.add(node->mark, count(node->keys.size(), "variable"), "give 1 to 64");
    for (std::size_t i = 0; i < node->keys.size(); ++i) {
      const YamlKey& key = node->keys[i];
      if (node->find(key.text) != &node->items[i]) continue;  // duplicate: finish() reports it
      map.find(key.text);
      if (!is_name(key.text) || key.text.find('-') != std::string::npos || is_reserved_name(key.text))
        mistakes_.add(key.mark, "'" + key.text + "' cannot be the name of a variable",
                      !is_name(key.text)
                          ? describe_name_rule(key.text)
                          : "expressions name variables: no '-', no unit, function or constant of the language");
      read_variable(key, node->items[i]);
    }
    map.finish();
  }

 private:
  void read_variable(const YamlKey& key, const YamlNode& node) {
    YamlMap map(node, "variable '" + key.text + "'", mistakes_);
    if (!node.is_mapping()) return;
    OptimizeVariable variable;
    variable.name = key.text;
    variable.mark = key.mark;
    const std::size_t before = mistakes_.count();
    const std::string where = map.only_one_of({"path", "paths"}, "the values of the scenario that it is");
    if (where == "path") variable.paths.push_back(read_text(*map.find("path"), mistakes_));
    if (where == "paths") {
      const YamlNode& list = *map.find("paths");
      if (!list.is_sequence() || list.items.empty())
        mistakes_.add(list.mark, "paths is not a list", "write [PATH, PATH]");
      for (std::size_t k = 0; k < list.items.size(); ++k) read_paths(list.items[k], k, variable);
    }
    const std::string range = map.only_one_of({"between", "values", "rows"}, "bounds or a catalogue");
    if (range == "between") read_bounds(*map.find("between"), variable);
    if (range == "values") read_catalogue(*map.find("values"), variable);
    if (range == "rows") read_rows(*map.find("rows"), variable);
    if (const YamlNode* titles = map.find("columns")) read_titles(*titles, range == "rows", variable);
    if (range != "rows") variable.columns.clear();
    if (const YamlNode* start = map.find("start")) read_start(*start, variable, mistakes_.count() == before);
    map.finish();
    for (const std::string& path : variable.paths)
      if (!paths_.insert(path).second)
        mistakes_.add(node.mark, "'" + path + "' is varied twice", "name each path once");
    if (mistakes_.count() == before) problem_.variables.push_back(std::move(variable));
  }

  // One path, or several that get the value of the same column.
  void read_paths(const YamlNode& node, std::size_t column, OptimizeVariable& variable) {
    const std::vector<YamlNode> one{node};
    for (const YamlNode& item : node.is_sequence() ? node.items : one) {
      variable.paths.push_back(read_text(item, mistakes_));
      variable.columns.push_back(column);
    }
  }

  // Reads rows of a catalogue: a value for each of the paths, in their order.
  void read_rows(const YamlNode& node, OptimizeVariable& variable) {
    if (!node.is_sequence()) return mistakes_.add(node.mark, "no catalogue", "write a list of rows: [[1 kN, 2 kN/m]]");
    if (node.items.size() < 2 || node.items.size() > kMaxCatalogue)
      return mistakes_.add(node.mark, "a catalogue of length " + std::to_string(node.items.size()),
                           "give 2 to 1000; `set` gives all runs one value");
    const std::size_t width = variable.columns.empty() ? 0 : variable.columns.back() + 1;
    if (width < 2)
      return mistakes_.add(node.mark, "rows for a single path", "name several `paths`, or give `values` instead");
    for (const YamlNode& row : node.items)
      if (!row.is_sequence() || row.items.size() != width)
        return mistakes_.add(row.mark, "not a row of " + count(width, "value"),
                             "one for each entry of `paths`, in their order");
    variable.catalogue = node.items;
    variable.upper = static_cast<double>(node.items.size() - 1);
  }

  // Reads names of the columns, by which expressions name their values.
  void read_titles(const YamlNode& node, bool of_rows, OptimizeVariable& variable) {
    if (!of_rows) return mistakes_.add(node.mark, "names of columns without rows", "leave them out");
    const std::size_t width = variable.columns.empty() ? 0 : variable.columns.back() + 1;
    if (!node.is_sequence() || node.items.size() != width)
      return mistakes_.add(node.mark, "not a name for each column", "as many as `paths` has entries");
    for (const YamlNode& item : node.items) {
      const std::string title = read_text(item, mistakes_);
      if (!is_name(title) || title.find('-') != std::string::npos || is_reserved_name(title) ||
          !titles_.insert(title).second)
        mistakes_.add(item.mark, "'" + title + "' cannot be the name of a column",
                      "expressions name it: no '-', no unit, function or constant of the language, each once");
      variable.titles.push_back(title);
    }
    for (const YamlNode& row : variable.catalogue) {
      std::vector<Quantity>& numbers = variable.row_numbers.emplace_back();
      for (const YamlNode& item : row.items) {
        const auto number = read_quantity(item, mistakes_);
        numbers.push_back(number.value_or(Quantity{}));
      }
    }
  }

  void read_bounds(const YamlNode& node, OptimizeVariable& variable) {
    if (!node.is_sequence() || node.items.size() != 2)
      return mistakes_.add(node.mark, "no pair of bounds", "write [LOWER, UPPER], with units: [2 kN, 20 kN]");
    const auto lower = read_quantity(node.items[0], mistakes_), upper = read_quantity(node.items[1], mistakes_);
    if (!lower || !upper) return;
    if (!(lower->dimension == upper->dimension) && lower->value != 0)
      mistakes_.add(
          node.items[1].mark,
          "the bounds are " + describe_dimension(lower->dimension) + " and " + describe_dimension(upper->dimension),
          "give both in the same kind of unit");
    else if (!(lower->value < upper->value))
      mistakes_.add(node.mark, "the lower bound is not below the upper one", "write [LOWER, UPPER]");
    variable.lower = lower->value;
    variable.upper = upper->value;
    variable.start = 0.5 * (lower->value + upper->value);
    variable.dimension = upper->dimension;
    variable.unit = describe_unit(upper->dimension);
  }

  void read_catalogue(const YamlNode& node, OptimizeVariable& variable) {
    if (!node.is_sequence()) return mistakes_.add(node.mark, "no catalogue", "write a list: [1 kN, 2 kN]");
    if (node.items.size() < 2 || node.items.size() > kMaxCatalogue)
      return mistakes_.add(node.mark, "a catalogue of length " + std::to_string(node.items.size()),
                           "give 2 to 1000; `set` gives all runs one value");
    variable.catalogue = node.items;
    variable.upper = static_cast<double>(node.items.size() - 1);
    for (const YamlNode& item : node.items) {
      Mistakes ignored("", {});
      const auto number = item.is_scalar() ? read_quantity(item, ignored) : std::nullopt;
      if (!number || ignored.count() != 0) return variable.numbers.clear();
      if (variable.numbers.empty()) variable.dimension = number->dimension;
      variable.numbers.push_back(number->value);
    }
    variable.unit = describe_unit(variable.dimension);
  }

  void read_start(const YamlNode& node, OptimizeVariable& variable, bool sound) {
    if (!sound) return;
    if (variable.is_catalogue()) {
      const auto same = [&](const YamlNode& item) { return to_text(Setting{"", item}) == to_text(Setting{"", node}); };
      const auto found = std::find_if(variable.catalogue.begin(), variable.catalogue.end(), same);
      if (found == variable.catalogue.end())
        return mistakes_.add(node.mark, "the start is not in the catalogue", "write it as the catalogue does");
      variable.start = static_cast<double>(found - variable.catalogue.begin());
      return;
    }
    const auto start = read_quantity(node, mistakes_);
    if (!start) return;
    if (!start->dimension.is_plain() && !(start->dimension == variable.dimension))
      mistakes_.add(node.mark, "the start is " + describe_dimension(start->dimension),
                    "give it in the unit of the bounds");
    else if (!(start->value >= variable.lower && start->value <= variable.upper))
      mistakes_.add(node.mark, "the start is not within the bounds", "a value within, or none: their middle");
    variable.start = start->value;
  }

  OptimizeProblem& problem_;
  Mistakes& mistakes_;
  std::set<std::string> paths_, titles_;
};

}  // namespace

void read_variables(YamlMap& top, OptimizeProblem& problem, Mistakes& mistakes) {
  VariableReader(problem, mistakes).read(top);
}

}  // namespace unlatch::hil
