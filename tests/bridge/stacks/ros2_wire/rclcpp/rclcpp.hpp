// The interface of rclcpp that unlatch_node.cpp uses, by its published interface (ROS 2 Humble, Apache-2.0), over
// eProsima's Fast DDS 2.9, which is the middleware of Humble: topics, types and qualities of service are on the wire as
// rmw_fastrtps has them (rt/NAME; PACKAGE::msg::dds_::TYPE_; reliable, volatile, the last 10), on the loopback
// interface alone, as with ROS_LOCALHOST_ONLY=1. No code of ROS.
#pragma once

#include <fastdds/rtps/transport/UDPv4TransportDescriptor.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/DataWriterListener.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/DataReaderListener.hpp>
#include <fastdds/dds/subscriber/SampleInfo.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <fastdds/dds/topic/Topic.hpp>
#include <functional>
#include <memory>
#include <stdexcept>
#include <string>
#include <thread>
#include <type_traits>
#include <utility>
#include <vector>

#include "message_type.hpp"

namespace rclcpp {

namespace dds = eprosima::fastdds::dds;

struct Logger {};
#define RCLCPP_ERROR(logger, ...) ((void)(logger), ++rclcpp::errors, std::printf(__VA_ARGS__), std::printf("\n"))
#define RCLCPP_INFO(logger, ...) ((void)(logger), std::printf(__VA_ARGS__), std::printf("\n"))

inline int errors = 0;
inline bool running = true;

// Reports the first counterpart on the wire on standard output.
class Matches : public dds::DataReaderListener, public dds::DataWriterListener {
 public:
  explicit Matches(std::string topic) : topic_(std::move(topic)) {}
  void on_subscription_matched(dds::DataReader*, const dds::SubscriptionMatchedStatus& status) override {
    report(status.current_count);
  }
  void on_publication_matched(dds::DataWriter*, const dds::PublicationMatchedStatus& status) override {
    report(status.current_count);
  }

 private:
  void report(int count) {
    if (count > 0) std::printf("%s is matched\n", topic_.c_str());
    std::fflush(stdout);
  }
  std::string topic_;
};

template <class Message>
class Publisher {
 public:
  using SharedPtr = std::shared_ptr<Publisher>;
  explicit Publisher(dds::DataWriter* writer) : writer_(writer) {}
  void publish(Message message) { writer_->write(&message); }

 private:
  dds::DataWriter* writer_;
};
template <class Message>
class Subscription {
 public:
  using SharedPtr = std::shared_ptr<Subscription>;
};

class Node {
 public:
  explicit Node(std::string name) : name_(std::move(name)) {
    dds::DomainParticipantQos qos = dds::PARTICIPANT_QOS_DEFAULT;
    qos.name("/" + name_);
    qos.transport().use_builtin_transports = false;
    const auto udp = std::make_shared<eprosima::fastdds::rtps::UDPv4TransportDescriptor>();
    udp->interfaceWhiteList.emplace_back("127.0.0.1");
    qos.transport().user_transports.push_back(udp);
    participant_ = dds::DomainParticipantFactory::get_instance()->create_participant(0, qos);
    if (participant_ == nullptr) throw std::runtime_error("Fast DDS opens no participant");
    publisher_ = participant_->create_publisher(dds::PUBLISHER_QOS_DEFAULT);
    subscriber_ = participant_->create_subscriber(dds::SUBSCRIBER_QOS_DEFAULT);
  }
  virtual ~Node() {
    participant_->delete_contained_entities();
    dds::DomainParticipantFactory::get_instance()->delete_participant(participant_);
  }
  Node(const Node&) = delete;
  Node& operator=(const Node&) = delete;

  // As of `--ros-args -p participant:=pilot -p patience_ms:=30000`: a stalled machine is no dead controller.
  template <class Value>
  Value declare_parameter(const std::string& name, const Value& fallback) {
    if constexpr (std::is_same_v<Value, std::string>)
      return name == "participant" ? "pilot" : fallback;
    else
      return name == "patience_ms" ? Value{30'000} : fallback;
  }

  template <class Message>
  typename Publisher<Message>::SharedPtr create_publisher(const std::string& name, int depth) {
    return std::make_shared<Publisher<Message>>(publisher_->create_datawriter(
        open_topic<Message>(name), set(dds::DATAWRITER_QOS_DEFAULT, depth), listen(name)));
  }

  template <class Message, class Callback>
  typename Subscription<Message>::SharedPtr create_subscription(const std::string& name, int depth, Callback callback) {
    dds::DataReader* reader = subscriber_->create_datareader(open_topic<Message>(name),
                                                             set(dds::DATAREADER_QOS_DEFAULT, depth), listen(name));
    takers_.push_back([reader, callback] {
      Message message;
      dds::SampleInfo info;
      while (reader->take_next_sample(&message, &info) == ReturnCode_t::RETCODE_OK)
        if (info.valid_data) callback(message);
    });
    return std::make_shared<Subscription<Message>>();
  }

  Logger get_logger() const { return {}; }

  void take_all() {
    for (const auto& take : takers_) take();
  }

 private:
  template <class Message>
  dds::Topic* open_topic(const std::string& name) {
    const dds::TypeSupport type(new ros2_wire::MessageType<Message>);
    type.register_type(participant_);
    return participant_->create_topic("rt" + expand(name), type.get_type_name(), dds::TOPIC_QOS_DEFAULT);
  }
  Matches* listen(const std::string& name) {
    return matches_.emplace_back(std::make_unique<Matches>(expand(name))).get();
  }
  template <class Qos>
  static Qos set(Qos qos, int depth) {
    qos.reliability().kind = dds::RELIABLE_RELIABILITY_QOS;
    qos.durability().kind = dds::VOLATILE_DURABILITY_QOS;
    qos.history().kind = dds::KEEP_LAST_HISTORY_QOS;
    qos.history().depth = depth;
    qos.endpoint().history_memory_policy = eprosima::fastrtps::rtps::PREALLOCATED_WITH_REALLOC_MEMORY_MODE;
    qos.data_sharing().off();
    return qos;
  }
  std::string expand(const std::string& topic) const { return topic[0] == '~' ? "/" + name_ + topic.substr(1) : topic; }

  std::string name_;
  dds::DomainParticipant* participant_ = nullptr;
  dds::Publisher* publisher_ = nullptr;
  dds::Subscriber* subscriber_ = nullptr;
  std::vector<std::function<void()>> takers_;
  std::vector<std::unique_ptr<Matches>> matches_;
};

inline void init(int, char**) {}
inline bool ok() { return running; }
// The node itself ends with 0 whatever it has reported.
inline void shutdown() {
  running = false;
  if (errors > 0) std::exit(1);
}

namespace executors {

class SingleThreadedExecutor {
 public:
  void add_node(const std::shared_ptr<Node>& node) { node_ = node; }
  void spin_some() { node_->take_all(); }
  void spin_once(std::chrono::nanoseconds timeout) {
    node_->take_all();
    std::this_thread::sleep_for(std::min<std::chrono::nanoseconds>(timeout, std::chrono::microseconds(20)));
  }

 private:
  std::shared_ptr<Node> node_;
};

}  // namespace executors

}  // namespace rclcpp
