// Results of a finite-element program for a structure: mass points, natural frequencies and shapes, attachment frames;
// and the neutral text file that carries it (MODES.md). Nothing here is computed: flexible_body.h does that.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "hil/language/scenario_error.h"

namespace unlatch::hil {

struct ModalPoint {
  double mass = 0;           // kg, ≥ 0
  Eigen::Vector3d position;  // undeformed, axes and origin of the file, m
  Eigen::Matrix3Xd shape;    // a column per mode: displacement, m per unit of modal coordinate
};

// A frame where joints, elements and sensors attach, or a point that is watched.
struct ModalMarker {
  std::string name;
  Eigen::Vector3d position;   // as above
  Eigen::Matrix3Xd shape;     // displacement
  Eigen::Matrix3Xd rotation;  // small rotation, rad per unit of modal coordinate
};

struct Modes {
  std::string title;
  std::vector<std::string> source;  // where it comes from, a line each
  Eigen::VectorXd frequencies_hz;   // ≥ 0; 0 for rigid-body modes
  std::vector<ModalMarker> markers;
  std::vector<ModalPoint> points;
  Eigen::Index get_count() const { return frequencies_hz.size(); }
};

// Both throw ScenarioError: an unreadable file, or every mistake found up to where reading on made no sense.
Modes read_modes_file(const std::string& path);
Modes read_modes_text(const std::string& text, const std::string& file);
// The shortest text that reads back as the same numbers.
std::string write_modes_text(const Modes& modes);

}  // namespace unlatch::hil
