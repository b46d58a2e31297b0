// The oracle's lattice mast in the form of the kernel: a flexible body with its invariants, and markers at its
// particles.
#pragma once

#include <string>

#include "tests/support/lumped_flexible.h"
#include "unlatch/model.h"

namespace unlatch::test {

inline Body build_flexible_body(const std::string& name, const ModalBody& lumped) {
  Body body;
  body.name = name;
  FlexibleBody shape;
  const Eigen::Index m = lumped.get_modes();
  shape.frequencies = lumped.frequencies;
  shape.damping = lumped.damping.cwiseQuotient(2 * lumped.frequencies);
  shape.momentum = Eigen::Matrix3Xd::Zero(3, m);
  shape.first.assign(static_cast<std::size_t>(m), Eigen::Matrix3d::Zero());
  shape.second.assign(static_cast<std::size_t>(m * m), Eigen::Matrix3d::Zero());
  for (std::size_t i = 0; i < lumped.masses.size(); ++i) {
    const double mass = lumped.masses[i];
    const Eigen::Vector3d& r = lumped.positions[i];
    const Eigen::Matrix3Xd& phi = lumped.shapes[i];
    body.mass += mass;
    body.inertia += mass * (r.squaredNorm() * Eigen::Matrix3d::Identity() - r * r.transpose());
    shape.momentum += mass * phi;
    for (Eigen::Index k = 0; k < m; ++k) {
      shape.first[static_cast<std::size_t>(k)] += mass * r * phi.col(k).transpose();
      for (Eigen::Index l = 0; l < m; ++l)
        shape.second[static_cast<std::size_t>(k * m + l)] += mass * phi.col(k) * phi.col(l).transpose();
    }
  }
  body.flexible = shape;
  return body;
}

// Builds a marker at a particle; `turn`: rotation of the marker's axes per modal coordinate, which a particle does not
// have.
inline Body build_marker(const std::string& name, int body, const ModalBody& lumped, std::size_t particle,
                         const Eigen::Matrix3Xd& turn) {
  Body out;
  out.name = name;
  out.marker = Marker{body, lumped.positions[particle], lumped.shapes[particle], turn};
  return out;
}

}  // namespace unlatch::test
