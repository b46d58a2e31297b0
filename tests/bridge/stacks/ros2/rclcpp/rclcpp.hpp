// The smallest stand-in for the interface of rclcpp that unlatch_node.cpp uses, by its published interface (ROS 2
// Humble, Apache-2.0): names and meanings, no code of it. Topics of one name are connected in this process; messages
// wait until the executor spins.
#pragma once

#include <chrono>
#include <cstdint>
#include <cstdio>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <vector>

namespace rclcpp {

struct Logger {};
#define RCLCPP_ERROR(logger, ...) ((void)(logger), ++rclcpp::errors, std::printf(__VA_ARGS__), std::printf("\n"))
#define RCLCPP_INFO(logger, ...) ((void)(logger), std::printf(__VA_ARGS__), std::printf("\n"))

inline int errors = 0;
inline std::vector<std::function<void()>> waiting;
inline bool running = true;

template <class Message>
std::map<std::string, std::vector<std::function<void(const Message&)>>>& listeners() {
  static std::map<std::string, std::vector<std::function<void(const Message&)>>> map;
  return map;
}

template <class Message>
class Publisher {
 public:
  using SharedPtr = std::shared_ptr<Publisher>;
  explicit Publisher(std::string topic) : topic_(std::move(topic)) {}
  void publish(const Message& message) {
    for (const auto& listener : listeners<Message>()[topic_])
      waiting.push_back([listener, message] { listener(message); });
  }

 private:
  std::string topic_;
};
template <class Message>
class Subscription {
 public:
  using SharedPtr = std::shared_ptr<Subscription>;
};

class Node {
 public:
  explicit Node(std::string name) : name_(std::move(name)) {}
  virtual ~Node() = default;
  template <class Value>
  Value declare_parameter(const std::string& name, const Value& fallback) {
    return name == "participant" ? Value(parameter<Value>()) : fallback;
  }
  template <class Message>
  typename Publisher<Message>::SharedPtr create_publisher(const std::string& topic, int) {
    return std::make_shared<Publisher<Message>>(expand(topic));
  }
  template <class Message, class Callback>
  typename Subscription<Message>::SharedPtr create_subscription(const std::string& topic, int, Callback callback) {
    listeners<Message>()[expand(topic)].push_back(callback);
    return std::make_shared<Subscription<Message>>();
  }
  Logger get_logger() const { return {}; }

 private:
  template <class Value>
  static Value parameter() {
    if constexpr (std::is_same_v<Value, std::string>)
      return "pilot";
    else
      return {};
  }
  std::string expand(const std::string& topic) const { return topic[0] == '~' ? "/" + name_ + topic.substr(1) : topic; }
  std::string name_;
};

void init(int count, char** arguments);
inline void shutdown() { running = false; }
inline bool ok() { return running; }

namespace executors {

class SingleThreadedExecutor {
 public:
  void add_node(const std::shared_ptr<Node>&) {}
  void spin_some() {
    std::vector<std::function<void()>> now;
    std::swap(now, waiting);
    for (const auto& call : now) call();
  }
  // One call, for which it waits at most `timeout`.
  void spin_once(std::chrono::nanoseconds timeout) {
    if (waiting.empty()) return std::this_thread::sleep_for(timeout);  // nobody else is in this process
    const auto call = waiting.front();
    waiting.erase(waiting.begin());
    call();
  }
};

}  // namespace executors

}  // namespace rclcpp
