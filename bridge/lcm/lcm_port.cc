// The LCM transport: one channel per message, UNLATCH_STATE and so on. Messages go out through liblcm, from a buffer
// that the codec of hil/session/messages fills, so that nothing allocates on our side; they come in through LcmSocket.
#include <lcm/lcm.h>

#include <array>
#include <optional>
#include <string_view>

#include "bridge/core/port.h"
#include "bridge/lcm/lcm_route.h"
#include "bridge/lcm/lcm_socket.h"

namespace unlatch::bridge {
namespace {

constexpr std::string_view kUdpScheme = "udpm://";

class LcmPort final : public Port {
 public:
  LcmPort(Role role, const LcmOptions& options) : Port(role) {
    if (!options.url.starts_with(kUdpScheme)) {
      throw PortError("LCM: '" + options.url + "' is not a UDP multicast address; write it like " + LcmOptions{}.url);
    }
    const LcmRoute route = find_lcm_route(options.url);
    if (route.interface.empty()) throw PortError(explain(options));
    if (route.interface != options.interface) throw PortError(explain_route(options, route.interface));
    lcm_.reset(lcm_create(options.url.c_str()));
    if (!lcm_) throw PortError(explain(options));
    socket_.emplace(role, route, options.interface);
  }

 private:
  struct Close {
    void operator()(lcm_t* lcm) const { lcm_destroy(lcm); }
  };

  // The documents show the same commands, of the interface lo.
  static std::string describe_remedy(const LcmOptions& options) {
    return "As root, `ip link set " + options.interface + " multicast on && ip route replace 224.0.0.0/4 dev " +
           options.interface + "` routes it through '" + options.interface + "'.";
  }

  static std::string explain(const LcmOptions& options) {
    return "LCM cannot open " + options.url + ". Most often the machine has no route for multicast. " +
           describe_remedy(options);
  }

  static std::string explain_route(const LcmOptions& options, const std::string& interface) {
    return "LCM: this machine's route for " + options.url + " leads through the interface '" + interface + "', not '" +
           options.interface + "'. Anyone on '" + interface +
           "' could command the simulator. To allow that, ask for it by name (--interface). " +
           describe_remedy(options);
  }

  bool send(const Message& message) override {
    if (message.kind == MessageKind::kHello) socket_->set_own_session(message.hello.session);
    const std::size_t length = hil::encode(message, buffer_);
    return length > 0 && lcm_publish(lcm_.get(), hil::get_channel(message.kind).data(), buffer_.data(),
                                     static_cast<unsigned int>(length)) == 0;
  }

  Received receive(Message& message, std::chrono::nanoseconds wait) override {
    bool readable = false;
    if (!socket_->pop(message, readable, wait)) return Received::kNothing;
    return readable ? Received::kMessage : Received::kMalformed;
  }

  [[nodiscard]] std::int64_t get_lost() const override { return socket_->get_lost(); }
  [[nodiscard]] std::int64_t get_unreadable() const noexcept override { return socket_->get_malformed(); }

  std::array<std::uint8_t, hil::kMaxWireBytes> buffer_{};  // of the thread that publishes
  std::unique_ptr<lcm_t, Close> lcm_;
  std::optional<LcmSocket> socket_;
};

}  // namespace

std::string describe(const LcmOptions& options) {
  const std::string text = "LCM, " + options.url + " on the interface '" + options.interface + "': ";
  if (options.interface == "lo") return text + "this machine only; every process on it may listen and command";
  return text +
         (find_lcm_route(options.url).ttl > 0 ? "everyone there may listen and command"
                                              : "nothing leaves this machine, but everyone there may command") +
         "; LCM has no access control";
}

std::unique_ptr<Port> open_lcm_port(Role role, const LcmOptions& options) {
  return std::make_unique<LcmPort>(role, options);
}

}  // namespace unlatch::bridge
