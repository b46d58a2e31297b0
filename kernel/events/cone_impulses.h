// Impulses of all closed pairs at once, by Newton's law along the normals and Coulomb's across them, where sweeps over
// one pair after the other do not end: feet that hold a body more than once, or whose frictions pass on to each other.
//
// The law as a zero (P. Alart, A. Curnier, Comput. Methods Appl. Mech. Eng. 92, 1991): with the rates u = Λp − c of the
// rows beyond their loads c, and a pair's own mobilities m_n along and m_t across its normal,
//
//   x = p_n − u_n/m_n,   y = p_t − u_t/m_t,
//   p_n = max(0, x),     p_t = the vector nearest to y with |p_t| ≤ μ max(0, x).
//
// It is piecewise smooth: Newton's method takes the derivative of the piece that it is on, and converges in some five
// iterations. Of redundant rows, whose impulses the zero leaves open, each iteration changes p by the least square
// (K. Levenberg, D. Marquardt): with the residual r and the derivative A, both in m/s, (AᵀA + λ) d = −Aᵀr, λ growing
// until |r| falls.
//
// Yield. Feet that stick and whose places contradict each other (touches that waited for a tick overlap by micrometres)
// have impulses without bound, or none that is found. Then each pair yields by the least of a few parts ε of its
// mobility: u + ε m p is in the place of u, which has bounded impulses always. By that the energy falls: with Coulomb's
// law of u + ε m p, p·u ≤ −ε m p².
//
// Forces of bodies that slip or stick are found likewise, with accelerations in the place of velocities: pairs that
// slip (Slips::kDirected) have p_t = −μ p_n s for the direction s of their slip, and all others the law above. With a
// small yield forces of redundant rows are those of least square, as kernel/integration/rigid_rows.h takes them: where
// p is within its cone, ε m p = −u is in the range of Λ.
//
// Cost: some n³ for each iteration, n rows; at most kMostCone iterations.
#pragma once

#include "kernel/plan/evaluation.h"

namespace unlatch {

// Part of the fastest rate of a blow that its impulses may leave unresolved.
inline constexpr double kImpulseResidual = 1e-8;
inline constexpr int kMostCone = 60;  // factorisations of one search

// The mobility along its normal of the pair that row r is of, by itself, 1/kg: the unit of its yield.
double get_pair_mobility(const RigidScratch& s, int r) noexcept;

// Whether pairs that slip have the directions of their slips.
enum class Slips { kFree, kDirected };
inline bool is_directed(const RigidScratch& s, int r, Slips slips) {
  const RigidMode mode = s.rows[static_cast<std::size_t>(r)].mode;
  return slips == Slips::kDirected && (mode == RigidMode::kSlips || mode == RigidMode::kCreeps);
}

// Improves the impulses in s.forces. Returns the part of `fastest` that is left unresolved.
double improve_cone_impulses(double fastest, Slips slips, RigidScratch& s) noexcept;

}  // namespace unlatch
