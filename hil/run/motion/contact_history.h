// Contacts of a run: touches and lifts, peak force located inside the steps, depth, impulse, slip and dissipation.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "hil/run/motion/extreme.h"
#include "hil/run/motion/motion_window.h"
#include "hil/run/simulation/simulation.h"
#include "hil/scenario/scenario.h"
#include "unlatch/contacts.h"

namespace unlatch::hil {

// One touch of a contact: from the instant at which some pair of its shapes closes to that at which all are open.
struct Touch {
  bool at_start = false;                 // it was closed when the run began
  double time = 0;                       // s
  std::optional<double> lift;            // s; none: it is still closed
  double duration = 0;                   // s
  double peak_force = 0, peak_time = 0;  // F_n, N; s
  double depth = 0, impulse = 0;         // m; N s
  std::vector<std::string> pairs;        // "sat.foot – floor.top", in the order in which they close
};

struct ContactRecord {
  std::string name;
  bool closed_at_start = false, closed = false;  // closed: at the end of the run
  int touches = 0;                               // without the contact at the start
  std::optional<double> touch, lift;             // the first touch and the latest lift, s
  double duration = 0;                           // time closed, s
  double peak_force = 0, peak_time = 0;          // F_n, N; s
  double depth = 0;                              // largest, m
  ContactTotals totals;                          // N s, m, J
  double slip_uncertainty = 0;                   // how far the path of its slip may be wrong, m: add_settled()
  std::vector<Touch> list;                       // the first kMostTouches
  static constexpr std::size_t kMostTouches = 1000;
};

// Shapes of the pairs that State::contacts has of a contact, as indices of its two surfaces: those of the base, with
// each of them those of the follower.
std::vector<std::pair<int, int>> list_contact_pairs(const Model& model, const Contact& contact);

// A state of a plan, with its memory.
struct OwnState {
  explicit OwnState(const Plan& plan);
  std::vector<std::uint64_t> block;
  State state;
};

// Contacts at the state that was asked for last, each computed once: several results are of one knot.
class ContactReadings {
 public:
  explicit ContactReadings(const Plan& plan);
  const ContactReading& get(const State& state, int contact);

 private:
  const Plan& plan_;
  OwnState of_;
  std::vector<std::optional<ContactReading>> readings_;  // by contact, as far as they were asked for
};

class ContactHistory {
 public:
  // `touches`: keep each touch, beside the whole.
  ContactHistory(const Scenario& scenario, const Simulation& simulation, bool touches = true);

  void begin(double time, const State& state);  // Begins at the state of the start.
  // Names of the pairs of a contact that close between two knots of one instant.
  [[nodiscard]] std::vector<std::string> list_closing(const State& before, const State& after,
                                                      std::size_t contact) const;
  // Adds events that acted between two knots of one instant.
  void add_events(const MotionKnot& before, const MotionKnot& after);
  // Adds the piece between these knots, to which the window has moved.
  void add(const MotionWindow& window, const MotionKnot& from, const MotionKnot& to);
  // Adds a step in which so many bounces of rigid contacts ended, since the next flight would have been shorter than
  // `settle`. A pair that stays in touch slips in the time in which it would have flown, settle (1 + e + e² + …) at
  // most.
  void add_settled(int bounces, std::span<const MotionKnot> knots);
  // How far the path of a contact's slip may be wrong so far, m.
  [[nodiscard]] double get_slip_uncertainty(int contact) const;
  // Records of the run so far, in the order of the model.
  [[nodiscard]] std::vector<ContactRecord> list() const;

  // Contact at a time of the window's two pieces, the later of which was added last. Totals are those of the beginning
  // of the piece.
  [[nodiscard]] ContactReading calc(const MotionWindow& window, int contact, double time) const;
  [[nodiscard]] ContactReading calc(const State& state, int contact) const;
  // Some pair of its shapes is closed.
  [[nodiscard]] bool is_closed(const State& state, std::size_t contact) const;
  [[nodiscard]] double calc(const State& state, int contact, Requirement::ContactValue value) const;

 private:
  // Between knots: force and depth are searched at the same times, and requirements ask for them as well.
  struct Known {
    double time;
    ContactReading reading;
  };
  struct Track {
    ContactRecord record;
    Smallest force, depth;              // minima of the negatives
    bool fresh = true;                  // no piece yet since the contact closed
    Smallest own_force{}, own_depth{};  // of the present touch
    double impulse = 0;                 // N s, total at its beginning
    bool kept = false;                  // the present touch is the last of the list
  };
  void open_touch(Track& track, std::size_t contact, double time, const State& before, const State& state);
  void close_touch(Track& track, int contact, Touch& touch) const;
  void add_bounce(Track& track, std::size_t contact, const MotionKnot& before, const MotionKnot& after);
  void finish(Track& track, int contact) const;

  const Scenario& scenario_;
  const Simulation& simulation_;
  const bool touches_;
  std::vector<Track> tracks_;
  std::vector<std::vector<std::pair<int, int>>> pairs_;  // by contact: shapes of its surfaces
  const MotionWindow* window_ = nullptr;
  mutable OwnState present_, previous_;  // scratch: states of the window's pieces, for which pairs are closed in them
  mutable ContactReadings readings_;     // of the knots
  mutable std::vector<std::vector<Known>> known_;  // by contact, of the window's two pieces
};

}  // namespace unlatch::hil
