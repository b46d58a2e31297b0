// Who reads a speed that the step gets wrong, where places and forces are right: the speed of an implicit spring's
// coordinate, or of the shape of a flexible body (hil/run/notices/implicit_audit.h). Bodies on the two sides of the
// spring's joint have it between them, and so have those that the flexible body is, or joins. Conservative: in a loop
// of joints all bodies have it between them; joints count in all their modes.
#pragma once

#include <vector>

#include "hil/scenario/requirements.h"
#include "unlatch/model.h"
#include "unlatch/state.h"

namespace unlatch::hil {

class SpeedReaders {
 public:
  // Keeps a reference. `spring`: the element, or kNone; else `body`: the flexible one.
  SpeedReaders(const Model& model, int spring, int body);

  // True if a requirement reads it by itself: not by the sensor or quantity that it names.
  [[nodiscard]] bool is_read_by(const Requirement& requirement) const;
  // True if anything else does, so that the motion may follow from it: a quantity, a guard, a sensor, an element other
  // than the spring (friction, a damper, a contact, the air), a joint that an event so far has locked. `state`: now.
  [[nodiscard]] bool is_read(const State& state) const;

 private:
  // Node of a body that is not in the graph as itself: a marker's flexible body; the ground is the last.
  [[nodiscard]] std::size_t find_node(int body) const;
  // Groups of bodies that joints connect, but for the joint or body that is left out (kNone: none).
  [[nodiscard]] std::vector<std::size_t> find_groups(int joint, int body) const;
  [[nodiscard]] bool is_in_loop() const;
  [[nodiscard]] bool is_between(int a, int b) const;
  [[nodiscard]] bool is_among(const std::vector<int>& bodies) const;
  [[nodiscard]] bool is_read_by(const unlatch::Quantity& quantity) const;
  [[nodiscard]] bool is_read_by_elements() const;
  [[nodiscard]] bool is_read_by_locks(const State& state) const;

  const Model* model_;
  int spring_, body_, joint_ = kNone;
  std::vector<std::size_t> whole_, parts_;  // groups with and without the joint or body
  bool looped_ = false;
};

}  // namespace unlatch::hil
