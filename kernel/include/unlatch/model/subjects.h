// What the parts of a model name: the bodies behind each subject, and what elements, laws and actions read and act on.
// For questions about what depends on what. The descriptions of the kinds answer them: those of elements by the indices
// that they pass to shift() (kernel/elements/kinds), those of laws and quantities by their tables.
#pragma once

#include <vector>

#include "unlatch/quantities.h"

namespace unlatch {

// What an element or a law names. Bodies of joints and surfaces are among the bodies; the ground is not.
struct Subjects {
  std::vector<int> bodies, laws, quantities, channels;  // their indices
  bool reads_speed = false;                             // of an element: how fast its bodies move decides its force
};

// Of each element, in the one numbering of all of them: bodies that it acts on or reads, laws and channels.
std::vector<Subjects> list_element_subjects(const Model& model);

// Of a law of the model itself: quantities, and channels, those of its tables among them.
Subjects list_law_subjects(const Model& model, const Law& law);

// Bodies of a subject, without the ground; none of a signal, a channel, an event or a law.
std::vector<int> list_subject_bodies(const Model& model, SubjectOf of, int subject);

// Bodies that an action acts on by itself, without the ground: not those of who waits for the signal that it raises.
std::vector<int> list_action_bodies(const Model& model, const Action& action);

}  // namespace unlatch
