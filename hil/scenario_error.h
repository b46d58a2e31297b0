// Mistakes in a scenario: each with its place, what is wrong and what would be right; all of them in one exception.
#pragma once

#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "hil/yaml_document.h"

namespace unlatch::hil {

struct ScenarioMistake {
  std::string file;
  SourceMark mark;                // line and column 0: the file as a whole
  std::string override_text;      // the override that brought it in, if one did
  std::string what;               // what is wrong
  std::string mend;               // what would be right
  std::string to_string() const;  // "file:line:column: what; mend"
};

class ScenarioError : public std::runtime_error {
 public:
  explicit ScenarioError(std::vector<ScenarioMistake> mistakes_in);  // what(): one line each
  std::vector<ScenarioMistake> mistakes;
};

// Collects mistakes while a scenario is read.
class Mistakes {
 public:
  Mistakes(std::string file, std::vector<std::string> overrides)
      : file_(std::move(file)), overrides_(std::move(overrides)) {}
  void add(const SourceMark& mark, std::string what, std::string mend);
  std::size_t count() const { return list_.size(); }
  void throw_if_any();  // sorted by place

 private:
  std::string file_;
  std::vector<std::string> overrides_;
  std::vector<ScenarioMistake> list_;
};

// "; did you mean 'mass'? known: …", from the names that would have been right.
std::string suggest(const std::string& wrong, const std::vector<std::string>& known);

}  // namespace unlatch::hil
