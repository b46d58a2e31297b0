// The linear model of a scenario about a state of its run, with names and units; its poles and steady-state gains.
// unlatch/linear_model.h says what the model is; loop_margins.h has the margins of loops around it.
#pragma once

#include <stdexcept>
#include <string>
#include <vector>

#include "hil/run/linear/poles.h"
#include "hil/run/linear/steady_gains.h"
#include "hil/run/simulation/simulation.h"
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
  LinearModel model;        // B and D have the columns of `inputs` alone
  std::vector<Pole> poles;  // of A, in ascending order of their size
  SteadyGains gains;        // what a constant input changes the outputs by in the end
  // What sensors do that y has not, one sentence for each sensor among the outputs: delays, own rates, errors.
  std::vector<std::string> left_out;
};

// Runs the scenario without flight software up to the state and linearises there. Throws LinearizationError,
// SimulationError.
LinearSystem linearize(const Scenario& scenario, const LinearRequest& request);
// Linearises about the simulation's present state, with its inputs; the request's time and event do not count.
LinearSystem linearize(const Scenario& scenario, const Simulation& simulation, const LinearRequest& request = {});

}  // namespace unlatch::hil
