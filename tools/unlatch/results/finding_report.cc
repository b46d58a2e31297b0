#include "tools/unlatch/results/finding_report.h"

#include <nlohmann/json.hpp>

#include "hil/run/findings/findings.h"
#include "hil/run/run.h"
#include "tools/common/terminal.h"
#include "tools/common/text.h"

namespace unlatch::tools {
namespace {

using Json = nlohmann::ordered_json;

const hil::SourceMark* find_mark(const hil::Scenario& scenario, const std::string& where) {
  const auto mark = scenario.marks.find(where);
  return mark == scenario.marks.end() ? nullptr : &mark->second;
}

}  // namespace

std::string get_place(const hil::Scenario& scenario, const std::string& where) {
  const hil::SourceMark* const mark = find_mark(scenario, where);
  if (mark == nullptr) return "";
  return scenario.files.at(static_cast<std::size_t>(mark->file)) + ":" + std::to_string(mark->line) + ":" +
         std::to_string(mark->column);
}

void print_findings(std::FILE* to, const hil::Scenario& scenario, const std::vector<hil::Finding>& findings) {
  if (findings.empty()) return;
  print_heading(to, "Warnings");
  for (const hil::Finding& finding : findings) {
    const std::string place = get_place(scenario, finding.where);
    const std::string text = finding.where + (finding.where.empty() ? "" : " ") + finding.text;
    std::fprintf(to, "  %s%s%s\n", place.c_str(), place.empty() ? "" : ": ", paint(to, Colour::kYellow, text).c_str());
  }
}

Json build_findings_json(const hil::Scenario& scenario, const std::vector<hil::Finding>& findings) {
  Json list = Json::array();
  for (const hil::Finding& finding : findings) {
    Json item = {{"name", finding.name}, {"where", finding.where}, {"text", finding.text}};
    if (const hil::SourceMark* const mark = find_mark(scenario, finding.where)) {
      item["file"] = scenario.files.at(static_cast<std::size_t>(mark->file));
      item["line"] = mark->line;
      item["column"] = mark->column;
    }
    list.push_back(item);
  }
  return list;
}

std::vector<hil::Finding> list_warnings(const hil::Scenario& scenario) {
  return hil::list_findings(scenario, *hil::build_simulation(scenario));
}

}  // namespace unlatch::tools
