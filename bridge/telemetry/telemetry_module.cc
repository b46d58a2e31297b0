// Module unlatch-telemetry: the sockets of telemetry, and the WebSocket.
#include <boost/asio/io_context.hpp>
#include <optional>
#include <utility>

#include "bridge/telemetry/live_server.h"
#include "bridge/telemetry/packet_outlet.h"
#include "bridge/telemetry/space_packets.h"
#include "bridge/telemetry/telemetry.h"

namespace unlatch::bridge {
namespace {

constexpr int kMostAtOnce = 256;  // operations of sockets, before the next message is heard

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
    }
    if (!layout_.is_complete()) {
      ++report_.early;
      return;
    }
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
  TelemetryReport report_;
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
