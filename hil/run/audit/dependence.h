// What depends on which bodies: quantities, laws, conditions, events, actions, requirements. Conservative: where the
// bodies are not known, these are all. Lists have neither the ground nor markers, whose flexible body stands for them.
#pragma once

#include <vector>

#include "hil/scenario/requirements.h"
#include "unlatch/model.h"

namespace unlatch::hil {

// Body that moves a body: of a marker its flexible body.
int find_carrier(const Model& model, int body);
// Both, but for the ground.
std::vector<int> list_pair(const Model& model, int base, int follower);
std::vector<int> list_all_bodies(const Model& model);
std::vector<int> list_joint_bodies(const Model& model, int joint);
std::vector<int> list_contact_bodies(const Model& model, int contact);

// Bodies on whose motion a law's value, or the instant of an event, depends.
std::vector<int> list_read_bodies(const Model& model, const unlatch::Law& law);
std::vector<int> list_guard_bodies(const Model& model, const unlatch::Event& event);
// Bodies that an event acts on.
std::vector<int> list_driven_bodies(const Model& model, const unlatch::Event& event);
// Bodies that sensors measure; those that commands drive, at once or by events.
std::vector<int> list_sensed_bodies(const Model& model);
std::vector<int> list_commanded_bodies(const Model& model);
// Bodies that a requirement is about, whatever decides the interval in which it holds.
std::vector<int> list_own_bodies(const Model& model, const Requirement& requirement);
// Bodies on which a requirement's value depends.
std::vector<int> list_bodies(const Model& model, const Requirement& requirement);

}  // namespace unlatch::hil
