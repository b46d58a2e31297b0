#include "hil/run/linear/linearization.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "hil/run/run.h"
#include "hil/scenario/base/index.h"
#include "hil/scenario/text/count.h"
#include "hil/scenario/text/number_text.h"
#include "hil/scenario/text/suggestion.h"
#include "unlatch/contacts.h"
#include "unlatch/quantities.h"

namespace unlatch::hil {
namespace {

using Complex = std::complex<double>;
using Eigen::Index;
using Eigen::MatrixXd;

constexpr const char* kAxes[] = {"x", "y", "z"};

LinearName name_coordinate(const Model& model, const LinearCoordinate& own) {
  const auto subject = static_cast<std::size_t>(own.subject);
  switch (own.kind) {
    case LinearCoordinate::Kind::kPosition:
      return {"body." + model.bodies[subject].name + "." + kAxes[own.axis], "m"};
    case LinearCoordinate::Kind::kAttitude:
      return {"body." + model.bodies[subject].name + ".rot_" + kAxes[own.axis], "rad"};
    case LinearCoordinate::Kind::kModal:
      return {"body." + model.bodies[subject].name + ".modal." + std::to_string(own.axis + 1), "1"};
    case LinearCoordinate::Kind::kJoint:
      break;
  }
  return {"joint." + model.joints[subject].name + "." + kRowNames[own.axis], own.axis < kRotX ? "m" : "rad"};
}

std::string get_rate_unit(const std::string& unit) { return unit == "1" ? "1/s" : unit + "/s"; }

// All values of sensors and quantities that may be outputs, in the order of the model.
struct Value {
  LinearName name;
  bool sensor;
  int index;    // into Workspace::sensors or Workspace::quantities
  int subject;  // index of the sensor or quantity in the model
};
std::vector<Value> list_values(const Scenario& scenario) {
  std::vector<Value> values;
  int sensors = 0;
  for (const Output& output : list_outputs(scenario)) {
    if (output.kind == Output::Kind::kSensor)
      for (const Output::Column& column : output.columns)
        values.push_back({{column.name, column.unit}, true, sensors++, output.subject});
    if (output.kind == Output::Kind::kQuantity)
      for (const Output::Column& column : output.columns)
        values.push_back({{column.name, column.unit}, false, output.subject, output.subject});
  }
  return values;
}

bool matches_name(const std::string& pattern, const std::string& name) {
  Output output;
  output.name = name;
  return matches(pattern, output);
}

// Numbers of the names that a pattern selects, in the order of the patterns, each once; all without a pattern.
std::vector<std::size_t> choose(const char* what, const std::vector<std::string>& patterns,
                                const std::vector<LinearName>& names) {
  std::vector<std::size_t> chosen;
  for (std::size_t i = 0; patterns.empty() && i < names.size(); ++i) chosen.push_back(i);
  for (const std::string& pattern : patterns) {
    bool any = false;
    for (std::size_t i = 0; i < names.size(); ++i) {
      if (!matches_name(pattern, names[i].name)) continue;
      any = true;
      if (std::ranges::find(chosen, i) == chosen.end()) chosen.push_back(i);
    }
    if (any) continue;
    std::string list;
    for (const LinearName& name : names) list += (list.empty() ? "" : ", ") + name.name;
    throw LinearizationError("there is no " + std::string(what) + " '" + pattern + "'" +
                             (list.empty() ? "; the scenario has none" : "; there are: " + list));
  }
  return chosen;
}

// Runs up to the state that the request names.
void advance(const Scenario& scenario, const LinearRequest& request, Simulation& simulation) {
  const Model& model = simulation.model();
  const std::int64_t last = calc_nearest_tick(request.event.empty() ? request.time : scenario.until, scenario.dt);
  const auto is_it = [&](const FiredEvent& fired) {
    const Event& event = model.events[static_cast<std::size_t>(fired.event)];
    return event.name == request.event || event.name + "." + event.subject == request.event;
  };
  if (!request.event.empty() && std::ranges::none_of(model.events, [&](const Event& event) {
        return event.name == request.event || event.name + "." + event.subject == request.event;
      })) {
    std::vector<std::string> names;
    for (const Event& event : model.events)
      names.push_back(event.subject.empty() ? event.name : event.name + "." + event.subject);
    throw LinearizationError("there is no event '" + request.event + "'; " + suggest(request.event, names));
  }
  if (request.event.empty() && request.time > scenario.until)
    throw LinearizationError("t = " + write_short(request.time) + " s is after the end of the run, " +
                             write_short(scenario.until) + " s; --until moves it");
  while (simulation.get_tick() < last) {
    const StepReport report = simulation.step();
    if (report.status != StepStatus::kOk)
      throw LinearizationError("the run ended at t = " + write_short(simulation.get_time()) +
                               " s: " + get_status_text(report.status));
    if (!request.event.empty() && std::ranges::any_of(report.events, is_it)) return;
  }
  if (!request.event.empty())
    throw LinearizationError("event '" + request.event + "' did not act before the end of the run, t = " +
                             write_short(simulation.get_time()) + " s");
}

// Keeps these columns of a matrix.
MatrixXd keep_columns(const MatrixXd& all, const std::vector<std::size_t>& columns) {
  MatrixXd kept(all.rows(), std::ssize(columns));
  for (Index k = 0; k < kept.cols(); ++k)
    kept.col(k) = all.col(static_cast<Index>(columns[static_cast<std::size_t>(k)]));
  return kept;
}

std::vector<LinearName> pick(const std::vector<LinearName>& names, const std::vector<std::size_t>& chosen) {
  std::vector<LinearName> out;
  for (const std::size_t i : chosen) out.push_back(names[i]);
  return out;
}

}  // namespace

LinearSystem linearize(const Scenario& scenario, const LinearRequest& request) {
  const auto simulation = build_simulation(scenario);
  advance(scenario, request, *simulation);
  return linearize(scenario, *simulation, request);
}

namespace {

// A closed rigid contact is no spring: small motions into it do not exist, and those away from it open it.
void refuse_rigid_contacts(const Model& model, const Simulation& simulation) {
  for (std::size_t i = 0; i < model.contacts.size(); ++i) {
    if (!model.contacts[i].rigid) continue;
    for (const ContactState& pair : get_contact_pairs(simulation.plan(), simulation.state(), static_cast<int>(i)))
      if (pair.closed != 0)
        throw LinearizationError("the rigid contact '" + model.contacts[i].name +
                                 "' is closed at t = " + write_short(simulation.get_time()) +
                                 " s: a linear model has no force on one side; give it a stiffness, or switch it off");
  }
}

// What a sensor does that the model's output has not, or nothing.
std::string describe_left_out(const Scenario& scenario, int sensor) {
  std::vector<std::string> parts;
  for (const RateGroup& group : scenario.rates.groups)
    if (std::ranges::find(group.sensors, sensor) != group.sensors.end() && group.rate.every > 1)
      parts.push_back("sampled each " + write_short(static_cast<double>(group.rate.every) * scenario.dt) + " s");
  for (const SensorErrors& errors : scenario.rates.errors.sensors) {
    if (errors.sensor != sensor) continue;
    if (errors.delay > 0) parts.push_back(count(errors.delay, "sample") + " late");
    if (errors.scale != 0) parts.push_back("scale " + write_short(errors.scale));
    if (!errors.misalignment.isZero(0)) parts.push_back("misalignment");
    if (errors.quantum > 0) parts.push_back("quantum");
    if (errors.range > 0) parts.push_back("range");
    if (errors.dropout > 0) parts.push_back("dropout " + write_short(errors.dropout));
  }
  std::string text;
  for (const std::string& part : parts) text += (text.empty() ? "" : ", ") + part;
  return text;
}

}  // namespace

LinearSystem linearize(const Scenario& scenario, const Simulation& simulation, const LinearRequest& request) {
  const Model& model = scenario.model;
  refuse_rigid_contacts(model, simulation);
  const std::vector<Value> values = list_values(scenario);
  std::vector<LinearName> channels, names;
  for (const Channel& channel : model.channels) channels.push_back({channel.name, channel.unit});
  for (const Value& value : values) names.push_back(value.name);
  const std::vector<std::size_t> inputs = choose("channel", request.inputs, channels);
  const std::vector<std::size_t> outputs = choose("sensor or quantity", request.outputs, names);

  // Sensors come first in the kernel's model; the order of the request comes after.
  LinearOutputs wanted;
  std::vector<std::size_t> places(outputs.size());
  for (const bool sensor : {true, false})
    for (std::size_t i = 0; i < outputs.size(); ++i) {
      const Value& value = values[outputs[i]];
      if (value.sensor != sensor) continue;
      places[i] = wanted.sensors.size() + wanted.quantities.size();
      (sensor ? wanted.sensors : wanted.quantities).push_back(value.index);
    }
  std::optional<LinearModel> linear =
      calc_linear_model(simulation.plan(), simulation.state(), simulation.get_inputs(), wanted);
  if (!linear)
    throw LinearizationError("a pivot vanishes at t = " + write_short(simulation.get_time()) +
                             " s: the joints hold no definite set of freedoms there");

  LinearSystem system;
  system.time = simulation.get_time();
  for (const LinearCoordinate& own : linear->coordinates) system.states.push_back(name_coordinate(model, own));
  for (std::size_t k = 0, f = system.states.size(); k < f; ++k) {
    const LinearName own = system.states[k];
    system.states.push_back({"rate." + own.name, get_rate_unit(own.unit)});
  }
  system.inputs = pick(channels, inputs);
  system.outputs = pick(names, outputs);
  int described = -1;  // values of one sensor follow one another
  for (const std::size_t i : outputs) {
    if (!values[i].sensor || values[i].subject == described) continue;
    described = values[i].subject;
    if (const std::string text = describe_left_out(scenario, described); !text.empty())
      system.left_out.push_back("sensor." + model.sensors[static_cast<std::size_t>(described)].name + ": " + text);
  }
  for (MatrixXd* const matrix : {&linear->B, &linear->B_error, &linear->D, &linear->D_error})
    *matrix = keep_columns(*matrix, inputs);
  for (MatrixXd* const matrix : {&linear->C, &linear->C_error, &linear->D, &linear->D_error})
    *matrix = keep_columns(matrix->transpose(), places).transpose();
  system.poles = calc_poles(linear->A, linear->A_error);
  std::vector<Complex> at_zero;
  double slowest = 0;
  for (const Pole& pole : system.poles) {
    if (pole.is_at_zero())
      at_zero.push_back(pole.value);
    else if (slowest == 0)
      slowest = std::abs(pole.value);
  }
  system.gains = calc_steady_gains(*linear, at_zero, slowest);
  system.model = std::move(*linear);
  return system;
}

}  // namespace unlatch::hil
