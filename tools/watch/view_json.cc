#include <nlohmann/json.hpp>

#include "tools/watch/screen.h"

namespace unlatch::tools {
namespace {

using Json = nlohmann::ordered_json;

Json build_counts(const View& view) {
  Json counts = Json::object();
  for (std::size_t i = 0; i < view.counts.size(); ++i) {
    counts[std::string(get_kind_name(static_cast<hil::MessageKind>(i)))] = {{"count", view.counts[i]},
                                                                            {"per_second", view.rates[i]}};
  }
  return counts;
}

Json build_health(const hil::HealthMessage& health) {
  Json rejected = Json::object();
  for (std::size_t i = 0; i < health.rejected.size(); ++i) {
    rejected[std::string(get_text(static_cast<hil::Reject>(i)))] = health.rejected[i];
  }
  return {{"tick", health.tick},
          {"step_ns", {{"p50", health.step_p50_ns}, {"max", health.step_max_ns}}},
          {"wakeup_ns", {{"p50", health.wakeup_p50_ns}, {"max", health.wakeup_max_ns}}},
          {"overruns", health.overruns},
          {"dropped", health.dropped},
          {"resent", health.resent},
          {"late", health.late},
          {"missing", health.missing},
          {"rejected", rejected}};
}

}  // namespace

std::string build_json(const View& view) {
  Json json = {{"schema", 1}, {"session", view.session}, {"scenario", view.scenario}};
  json["status"] = view.session == 0 ? "waiting" : std::string(get_text(view.status));
  if (view.has_hello) {
    json["pace"] = get_text(static_cast<hil::Pace>(view.hello.pace));
    json["dt"] = static_cast<double>(view.hello.dt_ns) * 1e-9;
    json["last_tick"] = view.hello.last_tick;
  }
  json["tick"] = view.tick;
  json["t"] = view.time;
  json["silent_s"] = view.silent_s;
  json["joints"] = Json::object();
  for (const WatchedJoint& joint : view.joints) {
    json["joints"][joint.name] = {{"mode", joint.mode}};
    if (view.reactions_tick >= 0) json["joints"][joint.name]["reaction"] = joint.reaction;
  }
  json["reactions_tick"] = view.reactions_tick;
  json["clearance"] = Json::array();
  for (const hil::Clearance& clearance : view.clearances) {
    json["clearance"].push_back({{"pair", {clearance.name_a, clearance.name_b}},
                                 {"method", hil::get_method_name(clearance.method)},
                                 {"now", clearance.now},
                                 {"least_seen", clearance.smallest},
                                 {"t", clearance.time}});
  }
  json["participants"] = Json::array();
  for (const WatchedParticipant& one : view.participants) {
    json["participants"].push_back({{"name", one.name},
                                    {"status", get_text(one.status)},
                                    {"answered_tick", one.tick},
                                    {"commands", one.commands}});
  }
  if (view.health) json["health"] = build_health(*view.health);
  json["messages"] = build_counts(view);
  json["lost"] = view.lost;
  json["lost_by_transport"] = view.port.lost;
  json["repeated"] = view.repeated;
  json["malformed"] = view.port.malformed;
  json["unfit"] = view.port.unfit;
  json["knows_scenario"] = view.knows_scenario;
  if (!view.scenario_note.empty()) json["note"] = view.scenario_note;
  json["notices"] = Json::array();
  for (const WatchedNotice& notice : view.notices) {
    json["notices"].push_back(
        {{"t", notice.time}, {"text", notice.text}, {"bad", notice.is_bad}, {"count", notice.count}});
  }
  return json.dump();
}

}  // namespace unlatch::tools
