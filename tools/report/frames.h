// Frames of a replay for a page, thinned out: every n-th tick, and every tick near an event. Positions are relative to
// those of the first body, which have full precision, so that single precision is enough for the others.
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <nlohmann/json_fwd.hpp>
#include <vector>

#include "hil/run/analysis/run_analysis.h"
#include "hil/run/recording/log_format.h"

namespace unlatch::tools {

// Columns of a frame, per item and in this order; `first` of each kind:
//   body     p_WB − p_W(first body) (3, m, W), q_WB (4: w x y z), v_WB (3, m/s, W), w_WB_B (3, rad/s, body axes)
//   joint    its mode (index), multipliers of the six rows (N, N m)
//   load     its size (N or N m)
//   pair     its clearance (m)
//   channel  the value that the last step read
//   sensor   the values of the model's sensors, one after the other
//   point    its position (3, m) in the axes and from the origin of the body that it is seen from
//   spring   of springs between points: force (N), length (m), switch scale
//   one-sided force (pusher, stop, cord)   force along its coordinate (N or N m), coordinate (m or rad), switch scale,
//            depth (m or rad; it acts where it is on and above 0); of a cord with a drum the bearing of its end and the
//            angle wound (rad)
//   contact  F_n (N), |F_t| (N), depth (m), slip (m/s)
//   requirement   the present value of its quantity, in its unit; NaN outside its interval
//   modal    of flexible bodies, in the model's order: the modal coordinates
//   received the values of the sensors that flight software had, if the recording has them
struct FrameLayout {
  FrameLayout(const hil::Scenario& scenario, std::size_t sensor_values, std::size_t received_count);
  std::size_t bodies = 0, joints, loads, pairs, channels, sensors, points, springs, one_sided, contacts, requirements,
              width;
  std::vector<std::size_t> modal;  // per body: its first modal column
  std::size_t received = 0, received_values = 0;
};
inline constexpr std::size_t kBodyColumns = 13, kJointColumns = 1 + kRows, kPointColumns = 3, kSpringColumns = 3,
                             kOneSidedColumns = 6, kContactColumns = 4;

class FrameRecorder {
 public:
  // All three must outlive it; the analysis is updated before each look().
  FrameRecorder(const hil::Scenario& scenario, const hil::Simulation& simulation, const hil::RunAnalysis& analysis,
                hil::SensorsShown shown = hil::SensorsShown::kAsScenario);

  // At every state, with what its step reported. `received`: sensor values that flight software has otherwise than they
  // were sampled.
  void look(const StepReport& report, std::span<const hil::LogReceived> received = {});
  // After the last look(): thins out what was kept until it takes at most `budget` bytes, and writes it down.
  [[nodiscard]] nlohmann::ordered_json build_json(std::size_t budget);

  [[nodiscard]] const FrameLayout& get_layout() const { return layout_; }

 private:
  struct Frame {
    std::int64_t tick = 0;
    Vec3 origin{};
    std::vector<float> values;
    bool pinned = false;
  };
  [[nodiscard]] Frame take(std::span<const hil::LogReceived> received) const;
  void take_loads(float* to) const;
  void take_points(float* to) const;
  void take_springs(float* to) const;
  void take_one_sided(float* to) const;
  void take_contacts(float* to) const;
  void take_modal(float* frame) const;
  void settle();
  void thin();
  [[nodiscard]] std::vector<std::size_t> find_varying() const;

  const hil::Scenario& scenario_;
  const hil::Simulation& simulation_;
  const hil::RunAnalysis& analysis_;
  const FrameLayout layout_;
  std::vector<Frame> kept_;
  std::deque<Frame> recent_;  // not yet known whether an event follows them
  std::int64_t every_ = 1, seen_ = 0, pinned_ = 0, pin_until_ = -1;
};

}  // namespace unlatch::tools
