// A run as JSON, one object on each line. Ticks have the form of the samples of `unlatch run --json`.
#include <cmath>
#include <nlohmann/json.hpp>

#include "tools/export/sink.h"
#include "tools/shape_json.h"

namespace unlatch::tools {
namespace {

using Json = nlohmann::ordered_json;

Json to_json(const Vec3& v) { return Json::array({v.x, v.y, v.z}); }
Json build_body(const hil::Scenario& scenario, std::size_t body) {
  Json shapes = Json::array();
  for (const hil::BodyShape& part : scenario.shapes[body]) {
    Json json = build_shape_json(part.shape);
    if (!part.name.empty()) json["name"] = part.name;
    if (!part.group.empty()) json["group"] = part.group;
    shapes.push_back(std::move(json));
  }
  return {{"name", scenario.model.bodies[body].name}, {"mass", scenario.model.bodies[body].mass}, {"shapes", shapes}};
}

std::string to_hex(std::int64_t hash) {
  char text[17];
  std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(hash));
  return text;
}

class JsonSink final : public Sink {
 public:
  explicit JsonSink(std::FILE* file) : file_(file) {}

  void begin(const Selection& selection, const hil::LogHeader& header) override {
    const hil::Scenario& scenario = selection.scenario();
    Json run = {{"kind", "run"},
                {"schema", 1},
                {"scenario", header.scenario_name},
                {"title", scenario.title},
                {"program", header.program},
                {"compiler", header.compiler},
                {"model_hash", to_hex(header.model_hash)},
                {"dt", header.dt},
                {"first_t", static_cast<double>(header.first_tick) * header.dt},
                {"units", "SI and radians; p, v in W; w in body axes; q (w, x, y, z) body to W"},
                {"rows", kRowNames}};
    run["bodies"] = Json::array();
    for (const std::size_t body : selection.bodies()) run["bodies"].push_back(build_body(scenario, body));
    run["joints"] = Json::array();
    for (const Joint& joint : scenario.model.joints) run["joints"].push_back(joint.name);
    run["channels"] = Json::array();
    for (const Channel& channel : scenario.model.channels) {
      run["channels"].push_back({{"name", channel.name}, {"unit", channel.unit}});
    }
    run["clearance"] = Json::array();
    for (const hil::ClearancePair& pair : scenario.clearance) run["clearance"].push_back({pair.a.name, pair.b.name});
    run["scenario_text"] = header.scenario_text;
    run["overrides"] = header.overrides;
    put(run);
  }

  void add_tick(const Selection& selection) override {
    for (const hil::TimelineEntry& event : selection.events()) {
      put({{"kind", "event"}, {"t", event.time}, {"name", event.name}, {"subject", event.subject}});
    }
    const hil::Simulation& simulation = selection.simulation();
    const Model& model = selection.scenario().model;
    Json bodies = Json::object(), reactions = Json::object(), clearance = Json::array(), channels = Json::object();
    for (const std::size_t i : selection.bodies()) {
      const unlatch::BodyState& body = simulation.state().bodies[i];
      bodies[model.bodies[i].name] = {{"p", to_json(body.p)},
                                      {"q", {body.q.w, body.q.x, body.q.y, body.q.z}},
                                      {"v", to_json(body.v)},
                                      {"w", to_json(body.w)},
                                      {"modal", selection.get_modal(i)}};
    }
    for (std::size_t i = 0; i < model.joints.size(); ++i) {
      reactions[model.joints[i].name] = build_reaction(selection, i);
    }
    for (const hil::Clearance& pair : selection.clearances()) clearance.push_back(pair.now);
    for (std::size_t i = 0; i < model.channels.size(); ++i) channels[model.channels[i].name] = simulation.channels()[i];
    put({{"kind", "tick"},
         {"tick", simulation.get_tick()},
         {"t", simulation.get_time()},
         {"bodies", bodies},
         {"reactions", reactions},
         {"clearance", clearance},
         {"channels", channels}});
  }

  void end(const ExportEnd& end) override {
    put({{"kind", "end"}, {"status", end.status}, {"message", end.message}, {"hash", end.hash}});
  }

 private:
  static Json build_reaction(const Selection& selection, std::size_t joint) {
    const JointMode& mode = selection.get_mode(joint);
    Json rows = Json::array(), values = Json::array();
    for (int row = 0; row < kRows; ++row) {
      if (!has_row(mode.rows, row)) continue;
      rows.push_back(kRowNames[row]);
      values.push_back(selection.simulation().workspace().multipliers[joint * kRows + static_cast<std::size_t>(row)]);
    }
    return {{"mode", mode.name}, {"rows", rows}, {"lambda", values}};
  }

  void put(const Json& json) {
    const std::string line = json.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n";
    std::fwrite(line.data(), 1, line.size(), file_);
  }

  std::FILE* file_;
};

}  // namespace

std::unique_ptr<Sink> build_json_sink(std::FILE* file) { return std::make_unique<JsonSink>(file); }

}  // namespace unlatch::tools
