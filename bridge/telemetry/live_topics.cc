#include "bridge/telemetry/live_topics.h"

#include <algorithm>
#include <nlohmann/json.hpp>

namespace unlatch::bridge {
namespace {

using hil::CatalogKind;
using hil::MessageKind;
using Json = nlohmann::json;

constexpr std::int64_t kNanosecond = 1'000'000'000;
constexpr const char* kRows[] = {"x", "y", "z", "rot_x", "rot_y", "rot_z"};

const Json kNumber{{"type", "number"}};
const Json kText{{"type", "string"}};

Json list_properties(const std::vector<std::string>& names, const Json& type = kNumber) {
  Json properties = Json::object();
  for (const std::string& name : names) properties[name] = type;
  return {{"type", "object"}, {"properties", properties}};
}
const Json kVector = list_properties({"x", "y", "z"});
const Json kTime = list_properties({"sec", "nsec"}, {{"type", "integer"}});

Json list_of(const Json& items) { return {{"type", "array"}, {"items", items}}; }
Json with(Json object, const char* key, const Json& type) {
  object["properties"][key] = type;
  return object;
}

std::string dump(const Json& json) { return json.dump(-1, ' ', false, Json::error_handler_t::replace); }

Json to_stamp(std::int64_t time_ns) { return {{"sec", time_ns / kNanosecond}, {"nsec", time_ns % kNanosecond}}; }
Json to_vector(double x, double y, double z) { return {{"x", x}, {"y", y}, {"z", z}}; }

// Positions in m, velocities in m/s, W; q is w, x, y, z, body to W; w rad/s, body axes.
std::string write_body_schema() {
  return dump(
      {{"type", "object"}, {"properties", {{"p", kVector}, {"q", list_of(kNumber)}, {"v", kVector}, {"w", kVector}}}});
}

// The part of a sensor's value before its component: "gyro" of "gyro.x".
std::string get_sensor(const std::string& value) { return value.substr(0, value.rfind('.')); }

}  // namespace

std::size_t LiveTopics::add(std::string name, std::string schema_name, std::string schema) {
  topics_.push_back({std::move(name), std::move(schema_name), std::move(schema)});
  return topics_.size() - 1;
}

LiveTopics::LiveTopics(const SessionLayout& layout)
    : session_(layout.get_session()),
      commanded_(layout.list(CatalogKind::kChannel).size()),
      received_(layout.list(CatalogKind::kSensor).size()) {
  const Json transform = {{"type", "object"},
                          {"properties",
                           {{"timestamp", kTime},
                            {"parent_frame_id", kText},
                            {"child_frame_id", kText},
                            {"translation", kVector},
                            {"rotation", with(kVector, "w", kNumber)}}}};
  tf_ = add("/tf", "foxglove.FrameTransforms",
            dump({{"type", "object"}, {"properties", {{"transforms", list_of(transform)}}}}));
  Json log = list_properties({"message", "name", "file"}, kText);
  log["properties"]["timestamp"] = kTime;
  log["properties"]["level"] = log["properties"]["line"] = {{"type", "integer"}};
  events_ = add("/events", "foxglove.Log", dump(log));
  health_ = add("/health", "unlatch.Health",
                dump(list_properties({"t", "tick", "wall_s", "step_p50_us", "step_max_us", "wakeup_p50_us",
                                      "wakeup_max_us", "overruns", "dropped", "resent", "late", "missing"})));
  for (const LayoutItem& channel : layout.list(CatalogKind::kChannel)) channels_.push_back(channel.name);
  commands_ = add("/channels", "unlatch.Channels", dump(list_properties(channels_)));
  const std::string body_schema = write_body_schema();
  first_body_ = topics_.size();
  for (const LayoutItem& body : layout.list(CatalogKind::kBody)) {
    bodies_.push_back(body.name);
    add("/bodies/" + body.name, "unlatch.Body", body_schema);
  }
  first_joint_ = topics_.size();
  for (const LayoutItem& joint : layout.list(CatalogKind::kJoint))
    add("/joints/" + joint.name, "unlatch.Joint",
        dump(with(list_properties({std::begin(kRows), std::end(kRows)}), "mode", {{"type", "integer"}})));
  const std::vector<LayoutItem>& values = layout.list(CatalogKind::kSensor);
  for (std::size_t i = 0; i < values.size(); ++i) {
    const std::string sensor = get_sensor(values[i].name);
    if (!sensors_.empty() && topics_[sensors_.back().topic].name == "/received/" + sensor)
      ++sensors_.back().count;
    else
      sensors_.push_back({add("/received/" + sensor, "unlatch.Sensor",
                              dump({{"type", "object"}, {"properties", {{"values", list_of(kNumber)}}}})),
                          i, 1});
  }
}

void LiveTopics::write_wanted(const hil::Message& message, std::vector<Text>& texts) {
  if (message.hello.session != session_) return;  // the first field of every message
  switch (message.kind) {
    case MessageKind::kState:
      time_ns_ = message.state.time_ns;
      return write_state(message.state, texts);
    case MessageKind::kReactions:
      return write_reactions(message.reactions, texts);
    case MessageKind::kEvent: {
      if (!wanted_[events_]) return;
      std::string text(hil::get_name(message.event.name));
      if (const auto subject = hil::get_name(message.event.subject); !subject.empty())
        text += " " + std::string(subject);
      constexpr int kInfo = 2;  // of foxglove.Log
      texts.push_back({events_, dump({{"timestamp", to_stamp(message.event.time_ns)},
                                      {"level", kInfo},
                                      {"message", text},
                                      {"name", "unlatch"},
                                      {"file", ""},
                                      {"line", 0}})});
      return;
    }
    case MessageKind::kHealth: {
      if (!wanted_[health_]) return;
      const hil::HealthMessage& health = message.health;
      const auto us = [](std::int64_t ns) { return 1e-3 * static_cast<double>(ns); };
      texts.push_back({health_, dump({{"t", 1e-9 * static_cast<double>(health.time_ns)},
                                      {"tick", health.tick},
                                      {"wall_s", 1e-9 * static_cast<double>(health.wall_ns)},
                                      {"step_p50_us", us(health.step_p50_ns)},
                                      {"step_max_us", us(health.step_max_ns)},
                                      {"wakeup_p50_us", us(health.wakeup_p50_ns)},
                                      {"wakeup_max_us", us(health.wakeup_max_ns)},
                                      {"overruns", health.overruns},
                                      {"dropped", health.dropped},
                                      {"resent", health.resent},
                                      {"late", health.late},
                                      {"missing", health.missing}})});
      return;
    }
    case MessageKind::kCommand: {
      const auto channel = static_cast<std::size_t>(message.command.channel);
      if (message.command.channel < 0 || channel >= commanded_.size()) return;
      commanded_[channel] = message.command.value;
      if (!wanted_[commands_]) return;
      texts.push_back({commands_, dump({{channels_[channel], commanded_[channel]}})});
      return;
    }
    default:
      return;
  }
}

void LiveTopics::write_state(const hil::StateMessage& state, std::vector<Text>& texts) {
  const auto part = static_cast<std::size_t>(state.part);
  const std::size_t first_body = part * hil::kBodiesPerPart, first_joint = part * hil::kJointsPerPart,
                    first_value = part * hil::kSensorsPerPart;
  Json transforms = Json::array();
  for (std::size_t i = 0; i < static_cast<std::size_t>(state.body_count) && first_body + i < bodies_.size(); ++i) {
    const hil::BodyStateMessage& body = state.bodies[i];
    if (wanted_[tf_])
      transforms.push_back({{"timestamp", to_stamp(time_ns_)},
                            {"parent_frame_id", "W"},
                            {"child_frame_id", bodies_[first_body + i]},
                            {"translation", to_vector(body.x, body.y, body.z)},
                            {"rotation", {{"x", body.qx}, {"y", body.qy}, {"z", body.qz}, {"w", body.qw}}}});
    const std::size_t topic = first_body_ + first_body + i;
    if (!wanted_[topic]) continue;
    texts.push_back({topic, dump({{"p", to_vector(body.x, body.y, body.z)},
                                  {"q", {body.qw, body.qx, body.qy, body.qz}},
                                  {"v", to_vector(body.vx, body.vy, body.vz)},
                                  {"w", to_vector(body.wx, body.wy, body.wz)}})});
  }
  if (!transforms.empty()) texts.push_back({tf_, dump({{"transforms", transforms}})});
  for (std::size_t i = 0; i < static_cast<std::size_t>(state.joint_count); ++i) {
    const std::size_t topic = first_joint_ + first_joint + i;
    if (topic < topics_.size() && wanted_[topic]) texts.push_back({topic, dump({{"mode", state.modes[i]}})});
  }
  for (std::size_t i = 0; i < static_cast<std::size_t>(state.sensor_count) && first_value + i < received_.size(); ++i)
    received_[first_value + i] = state.sensors[i];
  // A sensor is complete with its last value.
  const std::size_t end = first_value + static_cast<std::size_t>(state.sensor_count);
  for (const Sensor& sensor : sensors_) {
    const std::size_t last = sensor.first + sensor.count - 1;
    if (!wanted_[sensor.topic] || last < first_value || last >= end) continue;
    const auto begin = received_.begin() + static_cast<std::ptrdiff_t>(sensor.first);
    texts.push_back(
        {sensor.topic,
         dump({{"values", std::vector<double>(begin, begin + static_cast<std::ptrdiff_t>(sensor.count))}})});
  }
}

void LiveTopics::write_reactions(const hil::ReactionsMessage& reactions, std::vector<Text>& texts) const {
  constexpr std::size_t kRowCount = std::size(kRows);
  const std::size_t first = static_cast<std::size_t>(reactions.part) * hil::kReactionsPerPart / kRowCount;
  for (std::size_t i = 0; i < static_cast<std::size_t>(reactions.count) / kRowCount; ++i) {
    const std::size_t topic = first_joint_ + first + i;
    if (topic >= topics_.size() || !wanted_[topic]) continue;
    Json json = Json::object();
    for (std::size_t row = 0; row < kRowCount; ++row) json[kRows[row]] = reactions.multipliers[i * kRowCount + row];
    texts.push_back({topic, dump(json)});
  }
}

}  // namespace unlatch::bridge
