// Laws: expressions over quantities, channels and tables.
#include <algorithm>

#include "hil/scenario/base/index.h"
#include "hil/scenario/sections/scenario_reader.h"
#include "hil/scenario/text/operands.h"

namespace unlatch::hil {

// Names of one expression. Those of quantities: the ones that `quantities` has, as far as they are known.
class ScenarioReader::Names : public LawNames {
 public:
  // `element`: whose profile it is; empty for none.
  Names(ScenarioReader& reader, std::string element) : reader_(reader), element_(std::move(element)) {}

  std::optional<Operand> find_value(const std::string& name) override {
    const Model& model = reader_.model_;
    for (std::size_t i = 0; i < reader_.scenario_.named_quantities; ++i)
      if (model.quantities[i].name == name) return read_quantity_of(static_cast<int>(i));
    for (std::size_t i = 0; i < model.channels.size(); ++i)
      if (model.channels[i].name == name)
        return Operand{{1, dimension_of(get_si(model.channels[i]))},
                       {{LawStep::Kind::kCommand, static_cast<int>(i), 0}}};
    if (const int table = find(name); table != kNone) return look_up_where_it_is(name, at(table));
    if (name == "time") return add_quantity("time", unlatch::Quantity::Kind::kTime, 0);
    if (name == "on_time" && !element_.empty()) {
      const auto found = std::ranges::find(reader_.elements_, element_);
      return add_quantity("on_time of " + element_, unlatch::Quantity::Kind::kOnTime,
                          static_cast<int>(found - reader_.elements_.begin()));
    }
    return std::nullopt;
  }

  std::optional<TableSignature> find_table(const std::string& name) override {
    const int table = find(name);
    return table == kNone ? std::nullopt : std::optional(reader_.tables_[at(table)].signature);
  }

  std::vector<std::string> list_names() override {
    std::vector<std::string> names{"time"};
    if (!element_.empty()) names.emplace_back("on_time");
    for (std::size_t i = 0; i < reader_.scenario_.named_quantities; ++i)
      names.push_back(reader_.model_.quantities[i].name);
    for (const Channel& channel : reader_.model_.channels) names.push_back(channel.name);
    for (const Table& table : reader_.model_.tables) names.push_back(table.name);
    return names;
  }

 private:
  int find(const std::string& name) const {
    const std::vector<Table>& tables = reader_.model_.tables;
    const auto found = std::ranges::find_if(tables, [&](const Table& table) { return table.name == name; });
    return found == tables.end() ? kNone : static_cast<int>(found - tables.begin());
  }

  Operand read_quantity_of(int number) const {
    const Model& model = reader_.model_;
    const unlatch::Quantity& quantity = model.quantities[at(number)];
    if (quantity.kind == unlatch::Quantity::Kind::kLaw && reader_.open_laws_.count(quantity.subject) > 0)
      throw ExpressionError("quantity '" + quantity.name + "' is not known here",
                            "an expression may use those before it");
    return {{1, dimension_of(get_si(model, quantity))}, {{LawStep::Kind::kQuantity, number, 0}}};
  }

  // A quantity that the scenario does not name; each once.
  Operand add_quantity(const std::string& name, unlatch::Quantity::Kind kind, int subject) const {
    std::vector<unlatch::Quantity>& quantities = reader_.model_.quantities;
    const auto known = std::ranges::find_if(quantities, [&](const unlatch::Quantity& quantity) {
      return quantity.kind == kind && quantity.subject == subject && quantity.name == name + "#";
    });
    const auto number = static_cast<int>(known - quantities.begin());
    if (known == quantities.end()) {
      unlatch::Quantity& added = quantities.emplace_back();
      added.name = name + "#";
      added.kind = kind;
      added.subject = subject;
    }
    return {{1, dimension_of("s")}, {{LawStep::Kind::kQuantity, number, 0}}};
  }

