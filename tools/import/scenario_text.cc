// Writes an imported model as a scenario.
#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <set>
#include <sstream>

#include "hil/scenario/yaml/yaml_reader.h"
#include "tools/import/imported.h"

namespace unlatch::tools {
namespace {

using Kind = ImportedJoint::Kind;

constexpr std::size_t kNameLength = 40;  // of a scenario's names

// The shortest text that is read back as the same number.
std::string to_text(double value, const std::string& where) {
  if (!std::isfinite(value)) throw ImportError(where + " has a number that is not finite");
  std::array<char, 32> text;
  const auto result = std::to_chars(text.data(), text.data() + text.size(), value == 0 ? 0 : value);
  return {text.data(), result.ptr};
}

// Components that are nothing but the rounding of the others are 0.
Eigen::Vector3d clean(Eigen::Vector3d v) {
  constexpr double kRounding = 1e-12;  // of the largest
  const double largest = v.cwiseAbs().maxCoeff();
  for (double& component : v)
    if (std::abs(component) <= kRounding * largest) component = 0;
  return v;
}

std::string to_text(const Eigen::Vector3d& uncleaned, const std::string& where) {
  const Eigen::Vector3d v = uncleaned.allFinite() ? clean(uncleaned) : uncleaned;
  return "[" + to_text(v.x(), where) + ", " + to_text(v.y(), where) + ", " + to_text(v.z(), where) + "]";
}

std::string to_text(const Vec3& v, const std::string& where) { return to_text(Eigen::Vector3d(v.x, v.y, v.z), where); }

std::string to_text(const Eigen::Quaterniond& q, const std::string& where) {
  return "[" + to_text(q.w(), where) + ", " + to_text(q.x(), where) + ", " + to_text(q.y(), where) + ", " +
         to_text(q.z(), where) + "]";
}

// Names as scenarios have them, each once.
class Names {
 public:
  std::string make(const std::string& name, const std::string& otherwise) {
    std::string made;
    for (const char c : name.substr(0, kNameLength))
      made += std::isalnum(static_cast<unsigned char>(c)) || c == '-' ? c : '_';
    if (made.empty() || !std::isalpha(static_cast<unsigned char>(made[0]))) made = otherwise + made;
    made = made.substr(0, kNameLength);
    if (!hil::is_name(made)) made = otherwise + "_" + made;  // a word such as `on`
    std::string unique = made;
    for (int i = 2; !taken_.insert(unique).second; ++i) {
      const std::string suffix = "_" + std::to_string(i);
      unique = made.substr(0, kNameLength - suffix.size()) + suffix;
    }
    return unique;
  }

