// Clearances over a run: computed only where they can be smallest (conservative advancement, Mirtich 1996): between two
// knots a distance changes by no more than the bodies move relative to one another. Results: the smallest of the whole
// run and of the time after a pair was released, located inside the steps; ties told as such; and how fast they change
// at the end.
#pragma once

#include <vector>

#include "hil/motion/clearance.h"
#include "hil/motion/extreme.h"
#include "hil/motion/motion_window.h"
#include "hil/scenario/scenario.h"

namespace unlatch::hil {

// Pieces of motion in which no result can change are left out, or computed all the same; the results have the same
// bits.
enum class Skipping { kOn, kOff };

class ClearanceHistory {
 public:
  explicit ClearanceHistory(const Scenario& scenario, Skipping skipping = Skipping::kOn);

  // A state that no step produced.
  void begin(double time, std::span<const BodyState> bodies);
  // The window has moved on.
  void add(const MotionWindow& window);
  // The bodies of one list are joined to none of the other from now on; or to some of them again.
  void release(double time, const std::vector<int>& a, const std::vector<int>& b);
  void join(const std::vector<int>& bodies);

  [[nodiscard]] bool is_empty() const { return now_.empty(); }
  // Depth of a dip that is no noise, m.
  [[nodiscard]] double get_resolution(int pair) const;
  // At the end of the present piece, m; and at any time of the window.
  [[nodiscard]] double get_now(int pair) const {
    refresh(static_cast<std::size_t>(pair));
    return now_[static_cast<std::size_t>(pair)].now;
  }
  [[nodiscard]] double calc(const MotionWindow& window, int pair, double time) const;
  [[nodiscard]] const std::vector<Clearance>& get() const;
  // Witnesses and nearest shapes of a pair when it was smallest.
  [[nodiscard]] PairDistance calc_witnesses(int pair) const;

 private:
  // A body that is in a pair.
  struct Body {
    double turned = 0;   // rad, at most, up to its end
    bool fresh = false;  // `place` is of the present piece
  };
  // A body at the end of the present piece.
  struct Place {
    geometry::Placement at;
    Vec3 v{0, 0, 0}, w{0, 0, 0};  // of the origin; angular velocity; W axes
    Spatial acceleration{};       // of the origin, W axes
  };
  // The bounding sphere of one side of a pair as the other side sees it.
  struct Relative {
    Vec3 centre{0, 0, 0};  // m
    Mat3 R = kIdentity3;
    double speed = 0;     // m/s, at most, of any of its points
    double increase = 0;  // m/s², of any of its points, without the centripetal part
  };
  struct Track {
    Smallest whole, released;
    double size = 0;                    // m
    Relative reference;                 // when the distance was computed last
    Vec3 between{0, 0, 0};              // m, from one origin to the other, W axes, then
    double turned_a = 0, turned_b = 0;  // Body::turned, then
    double value = 0;                   // m, then
    double moved = 0;                   // m, at most, by which the distance has changed since, at the latest knot
    Relative latest;                    // at the latest knot
    bool followed = true;               // it is
    bool idle = false;                  // pieces were skipped; the next that is not begins anew
    mutable bool stale = false;         // `now` and `rate` of the latest knot are not computed
    geometry::Placement at_a, at_b;     // when it was smallest
    double tie = 0;                     // m: the value that later ones are compared with
    bool after_release = false;
    double release_time = 0;
  };
  void add_value(std::size_t pair, double time, double value);
  void refresh(std::size_t pair) const;
  static Place get_place(const BodyState& body, const Spatial& acceleration);
  [[nodiscard]] Relative calc_relative(std::size_t pair, const Place& a, const Place& b) const;
  [[nodiscard]] double calc_change(std::size_t pair, const Relative& from, const Relative& to) const;
  [[nodiscard]] double get_limit(std::size_t pair) const;
  [[nodiscard]] bool is_far(const MotionPiece& piece, std::size_t pair) const;
  const Place& get_end(const MotionPiece& piece, std::size_t body);
  bool skip(const MotionWindow& window, std::size_t pair);
  void set_reference(const MotionPiece& piece, std::size_t pair, double value);
  void keep_places(const MotionWindow& window, std::size_t pair);
  void publish(std::size_t pair);
  void find_touch(const MotionWindow& window, std::size_t pair, bool crosses, const TimeFunction& function);

  Skipping skipping_;
  ClearanceMonitor monitor_;
  mutable std::vector<Clearance> now_;
  std::vector<Track> tracks_;
  std::vector<Body> bodies_;              // by body; of those that are in a pair
  std::vector<Place> places_;             // by body; of those that are fresh
  std::vector<int> watched_;              // these bodies
  const MotionWindow* window_ = nullptr;  // the latest
};

}  // namespace unlatch::hil
