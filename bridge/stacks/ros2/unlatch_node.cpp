// ROS 2 node: the simulator on ROS topics. Copy this file, participant.{h,c}, unlatch_wire.h and unlatch_frame.h into a
// package (bridge/stacks/ros2.md has its CMakeLists.txt and package.xml), and run it beside a session over plain UDP.
//
//   publishes   /clock              rosgraph_msgs/Clock       simulated time
//               /tf                 tf2_msgs/TFMessage        bodies by their names, in the inertial frame
//               ~/sensors           sensor_msgs/JointState    names and values (position) of the sensors
//   hears       ~/command           sensor_msgs/JointState    channels and their values (position); stamp: that of the
//   State
//
// A State is answered with the command of its stamp, which may be empty; in lockstep the simulator waits for it, and
// after the parameter `patience_ms` the State is answered without.
#include <chrono>
#include <memory>
#include <rclcpp/rclcpp.hpp>
#include <rosgraph_msgs/msg/clock.hpp>
#include <sensor_msgs/msg/joint_state.hpp>
#include <string>
#include <tf2_msgs/msg/tf_message.hpp>

extern "C" {
#include "participant.h"
}

class UnlatchNode : public rclcpp::Node {
 public:
  UnlatchNode() : Node("unlatch") {
    const std::string participant = declare_parameter<std::string>("participant", "fsw");
    const std::string address = declare_parameter<std::string>("address", "127.0.0.1");
    const auto port = declare_parameter<std::int64_t>("port", 7670);
    patience_ = std::chrono::milliseconds(declare_parameter<std::int64_t>("patience_ms", 1000));
    clock_ = create_publisher<rosgraph_msgs::msg::Clock>("/clock", 10);
    tf_ = create_publisher<tf2_msgs::msg::TFMessage>("/tf", 10);
    sensors_ = create_publisher<sensor_msgs::msg::JointState>("~/sensors", 10);
    command_ = create_subscription<sensor_msgs::msg::JointState>(
        "~/command", 10, [this](const sensor_msgs::msg::JointState& message) { take(message); });
    open_ =
        unlatch_participant_open(&sim_, participant.c_str(), address.c_str(), static_cast<std::uint16_t>(port)) == 0;
    if (!open_) RCLCPP_ERROR(get_logger(), "no socket for the simulator at %s", address.c_str());
  }
  ~UnlatchNode() override {
    if (open_) unlatch_participant_close(&sim_);
  }

  // One message of the simulator; false once the session is over.
  bool spin(rclcpp::executors::SingleThreadedExecutor& executor) {
    if (!open_) return false;
    switch (unlatch_participant_poll(&sim_, 100)) {
      case UNLATCH_PARTICIPANT_STATE:
        publish();
        answered_ = false;
        for (const auto until = std::chrono::steady_clock::now() + patience_; !answered_ && rclcpp::ok();) {
          const auto left = until - std::chrono::steady_clock::now();
          if (left <= std::chrono::nanoseconds(0)) break;
          executor.spin_once(left);  // waits for the command without load
        }
        if (!answered_)
          RCLCPP_ERROR(get_logger(), "tick %ld: no command came in time", static_cast<long>(sim_.state.tick));
        answered_ = true;  // what comes now is late
        unlatch_participant_answer(&sim_);
        return true;
      case UNLATCH_PARTICIPANT_REFUSED:
        RCLCPP_ERROR(get_logger(), "refused by the simulator, reason %d", static_cast<int>(sim_.verdict.reason));
        return true;
      case UNLATCH_PARTICIPANT_END:
        RCLCPP_INFO(get_logger(), "the session ended at tick %ld", static_cast<long>(sim_.state.tick));
        return false;
      default:
        executor.spin_some();
        return true;
    }
  }

 private:
  [[nodiscard]] builtin_interfaces::msg::Time get_stamp() const {
    builtin_interfaces::msg::Time stamp;
    stamp.sec = static_cast<std::int32_t>(sim_.state.time_ns / 1'000'000'000);
    stamp.nanosec = static_cast<std::uint32_t>(sim_.state.time_ns % 1'000'000'000);
    return stamp;
  }
  [[nodiscard]] std::string get_name(int kind, int index) const {
    for (int i = 0; i < sim_.item_count; ++i)
      if (sim_.items[i].kind == kind && sim_.items[i].index == index)
        return reinterpret_cast<const char*>(sim_.items[i].name);
    return (kind == UNLATCH_CATALOG_KIND_BODY ? "body" : "item") + std::to_string(index);  // it has not come yet
  }

  void publish() {
    rosgraph_msgs::msg::Clock clock;
    clock.clock = get_stamp();
    clock_->publish(clock);
    tf2_msgs::msg::TFMessage tf;
    for (int i = 0; i < sim_.state.body_count; ++i) {
      const unlatch_wire_body_state& body = sim_.state.bodies[i];
      auto& one = tf.transforms.emplace_back();
      one.header.stamp = clock.clock;
      one.header.frame_id = "inertial";
      one.child_frame_id = get_name(UNLATCH_CATALOG_KIND_BODY, i);
      one.transform.translation.x = body.x;
      one.transform.translation.y = body.y;
      one.transform.translation.z = body.z;
      one.transform.rotation.w = body.qw;
      one.transform.rotation.x = body.qx;
      one.transform.rotation.y = body.qy;
      one.transform.rotation.z = body.qz;
    }
    tf_->publish(tf);
    sensor_msgs::msg::JointState sensors;
    sensors.header.stamp = clock.clock;
    for (int i = 0; i < sim_.state.sensor_count; ++i) {
      sensors.name.push_back(get_name(UNLATCH_CATALOG_KIND_SENSOR, i));
      sensors.position.push_back(sim_.state.sensors[i]);
    }
    sensors_->publish(sensors);
  }

  void take(const sensor_msgs::msg::JointState& message) {
    if (answered_ || !(message.header.stamp == get_stamp())) return;  // of another State
    for (std::size_t i = 0; i < message.name.size() && i < message.position.size(); ++i) {
      const int channel = unlatch_participant_find(&sim_, UNLATCH_CATALOG_KIND_CHANNEL, message.name[i].c_str());
      if (channel < 0 || unlatch_participant_command(&sim_, channel, message.position[i]) != 0)
        RCLCPP_ERROR(get_logger(), "no channel '%s' in this session, or too many commands", message.name[i].c_str());
    }
    answered_ = true;
  }

  unlatch_participant sim_{};
  bool open_ = false, answered_ = true;
  std::chrono::milliseconds patience_{1000};
  rclcpp::Publisher<rosgraph_msgs::msg::Clock>::SharedPtr clock_;
  rclcpp::Publisher<tf2_msgs::msg::TFMessage>::SharedPtr tf_;
  rclcpp::Publisher<sensor_msgs::msg::JointState>::SharedPtr sensors_;
  rclcpp::Subscription<sensor_msgs::msg::JointState>::SharedPtr command_;
};

int main(int count, char** arguments) {
  rclcpp::init(count, arguments);
  const auto node = std::make_shared<UnlatchNode>();
  rclcpp::executors::SingleThreadedExecutor executor;
  executor.add_node(node);
  while (rclcpp::ok() && node->spin(executor)) {
  }
  rclcpp::shutdown();
  return 0;
}
