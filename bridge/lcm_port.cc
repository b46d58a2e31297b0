// The LCM transport: one channel per message, UNLATCH_STATE and so on. Messages go out from a buffer that the codec of
// hil/messages fills, and come in through it, so that nothing allocates on our side.
#include <lcm/lcm.h>
#include <poll.h>

#include <algorithm>
#include <array>
#include <ctime>
#include <span>
#include <string_view>

#include "bridge/lcm_route.h"
#include "bridge/port.h"

namespace unlatch::bridge {
namespace {

// Messages of one kind that may wait: LCM drops the newest beyond that, silently.
constexpr int kQueueCapacity = 8192;

constexpr std::string_view kUdpScheme = "udpm://";

timespec to_timespec(std::chrono::nanoseconds time) {
  const auto seconds = std::chrono::duration_cast<std::chrono::seconds>(time);
  return {.tv_sec = seconds.count(), .tv_nsec = (time - seconds).count()};
}

class LcmPort final : public Port {
 public:
  LcmPort(Role role, const LcmOptions& options) : Port(role) {
    if (!options.url.starts_with(kUdpScheme)) {
      throw PortError("LCM: '" + options.url + "' is not a UDP multicast address; write it like " + LcmOptions{}.url);
    }
    const std::string interface = find_lcm_route(options.url).interface;
    if (!interface.empty() && interface != options.interface) throw PortError(explain_route(options, interface));
    lcm_.reset(lcm_create(options.url.c_str()));
    if (!lcm_) throw PortError(explain(options));
    for (std::size_t i = 0; i < hil::kMessageKinds; ++i) {
      subscriptions_[i] = {this, static_cast<MessageKind>(i)};
      if (receives(role, subscriptions_[i].kind)) subscribe(subscriptions_[i], options);
    }
  }

 private:
  struct Subscription {
    LcmPort* port;
    MessageKind kind;
  };
  struct Close {
    void operator()(lcm_t* lcm) const { lcm_destroy(lcm); }
  };

  static std::string explain(const LcmOptions& options) {
    return "LCM cannot open " + options.url +
           ". Most often the machine has no route for multicast: as root, `ip link set lo multicast on && ip route add "
           "224.0.0.0/4 dev lo` keeps it on the loopback interface.";
  }

  static std::string explain_route(const LcmOptions& options, const std::string& interface) {
    return "LCM: this machine's route for " + options.url + " leads through the interface '" + interface + "', not '" +
           options.interface + "'. Anyone on '" + interface +
           "' could command the simulator: ask for it by that name, or route it elsewhere, as root, with `ip route "
           "replace 224.0.0.0/4 dev " +
           options.interface + "`.";
  }

  void subscribe(Subscription& subscription, const LcmOptions& options) {
    // Channel names are views of literals, so that they end in NUL.
    lcm_subscription_t* handle =
        lcm_subscribe(lcm_.get(), hil::get_channel(subscription.kind).data(), handle_message, &subscription);
    if (!handle) throw PortError(explain(options));
    lcm_subscription_set_queue_capacity(handle, kQueueCapacity);
  }

  // Called by lcm_handle, in the thread that polls.
  static void handle_message(const lcm_recv_buf_t* buffer, const char*, void* user) {
    const auto& subscription = *static_cast<const Subscription*>(user);
    LcmPort& port = *subscription.port;
    const std::span bytes(static_cast<const std::uint8_t*>(buffer->data), buffer->data_size);
    port.result_ = hil::decode(subscription.kind, bytes, *port.target_) ? Received::kMessage : Received::kMalformed;
  }

  bool send(const Message& message) override {
    const std::size_t length = hil::encode(message, buffer_);
    return length > 0 && lcm_publish(lcm_.get(), hil::get_channel(message.kind).data(), buffer_.data(),
                                     static_cast<unsigned int>(length)) == 0;
  }

  Received receive(Message& message, std::chrono::nanoseconds wait) override {
    pollfd waiting{.fd = lcm_get_fileno(lcm_.get()), .events = POLLIN, .revents = 0};
    const timespec limit = to_timespec(std::max(wait, std::chrono::nanoseconds::zero()));
    if (ppoll(&waiting, 1, &limit, nullptr) <= 0) return Received::kNothing;
    target_ = &message;
    result_ = Received::kOther;
    lcm_handle(lcm_.get());  // one message, which handle_message decodes
    return result_;
  }

  std::array<Subscription, hil::kMessageKinds> subscriptions_{};
  std::array<std::uint8_t, hil::kMaxWireBytes> buffer_{};  // of the thread that publishes
  Message* target_ = nullptr;                              // of the thread that polls, as is result_
  Received result_ = Received::kOther;
  std::unique_ptr<lcm_t, Close> lcm_;
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
