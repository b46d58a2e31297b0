#include "hil/analysis/run_analysis.h"

#include <algorithm>
#include <cmath>

namespace unlatch::hil {

RunAnalysis::RunAnalysis(const Scenario& scenario, const Simulation& simulation, std::vector<std::int64_t> samples_in)
    : peaks(scenario.model.joints.size()),
      scenario_(scenario),
      simulation_(simulation),
      sample_ticks_(std::move(samples_in)),
      clearance_(scenario.clearance, scenario.shapes),
      poses_(scenario.model.bodies.size()),
      accuracy_(scenario, simulation) {
  std::sort(sample_ticks_.begin(), sample_ticks_.end());
}

void RunAnalysis::update(const StepReport& report) {
  accuracy_.update(report);
  for (const FiredEvent& fired : report.events) add_event(fired);
  audits.insert(audits.end(), report.audits.begin(), report.audits.end());
  postponed += report.postponed;

  const double time = simulation_.get_time();
  for (std::size_t joint = 0; joint < peaks.size(); ++joint) {
    for (std::size_t row = 0; row < kRows; ++row) {
      const double value = simulation_.workspace().multipliers[joint * kRows + row];
      if (std::abs(value) > std::abs(peaks[joint][row].value)) peaks[joint][row] = {value, time};
    }
  }
  if (!scenario_.clearance.empty()) {
    for (std::size_t i = 0; i < poses_.size(); ++i) {
      const BodyState& body = simulation_.state().bodies[i];
      poses_[i].p_WB = {body.p.x, body.p.y, body.p.z};
      poses_[i].q_WB = {body.q.w, body.q.x, body.q.y, body.q.z};
    }
    clearance_.update(time, poses_);
  }
  for (; next_sample_ < sample_ticks_.size() && sample_ticks_[next_sample_] <= simulation_.get_tick(); ++next_sample_) {
    if (sample_ticks_[next_sample_] == simulation_.get_tick()) take_sample();
  }
}

void RunAnalysis::add_event(const FiredEvent& fired) {
  const Model& model = scenario_.model;
  const Event& event = model.events[static_cast<std::size_t>(fired.event)];
  timeline.push_back({fired.time, event.name, event.subject});
  for (const Action& action : event.then) {
    if (action.kind != Action::Kind::kSetMode) continue;
    const Joint& joint = model.joints[static_cast<std::size_t>(action.subject)];
    if (joint.modes[static_cast<std::size_t>(action.mode)].rows != 0) continue;
    const auto body = static_cast<std::size_t>(joint.follower);
    const std::string base = joint.base == kGround ? "ground" : model.bodies[static_cast<std::size_t>(joint.base)].name;
    tip_offs.push_back({fired.time, model.bodies[body].name, base, joint.name, simulation_.state().bodies[body].w});
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
