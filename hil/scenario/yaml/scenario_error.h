// Mistakes in a scenario: each with its place, the fault and its correction; all of them in one exception.
#pragma once

#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "hil/scenario/text/expression.h"
#include "hil/scenario/yaml/yaml_document.h"

namespace unlatch::hil {

struct ScenarioMistake {
  std::string file;
  SourceMark mark;                // line and column 0: the file as a whole
  std::string override_text;      // override that caused it, if one did; with a line: the text there is correct
                                  // without it
  std::string what;               // the fault
  std::string mend;               // the correction
  std::string to_string() const;  // "file:line:column: what; mend"
};

class ScenarioError : public std::runtime_error {
 public:
  explicit ScenarioError(std::vector<ScenarioMistake> mistakes_in);  // what(): one line for each mistake
  std::vector<ScenarioMistake> mistakes;
};

// A number with a unit, as read at a node.
struct NumberRead {
  const YamlNode* node;
  std::string unit;  // SI
  double value;
};

// Collects mistakes while a scenario is read; resolves marks to files and instances, and holds the constants for
// expressions.
class Mistakes {
 public:
  Mistakes(std::string file, std::vector<std::string> overrides)
      : files_{std::move(file)}, overrides_(std::move(overrides)) {}
  // Numbers for SourceMark::file and SourceMark::instance.
  int add_file(std::string name);
  int add_instance(std::string description);
  int add_override(std::string text);  // for SourceMark::override_index

  void add(const SourceMark& mark, std::string what, std::string mend);
  std::size_t count() const { return list_.size(); }
  // Throws the mistakes, sorted by place. The same mistake of several instances of a template at one place is reported
  // once.
  void throw_if_any();

  const std::vector<std::string>& files() const { return files_; }
  std::string describe(const SourceMark& mark, const SourceMark& from) const;  // "on line 3", "in FILE on line 3"
  const Constants& constants() const { return constants_; }
  void add_constant(const std::string& name, const Quantity& value) { constants_[name] = value; }

  // Keeps the numbers that are read from now on: hil/scenario/yaml/yaml_numbers.h lists them.
  void keep_numbers() { keeps_numbers_ = true; }
  void note_number(const YamlNode& node, const std::string& unit, double value) {
    if (keeps_numbers_) numbers_.push_back({&node, unit, value});
  }
  const std::vector<NumberRead>& numbers() const { return numbers_; }

 private:
  void fold_instances();
  void fold_repeated();

  std::vector<std::string> files_, instances_;
  std::vector<std::string> overrides_;
  std::vector<ScenarioMistake> list_;
  Constants constants_;
  bool keeps_numbers_ = false;
  std::vector<NumberRead> numbers_;
};

}  // namespace unlatch::hil
