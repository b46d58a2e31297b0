#include "hil/run/outputs/output_reader.h"

#include <numeric>

#include "hil/run/motion/motion_window.h"
#include "hil/scenario/base/index.h"
#include "unlatch/readings.h"

namespace unlatch::hil {
namespace {

using Kind = Output::Kind;

void put(const Vec3& v, std::span<double> to) {
  to[0] = v.x;
  to[1] = v.y;
  to[2] = v.z;
}
void put(std::span<const double> values, std::span<double> to) { std::ranges::copy(values, to.begin()); }

bool is_of_body(Kind kind) { return kind <= Kind::kModalRate; }
bool is_of_joint(Kind kind) { return kind >= Kind::kMode && kind <= Kind::kAngleRate; }
bool is_of_contact(Kind kind) { return kind >= Kind::kContactForce && kind <= Kind::kContactDissipated; }
bool is_of_reading(Kind kind) { return kind >= Kind::kContactForce && kind <= Kind::kContactSlipSpeed; }
bool is_of_element(Kind kind) { return kind >= Kind::kElementForce && kind <= Kind::kElementScale; }

}  // namespace

OutputReader::OutputReader(const Scenario& scenario, const Simulation& simulation, SensorsShown shown)
    : scenario_(scenario),
      simulation_(simulation),
      list_(list_outputs(scenario, shown)),
      clearances_(scenario.clearance, scenario.shapes, scenario.ground_shapes),
      poses_(scenario.model.bodies.size()) {
  const Model model = place_markers(scenario.model);
  for (std::size_t i = 0; i < model.joints.size(); ++i) joints_.emplace_back(model, static_cast<int>(i));
  std::size_t first = 0;
  for (const Sensor& sensor : model.sensors) {
    first_sensor_value_.push_back(first);
    first += at(sensor_width(sensor.kind));
  }
}

void OutputReader::read(std::span<double> to) {
  std::vector<std::size_t> all(list_.size());
  std::iota(all.begin(), all.end(), std::size_t{0});
  read(all, to);
}

void OutputReader::read(std::span<const std::size_t> outputs, std::span<double> to) {
  bool fresh = false;   // clearances are up to date
  int contact = kNone;  // contact of `reading`, which takes some microseconds for each closed pair
  ContactReading reading;
  for (const std::size_t i : outputs) {
    const Output& output = list_[i];
    const std::span<double> own = to.subspan(output.first, output.columns.size());
    if (is_of_body(output.kind)) {
      read_body(output, own);
    } else if (is_of_joint(output.kind)) {
      read_joint(output, own);
    } else if (is_of_element(output.kind)) {
      read_element(output, own);
    } else if (is_of_contact(output.kind)) {
      if (is_of_reading(output.kind) && output.subject != contact) {
        contact = output.subject;
        reading = calc_contact(simulation_.plan(), simulation_.state(), contact);
      }
      read_contact(output, reading, own);
    } else if (output.kind == Kind::kSensor) {
      put(simulation_.workspace().sensors.subspan(first_sensor_value_[at(output.subject)], own.size()), own);
    } else if (output.kind == Kind::kReceived) {
      read_received(output, own);
    } else if (output.kind == Kind::kQuantity) {
      own[0] = simulation_.workspace().quantities[at(output.subject)];
    } else if (output.kind == Kind::kSignal) {
      own[0] = simulation_.state().signals[at(output.subject)];
    } else if (output.kind == Kind::kCommand) {
      own[0] = simulation_.channels()[at(output.subject)];
    } else {
      if (!fresh) update_clearances();
      fresh = true;
      own[0] = clearances_.get()[at(output.subject)].now;
    }
  }
}

void OutputReader::read_body(const Output& output, std::span<double> to) const {
  const State& state = simulation_.state();
  const BodyState& body = state.bodies[at(output.subject)];
  switch (output.kind) {
    case Kind::kPosition:
      return put(body.p, to);
    case Kind::kAttitude:
      to[0] = body.q.w;
      to[1] = body.q.x;
      to[2] = body.q.y;
      to[3] = body.q.z;
      return;
    case Kind::kVelocity:
      return put(body.v, to);
    case Kind::kRate:
      return put(body.w, to);
    case Kind::kAcceleration:
      return put(simulation_.workspace().accelerations[at(output.subject)].lin, to);
    case Kind::kAngularAcceleration:  // d(Rᵀw)/dt = Rᵀ dw/dt
      return put(
          transpose_times(rotation_matrix(body.q), simulation_.workspace().accelerations[at(output.subject)].ang), to);
    case Kind::kModal:
      return put(get_modal_coordinates(simulation_.plan(), state, output.subject), to);
    default:
      return put(get_modal_rates(simulation_.plan(), state, output.subject), to);
  }
}

void OutputReader::read_joint(const Output& output, std::span<double> to) const {
  const State& state = simulation_.state();
  const std::size_t joint = at(output.subject);
  if (output.kind == Kind::kMode) {
    to[0] = static_cast<double>(state.joints[joint].mode);
    return;
  }
  const JointGeometry& geometry = joints_[joint];
  const auto body = [&](int i) { return i < 0 ? get_rest() : state.bodies[at(i)]; };
  const BodyState base = body(geometry.get_base()), follower = body(geometry.get_follower());
  for (int k = 0; k < 3; ++k) {
    double& value = to[at(k)];
    switch (output.kind) {
      case Kind::kForce:
        value = simulation_.workspace().multipliers.get(joint, at(kX + k));
        break;
      case Kind::kMoment:
        value = simulation_.workspace().multipliers.get(joint, at(kRotX + k));
        break;
      case Kind::kDisplacement:
        value = geometry.calc_coordinate(base, follower, kX + k);
        break;
      case Kind::kAngle:
        value = geometry.calc_coordinate(base, follower, kRotX + k);
        break;
      case Kind::kSpeed:
        value = geometry.calc_speed(base, follower, kX + k);
        break;
      default:
        value = geometry.calc_speed(base, follower, kRotX + k);
    }
  }
}

void OutputReader::read_element(const Output& output, std::span<double> to) const {
  const ElementReading reading = calc_element(simulation_.plan(), simulation_.workspace(), output.subject);
  switch (output.kind) {
    case Kind::kElementForce:
      to[0] = reading.force;
      break;
    case Kind::kElementStroke:
      to[0] = reading.stroke;
      break;
    case Kind::kElementWound:
      to[0] = reading.wound;
      break;
    case Kind::kElementOnDrum:
      to[0] = reading.on_drum;
      break;
    case Kind::kElementRate:
      to[0] = reading.rate;
      break;
    case Kind::kElementScale:
      to[0] = reading.scale;
      break;
    default:
      to[0] = reading.length;
  }
}

// The values as last sampled, which a State carries, but for those that were recorded as others.
void OutputReader::read_received(const Output& output, std::span<double> to) const {
  const std::size_t first = first_sensor_value_[at(output.subject)];
  put(simulation_.get_sensors().subspan(first, to.size()), to);
  for (const LogReceived& one : received_)
    if (one.value >= 0 && at(one.value) >= first && at(one.value) < first + to.size())
      to[at(one.value) - first] = one.received;
}

void OutputReader::read_contact(const Output& output, const ContactReading& reading, std::span<double> to) const {
  const ContactTotals totals = get_contact_totals(simulation_.plan(), simulation_.state(), output.subject);
  switch (output.kind) {
    case Kind::kContactForce:
      to[0] = reading.normal;
      break;
    case Kind::kContactFriction:
      to[0] = reading.friction;
      break;
    case Kind::kContactDepth:
      to[0] = reading.depth;
      break;
    case Kind::kContactSlipSpeed:
      to[0] = reading.slip;
      break;
    case Kind::kContactImpulse:
      to[0] = totals.impulse;
      break;
    case Kind::kContactSlip:
      to[0] = totals.slip;
      break;
    default:
      to[0] = totals.dissipated;
  }
}

void OutputReader::update_clearances() {
  for (std::size_t i = 0; i < poses_.size(); ++i) {
    const BodyState& body = simulation_.state().bodies[i];
    poses_[i].p_WB = {body.p.x, body.p.y, body.p.z};
    poses_[i].q_WB = {body.q.w, body.q.x, body.q.y, body.q.z};
  }
  clearances_.update(simulation_.get_time(), poses_);
}

const std::string& OutputReader::get_mode_name(const Output& output, double value) const {
  return scenario_.model.joints[at(output.subject)].modes[static_cast<std::size_t>(value)].name;
}

}  // namespace unlatch::hil
