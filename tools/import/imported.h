// A model from another tool's file, in unlatch's terms: bodies in W at the file's zero configuration, body axes are
// those of the link, origins at the centres of mass. SI.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <iterator>
#include <map>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "hil/scenario/base/from_eigen.h"
#include "unlatch/geometry.h"

namespace unlatch::tools {

// The file is invalid, or has content that a scenario cannot express; what() says what, where, and the correction.
class ImportError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

struct ImportedBody {
  std::string name;
  int line = 0;  // in the file, from 1; 0: its reader knows no lines
  double mass = 0;
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();  // about the centre of mass, body axes
  Eigen::Vector3d p_WB = Eigen::Vector3d::Zero();     // of the centre of mass
  Eigen::Quaterniond q_WB = Eigen::Quaterniond::Identity();
  std::vector<geometry::Shape> shapes;  // body axes, from the centre of mass
};

struct ImportedJoint {
  enum class Kind { kWeld, kRevolute, kPrismatic, kPlanar, kBall, kUniversal };
  std::string name;
  int line = 0;  // as of a body
  Kind kind = Kind::kWeld;
  int base = -1, follower = 0;  // bodies; -1: the ground
  Eigen::Vector3d p_WJ = Eigen::Vector3d::Zero();
  // z: the axis of a revolute or prismatic joint, the normal of a planar one; x and y: the axes of a universal one.
  Eigen::Matrix3d R_WJ = Eigen::Matrix3d::Identity();
  double stiffness = 0, damping = 0, rest = 0;  // along or about z
};

struct ImportedModel {
  std::string name;
  std::string source;  // "URDF, file arm.urdf"
  double dt = 1e-3;    // s
  Eigen::Vector3d gravity{0, 0, -9.81};
  std::vector<ImportedBody> bodies;
  std::vector<ImportedJoint> joints;
  std::vector<std::string> remarks;  // what was left out or decided
};

inline constexpr std::size_t kMostImported = 4096;  // bodies, joints, shapes

// The readers, which throw ImportError. They and the libraries that they need are the module unlatch-import, whose
// function unlatch_get_import_readers gives this table.
struct ImportReaders {
  ImportedModel (*read_urdf)(const std::string& text, const std::string& path, bool fixed_base);  // the file's text
  ImportedModel (*read_mjcf)(const std::string& path);  // null: this program was built without MuJoCo
};
ImportedModel read_urdf(const std::string& text, const std::string& path, bool fixed_base);
ImportedModel read_mjcf(const std::string& path);

// Vectors and attitudes in the kernel's types, as its shapes have them.
using hil::to_vec3;
inline Quat to_quat(const Eigen::Quaterniond& q) { return {q.w(), q.x(), q.y(), q.z()}; }

// The axis as z of a right-handed frame.
Eigen::Matrix3d build_frame(const Eigen::Vector3d& axis);

struct WrittenScenario {
  std::string text;
  std::map<int, int> lines;  // first line of each body and joint in `text` → its line in the imported file, or 0

  // Line of the imported file that a line of `text` comes from; 0: none, or unknown.
  [[nodiscard]] int find_line(int written) const {
    const auto after = lines.upper_bound(written);
    return after == lines.begin() ? 0 : std::prev(after)->second;
  }

  // One string of both, as it goes from a child process to its parent, and back.
  [[nodiscard]] std::string pack() const;
  static WrittenScenario unpack(const std::string& packed);
};

// A scenario with the remarks as comments at its head. Names are made such as scenarios allow. Throws ImportError for
// numbers that are not finite.
WrittenScenario write_scenario(const ImportedModel& model);

}  // namespace unlatch::tools
