#include "tools/campaign/summary_text.h"

#include <algorithm>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "hil/scenario/yaml/setting.h"
#include "tools/campaign/failures.h"
#include "tools/campaign/review.h"
#include "tools/common/terminal.h"
#include "tools/common/text.h"

namespace unlatch::tools {
namespace {

std::string describe_number(const Json& value, const char* form) {
  return value.is_null() ? std::string("–") : format(form, value.get<double>());
}

// Tolerance limits on each side on which the requirement has a limit.
std::string describe_tolerance(const Json& requirement) {
  const Json& tolerance = requirement.at("tolerance");
  if (tolerance.at("without_value") > 0)
    return "none: " + count(tolerance.at("without_value").get<std::int64_t>(), "sample") + " without a value";
  if (!tolerance.contains("lower"))
    return "needs " + count(tolerance.at("samples_needed").get<std::int64_t>(), "sample");
  std::string text;
  if (!requirement.at("at_least").is_null())
    text = format("≥ %.5g", to_shown(requirement, tolerance.at("lower").get<double>()));
  if (!requirement.at("at_most").is_null())
    text += (text.empty() ? "" : ", ") + format("≤ %.5g", to_shown(requirement, tolerance.at("upper").get<double>()));
  return text;
}

void print_rare(std::FILE* to, const Json& rare) {
  print_heading(to, "Subset simulation: " + describe_rare_failure(rare));
  std::fprintf(to, "  %-6s %16s %14s %14s %10s %10s\n", "level", "samples", "margin", "probability", "c.o.v.",
               "accepted");
  int number = 0;
  for (const Json& level : rare.at("levels_run")) {
    const std::string range =
        format("%lld to %lld", level.at("first").get<long long>(), level.at("last").get<long long>() - 1);
    std::fprintf(to, "  %-6d %16s %14s %14s %10s %10s\n", number, range.c_str(),
                 describe_number(level.at("threshold"), "%.5g").c_str(),
                 describe_number(level.at("probability"), "%.4g").c_str(),
                 describe_number(level.at("deviation"), "%.3f").c_str(),
                 number == 0 ? "" : describe_number(level.at("acceptance"), "%.2f").c_str());
    ++number;
  }
  const RareResult result = describe_rare_result(rare);
  const bool finished = rare.at("finished").get<bool>(), met = finished && rare.at("met").get<bool>();
  std::fprintf(to, "  %s%s\n",
               finished ? paint(to, met ? Colour::kGreen : Colour::kRed, result.text).c_str() : result.text.c_str(),
               result.remark.c_str());
}

constexpr std::size_t kNamed = 10;  // samples that are listed

std::string list_samples(const Json& samples) {
  std::string numbers;
  for (std::size_t i = 0; i < std::min<std::size_t>(samples.size(), kNamed); ++i)
    numbers += (i == 0 ? "" : ", ") + std::to_string(samples[i].get<long long>());
  return samples.size() > kNamed ? numbers + ", …" : numbers;
}

// The step of a campaign with a tolerance, and what shows that it keeps it.
void print_step(std::FILE* to, const Json& step) {
  const double chosen = step.at("step").get<double>();
  std::fprintf(to, "  step %.9g s for a tolerance of %.3g (the scenario's: %.9g s)", chosen,
               step.at("tolerance").get<double>(), step.at("scenario_step").get<double>());
  for (const Json& trial : step.at("trials"))
    if (trial.at("step") == step.at("step"))
      std::fprintf(to, ": in %s the error is at most %.2g%s",
                   count(step.at("flights").get<std::int64_t>(), "flight").c_str(), trial.at("error").get<double>(),
                   trial.at("of").get<std::string>().empty()
                       ? ""
                       : (" (" + trial.at("of").get<std::string>() + ", " + trial.at("flight").get<std::string>() + ")")
                             .c_str());
  std::fprintf(to, "\n  %s checked at half the step, largest error %s",
               count(step.at("checked").get<std::int64_t>(), "sample").c_str(),
               describe_number(step.at("largest_error"), "%.2g").c_str());
  const Json& again = step.at("flown_again");
  if (!again.empty())
    std::fprintf(to, "; %s", paint(to, Colour::kYellow, "flown again finer: " + list_samples(again)).c_str());
  std::fprintf(to, "\n");
}

// What disperses the values of the requirements, by the measure that the sampling allows.
struct Influence {
  std::string input;
  bool estimated = false;  // samples that it is of have the value
  double value = 0;
  std::string text;  // with its interval
};

Influence build_influence(const Json& name, const Json& value, const Json& interval) {
  Influence influence{name, value.is_number(), value.is_number() ? value.get<double>() : 0, ""};
  influence.text = influence.input + " " + format("%.2g", influence.value);
  if (interval.is_array() && interval[0].is_number() && interval[1].is_number())
    influence.text += format(" (%.2g … %.2g)", interval[0].get<double>(), interval[1].get<double>());
  return influence;
}

std::vector<Influence> list_influences(const Json& sensitivity, const Json& inputs) {
  std::vector<Influence> list;
  if (sensitivity.contains("sobol")) {
    for (const Json& one : sensitivity.at("sobol"))
      list.push_back(build_influence(one.at("parameter"), one.at("total"), one.at("total_interval")));
  } else if (sensitivity.contains("morris")) {
    for (const Json& one : sensitivity.at("morris"))
      list.push_back(build_influence(one.at("parameter"), one.at("mean_size"), nullptr));
  } else if (sensitivity.contains("swings")) {
    for (const Json& one : sensitivity.at("swings")) {
      const bool whole = one.at("least").is_number();
      list.push_back(build_influence(
          one.at("parameter"),
          whole ? Json(one.at("greatest").get<double>() - one.at("least").get<double>()) : Json(nullptr), nullptr));
    }
  } else if (sensitivity.contains("grid_effects")) {
    for (std::size_t k = 0; k < sensitivity.at("grid_effects").size(); ++k)
      list.push_back(build_influence(inputs[k].at("name"), sensitivity.at("grid_effects")[k], nullptr));
  } else if (sensitivity.contains("first_order")) {
    const Json& orders = sensitivity.at("first_order");
    for (std::size_t k = 0; k < orders.size(); ++k)
      list.push_back(build_influence(inputs[k].at("name"), orders[k].at("index"), orders[k].at("interval")));
  }
  std::ranges::sort(list, std::greater<>(), &Influence::value);
  return list;
}

// Every sample with a value has the same one.
bool has_one_value(const Json& column) { return column.at("min").is_number() && column.at("min") == column.at("max"); }
bool is_constant(const Json& inputs, const std::string& name) {
  const auto input = std::ranges::find_if(inputs, [&](const Json& one) { return one.at("name") == name; });
  return input != inputs.end() && has_one_value(*input);
}

const char* get_influence_heading(const Json& sensitivity) {
  if (sensitivity.contains("sobol"))
    return "Influences: Sobol' totals, parts of a value's variance that go with an input, alone or with others";
  if (sensitivity.contains("morris"))
    return "Influences: mean sizes of elementary effects (Morris): 1.5 times the change of the value, in its SI unit, "
           "over two thirds of an input's levels, which are its quantiles of 1 %, 34 %, 66 % and 99 %";
  if (sensitivity.contains("swings"))
    return "Influences: ranges of a value over the levels of an input, the others at their medians, in its SI unit";
  if (sensitivity.contains("grid_effects"))
    return "Influences: parts of a value's variance over the grid by an input alone";
  return "Influences: parts of a value's variance by an input alone (first-order indices), with 95 % intervals";
}

// The requirements of samples that are chosen points: without probabilities, quantiles and tolerance limits.
void print_chosen_requirements(std::FILE* to, const Json& summary) {
  print_heading(to, "Requirements: failures of the samples, least and greatest value");
  std::fprintf(to, "  %-16s %8s %8s %8s %10s %10s\n", "", "failed", "faulted", "missing", "least", "greatest");
  for (const Json& requirement : summary.at("requirements")) {
    const auto shown = [&](const Json& value) {
      return value.is_null() ? std::string("–") : format("%.5g", to_shown(requirement, value.get<double>()));
    };
    std::fprintf(to, "  %-16s %8lld %8lld %8lld %10s %10s %s\n", requirement.at("id").get<std::string>().c_str(),
                 requirement.at("failed").get<long long>(), requirement.at("faulted").get<long long>(),
                 requirement.at("not_evaluated").get<long long>(), shown(requirement.at("min")).c_str(),
                 shown(requirement.at("max")).c_str(), get_shown_unit(requirement).c_str());
  }
}

void print_requirements(std::FILE* to, const Json& summary) {
  print_heading(
      to,
      std::string("Requirements") + (summary.contains("rare") ? ", first level alone" : "") +
          ": failures, their part, 95 % bounds of its probability (Clopper-Pearson), quantiles of the value, what 99 % "
          "of all runs keep to with 95 % confidence (Wilks)");
  if (const std::string basis = summary.at("basis").at("text"); !basis.empty())
    std::fprintf(to, "  %s\n", basis.c_str());
  std::fprintf(to, "  %-16s %8s %8s %8s %9s  %-23s %10s %10s %10s %10s %10s %-6s %s\n", "", "failed", "faulted",
               "missing", "part", "probability", "1 %", "5 %", "50 %", "95 %", "99 %", "", "tolerance");
  for (const Json& requirement : summary.at("requirements")) {
    const Json &p = requirement.at("probability"), &q = requirement.at("quantiles");
    const bool failed = requirement.at("failed") > 0;
    const auto shown = [&](const char* probability) {
      const Json& value = q.at(probability);
      return value.is_null() ? std::string("–") : format("%.5g", to_shown(requirement, value.get<double>()));
    };
    const std::string bounds = format("%.2e … %.2e", p[0].get<double>(), p[1].get<double>());
    std::fprintf(
        to, "  %-16s %s %8lld %8lld %9s  %-25s %10s %10s %10s %10s %10s %-6s %s\n",
        requirement.at("id").get<std::string>().c_str(),
        paint(to, failed ? Colour::kRed : Colour::kGreen, format("%8lld", requirement.at("failed").get<long long>()))
            .c_str(),
        requirement.at("faulted").get<long long>(), requirement.at("not_evaluated").get<long long>(),
        describe_number(requirement.at("estimate"), "%.5g").c_str(), bounds.c_str(), shown("0.01").c_str(),
        shown("0.05").c_str(), shown("0.5").c_str(), shown("0.95").c_str(), shown("0.99").c_str(),
        get_shown_unit(requirement).c_str(), describe_tolerance(requirement).c_str());
  }
}

void print_influences(std::FILE* to, const Json& summary) {
  constexpr std::size_t kMost = 5;
  constexpr double kExplained = 0.8;  // of the variance: less is said
  const bool whole = summary.at("samples") == summary.at("planned");
  bool begun = false;
  for (const Json& requirement : summary.at("requirements")) {
    const std::string id = requirement.at("id");
    const Json& columns = summary.at("columns");
    const auto column = std::ranges::find_if(columns, [&](const Json& one) { return one.at("name") == id; });
    if (column == columns.end() || !column->contains("sensitivity") || !summary.contains("inputs")) continue;
    const Json& sensitivity = column->at("sensitivity");
    const std::vector<Influence> list = list_influences(sensitivity, summary.at("inputs"));
    if (list.empty()) continue;
    if (!std::exchange(begun, true)) print_heading(to, get_influence_heading(sensitivity));
    const bool alone = sensitivity.contains("significant") && sensitivity.at("significant").is_number();
    const double least = alone ? sensitivity.at("significant").get<double>() : 0;
    std::string text;
    double sum = 0;
    std::size_t printed = 0;
    for (const Influence& one : list) {
      if (one.value <= least) break;
      sum += one.value;
      if (++printed <= kMost) text += (text.empty() ? "" : ", ") + one.text;
    }
    if (printed > kMost) text += ", and " + count(printed - kMost, "other input");
    std::string open, constant;
    for (const Influence& one : list) {
      std::string& names = whole && is_constant(summary.at("inputs"), one.input) ? constant : open;
      if (!one.estimated) names += (names.empty() ? "" : ", ") + one.input;
    }
    if (has_one_value(*column)) {
      text = "none: all values are equal";
    } else if (text.empty() && !alone && sensitivity.contains("first_order")) {
      text = "not estimated: fewer than 40 values";
    } else {
      if (!open.empty()) text += (text.empty() ? "" : "; ") + ("not estimated, since samples have no value: " + open);
      if (!constant.empty()) text += (text.empty() ? "" : "; ") + ("not dispersed: " + constant);
    }
    if (text.empty()) text = alone ? "of no input distinct from chance" : "of no input";
    if (alone) text += format("; chance reaches %.2g", least);
    if (sensitivity.contains("blocks")) {
      const std::int64_t used = sensitivity.at("blocks").at("used").get<std::int64_t>(),
                         left_out = sensitivity.at("blocks").at("left_out").get<std::int64_t>();
      text += left_out > 0 ? format("; by %lld of ", static_cast<long long>(used)) + count(used + left_out, "block") +
                                 ", the others lack a value"
                           : "; by " + count(used, "block");
    }
    if (alone && printed > 1 && summary.at("correlated").get<bool>())
      text += "; inputs may be correlated: their parts overlap and do not add up";
    else if (alone && printed > 1 && summary.at("directions").get<bool>())
      text += "; the components of a direction depend on one another: their parts overlap and do not add up";
    else if (alone && printed > 0 && sum < kExplained)
      text += format("; %.0f %% by none alone: inputs act together, or samples are few", 100 * (1 - sum));
    std::fprintf(to, "  %-16s %s\n", id.c_str(), text.c_str());
  }
}

}  // namespace

void print_summary(std::FILE* to, const Json& summary) {
  std::fprintf(to, "%s: %lld of %s, campaign hash %s\n", summary.at("campaign").get<std::string>().c_str(),
               summary.at("samples").get<long long>(), count(summary.at("planned").get<long long>(), "sample").c_str(),
               summary.at("hash").get<std::string>().c_str());
  for (const auto& [name, count] : summary.at("statuses").items())
    if (count > 0) std::fprintf(to, "  %lld %s\n", count.get<long long>(), name.c_str());
  for (const Json& remark : summary.at("remarks"))
    std::fprintf(to, "  %s\n", paint(to, Colour::kYellow, "note: " + remark.get<std::string>()).c_str());
  if (summary.contains("step")) print_step(to, summary.at("step"));
  const Json& unresolved = summary.at("unresolved");
  if (!unresolved.empty()) {
    std::fprintf(to, "  %s\n",
                 paint(to, Colour::kRed,
                       "unresolved: " + list_samples(unresolved) +
                           "; the step does not resolve them, they are neither met nor missed: `unlatch run CAMPAIGN "
                           "--sample I` gives the cause")
                     .c_str());
  }
  if (summary.contains("rare")) print_rare(to, summary.at("rare"));
  if (summary.at("requirements").empty()) return;
  const bool drawn = !summary.at("basis").at("draws").is_null();
  drawn ? print_requirements(to, summary) : print_chosen_requirements(to, summary);
  for (const Json& requirement : summary.at("requirements")) {
    if (!requirement.contains("without_blow")) continue;
    std::fprintf(to, "  %s\n",
                 paint(to, Colour::kYellow,
                       "note: the values of " + requirement.at("id").get<std::string>() + " in " +
                           count(requirement.at("without_blow").get<long long>(), "sample") +
                           " are without the impulse of a blow through the joint")
                     .c_str());
  }
  for (const Json& requirement : summary.at("requirements")) {
    if (!requirement.contains("uncertain")) continue;
    const Json& uncertain = requirement.at("uncertain");
    const std::string unit = requirement.value("unit", "");
    std::fprintf(to, "  %s\n",
                 paint(to, Colour::kYellow,
                       "note: " + requirement.at("id").get<std::string>() + ": " +
                           count(uncertain.at("samples").get<long long>(), "sample") + " known to ± " +
                           describe_number(uncertain.at("by"), "%.2g") + (unit.empty() ? "" : " " + unit) +
                           " at worst, between steps")
                     .c_str());
  }
  if (summary.contains("any_requirement")) {
    const Json &any = summary.at("any_requirement"), &p = any.at("probability");
    std::fprintf(to, "  any requirement: %lld failed, %lld unresolved", any.at("failed").get<long long>(),
                 any.at("unresolved").get<long long>());
    if (drawn)
      std::fprintf(to, ", probability %s, bounds %.2e … %.2e", describe_number(any.at("estimate"), "%.5g").c_str(),
                   p[0].get<double>(), p[1].get<double>());
    std::fprintf(to, "\n");
  }
  print_influences(to, summary);
  std::string worst;
  for (const Json& sample : summary.at("worst"))
    worst += (worst.empty() ? "" : ", ") + std::to_string(sample.get<long long>());
  std::fprintf(to, "\nWorst samples: %s\n", worst.c_str());
  std::fprintf(to, "Orders of events: %lld", summary.at("orders").at("count").get<long long>());
  if (const auto left_out = summary.at("orders").at("left_out").get<std::int64_t>(); left_out > 0)
    std::fprintf(
        to, ", without %s",
        (count(left_out, "sample") + " that faulted or " + (left_out == 1 ? "is" : "are") + " unresolved").c_str());
  std::fprintf(to, "\n");
}

}  // namespace unlatch::tools
