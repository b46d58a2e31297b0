// Model::contact_substeps: the parts into which closed contacts cut a step. A positive number is given; 0
// (kAutomaticSubsteps) leaves it to the step; −n does so too, with parts n times as fine, n ≥ 2.
//
// An automatic part is as long at every step (kernel/elements/kinds/contact/contact_parts.h). So that runs at several
// steps differ by the error of that choice too, one at half the step asks for parts that are twice as fine.
#pragma once

#include <algorithm>

namespace unlatch {

// Largest refinement.
inline constexpr int kMaxContactRefinement = 65536;

// True if the step chooses the number of parts.
constexpr bool has_automatic_parts(int contact_substeps) { return contact_substeps <= 0; }
// How many times as fine automatic parts are as those of kAutomaticSubsteps.
constexpr int get_contact_refinement(int contact_substeps) { return std::max(1, -contact_substeps); }
// The value that stands for automatic parts of a refinement.
constexpr int make_automatic_substeps(int refinement) { return refinement > 1 ? -refinement : 0; }

}  // namespace unlatch
