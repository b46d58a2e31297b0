#include "hil/scenario/measurable.h"

#include <algorithm>

#include "unlatch/quantities.h"

namespace unlatch::hil {
namespace {

using Measure = Requirement::Measure;

class Lister {
 public:
  explicit Lister(const Scenario& scenario) : scenario_(scenario), model_(scenario.model) {}

  std::vector<Measurable> list() {
    for (const ClearancePair& pair : scenario_.clearance)
      add(Measure::kClearance, 0, 0, pair.a.name + "." + pair.b.name, "[" + pair.a.name + ", " + pair.b.name + "]");
    add_bodies(Measure::kRate, "");
    for (const Event& event : model_.events) {
      const std::string name = event.name + (event.subject.empty() ? "" : ":" + event.subject);
      add(Measure::kTime, 0, 0, name, "{event: " + name + "}");
    }
    if (model_.events.size() > 1) add(Measure::kOrder, 0, 0, "", "[EVENT, EVENT, …]");
    add_reactions();
    add_bodies(Measure::kVelocity, "");
    add_bodies(Measure::kPosition, "");
    add_axes(Measure::kDisplacement, 0, kRotX);
    add_axes(Measure::kAngle, kRotX, kRows);
    add_axes(Measure::kSpeed, 0, kRows);
    add_bodies(Measure::kAxes, ", axis: […], other: […]");
    add_sensors();
    add_contacts();
    for (std::size_t i = 0; i < scenario_.named_quantities; ++i)
      add(Measure::kQuantity, i, 0, model_.quantities[i].name, model_.quantities[i].name);
    return std::move(list_);
  }

 private:
  void add(Measure quantity, std::size_t subject, int axis, const std::string& name, const std::string& text) {
    Requirement requirement;
    requirement.quantity = quantity;
    requirement.a = static_cast<int>(subject);
    requirement.axis = axis;
    const std::string& kind = get_quantity_name(quantity);
    list_.push_back({kind + (name.empty() ? "" : "." + name), get_unit(requirement, model_), kind + ": " + text});
  }
  void add_bodies(Measure quantity, const std::string& more) {
    for (std::size_t i = 0; i < model_.bodies.size(); ++i)
      add(quantity, i, 0, model_.bodies[i].name, "{body: " + model_.bodies[i].name + more + "}");
  }
  void add_reactions() {
    for (std::size_t i = 0; i < model_.joints.size(); ++i)
      for (int row = Requirement::kMoment; row < static_cast<int>(kRows); ++row) {
        const std::string name = row >= 0 ? kRowNames[row] : row == Requirement::kForce ? "force" : "moment";
        const std::string& joint = model_.joints[i].name;
        add(Measure::kReaction, i, row, joint + "." + name, "{joint: " + joint + ", row: " + name + "}");
      }
  }
  void add_axes(Measure quantity, int begin, int end) {
    for (std::size_t i = 0; i < model_.joints.size(); ++i)
      for (int axis = begin; axis < end; ++axis) {
        const std::string& joint = model_.joints[i].name;
        add(quantity, i, axis, joint + "." + kRowNames[axis], "{joint: " + joint + ", axis: " + kRowNames[axis] + "}");
      }
  }
  void add_sensors() {
    for (std::size_t i = 0; i < model_.sensors.size(); ++i) {
      const std::string& sensor = model_.sensors[i].name;
      const auto components = get_sensor_components(model_.sensors[i].kind);
      for (std::size_t k = 0; k < components.size(); ++k) {
        const std::string part = components[k];
        add(Measure::kSensor, i, static_cast<int>(k), sensor + part,
            "{name: " + sensor + (part.empty() ? "" : ", value: " + part.substr(1)) + "}");
      }
    }
  }
  void add_contacts() {
    static constexpr const char* kValues[] = {"force", "depth", "slip", "impulse", "dissipated"};  // ContactValue
    for (std::size_t i = 0; i < model_.contacts.size(); ++i)
      for (int value = 0; value < 5; ++value) {
        const std::string& contact = model_.contacts[i].name;
        add(Measure::kContact, i, value, contact + "." + kValues[value],
            "{name: " + contact + ", value: " + kValues[value] + "}");
      }
  }

  const Scenario& scenario_;
  const Model& model_;
  std::vector<Measurable> list_;
};

// SI; "" for a plain number.
std::string get_si_unit(const Model& model, const unlatch::Quantity& quantity) {
  const std::string unit = get_unit(model, quantity);
  return unit == "1" ? "" : unit;
}

std::string get_sensor_unit(const Model& model, const Sensor& sensor, int value) {
  unlatch::Quantity quantity = get_quantity(model, sensor);
  if (quantity.part == unlatch::Quantity::kAll) quantity.part = std::max(value, 0);
  return get_si_unit(model, quantity);
}

}  // namespace

std::string get_unit(const Requirement& requirement, const Model& model) {
  static constexpr const char* kContactUnits[] = {"N", "m", "m", "N s", "J"};
  const bool turns = requirement.axis >= kRotX;
  switch (requirement.quantity) {
    case Measure::kClearance:
    case Measure::kPosition:
      return "m";
    case Measure::kRate:
      return "rad/s";
    case Measure::kTime:
    case Measure::kOrder:
      return "s";
    case Measure::kReaction:
      return turns || requirement.axis == Requirement::kMoment ? "N m" : "N";
    case Measure::kVelocity:
      return "m/s";
    case Measure::kDisplacement:
    case Measure::kAngle:
      return turns ? "rad" : "m";
    case Measure::kSpeed:
      return turns ? "rad/s" : "m/s";
    case Measure::kAxes:
      return "rad";
    case Measure::kContact:
      return kContactUnits[requirement.axis];
    case Measure::kSensor:
      return requirement.a < 0
                 ? ""
                 : get_sensor_unit(model, model.sensors[static_cast<std::size_t>(requirement.a)], requirement.axis);
    case Measure::kQuantity:
      return static_cast<std::size_t>(requirement.a) < model.quantities.size()
                 ? get_si_unit(model, model.quantities[static_cast<std::size_t>(requirement.a)])
                 : "";
  }
  return "";
}

std::vector<Measurable> list_measurables(const Scenario& scenario) { return Lister(scenario).list(); }

}  // namespace unlatch::hil
