// Beside bridge/stacks/ros2/unlatch_node.cpp: a controller on ROS topics that flies bridge/examples/probe.yaml like the
// pilot: throttle open at 0.1 s, shut at 0.3 s. Exit code 1 if something was not as it should be.
#include <cmath>
#include <cstdlib>
#include <rclcpp/rclcpp.hpp>
#include <rosgraph_msgs/msg/clock.hpp>
#include <sensor_msgs/msg/joint_state.hpp>
#include <tf2_msgs/msg/tf_message.hpp>

namespace {

int states = 0;
double clock_s = -1;

void control(const sensor_msgs::msg::JointState& sensors) {
  ++states;
  const rclcpp::Publisher<sensor_msgs::msg::JointState> command("/unlatch/command");
  sensor_msgs::msg::JointState answer;
  answer.header.stamp = sensors.header.stamp;
  if (sensors.name != std::vector<std::string>{"gyro.x", "gyro.y", "gyro.z"}) ++rclcpp::errors;
  const std::int64_t ms = std::int64_t{sensors.header.stamp.sec} * 1000 + sensors.header.stamp.nanosec / 1'000'000;
  if (ms == 100 || ms == 300) {
    answer.name = {"throttle"};
    answer.position = {ms == 100 ? 1.0 : 0.0};
  }
  auto late = answer;  // of another State: not taken
  late.header.stamp.nanosec += 1;
  late.name = {"throttle"};
  late.position = {0.5};
  rclcpp::Publisher<sensor_msgs::msg::JointState>(command).publish(late);
  rclcpp::Publisher<sensor_msgs::msg::JointState>(command).publish(answer);
}

void check() {
  if (rclcpp::errors > 0 || states < 500 || std::abs(clock_s - 0.5) > 0.0015) std::_Exit(1);
}

}  // namespace

void rclcpp::init(int, char**) {
  listeners<sensor_msgs::msg::JointState>()["/unlatch/sensors"].push_back(control);
  listeners<rosgraph_msgs::msg::Clock>()["/clock"].push_back(
      [](const rosgraph_msgs::msg::Clock& message) { clock_s = message.clock.sec + 1e-9 * message.clock.nanosec; });
  listeners<tf2_msgs::msg::TFMessage>()["/tf"].push_back([](const tf2_msgs::msg::TFMessage& message) {
    if (message.transforms.size() != 1 || message.transforms[0].header.frame_id != "inertial" ||
        message.transforms[0].child_frame_id != "probe")
      ++errors;
  });
  std::atexit(check);
}
