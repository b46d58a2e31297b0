#include "bench/panel_array.h"

#include <string>

#include "tests/support/small_models.h"

namespace unlatch::bench {
namespace {

constexpr double kFold = 1.4;                         // rad, angle of the panels to either side at the start
constexpr double kDrive = 0.6, kFriction = 0.3;       // N m/rad, N m s/rad
constexpr double kLatch = 900, kLatchDamping = 6;     // N m/rad, N m s/rad
constexpr double kLength = 1, kHalf = 0.5 * kLength;  // m, of a panel

JointSpring build_spring(const std::string& name, int hinge, double stiffness, double damping, bool on) {
  JointSpring spring;
  spring.name = name;
  spring.joint = hinge;
  spring.stiffness = stiffness;
  spring.damping = damping;
  spring.on = on;
  return spring;
}

}  // namespace

Model build_panel_array(int panels) {
  Model model;
  model.name = "array" + std::to_string(panels);
  model.bodies.push_back(test::box("bus", 800, 300, 320, 280));
  Eigen::Vector3d edge(1, 0, 0);  // position of the next hinge
  for (int k = 0; k < panels; ++k) {
    const std::string id = std::to_string(k + 1);
    const Eigen::Quaterniond turn(Eigen::AngleAxisd(k % 2 == 0 ? kFold : -kFold, Eigen::Vector3d::UnitZ()));
    Body panel = test::box("panel" + id, 8, 2.7, 0.67, 3.3);
    panel.q_WB = turn;
    panel.p_WB = edge + turn * Eigen::Vector3d(kHalf, 0, 0);
    edge += turn * Eigen::Vector3d(kLength, 0, 0);
    model.bodies.push_back(panel);

    Joint hinge;
    hinge.name = "hinge" + id;
    hinge.base = k;
    hinge.follower = k + 1;
    hinge.point_base = {k == 0 ? 1 : kHalf, 0, 0};
    hinge.point_follower = {-kHalf, 0, 0};
    hinge.follower_axes = Eigen::Matrix3d::Identity();
    hinge.modes = {{"hinge", test::kRevoluteRows}};
    model.joints.push_back(hinge);
    model.joint_springs.push_back(build_spring("drive" + id, k, kDrive, kFriction, true));
    model.joint_springs.push_back(build_spring("latch" + id, k, kLatch, kLatchDamping, false));

    Event event;
    event.name = "latch";
    event.subject = "hinge" + id;
    event.when = test::when(Condition::Kind::kAngle, k, kRotZ, 0);
    event.when.below = k % 2 == 0;  // these unfold downwards
    Action close;
    close.kind = Action::Kind::kSwitch;
    close.subject = 2 * k + 1;
    close.value = 1;
    event.then = {close};
    model.events.push_back(event);
  }
  return model;
}

}  // namespace unlatch::bench
