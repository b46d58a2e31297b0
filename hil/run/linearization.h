// The linear model of a scenario about a state of its run, with names and units; its poles; and the margins of a loop
// that flight software closes around it. unlatch/linear_model.h says what the model is.
#pragma once

#include <complex>
#include <functional>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "hil/run/simulation/simulation.h"
#include "hil/run/steady_gains.h"
#include "hil/scenario/scenario.h"
#include "unlatch/linear_model.h"

namespace unlatch::hil {

// Error: no such event, input or output, or a singular state; what() says what would be right.
class LinearizationError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// Where the run is linearised, and what of it.
struct LinearRequest {
  double time = 0;      // s; moved to the nearest tick
  std::string event{};  // instead: the end of the step in which this event acts first, NAME or NAME.SUBJECT
  std::vector<std::string> inputs{}, outputs{};  // patterns of channels; of sensors' values and quantities. Empty: all
};

// A state, input or output.
struct LinearName {
  std::string name;  // "joint.hinge1.rot_z", "rate.joint.hinge1.rot_z", "sensor.gyro.x", "quantity.tip"
  std::string unit;  // "1" for a plain number
};

struct LinearSystem {
  double time = 0;  // s
  std::vector<LinearName> states, inputs, outputs;
  LinearModel model;                        // B and D have the columns of `inputs` alone
  std::vector<std::complex<double>> poles;  // of A, by their size, 1/s
  double pole_rounding = 0;                 // 1/s: poles smaller than this are not distinct from 0
  SteadyGains gains;                        // what a constant input changes the outputs by in the end
};

// Runs the scenario without flight software up to the state and linearises there. Throws LinearizationError,
// SimulationError.
LinearSystem linearize(const Scenario& scenario, const LinearRequest& request);
// Linearises about the simulation's present state, with its inputs; the request's time and event do not count.
LinearSystem linearize(const Scenario& scenario, const Simulation& simulation, const LinearRequest& request = {});

// A loop around one input: input = −Σ gain · output, sampled each `period` and held, `delay` late.
struct LoopRequest {
  std::string input;
  struct Term {
    double gain;
    std::string output;
  };
  std::vector<Term> terms;
  double period = 0;  // s; 0: continuous
  double delay = 0;   // s; with a period a whole number of these
};
// Parses "torque=12*sensor.angle+30*sensor.gyro.z". Throws LinearizationError.
LoopRequest parse_loop(const std::string& text);

// Margins of a loop, each the least over all crossings; absent if the loop has no such crossing below half the sampling
// frequency.
struct LoopMargins {
  bool stable = false;  // the closed loop; of an unstable one the margins say how far it is from another state
  struct At {
    double value, frequency;  // frequency: rad/s
  };
  std::optional<At> gain;   // factor above 1 that the loop's gain may grow by
  std::optional<At> drop;   // factor below 1 that it may fall to
  std::optional<At> phase;  // rad
  std::optional<At> delay;  // s
};
// Throws LinearizationError: no such input or output, or a delay that is no whole number of periods.
LoopMargins calc_margins(const LinearSystem& system, const LoopRequest& loop);

}  // namespace unlatch::hil
