#include "tools/dossier/factors.h"

#include "hil/scenario/language/scenario_sources.h"
#include "hil/scenario/yaml/yaml_reader.h"

namespace unlatch::tools {

const std::vector<Factor>& list_factors() {
  static const std::vector<Factor> factors{
      {"data_pedigree", "Data pedigree", "Where the data come from of which the model is made, and how good they are."},
      {"verification", "Verification",
       "Whether the program solves its equations: by tests, and by other solutions of them."},
      {"validation", "Validation", "Whether the model behaves as the real system does, by measurements of it."},
      {"input_pedigree", "Input pedigree",
       "Where the data come from of this analysis: the start, the surroundings, commands and events."},
      {"uncertainty", "Uncertainty characterisation",
       "How uncertain the results are: from the data, from the model, from the numerical method."},
      {"robustness", "Results robustness", "How much the results change if data and assumptions do."},
      {"use_history", "M&S history", "How the model and the program were used before, and with what success."},
      {"management", "M&S process and product management",
       "How model, program and results are kept, so that each can be found and repeated."},
      {"people", "Qualification of people",
       "Who made and used the model, and what they know of it. A factor of the first edition; later ones ask for it "
       "apart."}};
  return factors;
}

namespace {

Statement read_statement(const hil::YamlNode& node, const std::string& key, hil::Mistakes& mistakes) {
  if (!node.is_mapping()) return {hil::read_text(node, mistakes), {}};
  Statement statement;
  hil::YamlMap map(node, key, mistakes);
  if (const hil::YamlNode* const text = map.require("text")) statement.text = hil::read_text(*text, mistakes);
  if (const hil::YamlNode* const level = map.find("level")) {
    const bool is_level =
        level->is_scalar() && level->text.size() == 1 && level->text[0] >= '0' && level->text[0] <= '4';
    if (is_level)
      statement.level = level->text[0] - '0';
    else
      mistakes.add(level->mark, "'" + level->text + "' is no level", "a whole number from 0 to 4");
  }
  map.finish();
  return statement;
}

}  // namespace

Statements read_statements(const std::string& path) {
  Statements statements;
  if (path.empty()) return statements;
  hil::Mistakes mistakes(path, {});
  try {
    const hil::YamlNode root = hil::parse_yaml(hil::read_text_file(path, "file of statements"));
    hil::YamlMap map(root, "the statements", mistakes);
    if (const hil::YamlNode* const use = map.find("intended_use"))
      statements.intended_use = hil::read_text(*use, mistakes);
    if (const hil::YamlNode* const author = map.find("author")) statements.author = hil::read_text(*author, mistakes);
    for (const Factor& factor : list_factors())
      if (const hil::YamlNode* const node = map.find(factor.key))
        statements.of_factors[factor.key] = read_statement(*node, factor.key, mistakes);
    map.finish();
  } catch (const hil::YamlError& error) {
    mistakes.add(error.mark, error.what(), error.mend);
  }
  mistakes.throw_if_any();
  return statements;
}

nlohmann::ordered_json build_factors_json(const Statements& statements,
                                          const std::map<std::string, std::vector<std::string>>& evidence) {
  using Json = nlohmann::ordered_json;
  Json list = Json::array();
  for (const Factor& factor : list_factors()) {
    Json item = {{"key", factor.key}, {"name", factor.name}, {"asks", factor.asks}, {"evidence", Json::array()}};
    if (const auto found = evidence.find(factor.key); found != evidence.end()) item["evidence"] = found->second;
    const auto stated = statements.of_factors.find(factor.key);
    const bool is_stated = stated != statements.of_factors.end();
    item["statement"] = is_stated ? Json(stated->second.text) : Json(nullptr);
    item["level"] = is_stated && stated->second.level ? Json(*stated->second.level) : Json(nullptr);
    list.push_back(std::move(item));
  }
  return list;
}

}  // namespace unlatch::tools