 private:
  std::set<std::string> taken_{"ground"};
};

// A comment is one line, whatever the file called its things.
std::string build_comment(const std::string& text) {
  std::string line = "# ";
  for (const char c : text.substr(0, 300)) {
    const auto byte = static_cast<unsigned char>(c);
    line += byte < 0x20 || byte >= 0x7f ? '?' : c;
  }
  return line + "\n";
}

std::string build_shape(const geometry::Shape& shape, const std::string& where) {
  const std::string from = to_text(shape.from, where), to = to_text(shape.to, where);
  const std::string radius = ", radius: " + to_text(shape.radius, where) + "}}";
  switch (shape.kind) {
    case geometry::ShapeKind::kSphere:
      return "{sphere: {centre: " + from + radius;
    case geometry::ShapeKind::kCapsule:
      return "{capsule: {from: " + from + ", to: " + to + radius;
    case geometry::ShapeKind::kCylinder:
      return "{cylinder: {from: " + from + ", to: " + to + radius;
    case geometry::ShapeKind::kCone:
      return "{cone: {from: " + from + ", to: " + to + radius;
    case geometry::ShapeKind::kBox:
      return "{box: {centre: " + from + ", size: " + to_text(shape.size, where) + ", attitude: " +
             to_text(Eigen::Quaterniond(shape.q_BS.w, shape.q_BS.x, shape.q_BS.y, shape.q_BS.z), where) + "}}";
    case geometry::ShapeKind::kHull: {
      std::string points;
      for (const Vec3& point : shape.points) points += (points.empty() ? "" : ", ") + to_text(point, where);
      return "{hull: {points: [" + points + "]}}";
    }
    default:  // importers make no others
      break;
  }
  return "";
}

std::string describe_place(const char* kind, const std::string& name, int line) {
  return (line > 0 ? "line " + std::to_string(line) + ": " : "") + kind + " '" + name + "'";
}

std::string build_body(const ImportedBody& body, const std::string& name) {
  const std::string where = describe_place("body", body.name, body.line);
  const Eigen::Matrix3d I = 0.5 * (body.inertia + body.inertia.transpose());
  std::string text = "  " + name + ":\n    mass: " + to_text(body.mass, where) + " kg\n    inertia: [";
  for (int row = 0; row < 3; ++row) text += (row > 0 ? ", " : "") + to_text(Eigen::Vector3d(I.row(row)), where);
  text += "]  # kg m2, about the centre of mass\n    position: " + to_text(body.p_WB, where) +
          "  # m, of the centre of mass\n    attitude: " + to_text(body.q_WB, where) + "  # w x y z\n";
  if (body.shapes.empty()) return text;
  text += "    shape:\n";
  for (const geometry::Shape& shape : body.shapes) text += "      - " + build_shape(shape, where) + "\n";
  return text;
}

const char* get_mode(Kind kind) {
  switch (kind) {
    case Kind::kWeld:
      return "welded: {kind: weld}";
    case Kind::kRevolute:
      return "hinge: {kind: revolute, axis: z}";
    case Kind::kPrismatic:
      return "slider: {kind: prismatic, axis: z}";
    case Kind::kPlanar:
      return "plane: {kind: planar, axis: z}";
    case Kind::kBall:
      return "ball: {kind: ball}";
    case Kind::kUniversal:
      return "universal: {kind: universal}";
  }
  return "";
}

std::string build_joint(const ImportedModel& model, const ImportedJoint& joint, const std::string& name,
                        const std::vector<std::string>& bodies) {
  const std::string where = describe_place("joint", joint.name, joint.line);
  const auto to_local = [&model](int body, const Eigen::Vector3d& p_W) -> Eigen::Vector3d {
    if (body < 0) return p_W;
    const ImportedBody& at = model.bodies[static_cast<std::size_t>(body)];
    return at.q_WB.inverse() * (p_W - at.p_WB);
  };
  const Eigen::Quaterniond q_WB =
      joint.base < 0 ? Eigen::Quaterniond::Identity() : model.bodies[static_cast<std::size_t>(joint.base)].q_WB;
  const Eigen::Matrix3d R_BJ = q_WB.toRotationMatrix().transpose() * joint.R_WJ;
  const std::string base = joint.base < 0 ? "ground" : bodies[static_cast<std::size_t>(joint.base)];
  // z exactly as it is; x freed of what rounding has left along it, for the loader is strict.
  const Eigen::Vector3d z = clean(R_BJ.col(2)).normalized();
  const Eigen::Vector3d x = (R_BJ.col(0) - R_BJ.col(0).dot(z) * z).normalized();
  return "  " + name + ":\n    between: [" + base + ", " + bodies[static_cast<std::size_t>(joint.follower)] +
         "]\n    point: " + to_text(to_local(joint.base, joint.p_WJ), where) +
         "  # m, from the centre of mass\n    follower_point: " + to_text(to_local(joint.follower, joint.p_WJ), where) +
         "  # m\n    axes: {z: " + to_text(z, where) + ", x: " + to_text(x, where) + "}\n    modes: {" +
         get_mode(joint.kind) + "}\n";
}

std::string build_element(const ImportedJoint& joint, const std::string& name, const std::string& element) {
  const std::string where = describe_place("joint", joint.name, joint.line);
  const bool turns = joint.kind == Kind::kRevolute;
  return "  " + element + ": {type: joint_spring, joint: " + name + ", axis: " + (turns ? "rot_z" : "z") +
         ", stiffness: " + to_text(joint.stiffness, where) + ", damping: " + to_text(joint.damping, where) +
         ", rest: " + to_text(joint.rest, where) + (turns ? "}  # N m/rad, N m s/rad, rad\n" : "}  # N/m, N s/m, m\n");
}

}  // namespace

Eigen::Matrix3d build_frame(const Eigen::Vector3d& axis) {
  const Eigen::Vector3d z = axis.normalized();
  Eigen::Matrix3d R;
  R.col(2) = z;
  R.col(0) = z.unitOrthogonal();
  R.col(1) = z.cross(R.col(0));
  return R;
}

std::string WrittenScenario::pack() const {
  std::string packed = std::to_string(lines.size());
  for (const auto& [written_line, imported_line] : lines)
    packed += " " + std::to_string(written_line) + " " + std::to_string(imported_line);
  return packed + "\n" + text;
}

WrittenScenario WrittenScenario::unpack(const std::string& packed) {
  WrittenScenario written;
  std::istringstream head(packed);
  std::size_t count = 0;
  head >> count;
  for (int written_line, imported_line; count > 0 && head >> written_line >> imported_line; --count)
    written.lines.emplace(written_line, imported_line);
  written.text = packed.substr(packed.find('\n') + 1);
  return written;
}

WrittenScenario write_scenario(const ImportedModel& model) {
  if (model.bodies.empty()) throw ImportError("it has no body with mass that can move");
  WrittenScenario written;
  std::string& text = written.text;
  const auto mark = [&](int line) {
    written.lines.emplace(1 + static_cast<int>(std::count(text.begin(), text.end(), '\n')), line);
  };
  text = build_comment("Imported by `unlatch import` from " + model.source +
                                   ". A starting point: read what was left out.");
  for (const std::string& remark : model.remarks) text += build_comment("- " + remark);
  text += "unlatch: 1\nname: " + Names().make(model.name, "model") + "\nstep: {dt: " + to_text(model.dt, "the step") +
          " s, until: " + to_text(std::ceil(10 / model.dt) * model.dt, "the step") +
          " s}\ngravity: {uniform: " + to_text(model.gravity, "gravity") + "}  # m/s2\n\nbodies:\n";
  Names body_names, joint_names, element_names;
  std::vector<std::string> bodies;
  for (const ImportedBody& body : model.bodies) {
    bodies.push_back(body_names.make(body.name, "body"));
    mark(body.line);
    text += build_body(body, bodies.back());
  }
  std::string elements;
  if (!model.joints.empty()) text += "\njoints:\n";
  for (const ImportedJoint& joint : model.joints) {
    const std::string name = joint_names.make(joint.name, "joint");
    mark(joint.line);
    text += build_joint(model, joint, name, bodies);
    if (joint.stiffness != 0 || joint.damping != 0)
      elements += build_element(joint, name, element_names.make(name, "spring"));
  }
  mark(0);
  if (!elements.empty()) text += "\nelements:\n" + elements;
  return written;
}

}  // namespace unlatch::tools
