// Quantities in the scenario language, from the kernel's table: keys, patterns, and the list of those that a scenario
// has.
#pragma once

#include <string>
#include <vector>

#include "unlatch/quantities.h"

namespace unlatch::hil {

struct Scenario;

// Kinds by their key in the language, all but those that the kernel alone uses: "velocity".
const std::vector<std::string>& list_quantity_keys();
const QuantityTraits* find_quantity_traits(const std::string& key);  // null for any other text
// Key that names a subject: "body"; of surfaces "between".
const char* get_subject_key(SubjectOf of);
// Key of the direction of a vector: "along", of a rate "about".
const char* get_direction_key(const QuantityTraits& traits);
// The kind needs more than the name of its subject.
bool needs_more(const QuantityTraits& traits);
// How a kind is written: "{joint: NAME, axis: AXIS}".
std::string write_pattern(const QuantityTraits& traits);
// How a quantity is written: "velocity: {body: pod, relative_to: core}".
std::string write_quantity(const Model& model, const unlatch::Quantity& quantity);
// Unit of a sensor's values: "kg/m3"; "N, N m" where some values have one and some the other.
std::string get_unit(const Model& model, const Sensor& sensor);

// Quantities that a scenario may name: each kind with each of its subjects and rows, of vectors the size, seen from the
// ground. Those of two surfaces are of pairs that the model has.
std::vector<unlatch::Quantity> list_possible_quantities(const Model& model);

}  // namespace unlatch::hil
