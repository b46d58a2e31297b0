// Results of a finite-element program for a structure: mass points, natural frequencies and shapes, attachment frames;
// and the neutral text file for them (MODES.md). flexible_body.h computes; this file only reads and writes.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "hil/scenario/yaml/scenario_error.h"

namespace unlatch::hil {

struct ModalPoint {
  double mass = 0;           // kg, ≥ 0
  Eigen::Vector3d position;  // undeformed, axes and origin of the file, m
  Eigen::Matrix3Xd shape;    // a column per mode: displacement, m per unit of modal coordinate
};

// Attachment frame of joints, elements and sensors, or an observed point.
struct ModalMarker {
  std::string name;
  Eigen::Vector3d position;   // undeformed, axes and origin of the file, m
  Eigen::Matrix3Xd shape;     // displacement
  Eigen::Matrix3Xd rotation;  // small rotation, rad per unit of modal coordinate
};

struct Modes {
  std::string title;
  std::vector<std::string> source;  // origin of the data, one line each
  Eigen::VectorXd frequencies_hz;   // ≥ 0; 0 for rigid-body modes
  std::vector<ModalMarker> markers;
  std::vector<ModalPoint> points;
  Eigen::Index get_count() const { return frequencies_hz.size(); }
};

// Both functions throw ScenarioError: an unreadable file, or every mistake up to the place where reading had to stop.
Modes read_modes_file(const std::string& path);
Modes read_modes_text(const std::string& text, const std::string& file);
// Shortest text that reads back as the same numbers.
std::string write_modes_text(const Modes& modes);

}  // namespace unlatch::hil
