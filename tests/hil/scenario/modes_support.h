// Structures with known modes, for facts about modes files and flexible bodies.
#pragma once

#include <Eigen/Dense>
#include <numbers>

#include "hil/scenario/flexible/modes_file.h"
#include "tests/support/lumped_flexible.h"

namespace unlatch::test {

// Lattice mast of lumped_flexible.h in the form of a modes file, moved off the origin; a marker at each end, whose
// rotation is that of the fit to the four points.
inline hil::Modes build_mast_modes(int bays, int count, Support support) {
  const ModalBody mast = build_lattice_mast(bays, count, support);
  hil::Modes modes;
  modes.title = "A mast";
  modes.source = {"tests/support/lumped_flexible.h"};
  modes.frequencies_hz = mast.frequencies / (2 * std::numbers::pi);
  const Eigen::Vector3d offset(1.5, -2, 0.25);
  for (std::size_t i = 0; i < mast.masses.size(); ++i)
    modes.points.push_back({mast.masses[i], mast.positions[i] + offset, mast.shapes[i]});
  for (const std::size_t end : {std::size_t{0}, mast.masses.size() - 4}) {
    hil::ModalMarker marker;
    marker.name = end == 0 ? "root" : "tip";
    marker.position = Eigen::Vector3d::Zero();
    marker.shape = Eigen::Matrix3Xd::Zero(3, count);
    for (std::size_t i = end; i < end + 4; ++i) {
      marker.position += modes.points[i].position / 4;
      marker.shape += modes.points[i].shape / 4;
    }
    marker.rotation = 0.1 * marker.shape;  // any rotation: it is treated in the same way
    modes.markers.push_back(marker);
  }
  return modes;
}

}  // namespace unlatch::test
