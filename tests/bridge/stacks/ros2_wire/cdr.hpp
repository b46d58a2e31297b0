// Messages of ROS 2 as CDR, field by field in the order of their published .msg files, written with Fast CDR: what a
// ROS installation generates from these files.
#pragma once

#include <fastcdr/Cdr.h>

#include "messages.hpp"

namespace ros2_wire {

using eprosima::fastcdr::Cdr;

// One function per type for both directions: Cdr's operators are `<<` to write and `>>` to read.
struct Writer {
  Cdr& cdr;
  template <class Value>
  void operator()(const Value& value) {
    cdr << value;
  }
  template <class Value, class Each>
  void each(std::vector<Value>& values, const Each& visit_one) {
    cdr << static_cast<std::uint32_t>(values.size());
    for (Value& value : values) visit_one(*this, value);
  }
};
struct Reader {
  Cdr& cdr;
  template <class Value>
  void operator()(Value& value) {
    cdr >> value;
  }
  template <class Value, class Each>
  void each(std::vector<Value>& values, const Each& visit_one) {
    std::uint32_t count = 0;
    cdr >> count;
    values.clear();
    // No memory for a count that is larger than the message: reading past its end throws.
    for (std::uint32_t i = 0; i < count; ++i) visit_one(*this, values.emplace_back());
  }
};

template <class Direction>
void visit(Direction& field, builtin_interfaces::msg::Time& time) {
  field(time.sec);
  field(time.nanosec);
}
template <class Direction>
void visit(Direction& field, std_msgs::msg::Header& header) {
  visit(field, header.stamp);
  field(header.frame_id);
}
template <class Direction>
void visit(Direction& field, geometry_msgs::msg::TransformStamped& stamped) {
  visit(field, stamped.header);
  field(stamped.child_frame_id);
  geometry_msgs::msg::Vector3& p = stamped.transform.translation;
  geometry_msgs::msg::Quaternion& q = stamped.transform.rotation;
  for (double* number : {&p.x, &p.y, &p.z, &q.x, &q.y, &q.z, &q.w}) field(*number);
}
template <class Direction>
void visit(Direction& field, rosgraph_msgs::msg::Clock& clock) {
  visit(field, clock.clock);
}
template <class Direction>
void visit(Direction& field, sensor_msgs::msg::JointState& joints) {
  visit(field, joints.header);
  field(joints.name);
  field(joints.position);
  field(joints.velocity);
  field(joints.effort);
}
template <class Direction>
void visit(Direction& field, tf2_msgs::msg::TFMessage& tf) {
  field.each(tf.transforms, [](Direction& one, geometry_msgs::msg::TransformStamped& stamped) { visit(one, stamped); });
}

// The names of the types on the wire: rmw_fastrtps' and rmw_cyclonedds' PACKAGE::msg::dds_::TYPE_.
template <class Message>
inline constexpr const char* kTypeName = nullptr;
template <>
inline constexpr const char* kTypeName<rosgraph_msgs::msg::Clock> = "rosgraph_msgs::msg::dds_::Clock_";
template <>
inline constexpr const char* kTypeName<sensor_msgs::msg::JointState> = "sensor_msgs::msg::dds_::JointState_";
template <>
inline constexpr const char* kTypeName<tf2_msgs::msg::TFMessage> = "tf2_msgs::msg::dds_::TFMessage_";

}  // namespace ros2_wire
