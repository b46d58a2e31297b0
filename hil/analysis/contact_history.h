// Contacts of a run: touches and lifts, the peak of the force located inside the steps, depth, impulse, slip and loss.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "hil/analysis/extreme.h"
#include "hil/analysis/motion_window.h"
#include "hil/scenario/scenario.h"
#include "hil/simulation/simulation.h"
#include "unlatch/contacts.h"

namespace unlatch::hil {

struct ContactRecord {
  std::string name;
  bool closed_at_start = false, closed = false;  // closed: at the end
  int touches = 0;                               // without that of the start
  std::optional<double> touch, lift;             // the first touch and the latest lift, s
  double duration = 0;                           // closed, s
  double peak_force = 0, peak_time = 0;          // F_n, N; s
  double depth = 0;                              // largest, m
  ContactTotals totals;                          // N s, m, J
};

class ContactHistory {
 public:
  ContactHistory(const Scenario& scenario, const Simulation& simulation);

  void begin(const State& state);  // of the start
  // Events acted between two knots of one instant.
  void add_events(const MotionKnot& before, const MotionKnot& after);
  // The window has moved on to the piece between these knots.
  void add(const MotionWindow& window, const MotionKnot& from, const MotionKnot& to);
  // Of the run so far, in the order of the model.
  [[nodiscard]] std::vector<ContactRecord> list() const;

  // A contact at a time of the present piece; at its end and at its beginning it is that of the knots. Totals are those
  // of its beginning.
  [[nodiscard]] ContactReading calc(const MotionWindow& window, int contact, double time) const;
  [[nodiscard]] ContactReading calc(const State& state, int contact) const;
  [[nodiscard]] double calc(const State& state, int contact, Requirement::ContactValue value) const;

 private:
  struct Track {
    ContactRecord record;
    Smallest force, depth;  // of the negatives
    bool fresh = true;      // no piece yet since it closed
  };
  [[nodiscard]] bool is_closed(const State& state, std::size_t contact) const;
  void finish(Track& track, int contact) const;

  const Simulation& simulation_;
  std::vector<Track> tracks_;
  const MotionWindow* window_ = nullptr;
  mutable std::vector<std::uint64_t> block_;  // scratch: a state of this piece
  mutable State scratch_;
};

}  // namespace unlatch::hil
