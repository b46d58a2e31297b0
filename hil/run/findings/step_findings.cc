#include <algorithm>
#include <cstdint>
#include <limits>
#include <numbers>

#include "hil/run/findings/finding_parts.h"
#include "hil/run/notices/contact_resolution.h"
#include "hil/run/notices/format.h"
#include "hil/run/notices/friction_resolution.h"
#include "hil/run/notices/profile_watch.h"
#include "hil/run/notices/resolution.h"
#include "hil/scenario/base/index.h"
#include "hil/scenario/text/count.h"
#include "unlatch/contacts.h"
#include "unlatch/model/law_places.h"
#include "unlatch/redundancy.h"

namespace unlatch::hil {
namespace {

// Steps that a pusher's stroke, a ramp, a table's interval or a delay needs; ten of them locate its end to some 1e-3.
constexpr double kStepsToResolve = 10;

void add_short(const std::string& where, const char* what, double duration, double dt, std::vector<Finding>& findings) {
  if (!(duration > 0) || duration >= kStepsToResolve * dt) return;
  findings.push_back({"step", where,
                      format("%s takes %.4g s, %.2g steps of %.4g s: at least %.0f resolve it", what, duration,
                             duration / dt, dt, kStepsToResolve)});
}

void judge_springs(const Model& model, const Simulation& simulation, double dt, std::vector<Finding>& findings) {
  for (const SpringResolution& spring : calc_resolutions(simulation)) {
    const std::string where = quoted("element", model.element_name(spring.element));
    const auto i = static_cast<std::size_t>(spring.element) - model.loads.size();
    if (i < model.point_springs.size() && model.point_springs[i].push_only && spring.largest_omega > 0)
      add_short(where, "its stroke, a quarter of its period,", 0.5 * std::numbers::pi / spring.largest_omega, dt,
                findings);
    const double worst = dt * spring.get_worst();
    if (worst > kAccurate)
      findings.push_back(
          {"step", where,
           format("h*omega or h*decay comes to %.3g%s%s%s: %s", worst, spring.where.empty() ? "" : " with ",
                  spring.where.c_str(), spring.implicit ? ", implicitly" : "",
                  spring.implicit   ? "second order, damps what the step does not resolve"
                  : worst > kStable ? "unstable; make the step smaller, or the element softer"
                                    : "stable, but not resolved accurately")});
  }
}

void judge_loads(const Model& model, double dt, std::vector<Finding>& findings) {
  for (const Load& load : model.loads) {
    const std::vector<double>& times = load.profile.times;
    constexpr std::size_t kMost = kMostCorners;  // points in a step that is split at them
    double shortest = std::numeric_limits<double>::infinity();
    for (std::size_t i = kMost; i < times.size(); ++i) shortest = std::min(shortest, times[i] - times[i - kMost]);
    if (load.profile.kind == Profile::Kind::kTable && shortest < dt)
      findings.push_back(
          {"step", quoted("element", load.name),
           format("its table has %s within %.4g s; a step of %.4g s is split at %d at most, and passes over more",
                  count(kMostCorners + 1, "point").c_str(), shortest, dt, kMostCorners)});
    if (const double frequency = find_frequency(load.profile); dt * frequency > kSineAngle)
      findings.push_back(
          {"step", quoted("element", load.name),
           format("its sine of %.4g rad/s turns by %.3g rad in a step of %.4g s, which resolves %.2g: a step of %.3g s "
                  "would do",
                  frequency, dt * frequency, dt, kSineAngle, kRoundedDown * kUnresolvedSize / frequency)});
    if (load.profile.kind == Profile::Kind::kExponential && load.profile.tau < dt / kAccurate)
      findings.push_back(
          {"step", quoted("element", load.name),
           format("its time constant, %.4g s, is less than five steps of %.4g s", load.profile.tau, dt)});
  }
}

void judge_contacts(const Model& model, const Simulation& simulation, double dt, std::vector<Finding>& findings) {
  for (std::size_t i = 0; i < model.contacts.size(); ++i) {
    const Contact& contact = model.contacts[i];
    const std::string where = quoted("contact", contact.name);
    const ContactReading reading = calc_contact(simulation.plan(), simulation.state(), static_cast<int>(i));
    if (reading.closed && contact.rigid)
      findings.push_back({"contact", where, format("bears %.4g N at the start: that is no touch", reading.normal)});
    if (contact.rigid) continue;  // no step resolves it the better
    if (reading.closed)
      findings.push_back(
          {"contact", where, format("is closed at the start, %.4g m deep: that is no touch", reading.depth)});
    const double speed = estimate_speed(model, simulation.state(), contact);
    ContactRates rates = reading.closed ? calc_rates(model, simulation.state(), contact, reading)
                                        : estimate_rates(model, contact, speed);
    // Friction acts beside the centre of mass, so that it also turns the bodies.
    if (!reading.closed && rates.decay > 0)
      rates.decay *= calc_most_mobility(model, contact) / calc_least_mobility(model, contact);
    const std::string text = describe_unresolved(rates, dt, get_most_contact_substeps(model));
    const bool of_speed = !reading.closed && (contact.exponent > 1 || contact.friction > 0);
    if (!text.empty())
      findings.push_back({"contact", where, text + (of_speed ? format(" (for a blow of %.3g m/s)", speed) : "")});
  }
}

void judge_frictions(const Model& model, const Simulation& simulation, double dt, std::vector<Finding>& findings) {
  if (!has_friction(model)) return;
  const std::vector<ElementMobility> mobilities = calc_mobilities(simulation);
  for (const FrictionRate& rate : calc_friction_rates(simulation, mobilities))
    if (const std::string text = describe_unresolved(rate, dt); !text.empty())
      findings.push_back({"friction", quoted("element", model.element_name(rate.element)), text});
}

void judge_turns(const Model& model, double dt, std::vector<Finding>& findings) {
  for (const Body& body : model.bodies) {
    const double size = body.w_WB_B.norm() * dt;
    if (!body.marker && size > kAccurate)
      findings.push_back(
          {"step", quoted("body", body.name), format("begins with |w|*h %.3g: beyond %.2g", size, kAccurate)});
  }
}

// What a real-time run may not keep up with: loops that are open at one body cost by their square.
void judge_loops(const Plan& plan, std::vector<Finding>& findings) {
  constexpr double kCostly = 10;  // times the solver's work without loops
  constexpr int kWide = 12;       // as many bolts of one flange cost little by themselves
  const LoopOverlap overlap = plan.get_loop_overlap();
  const LoopCost cost = calc_loop_cost(plan);
  const double times = static_cast<double>(cost.loops) / static_cast<double>(std::max<std::int64_t>(1, cost.tree));
  if (times < kCostly || overlap.widest <= kWide) return;
  findings.push_back(
      {"loops", "",
       format("of the closed loops, %d in all, at most %d are open at one body%s: they take the solver some %.0f times "
              "the work of the rest, so look whether a run keeps up",
              overlap.loops, overlap.widest,
              overlap.local ? "" : ", since a flexible body on the way of one leaves all to one dense matrix", times)});
}

}  // namespace

void add_step_findings(const Scenario& scenario, const Simulation& simulation, std::vector<Finding>& findings) {
  const Model& model = scenario.model;
  judge_springs(model, simulation, scenario.dt, findings);
  judge_loads(model, scenario.dt, findings);
  judge_contacts(model, simulation, scenario.dt, findings);
  judge_frictions(model, simulation, scenario.dt, findings);
  judge_turns(model, scenario.dt, findings);
  judge_loops(simulation.plan(), findings);
}

}  // namespace unlatch::hil
