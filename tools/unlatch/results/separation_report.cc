// Separations of a run, as a table and as JSON.
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "tools/common/alike.h"
#include "tools/common/terminal.h"
#include "tools/common/text.h"
#include "tools/unlatch/results/report.h"
#include "tools/unlatch/results/verdict_report.h"

namespace unlatch::tools {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kDegPerRad = 57.29577951308232;

std::vector<std::vector<std::size_t>> fold(const std::vector<std::string>& names) {
  std::vector<std::string> keys;
  for (const std::string& name : names) keys.push_back(without_numbers(name));
  return group_alike(keys);
}

// The body; of a marker the body that carries it.
int get_carrier(const RunReport& report, int body) {
  if (body == kGround) return body;
  const auto& marker = report.scenario.model.bodies[static_cast<std::size_t>(body)].marker;
  return marker ? marker->body : body;
}

// "core", or "core + antenna" for an assembly.
std::string get_title(const RunReport& report, const hil::SeparatedSide& side) {
  const int main = get_carrier(report, side.body);
  std::string title = get_body_name(report.scenario.model, main);
  std::vector<std::string> names;
  for (const int body : side.bodies)
    if (body != main && get_carrier(report, body) == body) names.push_back(get_body_name(report.scenario.model, body));
  for (const std::vector<std::size_t>& group : fold(names)) title += " + " + name_group(group, names);
  return title;
}

const hil::Clearance* find_clearance(const RunReport& report, const hil::Separation& pair) {
  return pair.pair < 0 ? nullptr : &report.analysis.clearances()[static_cast<std::size_t>(pair.pair)];
}

// Slower, or opening at the end: not closing. Convex distances are exact to 1e-6 m.
bool is_closing(const hil::Clearance& clearance) { return clearance.now > 0 && clearance.rate < -1e-6; }

// A rate in deg/s as it is printed: with four decimals, and never as -0.0000.
double to_shown_rate(double rate) {
  const double degrees = rate * kDegPerRad;
  return std::abs(degrees) < 0.00005 ? 0 : degrees;
}

void print_side(std::FILE* to, const RunReport& report, const hil::SeparatedSide& side) {
  if (side.body == kGround) return;
  std::fprintf(to, "    %-24s axial %9.4f, transverse %9.4f deg/s",
               get_body_name(report.scenario.model, side.body).c_str(), to_shown_rate(side.rate.axial),
               to_shown_rate(side.rate.transverse));
  if (side.has_coning && std::isfinite(side.coning.period))
    std::fprintf(to, "; coning half-angle %.4g deg, nutation period %.5g s", side.coning.half_angle * kDegPerRad,
                 side.coning.period);
  std::fputc('\n', to);
}

void print_separation(std::FILE* to, const RunReport& report, const hil::Separation& pair) {
  std::fprintf(to, "  %s – %s\n", get_title(report, pair.base).c_str(), get_title(report, pair.follower).c_str());
  std::fprintf(to, "    released                 %.6f s (%s%s), end of push %.6f s%s%s\n", pair.release,
               pair.joint.c_str(), pair.indirect ? "; still joined through others" : "", pair.end,
               pair.pushes ? ": a spring still acts at the end of the run" : "",
               pair.rejoined ? "; joined again later" : "");
  std::fprintf(to, "    relative velocity        %.6g m/s along %s, %.6g m/s across\n", pair.along, pair.axis.c_str(),
               drop_rounding(pair.across, std::abs(pair.along)));
  std::fprintf(to, "    relative rate            axial %9.4f, transverse %9.4f deg/s\n",
               to_shown_rate(pair.relative.axial), to_shown_rate(pair.relative.transverse));
  print_side(to, report, pair.base);
  print_side(to, report, pair.follower);
  std::vector<std::string> springs;
  for (const hil::Push& push : pair.pushers) springs.push_back(push.spring);
  for (const std::vector<std::size_t>& group : fold(springs)) {
    double impulse = 0, work = 0;
    for (const std::size_t i : group) {
      impulse += pair.pushers[i].impulse;
      work += pair.pushers[i].work;
    }
    std::fprintf(to, "    %-24s impulse %.6g N s, energy %.6g J from the release on%s\n",
                 name_group(group, springs).c_str(), impulse, work, group.size() > 1 ? ", all together" : "");
  }
  const hil::Clearance* const clearance = find_clearance(report, pair);
  if (clearance == nullptr) return;
  const hil::Clearance::AfterRelease& after = *clearance->after_release;
  std::fprintf(to, "    smallest clearance       %.6g m at %.6f s, after the release (%s – %s)", after.smallest,
               after.time, clearance->name_a.c_str(), clearance->name_b.c_str());
  if (is_closing(*clearance)) {
    char text[80];
    std::snprintf(text, sizeof text, "; still closing at the end, %.4g m/s", -clearance->rate);
    std::fputs(paint(to, Colour::kYellow, text).c_str(), to);
  }
  std::fputc('\n', to);
}

Json build_rate(const hil::SplitRate& rate) { return {{"axial", rate.axial}, {"transverse", rate.transverse}}; }

Json build_side(const RunReport& report, const hil::SeparatedSide& side) {
  Json bodies = Json::array();
  for (const int body : side.bodies) bodies.push_back(get_body_name(report.scenario.model, body));
  Json json = {
      {"body", get_body_name(report.scenario.model, side.body)}, {"bodies", bodies}, {"rate", build_rate(side.rate)}};
  json["coning_half_angle"] = side.has_coning ? Json(side.coning.half_angle) : Json(nullptr);
  json["nutation_period"] =
      side.has_coning && std::isfinite(side.coning.period) ? Json(side.coning.period) : Json(nullptr);
  return json;
}

}  // namespace

