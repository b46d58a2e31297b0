// Typed reading of YAML nodes. A missing or wrong value is noted in `Mistakes` and replaced by the default, so that one
// pass finds all mistakes.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "hil/scenario/yaml/scenario_error.h"
#include "hil/scenario/yaml/yaml_document.h"

namespace unlatch::hil {

// Reads a finite number, or an expression (hil/scenario/text/expression.h) that may use the scenario's constants.
// `unit` is the expected SI unit, "" for a plain number: `4.38 t` reads as 4380 where "kg" is expected. A number alone
// is in that unit. read_quantity() does the same for any dimension; it returns nothing, and notes a mistake, if the
// node is no number.
std::optional<Quantity> read_quantity(const YamlNode& node, Mistakes& mistakes);
double read_number(const YamlNode& node, const std::string& unit, double fallback, Mistakes& mistakes);
bool is_truth_value(const YamlNode& node);  // true, false; on and off are accepted as well
bool read_bool(const YamlNode& node, bool fallback, Mistakes& mistakes);
std::string read_text(const YamlNode& node, Mistakes& mistakes);
std::string read_name(const YamlNode& node, Mistakes& mistakes);
Eigen::Vector3d read_vector(const YamlNode& node, const std::string& unit, const Eigen::Vector3d& fallback,
                            Mistakes& mistakes);
// Reads exactly `count` items, or any number of them if it is 0.
std::vector<double> read_numbers(const YamlNode& node, std::size_t count, const std::string& unit, Mistakes& mistakes);
// Index of one of `choices`; `kind`: their kind, for messages: "body". -1 and a mistake if it is none of them.
int read_choice(const YamlNode& node, const std::string& kind, const std::vector<std::string>& choices,
                Mistakes& mistakes);

// Returns true for names: letters, digits, `_` and `-`, beginning with a letter, at most 40 characters (the limit of
// messages). Words that YAML 1.1 tools read as true, false or null are no names: yes, no, on, off, true, false, null.
bool is_name(const std::string& text);
std::string describe_name_rule(const std::string& text);  // correction if `text` is no name

// One mapping. Keys that are requested are known; finish() reports the others, duplicates, and nodes that are no
// mapping.
class YamlMap {
 public:
  YamlMap(const YamlNode& node, std::string what, Mistakes& mistakes);

  const YamlNode* find(const std::string& key);     // null if absent
  const YamlNode* require(const std::string& key);  // null and a mistake if absent
  void read_header(const std::string& key);         // `key: 1`, the language of the file and its version
  double number(const std::string& key, const std::string& unit, std::optional<double> fallback = {});
  bool boolean(const std::string& key, bool fallback);
  Eigen::Vector3d vector(const std::string& key, const std::string& unit,
                         const std::optional<Eigen::Vector3d>& fallback = {});
  int choice(const std::string& key, const std::string& kind, const std::vector<std::string>& choices);  // required
  int choice(const std::string& key, const std::string& kind, const std::vector<std::string>& choices, int fallback);
  // Returns the one of these keys that is present; "" and a mistake unless exactly one is. `need`: the purpose, for the
  // message.
  std::string only_one_of(const std::vector<std::string>& keys, const std::string& need);
  void finish();

  const YamlNode& node() const { return node_; }

 private:
  const YamlNode& node_;
  std::string what_;
  Mistakes& mistakes_;
  std::vector<std::string> known_;
};

}  // namespace unlatch::hil
