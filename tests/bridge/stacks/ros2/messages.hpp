// Stand-ins for messages of ROS 2: their published fields, as far as unlatch_node.cpp uses them.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace builtin_interfaces::msg {
struct Time {
  std::int32_t sec = 0;
  std::uint32_t nanosec = 0;
  bool operator==(const Time& other) const { return sec == other.sec && nanosec == other.nanosec; }
};
}  // namespace builtin_interfaces::msg
namespace std_msgs::msg {
struct Header {
  builtin_interfaces::msg::Time stamp;
  std::string frame_id;
};
}  // namespace std_msgs::msg
namespace geometry_msgs::msg {
struct Vector3 {
  double x = 0, y = 0, z = 0;
};
struct Quaternion {
  double x = 0, y = 0, z = 0, w = 1;
};
struct Transform {
  Vector3 translation;
  Quaternion rotation;
};
struct TransformStamped {
  std_msgs::msg::Header header;
  std::string child_frame_id;
  Transform transform;
};
}  // namespace geometry_msgs::msg
namespace rosgraph_msgs::msg {
struct Clock {
  builtin_interfaces::msg::Time clock;
};
}  // namespace rosgraph_msgs::msg
namespace sensor_msgs::msg {
struct JointState {
  std_msgs::msg::Header header;
  std::vector<std::string> name;
  std::vector<double> position, velocity, effort;
};
}  // namespace sensor_msgs::msg
namespace tf2_msgs::msg {
struct TFMessage {
  std::vector<geometry_msgs::msg::TransformStamped> transforms;
};
}  // namespace tf2_msgs::msg
