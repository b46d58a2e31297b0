// Indices of a model, which are ints: conversion to those of vectors and to the common numbering of elements, and
// lists of them.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include "unlatch/model.h"

namespace unlatch::hil {

constexpr std::size_t at(int index) { return static_cast<std::size_t>(index); }

inline bool contains(const std::vector<int>& list, int index) {
  return std::find(list.begin(), list.end(), index) != list.end();
}

// Rows that some mode of a joint holds.
inline RowSet list_held_rows(const Joint& joint) {
  RowSet rows = 0;
  for (const JointMode& mode : joint.modes) rows = static_cast<RowSet>(rows | mode.rows);
  return rows;
}

// Number, as in State::elements, of the model's first one-sided force; the others follow it. Counted from the front:
// new kinds of elements come after all others.
inline int get_first_one_sided(const Model& model) {
  return static_cast<int>(model.loads.size() + model.point_springs.size() + model.joint_springs.size() +
                          model.plane_torsions.size() + model.contacts.size());
}

}  // namespace unlatch::hil
