// A flexible body from the results of a finite-element program (modes_file.h): a floating frame at the undeformed
// centre of mass, modal coordinates, and the inertia invariants that the motion needs.
//
// A mass point at r moves with u = Φ η about a frame that moves as a whole. Modes as they come are orthonormal and free
// of momentum only as far as the masses were lumped and the digits printed. So rigid motion is projected out of the
// shapes, Φ ← Φ − t − ρ × r, which costs no strain energy, and with the stiffness diag(ω²) of the modes as they came,
// each scaled to modal mass 1, the small eigenproblem is solved again: then ΦᵀMΦ = 1, ∫Φ dm = 0 and ∫ r × Φ dm = 0 to
// round-off (mean-axis conditions at rest). All sums run in the order of the file, so that the same file gives the same
// bits.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "hil/flexible/modes_file.h"
#include "unlatch/model.h"

namespace unlatch::hil {

// The data that the kernel needs, all from the undeformed centre of mass.
struct FlexibleStructure {
  double mass = 0;          // kg
  Eigen::Vector3d centre;   // of mass, undeformed, from the file's origin, m
  Eigen::Matrix3d inertia;  // undeformed, about the centre of mass, kg m²
  FlexibleBody flexible;    // modes and inertia invariants
  struct NamedMarker {
    std::string name;
    Marker marker;  // its body is set by the loader
  };
  std::vector<NamedMarker> markers;
};

// One elastic mode of the file, as found and as it became.
struct ModeFinding {
  int number = 0;      // in the file, from 1
  double file_hz = 0;  // as in the file
  double hz = 0;       // with the file's masses, momentum-free and orthonormal
  double overlap = 0;  // |cosine| between the two shapes, by mass: 1 is the same shape
  bool selected = false;
  // Shares of the whole mass and of the inertia about x, y, z that move with the mode as it came (effective modal
  // masses): 0 for modes of a free structure.
  Eigen::Vector3d effective_mass, effective_inertia;
  // Φᵀ Φ/ω² and Ψᵀ Ψ/ω² at each marker, as shares of the sum over the file's elastic modes: what is lost without it.
  std::vector<double> compliance, angular_compliance;
};

struct FlexibleReport {
  double found_gram = 0;          // largest |Φ_kᵀ M Φ_l − δ_kl|, shapes scaled to unit modal mass, as they came
  double found_momentum = 0;      // largest |∫Φ dm|/√(m m_k) or |∫ r × Φ dm|/√(J m_k), as they came
  double gram = 0, momentum = 0;  // of the modes that came out
  std::vector<int> rigid;         // numbers of the file's modes that are rigid motions: left out
  std::vector<ModeFinding> modes;
};

struct ModeSelection {
  std::vector<int> numbers;           // of the file's modes, from 1; empty: all elastic ones
  std::vector<double> damping = {0};  // ζ, of critical: one for all, or one for each number
};

// The same points and markers from the centre of mass, with the elastic modes alone, orthonormal and momentum-free.
// Throws std::invalid_argument: a structure without extent, modes that are not independent.
Modes condition_modes(const Modes& found, FlexibleReport& report);

// Sums over the points, whatever the modes are; `modes` conditioned, damping in ζ of its modes.
FlexibleStructure calc_invariants(const Modes& modes, const std::vector<double>& damping);

// Conditions all modes, then takes those that are selected. Throws std::invalid_argument as above, and for a selection
// that names a mode which the file has not, or not as an elastic one.
FlexibleStructure build_flexible_body(const Modes& found, const ModeSelection& selection, FlexibleReport& report);

}  // namespace unlatch::hil
