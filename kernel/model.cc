#include "kernel/model.h"

namespace unlatch {

const char* const kRowNames[kRows] = {"x", "y", "z", "rot_x", "rot_y", "rot_z"};

int sensor_width(Sensor::Kind kind) {
  switch (kind) {
    case Sensor::Kind::kAttitude:
      return 4;
    case Sensor::Kind::kReaction:
      return kRows;
    case Sensor::Kind::kPosition:
    case Sensor::Kind::kVelocity:
    case Sensor::Kind::kRate:
    case Sensor::Kind::kAcceleration:
    case Sensor::Kind::kSpecificForce:
      return 3;
    case Sensor::Kind::kContact:
    case Sensor::Kind::kDisplacement:
    case Sensor::Kind::kAngle:
    case Sensor::Kind::kSpeed:
      return 1;
  }
  return 0;
}

// Of a reaction and a speed: depends on the row, so both units are named.
const char* sensor_unit(Sensor::Kind kind) {
  switch (kind) {
    case Sensor::Kind::kPosition:
    case Sensor::Kind::kDisplacement:
      return "m";
    case Sensor::Kind::kVelocity:
      return "m/s";
    case Sensor::Kind::kRate:
      return "rad/s";
    case Sensor::Kind::kAcceleration:
    case Sensor::Kind::kSpecificForce:
      return "m/s2";
    case Sensor::Kind::kAttitude:
    case Sensor::Kind::kContact:
      return "1";
    case Sensor::Kind::kReaction:
      return "N, N m";
    case Sensor::Kind::kAngle:
      return "rad";
    case Sensor::Kind::kSpeed:
      return "m/s, rad/s";
  }
  return "";
}

int Model::element_count() const {
  return static_cast<int>(loads.size() + point_springs.size() + joint_springs.size() + plane_torsions.size());
}

const std::string& Model::element_name(int element) const {
  auto index = static_cast<std::size_t>(element);
  if (index < loads.size()) return loads[index].name;
  index -= loads.size();
  if (index < point_springs.size()) return point_springs[index].name;
  index -= point_springs.size();
  if (index < joint_springs.size()) return joint_springs[index].name;
  return plane_torsions.at(index - joint_springs.size()).name;
}

}  // namespace unlatch
