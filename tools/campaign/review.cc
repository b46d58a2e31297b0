#include "tools/campaign/review.h"

#include <vector>

#include "hil/scenario/yaml/setting.h"
#include "tools/campaign/failures.h"
#include "tools/common/text.h"

namespace unlatch::tools {
namespace {

const char* const kQuantiles[] = {"0.01", "0.05", "0.5", "0.95", "0.99"};

using Row = std::vector<std::string>;

std::string show(const Json& item, const Json& value, const char* form) {
  return value.is_null() ? std::string() : format(form, to_shown(item, value.get<double>()));
}

std::string show(const Json& value, const char* form) {
  return value.is_null() ? std::string() : format(form, value.get<double>());
}

// Neither met nor missed where unresolved samples leave it open; "met": by every sample.
std::string judge(const Json& requirement) {
  if (requirement.at("failed") > 0) return "not met";
  return requirement.at("unresolved") > 0 ? "unresolved" : "met";
}

Row head_requirements() {
  Row row{"requirement", "text",       "unit",        "at least",  "at most",    "verdict", "failed",  "faulted",
          "missing",     "unresolved", "probability", "bound low", "bound high", "least",   "greatest"};
  for (const char* p : kQuantiles) row.push_back("quantile " + std::string(p));
  row.insert(row.end(), {"99 % are above", "99 % are below"});
  return row;
}

Row build_requirement(const Json& one, const char* form) {
  const Json& bounds = one.at("probability");
  Row row{one.at("id"),
          one.at("text"),
          get_shown_unit(one),
          show(one, one.at("at_least"), form),
          show(one, one.at("at_most"), form),
          judge(one),
          std::to_string(one.at("failed").get<long long>()),
          std::to_string(one.at("faulted").get<long long>()),
          std::to_string(one.at("not_evaluated").get<long long>()),
          std::to_string(one.at("unresolved").get<long long>()),
          show(one.at("estimate"), form),
          bounds.is_null() ? std::string() : show(bounds[0], form),
          bounds.is_null() ? std::string() : show(bounds[1], form),
          show(one, one.at("min"), form),
          show(one, one.at("max"), form)};
  for (const char* p : kQuantiles) row.push_back(show(one, one.at("quantiles").at(p), form));
  const Json& tolerance = one.at("tolerance");
  for (const char* side : {"lower", "upper"})
    row.push_back(tolerance.is_object() && tolerance.contains(side) ? show(one, tolerance.at(side), form)
                                                                    : std::string());
  return row;
}

// The row of a run that misses any requirement.
Row build_any(const Json& any, const char* form) {
  Row row(head_requirements().size());
  row[0] = "any";
  row[1] = "Any requirement is not met";
  row[5] = any.at("failed") > 0 ? "not met" : any.at("unresolved") > 0 ? "unresolved" : "met";
  row[6] = std::to_string(any.at("failed").get<long long>());
  row[9] = std::to_string(any.at("unresolved").get<long long>());
  row[10] = show(any.at("estimate"), form);
  const Json& bounds = any.at("probability");
  if (bounds.is_null()) return row;
  row[11] = show(bounds[0], form);
  row[12] = show(bounds[1], form);
  return row;
}

std::vector<Row> build_rows(const Json& summary, const char* form) {
  std::vector<Row> rows{head_requirements()};
  for (const Json& one : summary.at("requirements")) rows.push_back(build_requirement(one, form));
  if (summary.contains("any_requirement")) rows.push_back(build_any(summary.at("any_requirement"), form));
  return rows;
}

std::string to_markdown(const std::vector<Row>& rows) {
  std::string text;
  const auto add = [&](const Row& row) {
    text += "|";
    for (std::string cell : row) {
      for (std::size_t at = 0; (at = cell.find('|', at)) != std::string::npos; at += 2) cell.insert(at, "\\");
      text += " " + cell + " |";
    }
    text += "\n";
  };
  for (std::size_t i = 0; i < rows.size(); ++i) {
    add(rows[i]);
    if (i == 0) add(Row(rows[0].size(), "---"));
  }
  return text;
}

}  // namespace

double to_shown(const Json& item, double value) {
  return item.contains("shown") && !item.at("shown").is_null() ? value / item.at("shown").at("factor").get<double>()
                                                               : value;
}

std::string get_shown_unit(const Json& item) {
  return item.contains("shown") && !item.at("shown").is_null() ? item.at("shown").at("unit").get<std::string>()
                                                               : item.at("unit").get<std::string>();
}

std::string write_requirements_csv(const Json& summary) {
  std::string text;
  for (const Row& row : build_rows(summary, "%.10g")) {
    for (std::size_t i = 0; i < row.size(); ++i) text += (i == 0 ? "" : ",") + quote_cell(row[i]);
    text += "\r\n";
  }
  return text;
}

std::string write_review(const Json& summary) {
  std::string text = "# " + summary.at("campaign").get<std::string>() + "\n\n" +
                     count(summary.at("samples").get<long long>(), "sample") + " of scenario " +
                     summary.at("scenario").get<std::string>() + ", campaign hash " +
                     summary.at("hash").get<std::string>() + ".";
  for (const auto& [name, number] : summary.at("statuses").items())
    if (number > 0) text += " " + std::to_string(number.get<long long>()) + " " + name + ".";
  if (summary.contains("rare")) {
    const RareResult result = describe_rare_result(summary.at("rare"));
    text += "\n\n## Subset simulation: " + describe_rare_failure(summary.at("rare")) + "\n\n" + result.text +
            result.remark + ".";
  }
  text += summary.contains("rare") ? "\n\n## Requirements, first level alone\n\n" : "\n\n## Requirements\n\n";
  if (const Json& basis = summary.at("basis"); !basis.at("text").get<std::string>().empty())
    text +=
        "Sampling " + basis.at("sampling").get<std::string>() + ": " + basis.at("text").get<std::string>() + ".\n\n";
  if (!summary.at("basis").at("draws").is_null())
    text +=
        "Bounds of probabilities: Clopper-Pearson, 95 %. Limits that 99 % of all runs keep to: Wilks, with 95 % "
        "confidence. ";
  text +=
      "An unresolved sample depends on something that the step does not resolve: it is neither met nor "
      "missed, and the bounds hold whatever it is.\n\n";
  text += to_markdown(build_rows(summary, "%.5g"));
  if (!summary.contains("inputs")) return text;
  std::vector<Row> rows{{"input", "unit", "least", "mean", "deviation", "greatest"}};
  for (const Json& input : summary.at("inputs"))
    rows.push_back({input.at("name"), get_shown_unit(input), show(input, input.at("min"), "%.5g"),
                    show(input, input.at("mean"), "%.5g"), show(input, input.at("deviation"), "%.5g"),
                    show(input, input.at("max"), "%.5g")});
  const bool drawn = !summary.at("basis").at("draws").is_null();
  return text +
         (summary.contains("rare") ? "\n## Inputs, as drawn in the first level\n\n"
          : drawn                  ? "\n## Inputs, as drawn\n\n"
                                   : "\n## Inputs, as chosen\n\n") +
         to_markdown(rows);
}

}  // namespace unlatch::tools
