// Clearances over a run: the smallest of the whole run and of the time after a pair was released, located inside the
// steps; ties told as such; and how fast they change at the end.
#pragma once

#include <vector>

#include "hil/analysis/clearance.h"
#include "hil/analysis/extreme.h"
#include "hil/analysis/motion_window.h"
#include "hil/scenario/scenario.h"

namespace unlatch::hil {

class ClearanceHistory {
 public:
  explicit ClearanceHistory(const Scenario& scenario);

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
  [[nodiscard]] double get_now(int pair) const { return now_[static_cast<std::size_t>(pair)].now; }
  [[nodiscard]] double calc(const MotionWindow& window, int pair, double time) const;
  [[nodiscard]] const std::vector<Clearance>& get() const { return now_; }
  // Witnesses and nearest shapes of a pair when it was smallest.
  [[nodiscard]] PairDistance calc_witnesses(int pair) const;

 private:
  struct Track {
    Smallest whole, released;
    geometry::Placement at_a, at_b;  // when it was smallest
    double tie = 0;                  // m: the value that later ones are compared with
    bool after_release = false;
    double release_time = 0;
  };
  void add_value(std::size_t pair, double time, double value);
  void keep_places(const MotionWindow& window, std::size_t pair);
  void find_touch(const MotionWindow& window, std::size_t pair, double before, double value,
                  const Smallest::Function& function);

  ClearanceMonitor monitor_;
  std::vector<Clearance> now_;
  std::vector<Track> tracks_;
};

}  // namespace unlatch::hil
