#include "hil/run/audit/energy_audit.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>

#include "unlatch/model/law_places.h"

namespace unlatch::hil {
namespace {

constexpr std::size_t kAlignment = 64;
constexpr double kStill = 1e-6;  // m/s: the energy of slower bodies is not judged; for bodies at rest it is rounding

std::span<std::byte> align(std::vector<std::byte>& memory, std::size_t bytes) {
  void* first = memory.data();
  std::size_t space = memory.size();
  return {static_cast<std::byte*>(std::align(kAlignment, bytes, first, space)), bytes};
}

std::vector<int> find_implicit(const Simulation& simulation, Workspace& workspace) {
  std::vector<int> elements;
  for (const ElementFrequency& element : calc_frequencies(simulation.plan(), simulation.state(), workspace))
    if (element.implicit) elements.push_back(element.element);
  return elements;
}

bool has_implicit_modes(const Model& model, double dt) {
  return std::any_of(model.bodies.begin(), model.bodies.end(), [dt](const Body& body) {
    return body.flexible && body.flexible->frequencies.size() > 0 &&
           dt * body.flexible->frequencies.maxCoeff() > kResolved;
  });
}

// Energy as the observer sees it who follows the centre of mass, or stands on the ground that holds the system. The
// centre's velocity is first that near it, then corrected.
struct Seen {
  EnergyFlow flow;
  AuditFrame frame;
};
Seen look(const Simulation& simulation) {
  const AuditFrame near = calc_audit_frame(simulation.plan(), simulation.state(), simulation.workspace());
  const EnergyFlow flow =
      calc_energy_flow(simulation.plan(), simulation.state(), simulation.workspace(), near.velocity);
  if (near.grounded) return {flow, near};
  const Vec3 rest = (1 / flow.mass) * flow.momentum;
  return {change_frame(flow, rest), {.grounded = false, .velocity = near.velocity + rest}};
}

// Kinetic energy that an event's actions may add, as seen from the centre of mass, which their impulses accelerate.
double calc_allowed_from_centre(const EventAudit& audit) {
  const Vec3 impulse = audit.allowed.momentum, mean = audit.flow_before.momentum + 0.5 * impulse;
  return audit.allowed.kinetic - dot(mean, impulse) / audit.flow_before.mass;
}

}  // namespace

EnergyAudit::EnergyAudit(const Simulation& simulation)
    : simulation_(simulation),
      implicit_modes_(has_implicit_modes(simulation.model(), simulation.plan().get_options().dt)),
      corners_(has_driving_corners(simulation.model())),
      memory_(simulation.plan().get_workspace_bytes() + kAlignment),
      workspace_(simulation.plan(), align(memory_, simulation.plan().get_workspace_bytes())),
      block_(simulation.plan().get_state_bytes() / sizeof(std::uint64_t)),
      before_(simulation.plan(), std::as_writable_bytes(std::span(block_))) {
  implicit_ = find_implicit(simulation, workspace_);
}

void EnergyAudit::update(const StepReport& report) {
  if (begun_)
    add_tick(report);
  else
    begin();
}

void EnergyAudit::begin() {
  begun_ = true;
  const auto [flow, frame] = look(simulation_);
  following_.begin(flow);
  keep(flow, frame);
}

EnergyFlow EnergyAudit::calc_start(bool& smooth) {
  const std::span<const double> inputs = simulation_.get_inputs();
  if (std::equal(inputs.begin(), inputs.end(), inputs_.begin(), inputs_.end())) return now_;
  smooth = false;
  if (update_outputs(simulation_.plan(), Inputs{inputs}, before_, workspace_) != StepStatus::kOk) return now_;
  return calc_energy_flow(simulation_.plan(), before_, workspace_, frame_.velocity);
}

bool EnergyAudit::is_implicit() const {
  const State& state = simulation_.state();
  return implicit_modes_ || std::any_of(implicit_.begin(), implicit_.end(), [&state](int element) {
           const ElementState& s = state.elements[static_cast<std::size_t>(element)];
           return s.from != 0 || s.to != 0;
         });
}

bool EnergyAudit::has_corner(double from, double to) const {
  const std::vector<Load>& loads = simulation_.model().loads;
  for (std::size_t i = 0; i < loads.size(); ++i) {
    const ElementState& on = simulation_.state().elements[i];
    if (loads[i].profile.kind != Profile::Kind::kTable || (on.from == 0 && on.to == 0)) continue;
    const std::vector<double>& times = loads[i].profile.times;
    const auto knot = std::lower_bound(times.begin(), times.end(), from - on.switched_on);
    if (knot != times.end() && *knot <= to - on.switched_on) return true;
  }
  return false;
}

void EnergyAudit::add_tick(const StepReport& report) {
  const double dt = simulation_.plan().get_options().dt, end = simulation_.get_time();
  const auto [flow, frame] = look(simulation_);
  const bool grounded = frame_.grounded || frame.grounded;
  const bool corner = has_corner(end - dt, end) || std::ranges::any_of(simulation_.get_motion(), &MotionKnot::corner);
  bool smooth = report.audits.empty() && !corner && !(corners_ && report.substeps > 1);
  const EnergyFlow start = calc_start(smooth);
  if (grounded != grounded_) following_.forget();
  const bool implicit = is_implicit();
  const auto add = [&](const auto& see, const auto& see_event, const auto& calc_allowed) {
    const EnergyFlow from = see(start, frame_), reached = see(flow, frame);
    following_.begin_tick(smooth);
    EnergyFlow last = from;
    double time = end - dt;
    for (const EventAudit& audit : report.audits) {
      following_.add_piece(last, see_event(audit.flow_before), audit.time - time);
      following_.add_impulse(calc_allowed(audit));
      last = see_event(audit.flow_after);
      time = audit.time;
    }
    following_.add_piece(last, reached, end - time);
    following_.finish_tick(from, reached, implicit, end);
  };
  if (grounded)
    add([](const EnergyFlow& seen, const AuditFrame& from) { return change_frame(seen, -from.velocity); },
        [](const EnergyFlow& seen) { return seen; }, [](const EventAudit& audit) { return audit.allowed.kinetic; });
  else
    add([](const EnergyFlow& seen, const AuditFrame&) { return seen; },
        [](const EnergyFlow& seen) { return change_frame(seen, (1 / seen.mass) * seen.momentum); },
        calc_allowed_from_centre);
  grounded_ = grounded;
  keep(flow, frame);
}

void EnergyAudit::keep(const EnergyFlow& flow, const AuditFrame& frame) {
  now_ = flow;
  frame_ = frame;
  const std::span<const std::byte> bytes = simulation_.state().get_bytes();
  std::memcpy(block_.data(), bytes.data(), bytes.size());
  inputs_.assign(simulation_.get_inputs().begin(), simulation_.get_inputs().end());
}

void EnergyObserver::begin(const EnergyFlow& flow) {
  balance_.scale = std::max(flow.kinetic + flow.strain, 0.5 * flow.mass * kStill * kStill);
}

void EnergyObserver::begin_tick(bool smooth) {
  tick_work_ = 0;
  smooth_ = smooth;
  if (!smooth) known_ = 0;
}

void EnergyObserver::add_piece(const EnergyFlow& from, const EnergyFlow& to, double h) {
  if (known_ > 0)
    add_smooth(from, to, h);
  else
    add_trapezoid(from, to, h);
  // Losses of contacts need no integral over time: contacts accumulate them.
  balance_.strain += from.strain - to.strain;
  balance_.contacts += from.dissipated - to.dissipated;
  tick_work_ += (from.strain - to.strain) + (from.dissipated - to.dissipated);
}

void EnergyObserver::add_impulse(double kinetic) {
  balance_.impulses += kinetic;
  tick_work_ += kinetic;
}

void EnergyObserver::add_trapezoid(const EnergyFlow& from, const EnergyFlow& to, double h) {
  for (std::size_t i = 0; i < balance_.work.size(); ++i) {
    const double work = 0.5 * h * (from.power[i] + to.power[i]);
    balance_.work[i] += work;
    tick_work_ += work;
  }
}

void EnergyObserver::add_smooth(const EnergyFlow& from, const EnergyFlow& to, double h) {
  for (std::size_t i = 0; i < balance_.work.size(); ++i) {
    const double second = to.power[i] - 2 * from.power[i] + earlier_.power[i];
    double work = h / 12 * (5 * to.power[i] + 8 * from.power[i] - earlier_.power[i]);
    if (known_ > 1) work -= h / 24 * (second - (from.power[i] - 2 * earlier_.power[i] + oldest_.power[i]));
    balance_.work[i] += work;
    tick_work_ += work;
  }
}

void EnergyObserver::finish_tick(const EnergyFlow& start, const EnergyFlow& reached, bool implicit, double time) {
  const double gained = reached.kinetic - start.kinetic, unexplained = gained - tick_work_;
  balance_.kinetic += gained;
  (unexplained < 0 && implicit ? balance_.numerical : balance_.unexplained) += unexplained;
  balance_.scale = std::max(balance_.scale, reached.kinetic + reached.strain);
  if (!(std::abs(balance_.unexplained) <= std::abs(balance_.largest))) {
    balance_.largest = balance_.unexplained;
    balance_.largest_time = time;
  }
  oldest_ = earlier_;
  earlier_ = start;
  known_ = smooth_ ? std::min(known_ + 1, 2) : 0;
}

}  // namespace unlatch::hil
