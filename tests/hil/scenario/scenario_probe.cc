// scenario_probe: for each line of standard input, a JSON text of a scenario, prints one line of JSON: its mistakes, or
// a summary of the loaded scenario. language_test.py asks it hundreds of questions.
#include <iostream>
#include <nlohmann/json.hpp>

#include "hil/scenario/scenario.h"
#include "kernel/compile/model_hash.h"

namespace {

using nlohmann::json;

// Values of all keys with a default.
json summarize(const unlatch::hil::Scenario& s) {
  unlatch::PlanOptions options;
  options.dt = s.dt;
  const auto& fsw = s.flight_software;
  json out{{"model", unlatch::calc_model_hash(s.model, options)},
           {"units", json::array()},
           {"software",
            {fsw.required, fsw.timeout, fsw.pause_limit, fsw.cutoff, fsw.delay, static_cast<int>(fsw.policy),
             fsw.horizon, fsw.queue}},
           {"timing",
            {static_cast<int>(s.timing.overruns.kind), s.timing.overruns.max_ticks, s.timing.spin, s.timing.watchdog,
             s.timing.watchdog_aborts, s.timing.per_tick}},
           {"states", {s.rates.states.every, s.rates.states.phase}},
           {"shapes", json::array()}};
  for (const auto& channel : s.model.channels) out["units"].push_back(channel.unit);
  for (const auto& group : s.rates.groups)
    out["groups"].push_back({group.rate.every, group.rate.phase, group.sensors, group.channels});
  for (const auto& shapes : s.shapes)
    for (const auto& [name, group, shape, mesh] : shapes) {
      if (mesh) {
        const auto& [file, scale, origin, q] = mesh->get_place();
        out["shapes"].push_back({name, group, file, scale, origin.x, origin.y, origin.z, q.w, q.x, q.y, q.z});
        continue;
      }
      const auto& q = shape.q_BS;
      out["shapes"].push_back({name, group, static_cast<int>(shape.kind), shape.from.x, shape.from.y, shape.from.z, q.w,
                               q.x, q.y, q.z, shape.half});
    }
  for (const auto& pair : s.clearance) out["clearance"].push_back({pair.a.name, pair.b.name, pair.except});
  return out;
}

}  // namespace

int main() {
  for (std::string line; std::getline(std::cin, line);) {
    json answer;
    try {
      const json question = json::parse(line);
      const auto s = unlatch::hil::load_scenario_text(question.at("text"), "s.yaml",
                                                      question.value("set", std::vector<std::string>()));
      answer["scenario"] = summarize(s);
    } catch (const unlatch::hil::ScenarioError& error) {
      for (const auto& mistake : error.mistakes)
        answer["mistakes"].push_back({{"what", mistake.what}, {"mend", mistake.mend}});
    }
    std::cout << answer.dump(-1, ' ', false, json::error_handler_t::replace) << "\n" << std::flush;
  }
}
