// A run as JSON, one object on each line. Ticks have the form of the samples of `unlatch run --json`.
#include <algorithm>
#include <nlohmann/json.hpp>

#include "tools/common/shape_json.h"
#include "tools/common/text.h"
#include "tools/export/output_json.h"
#include "tools/export/sink.h"

namespace unlatch::tools {
namespace {

using Json = nlohmann::ordered_json;

Json build_shapes(const std::vector<hil::BodyShape>& parts) {
  Json shapes = Json::array();
  for (const hil::BodyShape& part : parts) {
    Json json = build_shape_json(part);
    if (!part.name.empty()) json["name"] = part.name;
    if (!part.group.empty()) json["group"] = part.group;
    shapes.push_back(std::move(json));
  }
  return shapes;
}

Json build_body(const hil::Scenario& scenario, std::size_t body) {
  return {{"name", scenario.model.bodies[body].name},
          {"mass", scenario.model.bodies[body].mass},
          {"shapes", build_shapes(scenario.shapes[body])}};
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
                {"units", "SI and radians; p, v, a in W; w, alpha in body axes; q (w, x, y, z) body to W"},
                {"rows", kRowNames}};
    const std::vector<hil::Output>& list = selection.reader().list();
    const auto chosen = [&](const char* group, const std::string& name) {
      return std::ranges::any_of(selection.outputs(),
                                 [&](std::size_t i) { return list[i].group == group && list[i].of == name; });
    };
    run["bodies"] = Json::array();
    for (std::size_t i = 0; i < scenario.model.bodies.size(); ++i)
      if (chosen("body", scenario.model.bodies[i].name)) run["bodies"].push_back(build_body(scenario, i));
    run["ground"] = build_shapes(scenario.ground_shapes);
    run["joints"] = Json::array();
    for (const Joint& joint : scenario.model.joints)
      if (chosen("joint", joint.name)) run["joints"].push_back(joint.name);
    run["channels"] = Json::array();
    for (const Channel& channel : scenario.model.channels)
      if (chosen("command", channel.name)) run["channels"].push_back({{"name", channel.name}, {"unit", channel.unit}});
    run["outputs"] = build_output_list_json(list, selection.outputs());
    run["clearance"] = Json::array();
    for (const hil::ClearancePair& pair : scenario.clearance) run["clearance"].push_back({pair.a.name, pair.b.name});
    run["clearance_methods"] = Json::array();
    for (const hil::Clearance& pair : selection.reader().get_clearances())
      run["clearance_methods"].push_back(hil::get_method_name(pair.method));
    run["scenario_text"] = header.scenario_text;
    run["overrides"] = header.overrides;
    put(run);
  }

  void add_tick(const Selection& selection) override {
    for (const hil::TimelineEntry& event : selection.events()) {
      Json line = {{"kind", "event"}, {"t", event.time}, {"name", event.name}, {"subject", event.subject}};
      if (!event.shapes.empty()) line["shapes"] = event.shapes;
      put(line);
    }
    Json tick = {
        {"kind", "tick"}, {"tick", selection.simulation().get_tick()}, {"t", selection.simulation().get_time()}};
    tick.update(
        build_outputs_json(selection.reader(), selection.scenario().model, selection.due(), selection.values()));
    put(tick);
  }

  void add_contact(const hil::ContactRecord& contact) override {
    for (const hil::Touch& touch : contact.list)
      put({{"kind", "touch"},
           {"contact", contact.name},
           {"t", touch.time},
           {"lift", touch.lift ? Json(*touch.lift) : Json(nullptr)},
           {"duration", touch.duration},
           {"shapes", touch.pairs},
           {"peak_force", touch.peak_force},
           {"peak_t", touch.peak_time},
           {"depth", touch.depth},
           {"impulse", touch.impulse}});
  }

  void end(const ExportEnd& end) override {
    put({{"kind", "end"}, {"status", end.status}, {"message", end.message}, {"hash", end.hash}});
  }

 private:
  void put(const Json& json) {
    const std::string line = json.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n";
    std::fwrite(line.data(), 1, line.size(), file_);
  }

  std::FILE* file_;
};

}  // namespace

std::unique_ptr<Sink> build_json_sink(std::FILE* file) { return std::make_unique<JsonSink>(file); }

}  // namespace unlatch::tools
