// Clearances over a run, computed only where they can be smallest (conservative advancement, Mirtich 1996): between two
// knots a distance changes by no more than the bodies move relative to one another. Results: the smallest of the whole
// run and of the time after a pair was released, located inside the steps; ties, reported as such; and the rate of
// change at the end.
#pragma once

#include <vector>

#include "hil/run/motion/extreme.h"
#include "hil/run/motion/motion_window.h"
#include "hil/run/motion/relative_motion.h"
#include "hil/run/motion/shape_dips.h"
#include "hil/scenario/scenario.h"
#include "hil/scenario/shapes/clearance.h"

namespace unlatch::hil {

class ClearanceHistory {
 public:
  // `skipping`: of pieces of motion in which no result can change.
  explicit ClearanceHistory(const Scenario& scenario, Skipping skipping = Skipping::kOn);

  // Begins at a state that no step produced.
  void begin(double time, std::span<const BodyState> bodies);
  // Adds the piece to which the window has moved.
  void add(const MotionWindow& window);
  // Notes that no body of one list is joined to any of the other from now on; or that some are joined again.
  void release(double time, const std::vector<int>& a, const std::vector<int>& b);
  void join(const std::vector<int>& bodies);

  [[nodiscard]] bool is_empty() const { return now_.empty(); }
  // Smallest depth of a dip that is not rounding, m.
  [[nodiscard]] double get_resolution(int pair) const;
  // Error of a distance, m: the part kDistanceError of the size of the two (geometry, limits).
  static constexpr double kDistanceError = 1e-9;
  [[nodiscard]] double get_error(int pair) const;
  // Distance at the end of the present piece, m; and at any time of the window.
  [[nodiscard]] double get_now(int pair) const {
    refresh(static_cast<std::size_t>(pair));
    return now_[static_cast<std::size_t>(pair)].now;
  }
  [[nodiscard]] double calc(const MotionWindow& window, int pair, double time) const;
  // True only if no distance within the present piece is below `limit`, m: a cheap bound.
  [[nodiscard]] bool stays_above(int pair, double limit) const;
  [[nodiscard]] const std::vector<Clearance>& get() const;
  // Witness points and nearest shapes of a pair at its smallest value.
  [[nodiscard]] PairDistance calc_witnesses(int pair) const;

 private:
  // A body of some pair.
  struct Body {
    double turned = 0;   // rad, bound on its rotation up to the end of the piece
    bool fresh = false;  // `place` belongs to the present piece
  };
  struct Track {
    Smallest whole, released;
    double size = 0;                    // m
    RelativeMotion reference;           // at the latest computation of the distance
    Vec3 between{0, 0, 0};              // m, from one origin to the other, W axes, at that time
    double turned_a = 0, turned_b = 0;  // Body::turned, at that time
    double value = 0;                   // m, at that time
    double moved = 0;                   // m, bound on the change of the distance since then, at the latest knot
    double length = 0;                  // m, of the relative motion within the piece, if the piece was not skipped
    RelativeMotion latest;              // at the latest knot
    bool followed = true;               // `latest` is up to date
    bool still = false;                 // the pair does not move within the piece
    double least = 0;                   // m, no distance within the piece is below it; −infinity: not known
    int parted = 0, wait = 1;           // pieces that planes alone showed to be skipped; of them to the next reference
    bool idle = false;                  // pieces were skipped; the next computed piece begins anew
    mutable bool stale = false;         // `now` and `rate` of the latest knot are not computed
    mutable bool rateless = false;      // `now` alone is
    geometry::Placement at_a, at_b;     // at the smallest value
    double tie = 0;                     // m: reference value for ties
    bool after_release = false;
    double release_time = 0;
  };
  // Place of a body, or of the ground, in places_, bodies_ and the pieces of a window.
  [[nodiscard]] std::size_t get_index(int body) const {
    return body == kGround ? bodies_.size() - 1 : static_cast<std::size_t>(body);
  }
  void add_value(std::size_t pair, double time, double value);
  void refresh(std::size_t pair) const;
  void refresh_rate(std::size_t pair) const;
  [[nodiscard]] RelativeMotion calc_relative(std::size_t pair, const MovingBody& a, const MovingBody& b) const;
  [[nodiscard]] double calc_change(std::size_t pair, const RelativeMotion& from, const RelativeMotion& to) const;
  [[nodiscard]] double get_smallest(std::size_t pair) const;
  [[nodiscard]] double get_limit(std::size_t pair) const;
  [[nodiscard]] double calc_far(const MotionPiece& piece, std::size_t pair) const;
  const MovingBody& get_end(const MotionPiece& piece, std::size_t body);
  bool skip(const MotionWindow& window, std::size_t pair);
  void set_reference(const MotionPiece& piece, std::size_t pair, double value);
  void keep_places(const MotionWindow& window, std::size_t pair);
  void publish(std::size_t pair);
  void look_between_knots(const MotionPiece& piece, std::size_t pair, double before, double value);
  [[nodiscard]] double calc_fastest(const MotionPiece& piece, std::size_t pair) const;
  void find_touch(const MotionWindow& window, std::size_t pair, bool crosses, const TimeFunction& function);

  Skipping skipping_;
  ClearanceMonitor monitor_;
  mutable std::vector<Clearance> now_;
  std::vector<Track> tracks_;
  mutable std::vector<ShapeDips> dips_;   // of each pair
  std::vector<Body> bodies_;              // by body; only bodies of some pair
  std::vector<MovingBody> places_;        // by body; only fresh ones
  std::vector<int> watched_;              // bodies of some pair
  const MotionWindow* window_ = nullptr;  // the latest
};

}  // namespace unlatch::hil
