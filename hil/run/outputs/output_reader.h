// Reads values of a scenario's outputs (hil/scenario/outputs.h) at the present state of its run, from the state and the
// evaluation of the latest step. Off the cyclic thread: clearances allocate.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "hil/run/motion/joint_frame.h"
#include "hil/run/recording/log_format.h"
#include "hil/run/simulation/simulation.h"
#include "hil/scenario/outputs.h"
#include "hil/scenario/scenario.h"
#include "hil/scenario/shapes/clearance.h"
#include "unlatch/contacts.h"

namespace unlatch::hil {

class OutputReader {
 public:
  // Keeps references to both.
  OutputReader(const Scenario& scenario, const Simulation& simulation, SensorsShown shown = SensorsShown::kAsScenario);

  // Sets the sensor values that flight software has at the present state and that were not sampled.
  void set_received(std::span<const LogReceived> received) { received_.assign(received.begin(), received.end()); }

  [[nodiscard]] const std::vector<Output>& list() const { return list_; }
  [[nodiscard]] std::size_t count_values() const { return hil::count_values(list_); }

  // Clearances of the scenario's pairs, in their order, from the latest reading.
  [[nodiscard]] const std::vector<Clearance>& get_clearances() const { return clearances_.get(); }

  // Reads the requested outputs into `to`, count_values() numbers; the others stay unchanged.
  void read(std::span<double> to);
  void read(std::span<const std::size_t> outputs, std::span<double> to);

  // Name of a joint's mode, by the value of its output `mode`.
  [[nodiscard]] const std::string& get_mode_name(const Output& output, double value) const;

 private:
  void read_body(const Output& output, std::span<double> to) const;
  void read_joint(const Output& output, std::span<double> to) const;
  // `reading`: for outputs of contacts.
  void read_contact(const Output& output, const ContactReading& reading, std::span<double> to) const;
  void read_element(const Output& output, std::span<double> to) const;
  void read_received(const Output& output, std::span<double> to) const;
  void update_clearances();

  const Scenario& scenario_;
  const Simulation& simulation_;
  const std::vector<Output> list_;
  std::vector<JointGeometry> joints_;
  std::vector<std::size_t> first_sensor_value_;  // by sensor
  std::vector<LogReceived> received_;
  ClearanceMonitor clearances_;
  std::vector<Pose> poses_;
};

}  // namespace unlatch::hil
