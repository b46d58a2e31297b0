// The factors by which NASA-STD-7009 assesses the credibility of results: what each asks, and what its author states.
// The program gives evidence; levels and what it cannot know are statements, from a file.
#pragma once

#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

namespace unlatch::tools {

struct Factor {
  const char *key, *name, *asks;
};
// In the order of the standard: development, use, supporting evidence.
const std::vector<Factor>& list_factors();

struct Statement {
  std::string text;
  std::optional<int> level;  // 0 to 4
};
struct Statements {
  std::string intended_use, author;
  std::map<std::string, Statement> of_factors;  // by their keys
};
// Reads a YAML file: keys of factors with a text, or {level, text}; intended_use, author. Throws hil::ScenarioError
// with every mistake. Empty path: none.
Statements read_statements(const std::string& path);

// [{key, name, asks, evidence: […], statement, level}]
nlohmann::ordered_json build_factors_json(const Statements& statements,
                                          const std::map<std::string, std::vector<std::string>>& evidence);

}  // namespace unlatch::tools
