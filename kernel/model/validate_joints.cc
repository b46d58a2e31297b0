// Joints: legal frames and modes, and an initial state in which the rows of the initial mode hold.
#include <Eigen/Geometry>
#include <algorithm>

#include "kernel/model/validate.h"

namespace unlatch {
namespace {

constexpr double kOrthonormal = 1e-9;  // of axes that were given as a frame
constexpr double kClosed = 1e-6;       // m, rad: smaller gaps are closed by the first projection
constexpr double kAtRest = 1e-6;       // m/s, rad/s: the same of velocities

// Motion of a body at the start; the ground rests.
struct Motion {
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  Eigen::Vector3d p = Eigen::Vector3d::Zero(), v = Eigen::Vector3d::Zero(), w = Eigen::Vector3d::Zero();  // in W
};

Motion get_motion(const Model& model, int body) {
  Motion m;
  if (body == kGround) return m;
  const Body& b = model.bodies[static_cast<std::size_t>(body)];
  m.R = b.q_WB.normalized().toRotationMatrix();
  m.p = b.p_WB;
  m.v = b.v_WB;
  m.w = m.R * b.w_WB_B;
  return m;
}

bool is_finite(const Motion& m) { return m.R.allFinite() && m.p.allFinite() && m.v.allFinite() && m.w.allFinite(); }

bool is_right_handed(const Eigen::Matrix3d& m) {
  return m.allFinite() && (m.transpose() * m - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() < kOrthonormal &&
         m.determinant() > 0;
}

std::string list_gaps(const Eigen::Vector3d& gap, RowSet rows, int first, double tolerance, const std::string& unit) {
  std::string text;
  for (int k = 0; k < 3; ++k)
    if (has_row(rows, first + k) && !(std::abs(gap[k]) < tolerance))
      text += (text.empty() ? "" : ", ") + show(gap[k]) + " " + unit + " along " + kRowNames[first + k];
  return text;
}

// The part of a vector, given along x, y, z of `axes`, that these rows forbid; in the axes' outer frame.
Eigen::Vector3d restrict_to(RowSet rows, int first, const Eigen::Matrix3d& axes, const Eigen::Vector3d& along) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (int k = 0; k < 3; ++k)
    if (has_row(rows, first + k)) sum += axes.col(k) * along[k];
  return sum;
}

// Rows of a joint at the start, as kernel/joints/residuals.cc has them.
struct InitialRows {
  RowSet rows;
  Motion base, follower;
  Eigen::Matrix3d n, m, m_follower;    // joint frame, rotation frame, the latter carried by the follower; in W
  Eigen::Vector3d r_base, r_follower;  // from each body's origin to the follower's point, in W
};

InitialRows calc_initial_rows(const Model& model, const Joint& joint) {
  InitialRows s;
  s.rows = joint.modes[static_cast<std::size_t>(joint.mode)].rows;
  s.base = get_motion(model, joint.base);
  s.follower = get_motion(model, joint.follower);
  s.n = s.base.R * joint.axes;
  s.m = s.base.R * joint.rotation_axes.value_or(joint.axes);
  s.m_follower = joint.follower_axes ? Eigen::Matrix3d(s.follower.R * *joint.follower_axes) : s.m;
  s.r_follower = s.follower.R * joint.point_follower;
  s.r_base = s.follower.p + s.r_follower - s.base.p;
  if (joint.universal && (s.rows & kRotationRows) == row_bit(kRotZ))
    s.m.col(2) = s.m.col(0).cross(s.m_follower.col(1)).normalized();
  return s;
}

void check_position(const std::string& where, const Joint& joint, const Model& model, const InitialRows& s,
                    ModelErrors& errors) {
  const Eigen::Vector3d gap = s.n.transpose() * (s.r_base - s.base.R * joint.point_base);
  const std::string gaps = list_gaps(gap, s.rows, kX, kClosed, "m");
  if (gaps.empty()) return;
  const Eigen::Vector3d move = -restrict_to(s.rows, kX, s.n, gap);
  errors.push_back({where, "its points are apart at the start: " + gaps,
                    "move body '" + model.bodies[static_cast<std::size_t>(joint.follower)].name + "' by " + show(move) +
                        " m in the inertial frame, or correct the points",
                    "point"});
}

// With follower_axes given, the rotation frames may disagree at the start.
void check_orientation(const std::string& where, const Joint& joint, const InitialRows& s, ModelErrors& errors) {
  const RowSet rotation = s.rows & kRotationRows;
  Eigen::Vector3d gap = Eigen::Vector3d::Zero();
  const bool crossed = joint.universal && rotation == row_bit(kRotZ);
  if (crossed) {
    const double cosine = s.m.col(0).dot(s.m_follower.col(1));
    if (!(std::abs(cosine) < 1 - 1e-6))
      return errors.push_back(
          {where, "its two axes of turning coincide", "x of the base and y of the follower cross", "axes"});
    gap[2] = -cosine;
  } else if (rotation == kRotationRows) {
    const Eigen::AngleAxisd turn(Eigen::Matrix3d(s.m.transpose() * s.m_follower));
    gap = turn.angle() * turn.axis();
  } else {
    for (int a = 0; a < 3; ++a)
      if (rotation == (kRotationRows & static_cast<RowSet>(~row_bit(kRotX + a))))
        gap = s.m.transpose() * s.m.col(a).cross(s.m_follower.col(a));
  }
  const std::string gaps = list_gaps(gap, s.rows, kRotX, kClosed, "rad");
  if (!gaps.empty())
    errors.push_back({where, "its frames are turned against each other at the start: " + gaps,
                      "correct the attitudes, or leave follower_axes out: the frames then agree at the start",
                      "follower_axes"});
}

void check_velocity(const std::string& where, const Joint& joint, const Model& model, const InitialRows& s,
                    ModelErrors& errors) {
  const Eigen::Vector3d w_rel = s.follower.w - s.base.w;
  const Eigen::Vector3d v_base = s.base.v + s.base.w.cross(s.r_base);
  const Eigen::Vector3d slip = s.n.transpose() * (s.follower.v + s.follower.w.cross(s.r_follower) - v_base);
  const Eigen::Vector3d turn = s.m.transpose() * w_rel;
  std::string gaps = list_gaps(slip, s.rows, kX, kAtRest, "m/s");
  const std::string turns = list_gaps(turn, s.rows, kRotX, kAtRest, "rad/s");
  gaps += (gaps.empty() || turns.empty() ? "" : ", ") + turns;
  if (gaps.empty()) return;
  // The nearest motion that the rows allow: first the rotation, then the point.
  const Eigen::Vector3d w = s.follower.w - restrict_to(s.rows, kRotX, s.m, turn);
  const Eigen::Vector3d slip_then = s.n.transpose() * (s.follower.v + w.cross(s.r_follower) - v_base);
  const Eigen::Vector3d v = s.follower.v - restrict_to(s.rows, kX, s.n, slip_then);
  errors.push_back({where, "its bodies move apart at the start: " + gaps,
                    "give matching velocities: body '" + model.bodies[static_cast<std::size_t>(joint.follower)].name +
                        "' with velocity " + show(v) + " m/s (inertial) and rate " +
                        show(Eigen::Vector3d(s.follower.R.transpose() * w)) + " rad/s (body axes)",
                    "between"});
}

// Frames and modes of one joint. True: they are legal, so that the initial state can be looked at.
bool check_joint(const Model& model, const std::string& where, const Joint& joint, ModelErrors& errors) {
  const std::size_t before = errors.size();
  const auto report = [&](const std::string& what, const std::string& mend, const std::string& key) {
    errors.push_back({where, what, mend, key});
  };
  if (joint.base != kGround && !is_index(joint.base, model.bodies.size()))
    report("its base is no body", "a body's index, or kGround", "between");
  if (!is_index(joint.follower, model.bodies.size()))
    report("its follower is no body", "a body's index", "between");
  else if (joint.base == joint.follower)
    report("it connects a body with itself", "name two bodies", "between");
  if (!joint.point_base.allFinite()) report("point is not finite", "give a finite value", "point");
  if (!joint.point_follower.allFinite())
    report("follower_point is not finite", "give a finite value", "follower_point");
  const std::string frame = "unit axes, perpendicular to 1e-9, right-handed";
  if (!is_right_handed(joint.axes)) report("axes is not a frame", frame, "axes");
  if (joint.rotation_axes && !is_right_handed(*joint.rotation_axes))
    report("rotation_axes is not a frame", frame, "rotation_axes");
  if (joint.follower_axes && !is_right_handed(*joint.follower_axes))
    report("follower_axes is not a frame", frame, "follower_axes");
  if (!(joint.share > 0) || !std::isfinite(joint.share))
    report("share is " + show(joint.share), "a stiffness beside that of other joints, greater than 0", "share");
  if (joint.share_length && (!(*joint.share_length > 0) || !std::isfinite(*joint.share_length)))
    report("share_length is " + show(*joint.share_length) + " m", "a length greater than 0", "share_length");
  if (joint.modes.empty()) report("it has no modes", "give at least one, such as {rows: [x, y, z]}", "modes");
  for (std::size_t i = 0; i < joint.modes.size(); ++i) {
    const JointMode& mode = joint.modes[i];
    if (mode.name.empty()) report("a mode has no name", "give it one", "modes");
    if ((mode.rows & ~(kPointRows | kRotationRows)) != 0)
      report("mode '" + mode.name + "' has rows that do not exist", "rows x … rot_z", "modes");
    for (std::size_t k = 0; k < i; ++k)
      if (joint.modes[k].name == mode.name)
        report("two modes are called '" + mode.name + "'", "give each its own name", "modes");
  }
  if (!joint.modes.empty() && !is_index(joint.mode, joint.modes.size()))
    report("its initial mode does not exist", "the index of one of its modes", "mode");
  return errors.size() == before;
}

}  // namespace

void validate_joints(const Model& model, ModelErrors& errors) {
  for (const Joint& joint : model.joints) {
    const std::string where = quoted("joint", joint.name);
    if (!check_joint(model, where, joint, errors)) continue;
    const InitialRows initial = calc_initial_rows(model, joint);
    if (!is_finite(initial.base) || !is_finite(initial.follower)) continue;  // reported with the body
    check_position(where, joint, model, initial, errors);
    check_orientation(where, joint, initial, errors);
    check_velocity(where, joint, model, initial, errors);
  }
}

}  // namespace unlatch