void print_separations(std::FILE* to, const RunReport& report) {
  const std::vector<hil::Separation> pairs = report.analysis.list_separations();
  if (pairs.empty()) return;
  std::fprintf(
      to, "\n%s\n",
      paint(to, Colour::kBold, "Separations (rates and velocities at the end of push, in the inertial frame)").c_str());
  std::vector<std::string> keys;
  for (const hil::Separation& pair : pairs)
    keys.push_back(without_numbers(get_title(report, pair.base) + " – " + get_title(report, pair.follower)));
  for (const std::vector<std::size_t>& group : group_alike(keys)) {
    const std::size_t fastest = *std::max_element(group.begin(), group.end(), [&](std::size_t i, std::size_t k) {
      return pairs[i].relative.transverse < pairs[k].relative.transverse;
    });
    if (group.size() > 1)
      std::fprintf(to, "  of %s %s the one that turns fastest across the axis:\n", count(group.size(), "pair").c_str(),
                   keys[fastest].c_str());
    print_separation(to, report, pairs[fastest]);
  }
}

nlohmann::ordered_json build_separations_json(const RunReport& report) {
  Json list = Json::array();
  for (const hil::Separation& pair : report.analysis.list_separations()) {
    Json springs = Json::array();
    for (const hil::Push& push : pair.pushers)
      springs.push_back({{"name", push.spring}, {"impulse", push.impulse}, {"energy", push.work}});
    Json json = {{"pair",
                  {get_body_name(report.scenario.model, pair.base.body),
                   get_body_name(report.scenario.model, pair.follower.body)}},
                 {"joint", pair.joint},
                 {"release", pair.release},
                 {"end_of_push", pair.end},
                 {"still_pushed", pair.pushes},
                 {"joined_again", pair.rejoined},
                 {"still_joined", pair.indirect},
                 {"axis", pair.axis},
                 {"velocity", {{"along", pair.along}, {"across", pair.across}}},
                 {"relative_rate", build_rate(pair.relative)},
                 {"sides", {build_side(report, pair.base), build_side(report, pair.follower)}},
                 {"springs", springs}};
    if (const hil::Clearance* const clearance = find_clearance(report, pair)) {
      json["clearance"] = {{"pair", {clearance->name_a, clearance->name_b}},
                           {"min", clearance->after_release->smallest},
                           {"t", clearance->after_release->time},
                           {"method", hil::get_method_name(clearance->method)},
                           {"now", clearance->now},
                           {"closing", is_closing(*clearance)},
                           {"rate", clearance->rate}};
    } else {
      json["clearance"] = nullptr;
    }
    list.push_back(std::move(json));
  }
  return list;
}

}  // namespace unlatch::tools