  // A table without arguments: at what its axes are of.
  Operand look_up_where_it_is(const std::string& name, std::size_t number) {
    TableSource& source = reader_.tables_[number];
    if (std::ranges::find(source.of, nullptr) != source.of.end())
      throw ExpressionError("table '" + name + "' does not say what its axes are of",
                            "name(x, y), with one value per axis, or `of` at each axis");
    if (source.is_open) throw ExpressionError("table '" + name + "' is looked up at itself", "another `of`");
    source.is_open = true;
    std::vector<Operand> arguments;
    for (const YamlNode* const of : source.of) {
      if (of->is_scalar()) {
        arguments.push_back(compile_expression(of->text, reader_.mistakes_.constants(), *this));
      } else {
        const int quantity = reader_.read_quantity_index("quantity", *of);
        arguments.push_back({{1, dimension_of(get_si(reader_.model_, reader_.model_.quantities.at(at(quantity))))},
                             {{LawStep::Kind::kQuantity, quantity, 0}}});
      }
    }
    reader_.tables_[number].is_open = false;
    return look_up(name, source.signature, arguments);
  }

  ScenarioReader& reader_;
  const std::string element_;
};

// Steps of a law, and its dimension. `unit`: SI; nothing: that of the expression.
void ScenarioReader::compile_law(int law, const YamlNode& node, const std::optional<std::string>& unit,
                                 const std::string& element) {
  compile_steps(law, node, unit, element);
  open_laws_.erase(law);
}

void ScenarioReader::compile_steps(int law, const YamlNode& node, const std::optional<std::string>& unit,
                                   const std::string& element) {
  model_.laws[at(law)].steps = {LawStep{}};  // until there is something better
  if (!node.is_scalar())
    return mistakes_.add(node.mark, "an expression is text", "write expression: \"2 * thrust(time)\"");
  try {
    Names names(*this, element);
    Operand operand = compile_expression(node.text, mistakes_.constants(), names);
    const Dimension& given = operand.quantity.dimension;
    const bool alone = operand.is_constant() && given.is_plain();
    if (unit && !alone && !dimension_of(*unit).takes(given))
      throw ExpressionError(
          "this expression is " + describe_dimension(given) + ", not " + describe_dimension(dimension_of(*unit)),
          given.is_plain()                 ? "multiply it by 1 " + *unit
          : dimension_of(*unit).is_plain() ? "divide it by (1 " + describe_unit(given) + ")"
                                           : "give it the unit " + *unit);
    Law& compiled = model_.laws[at(law)];
    compiled.steps = operand.is_constant() ? std::vector{LawStep{LawStep::Kind::kConstant, 0, operand.quantity.value}}
                                           : std::move(operand.steps);
    const std::string si = unit ? *unit : describe_unit(given);
    compiled.unit = si.empty() ? "1" : si;
  } catch (const ExpressionError& error) {
    mistakes_.add(node.mark, error.what(),
                  error.mend.empty() ? "an expression over quantities, channels and tables" : error.mend);
  }
}

// Index of a new law. It has neither steps nor a unit yet.
int ScenarioReader::add_law(const std::string& name, const YamlNode& node) {
  const int number = static_cast<int>(model_.laws.size());
  model_.laws.emplace_back().name = name;
  open_laws_.insert(number);
  nodes_["law '" + name + "'"] = &node;
  scenario_.marks["law '" + name + "'"] = node.mark;
  return number;
}

// `expression` of an element, with the keys beside it. Quantities are read later: see compile_element_laws().
int ScenarioReader::read_law(YamlMap& map, const std::string& unit, const std::string& name,
                             const std::string& element) {
  const int law = add_law(name, *map.find("expression"));
  read_scaling(map, unit, model_.laws[at(law)]);
  element_laws_.push_back({law, map.find("expression"), unit, element});
  return law;
}

void ScenarioReader::compile_element_laws() {
  for (const ElementLaw& own : element_laws_) compile_law(own.law, *own.node, own.unit, own.element);
  element_laws_.clear();
}

// A quantity that is an expression, by the keys beside it.
void ScenarioReader::read_expression_quantity(YamlMap& map, int law) {
  std::optional<std::string> unit;
  if (map.find("unit") != nullptr) {
    const unlatch::hil::Quantity given = read_unit(map);
    if (given.value != 1) mistakes_.add(map.find("unit")->mark, "this is not an SI unit", "N for kN, rad for deg");
    unit = describe_unit(given.dimension);
  }
  compile_law(law, *map.find("expression"), unit, "");
  const std::string& si = model_.laws[at(law)].unit;
  read_scaling(map, si == "1" ? "" : si, model_.laws[at(law)]);
}

}  // namespace unlatch::hil
