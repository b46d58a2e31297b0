// Module unlatch-telemetry: the sockets of telemetry, and the WebSocket.
#include <boost/asio/io_context.hpp>
#include <map>
#include <optional>
#include <utility>

#include "bridge/telemetry/live_server.h"
#include "bridge/telemetry/packet_outlet.h"
#include "bridge/telemetry/sequence_gaps.h"
#include "bridge/telemetry/space_packets.h"
#include "bridge/telemetry/telemetry.h"

namespace unlatch::bridge {
namespace {

constexpr int kMostAtOnce = 256;  // operations of sockets, before the next message is heard

// What of a session was lost before it came here: of each kind that the simulator numbers, and of each part.
class Losses {
 public:
  void hear(const hil::Message& message, const SessionLayout& layout) {
    if (message.hello.session != layout.get_session()) return;  // the first field of all
    switch (message.kind) {
      case hil::MessageKind::kState:
        if (message.state.part < layout.count_state_parts()) states_[message.state.part].hear(message.state.sequence);
        break;
      case hil::MessageKind::kReactions:
        if (message.reactions.part < layout.count_reaction_parts())
          reactions_[message.reactions.part].hear(message.reactions.sequence);
        break;
      case hil::MessageKind::kEvent:
        events_.hear(message.event.sequence);
        break;
      case hil::MessageKind::kHealth:
        health_.hear(message.health.sequence);
        break;
      default:
        break;
    }
  }
  void add_to(TelemetryReport& report) const {
    for (const auto& [part, gaps] : states_) {
      report.states_lost += gaps.get_lost();
      report.lost += gaps.get_lost();
    }
    for (const auto& [part, gaps] : reactions_) report.lost += gaps.get_lost();
    report.lost += events_.get_lost() + health_.get_lost();
  }

 private:
  std::map<std::int32_t, SequenceGaps> states_, reactions_;  // by part
  SequenceGaps events_, health_;
};

class SocketTelemetry final : public Telemetry {
 public:
  explicit SocketTelemetry(const TelemetryOptions& options) : rate_(options.rate) {
    if (!options.udp.empty() || !options.tcp.empty()) outlet_.emplace(io_, options.udp, options.tcp);
    if (!options.live.empty()) live_.emplace(io_, options.live, options.origins);
  }

  void hear(const hil::Message& message, Time now) override {
    ++report_.heard;
    if (layout_.hear(message)) {
      announced_ = false;
      tick_ = -1;
      losses_.add_to(report_);
      losses_ = {};
    }
    if (!layout_.is_complete()) {
      ++report_.early;
      return;
    }
    losses_.hear(message, layout_);
    if (!std::exchange(announced_, true)) {
      if (on_layout) on_layout(layout_);
      if (live_) live_->begin(layout_);
    }
    if (message.kind == hil::MessageKind::kState && !is_due(message.state, now)) {
      ++report_.thinned;
      return;
    }
    if (outlet_ && writer_.write(message, layout_, packet_)) outlet_->send({packet_.begin(), packet_.end()});
    if (live_) live_->send(message);
  }

  bool serve() override {
    int done = 0;
    while (done < kMostAtOnce && io_.poll_one() > 0) ++done;
    if (io_.stopped()) io_.restart();  // it had nothing to do
    return done == kMostAtOnce;
  }

  [[nodiscard]] TelemetryReport get_report() const override {
    TelemetryReport report = report_;
    losses_.add_to(report);
    if (outlet_) report.packets = outlet_->get_counts();
    if (live_) report.live = live_->get_counts();
    return report;
  }

 private:
  // A tick is sent whole: its last part is due if its first was. The last State of a session always is.
  [[nodiscard]] bool is_due(const hil::StateMessage& state, Time now) {
    if (rate_ <= 0 || state.tick == tick_ || state.status >= static_cast<std::int32_t>(hil::RunStatus::kDone))
      return true;
    if (now - last_ < std::chrono::duration<double>(1 / rate_)) return false;
    last_ = now;
    tick_ = state.tick;
    return true;
  }

  const double rate_;
  Time last_{};  // of the latest tick sent
  std::int64_t tick_ = -1;
  bool announced_ = false;
  TelemetryReport report_;  // with the losses of sessions before this one
  Losses losses_;
  SessionLayout layout_;
  SpacePacketWriter writer_;
  SpacePacket packet_;
  boost::asio::io_context io_{1};  // before the others, whose sockets are in it
  std::optional<PacketOutlet> outlet_;
  std::optional<LiveServer> live_;
};

}  // namespace
}  // namespace unlatch::bridge

extern "C" unlatch::bridge::Telemetry* unlatch_open_telemetry(const unlatch::bridge::TelemetryOptions& options) {
  return new unlatch::bridge::SocketTelemetry(options);
}
