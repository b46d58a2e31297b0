// Messages as topics of the Foxglove WebSocket protocol (subprotocol foxglove.websocket.v1): JSON with JSON schemas,
// and the names and keys of the MCAP export, so that a layout made for a recording shows a running session:
//
//   /tf                    foxglove.FrameTransforms   frames of the bodies in W
//   /bodies/NAME           p, q, v, w
//   /joints/NAME           mode (its index), and the reactions x … rot_z, ten times a second
//   /received/NAME         values: a sensor as flight software receives it
//   /channels              commanded values
//   /events                foxglove.Log
//   /health                the numbers of Health
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "bridge/telemetry/session_layout.h"

namespace unlatch::bridge {

struct LiveTopic {
  std::string name, schema_name, schema;  // schema: JSON Schema, as text
};

class LiveTopics {
 public:
  // Topics of a layout that is complete.
  explicit LiveTopics(const SessionLayout& layout);

  [[nodiscard]] const std::vector<LiveTopic>& list() const { return topics_; }

  // A message as texts of its topics. `is_wanted(topic)`: some client subscribes to it; others are left out.
  struct Text {
    std::size_t topic;
    std::string json;
  };
  template <class Wanted>
  void write(const hil::Message& message, const Wanted& is_wanted, std::vector<Text>& texts) {
    wanted_.resize(topics_.size());
    for (std::size_t i = 0; i < topics_.size(); ++i) wanted_[i] = is_wanted(i);
    write_wanted(message, texts);
  }
  // Simulated time of a message, ns; that of the latest one that has a time.
  [[nodiscard]] std::int64_t get_time() const { return time_ns_; }

 private:
  std::size_t add(std::string name, std::string schema_name, std::string schema);
  void write_wanted(const hil::Message& message, std::vector<Text>& texts);
  void write_state(const hil::StateMessage& state, std::vector<Text>& texts);
  void write_reactions(const hil::ReactionsMessage& reactions, std::vector<Text>& texts) const;

  struct Sensor {
    std::size_t topic, first, count;  // values of the session
  };
  const std::int64_t session_;
  std::vector<LiveTopic> topics_;
  std::vector<bool> wanted_;
  std::vector<std::string> bodies_, channels_;
  std::vector<double> commanded_, received_;
  std::vector<Sensor> sensors_;
  std::size_t tf_, first_body_, first_joint_, commands_, events_, health_;
  std::int64_t time_ns_ = 0;
};

}  // namespace unlatch::bridge
