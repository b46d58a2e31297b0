// A flexible body from the results of a finite-element program (modes_file.h): a floating frame at the undeformed
// centre of mass, modal coordinates, and the inertia invariants that the motion needs.
//
// A mass point at r moves by u = Φ η relative to a frame that moves as a rigid body. The modes of a file are
// orthonormal and free of momentum only within the accuracy of lumped masses and printed digits. So rigid motion is
// projected out of the shapes, Φ ← Φ − t − ρ × r, which costs no strain energy. With the stiffness diag(ω²) of the
// original modes, each scaled to modal mass 1, the small eigenproblem is solved again: then ΦᵀMΦ = 1, ∫Φ dm = 0 and ∫ r
// × Φ dm = 0 to round-off (mean-axis conditions at rest). All sums run in the order of the file, so that the same file
// gives the same bits.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <string>
#include <vector>

#include "hil/scenario/flexible/modes_file.h"
#include "unlatch/model.h"

namespace unlatch::hil {

// Data for the kernel, all relative to the undeformed centre of mass.
struct FlexibleStructure {
  double mass = 0;          // kg
  Eigen::Vector3d centre;   // undeformed centre of mass, from the file's origin, m
  Eigen::Matrix3d inertia;  // undeformed, about the centre of mass, kg m²
  FlexibleBody flexible;    // modes and inertia invariants
  struct NamedMarker {
    std::string name;
    Marker marker;  // the loader sets its body
  };
  std::vector<NamedMarker> markers;
};

// One elastic mode, in the file and after conditioning.
struct ModeFinding {
  int number = 0;      // in the file, from 1
  double file_hz = 0;  // frequency in the file
  double hz = 0;       // frequency with the file's masses, momentum-free and orthonormal
  double overlap = 0;  // |cosine| between the two shapes, weighted by mass: 1 is the same shape
  bool selected = false;
  // Parts of the whole mass and of the inertia about x, y, z that move with the original mode (effective modal masses):
  // 0 for modes of a free structure.
  Eigen::Vector3d effective_mass, effective_inertia;
  // Φᵀ Φ/ω² and Ψᵀ Ψ/ω² at each marker, relative to the sum over the file's elastic modes: the part that is lost
  // without the mode.
  std::vector<double> compliance, angular_compliance;
};

struct FlexibleReport {
  double found_gram = 0;      // largest |Φ_kᵀ M Φ_l − δ_kl| of the original shapes, scaled to unit modal mass
  double found_momentum = 0;  // largest |∫Φ dm|/√(m m_k) or |∫ r × Φ dm|/√(J m_k) of the original shapes
  double gram = 0, momentum = 0;  // the same of the conditioned modes
  std::vector<int> rigid;         // numbers of the file's rigid-body modes, which are left out
  std::vector<ModeFinding> modes;
};

struct ModeSelection {
  std::vector<int> numbers;           // numbers of the file's modes, from 1; empty: all elastic ones
  std::vector<double> damping = {0};  // ζ, relative to critical: one for all modes, or one for each
};

// Conditions modes: the same points and markers relative to the centre of mass, with the elastic modes alone,
// orthonormal and momentum-free. Throws std::invalid_argument for a structure without extent and for dependent modes.
Modes condition_modes(const Modes& found, FlexibleReport& report);

// Sums the invariants over the points. `modes`: conditioned; `damping`: ζ of each of its modes.
FlexibleStructure calc_invariants(const Modes& modes, const std::vector<double>& damping);
// Sets ζ: one for all modes, or one for each. Throws std::invalid_argument for another number of them, or of other
// sizes.
void set_damping(const std::vector<double>& damping, FlexibleStructure& structure);

// Conditions all modes, then selects some. Throws std::invalid_argument as above, and for a selected mode that is not
// in the file or not elastic.
FlexibleStructure build_flexible_body(const Modes& found, const ModeSelection& selection, FlexibleReport& report);

// A file of modes as a scenario uses it, but for the damping. Another reading of the same scenario with other values
// takes it from the first: reading and conditioning depend on the file and the selected modes alone.
struct KnownStructure {
  std::string path;          // of the file
  std::vector<int> numbers;  // selected modes
  FlexibleStructure structure;
  FlexibleReport report;
};
using KnownStructures = std::vector<std::shared_ptr<const KnownStructure>>;

}  // namespace unlatch::hil
