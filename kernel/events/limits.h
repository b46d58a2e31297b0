// Limits on the work of the search for events. Each loop of a step over tries or sub-steps ends at one of them; what a
// step can cost at most follows from them (kernel/cost).
#pragma once

namespace unlatch {

inline constexpr int kMostTries = 24;         // that locate one event
inline constexpr int kMostLooks = 8;          // that search for touches within a sub-step
inline constexpr int kMostCornerTries = 6;    // that end at a corner of a law
inline constexpr int kMostJumpTries = 12;     // that end behind a jump of a law
inline constexpr int kMostCornerSplits = 8;   // of a step, at corners of laws
inline constexpr int kMostFeatureTries = 5;   // that end where the feature of a closed pair changes
inline constexpr int kMostFeatureSplits = 8;  // of a step, at changes of features and jumps of rigid forces

// Rounds of events at one instant that rigid contacts add: for each pair, and for each that has friction.
inline constexpr int kRigidRounds = 8, kRoughRounds = 40;
constexpr int calc_rigid_rounds(int pairs, int rough) { return kRigidRounds * (pairs - rough) + kRoughRounds * rough; }

}  // namespace unlatch
