#include "hil/run/analysis/run_analysis.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "hil/run/analysis/event_rounds.h"
#include "hil/run/analysis/extreme_verdict.h"
#include "hil/run/analysis/step_uncertainty.h"
#include "hil/run/audit/step_audit.h"
#include "hil/run/notices/format.h"
#include "hil/scenario/base/index.h"
#include "unlatch/quantities.h"

namespace unlatch::hil {

RunAnalysis::RunAnalysis(const Scenario& scenario, Simulation& simulation, const AnalysisRequest& request)
    : scenario_(scenario),
      simulation_(simulation),
      request_(request),
      clearance_(scenario),
      contacts_(scenario, simulation, request.touches),
      peaks_(scenario.model.joints.size()),
      requirements_(scenario, simulation, clearance_, contacts_),
      separations_(scenario, request.pushes),
      accuracy_(scenario, simulation, request.accuracy),
      unseen_clearances_(scenario),
      unseen_crossings_(scenario.model),
      unseen_engagements_(scenario.model) {
  for (const UnsearchedEvent& unsearched : list_unsearched(scenario.model)) accuracy_.report_unsearched(unsearched);
  simulation.keep_motion();
}

void RunAnalysis::update(const StepReport& report, std::span<const LogReceived> received) {
  accuracy_.update(report);
  audits.insert(audits.end(), report.audits.begin(), report.audits.end());
  search.postponed += report.postponed;
  search.unlocated += report.open.unlocated;
  search.corners += report.open.corners;
  search.unseen += report.open.unseen;

  if (request_.redundancy) update_shared(report);

  if (report.substeps == 0) {
    clearance_.begin(simulation_.get_time(), simulation_.state().bodies);
    contacts_.begin(simulation_.get_time(), simulation_.state());
    peaks_.begin(simulation_.get_time(), simulation_.workspace().multipliers);
  } else {
    requirements_.begin_step(report);
    if (report.settled > 0) contacts_.add_settled(report.settled, simulation_.get_motion());
    add_motion(report.events);
  }
  add_received(received);
}

void RunAnalysis::add_received(std::span<const LogReceived> received) {
  received_.assign(simulation_.get_sensors().begin(), simulation_.get_sensors().end());
  for (const LogReceived& one : received)
    if (one.value >= 0 && static_cast<std::size_t>(one.value) < received_.size())
      received_[static_cast<std::size_t>(one.value)] = one.received;
  requirements_.add_received(simulation_.get_time(), received_);
}

// Updates the shared reactions. The set of redundant rows changes only with their number and with events. At first no
// step has reported it.
void RunAnalysis::update_shared(const StepReport& report) {
  const double time = simulation_.get_time();
  if (!redundant_ || *redundant_ != report.redundant || !report.events.empty()) {
    std::vector<RedundantRows> now =
        list_redundant_rows(simulation_.plan(), simulation_.state(), simulation_.workspace());
    for (SharedReactions& entry : shared)
      entry.lasts =
          entry.lasts && std::erase_if(now, [&](const RedundantRows& rows) { return rows == entry.rows; }) > 0;
    for (RedundantRows& rows : now) shared.push_back({std::move(rows), time, time, true});
    redundant_ = report.redundant;
  }
  for (SharedReactions& entry : shared)
    if (entry.lasts) entry.until = time;
}

// Adds the pieces of motion between the knots of the step; a knot that begins anew inside the step is just after
// events.
void RunAnalysis::add_motion(std::span<const FiredEvent> events) {
  const std::span<const MotionKnot> knots = simulation_.get_motion();
  const std::span<const double> inputs = simulation_.get_inputs();
  bool switched = !std::ranges::equal(inputs, inputs_);
  inputs_.assign(inputs.begin(), inputs.end());
  std::size_t done = 0;
  for (std::size_t i = 1; i < knots.size(); ++i) {
    const MotionKnot &from = knots[i - 1], &to = knots[i];
    if (!to.begins) {
      window_.move_on(from, to);
      clearance_.add(window_);
      contacts_.add(window_, from, to);
      if (request_.reactions) peaks_.add(from, to, window_.is_smooth() && !switched);
      requirements_.add_piece(window_, from, to, inputs, switched);
      switched = false;
      separations_.add_piece(window_, from, to);
      for (const UnseenClearance& unseen : unseen_clearances_.find(window_))
        if (from.state.events[at(unseen.event)].phase == EventPhase::kArmed) accuracy_.report_unseen(unseen);
      for (const UnseenCrossing& unseen : unseen_crossings_.find(window_, from, to, simulation_.get_inputs()))
        accuracy_.report_unseen(unseen);
      for (const LostTrigger& lost : unseen_crossings_.find_lost(from, to, inputs)) accuracy_.report_lost(lost);
      for (const UnseenEngagement& unseen : unseen_engagements_.find(window_, from, to))
        accuracy_.report_unseen(unseen);
      continue;
    }
    switched = switched || is_switched(from, to);
    contacts_.add_events(from, to);
    std::size_t count = 0;
    while (count < events.size() && events[count].time == to.time) {
      const bool has_piece = i > 1 && !from.begins;
      add_event(events[count++], has_piece ? &knots[i - 2] : nullptr, from, to);
    }
    separations_.add_events(from, to, clearance_);
    requirements_.add_events(list_rounds(events.first(count), done, from, to, simulation_.get_rounds()));
    events = events.subspan(count);
    done += count;
  }
}

// Of the touch or lift of a contact, the pairs of shapes that close or open.
std::string RunAnalysis::list_shapes(const Event& event, const MotionKnot& before, const MotionKnot& after) const {
  const std::vector<Contact>& contacts = scenario_.model.contacts;
  const bool touches = event.name == "touch";
  if (!touches && event.name != "lift") return {};
  const auto found = std::ranges::find(contacts, event.subject, &Contact::name);
  if (found == contacts.end()) return {};
  const auto number = static_cast<std::size_t>(found - contacts.begin());
  std::string text;
  for (const std::string& pair : touches ? contacts_.list_closing(before.state, after.state, number)
                                         : contacts_.list_closing(after.state, before.state, number))
    text += (text.empty() ? "" : ", ") + pair;
  return text;
}

namespace {

// The quantity for which an event waits, if it is one, and acts at once.
std::optional<int> find_awaited(const Event& event) {
  if (event.when.kind != Condition::Kind::kQuantity || event.delay > 0) return {};
  return event.when.subject;
}

}  // namespace

void RunAnalysis::add_event(const FiredEvent& fired, const MotionKnot* earlier, const MotionKnot& before,
                            const MotionKnot& after) {
  const Model& model = scenario_.model;
  const Event& event = model.events[static_cast<std::size_t>(fired.event)];
  double rate = 0;
  if (const auto awaited = find_awaited(event); awaited && earlier != nullptr && before.time > earlier->time)
    rate = (before.quantities[at(*awaited)] - earlier->quantities[at(*awaited)]) / (before.time - earlier->time);
  timeline.push_back({fired.time, event.name, event.subject, list_shapes(event, before, after), fired.event, rate});
  for (const Action& action : event.then) {
    if (action.kind != Action::Kind::kSetMode) continue;
    const Joint& joint = model.joints[static_cast<std::size_t>(action.subject)];
    if (joint.modes[static_cast<std::size_t>(action.mode)].rows != 0) continue;
    const auto body = static_cast<std::size_t>(joint.follower);
    const std::string base = joint.base == kGround ? "ground" : model.bodies[static_cast<std::size_t>(joint.base)].name;
    tip_offs.push_back({fired.time, model.bodies[body].name, base, joint.name, after.state.bodies[body].w});
  }
}

namespace {

// Error of the steps, in parts of the motion, from which on it may be more than the verdict's margin.
double calc_doubtful_part(const Verdict& verdict) {
  constexpr double kLeast = 1e-5;  // of the motion: less is no reason for doubt, however small the margin
  const double size = std::max(std::abs(verdict.value), std::abs(verdict.limit));
  return size > 0 ? std::max(kLeast, std::abs(verdict.margin) / (StepAudit::kPhase * size)) : HUGE_VAL;
}

// The contact of whose slip's path the requirement is.
std::optional<int> find_slipping_contact(const Model& model, const Requirement& requirement) {
  if (requirement.quantity == Requirement::Measure::kContact)
    return static_cast<Requirement::ContactValue>(requirement.axis) == Requirement::ContactValue::kSlip
               ? std::optional(requirement.a)
               : std::nullopt;
  if (requirement.quantity != Requirement::Measure::kQuantity) return {};
  const unlatch::Quantity& quantity = model.quantities[at(requirement.a)];
  return quantity.kind == unlatch::Quantity::Kind::kContactSlip ? std::optional(quantity.subject) : std::nullopt;
}

// Whether the limit lies within a verdict's uncertainty.
bool may_differ(const Verdict& verdict) {
  return verdict.is_uncertain() && std::abs(verdict.margin) < verdict.uncertainty;
}
// Whether the uncertainty is more than kKnown allows.
bool is_unknown(const Verdict& verdict) {
  return verdict.uncertainty > kKnown * std::max(std::abs(verdict.value), kLimitPart * std::abs(verdict.limit));
}

}  // namespace

double RunAnalysis::calc_time_uncertainty(const TimelineEntry& entry) const {
  if (entry.event == kNone || entry.rate == 0) return 0;
  const std::optional<int> awaited = find_awaited(scenario_.model.events[at(entry.event)]);
  if (!awaited) return 0;
  const unlatch::Quantity& quantity = scenario_.model.quantities[at(*awaited)];
  Requirement requirement;
  requirement.quantity = Requirement::Measure::kQuantity;
  requirement.a = *awaited;
  requirement.unit = get_unit(scenario_.model, quantity);
  const double threshold = scenario_.model.events[at(entry.event)].when.threshold;
  return calc_step_uncertainty(scenario_.model, requirement, threshold, entry.time, accuracy_.get_steps()) /
         std::abs(entry.rate);
}

double RunAnalysis::calc_time_uncertainty(const Requirement& requirement, double time) const {
  double sum = 0;
  for (std::size_t i = 0; i < requirement.events.size(); ++i) {
    const EventName& instant = requirement.events[i];
    const bool is_timed = requirement.quantity == Requirement::Measure::kTime && i == 0;  // which occurrence it is
    const auto entry = std::ranges::find_if(timeline, [&](const TimelineEntry& own) {
      return own.event == instant.event && (!is_timed || own.time == time);
    });
    if (instant.event != kNone && entry != timeline.end()) sum += calc_time_uncertainty(*entry);
  }
  return sum;
}

std::vector<Verdict> RunAnalysis::judge() const {
  std::vector<Verdict> verdicts = requirements_.judge(window_);
  const UnresolvedBodies unresolved = accuracy_.get_unresolved();
  const StepError worst = accuracy_.get_steps().find_worst();
  const double largest = worst.error / worst.change;
  for (Verdict& verdict : verdicts) {
    const Requirement& requirement = scenario_.requirements[verdict.requirement];
    // A value of an instant depends on what came before it; a search over an interval, on all of it.
    const bool is_instant = verdict.evaluated && (requirement.at.is_named() || requirement.is_of_events());
    const double until = is_instant ? verdict.time : requirements_.get_end(verdict.requirement);
    std::string cause = unresolved.find_cause(requirement, until, verdict.evaluated ? verdict.time : HUGE_VAL);
    // What is not resolved may be wrong by any amount: what steps or polynomials show is no bound.
    if (!cause.empty() && verdict.evaluated) verdict.uncertainty = std::numeric_limits<double>::infinity();
    if (cause.empty() && verdict.evaluated && verdict.is_resolved() && !requirement.is_of_events())
      if (const double part = calc_doubtful_part(verdict); part < StepAudit::kLimit && largest > part)
        cause = accuracy_.get_doubtful(part).find_cause(requirement, until, verdict.time);
    if (!cause.empty()) verdict.unresolved = std::move(cause);
    if (!verdict.evaluated || !verdict.is_error_known() || requirement.quantity == Requirement::Measure::kOrder)
      continue;
    const double of_steps =
        requirement.is_of_events()
            ? calc_time_uncertainty(requirement, verdict.time)
            : calc_step_uncertainty(scenario_.model, requirement, verdict.value, until, accuracy_.get_steps());
    // Of errors of the steps that are large, whatever the limit, accuracy_ has decided above.
    if (of_steps > Verdict::kExact * std::abs(verdict.value)) {
      verdict.uncertainty += of_steps;
      if (verdict.is_resolved() && may_differ(verdict))
        verdict.unresolved = format(
            "the steps make an error of some %.2g in %.6g, as those show that were taken again as two halves; a "
            "smaller step would do",
            of_steps, verdict.value);
    }
    if (const auto contact = find_slipping_contact(scenario_.model, requirement)) {
      verdict.uncertainty += contacts_.get_slip_uncertainty(*contact);
      if (verdict.is_resolved() && (may_differ(verdict) || is_unknown(verdict)))
        verdict.unresolved = format(
            "its bounces ended, and how long it would have flown meanwhile, without a slip, is not known: %.6g m is "
            "known to %.2g m only; a smaller `settle`, or a smaller step, would do",
            verdict.value, verdict.uncertainty);
    }
  }
  return verdicts;
}

std::int64_t calc_nearest_tick(double time, double dt) { return std::llround(time / dt); }

}  // namespace unlatch::hil
