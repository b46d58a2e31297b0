#include "hil/analysis/run_analysis.h"

#include <algorithm>
#include <cmath>

namespace unlatch::hil {

RunAnalysis::RunAnalysis(const Scenario& scenario, Simulation& simulation, std::vector<std::int64_t> samples_in)
    : peaks(scenario.model.joints.size()),
      scenario_(scenario),
      simulation_(simulation),
      sample_ticks_(std::move(samples_in)),
      clearance_(scenario),
      contacts_(scenario, simulation),
      requirements_(scenario, clearance_, contacts_),
      separations_(scenario),
      accuracy_(scenario, simulation) {
  std::sort(sample_ticks_.begin(), sample_ticks_.end());
  simulation.keep_motion();
}

void RunAnalysis::update(const StepReport& report) {
  accuracy_.update(report);
  audits.insert(audits.end(), report.audits.begin(), report.audits.end());
  postponed += report.postponed;

  update_shared(report);

  const double time = simulation_.get_time();
  for (std::size_t joint = 0; joint < peaks.size(); ++joint) {
    for (std::size_t row = 0; row < kRows; ++row) {
      const double value = simulation_.workspace().multipliers[joint * kRows + row];
      if (std::abs(value) > std::abs(peaks[joint][row].value)) peaks[joint][row] = {value, time};
    }
  }
  if (report.substeps == 0) {
    clearance_.begin(time, simulation_.state().bodies);
    contacts_.begin(simulation_.state());
  } else {
    add_motion(report.events);
  }
  for (; next_sample_ < sample_ticks_.size() && sample_ticks_[next_sample_] <= simulation_.get_tick(); ++next_sample_) {
    if (sample_ticks_[next_sample_] == simulation_.get_tick()) take_sample();
  }
}

// Which rows are redundant changes only with their number and with events. At first no step has told it.
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

// Pieces of motion between the knots of the step; a knot that begins anew within it is just after events.
void RunAnalysis::add_motion(std::span<const FiredEvent> events) {
  const std::span<const MotionKnot> knots = simulation_.get_motion();
  for (std::size_t i = 1; i < knots.size(); ++i) {
    const MotionKnot &from = knots[i - 1], &to = knots[i];
    if (!to.begins) {
      window_.move_on(from, to);
      clearance_.add(window_);
      contacts_.add(window_, from, to);
      requirements_.add_piece(window_, from, to);
      separations_.add_piece(window_, from, to);
      continue;
    }
    contacts_.add_events(from, to);
    std::size_t count = 0;
    while (count < events.size() && events[count].time == to.time) add_event(events[count++], to);
    separations_.add_events(from, to, clearance_);
    requirements_.add_events(events.first(count), from, to);
    events = events.subspan(count);
  }
}

void RunAnalysis::add_event(const FiredEvent& fired, const MotionKnot& after) {
  const Model& model = scenario_.model;
  const Event& event = model.events[static_cast<std::size_t>(fired.event)];
  timeline.push_back({fired.time, event.name, event.subject});
  for (const Action& action : event.then) {
    if (action.kind != Action::Kind::kSetMode) continue;
    const Joint& joint = model.joints[static_cast<std::size_t>(action.subject)];
    if (joint.modes[static_cast<std::size_t>(action.mode)].rows != 0) continue;
    const auto body = static_cast<std::size_t>(joint.follower);
    const std::string base = joint.base == kGround ? "ground" : model.bodies[static_cast<std::size_t>(joint.base)].name;
    tip_offs.push_back({fired.time, model.bodies[body].name, base, joint.name, after.state.bodies[body].w});
  }
}

void RunAnalysis::take_sample() {
  Sample& sample = samples.emplace_back();
  sample.tick = simulation_.get_tick();
  sample.time = simulation_.get_time();
  sample.bodies.assign(simulation_.state().bodies.begin(), simulation_.state().bodies.end());
  sample.modal.resize(sample.bodies.size());
  for (std::size_t b = 0; b < sample.modal.size(); ++b) {
    const std::span<const double> eta =
        get_modal_coordinates(simulation_.plan(), simulation_.state(), static_cast<int>(b));
    sample.modal[b].assign(eta.begin(), eta.end());
  }
  for (std::size_t i = 0; i < scenario_.model.joints.size(); ++i) {
    const Joint& joint = scenario_.model.joints[i];
    const JointMode& mode = joint.modes[static_cast<std::size_t>(simulation_.state().joints[i].mode)];
    ReactionSample& reaction = sample.reactions.emplace_back();
    reaction.joint = joint.name;
    reaction.mode = mode.name;
    reaction.rows = mode.rows;
    for (std::size_t row = 0; row < kRows; ++row) {
      reaction.multipliers[row] = simulation_.workspace().multipliers[i * kRows + row];
    }
  }
}

std::int64_t calc_nearest_tick(double time, double dt) { return std::llround(time / dt); }

}  // namespace unlatch::hil
