#include "tools/export/selection.h"

#include <algorithm>
#include <numeric>
#include <stdexcept>

namespace unlatch::tools {

Selection::Selection(const hil::Scenario& scenario, const hil::Simulation& simulation,
                     const std::vector<std::string>& bodies, std::int64_t every)
    : scenario_(scenario),
      simulation_(simulation),
      every_(every),
      clearances_(scenario.clearance, scenario.shapes),
      poses_(scenario.model.bodies.size()) {
  const auto& all = scenario.model.bodies;
  for (const std::string& name : bodies) {
    const auto found = std::find_if(all.begin(), all.end(), [&name](const Body& body) { return body.name == name; });
    if (found == all.end()) {
      throw std::invalid_argument("there is no body '" + name + "' in scenario '" + scenario.name + "'");
    }
    bodies_.push_back(static_cast<std::size_t>(found - all.begin()));
  }
  if (bodies.empty()) {
    bodies_.resize(all.size());
    std::iota(bodies_.begin(), bodies_.end(), 0U);
  }
}

bool Selection::look(const StepReport& report) {
  if (events_are_out_) events_.clear();
  events_are_out_ = false;
  for (const FiredEvent& fired : report.events) {
    const unlatch::Event& event = scenario_.model.events[static_cast<std::size_t>(fired.event)];
    events_.push_back({fired.time, event.name, event.subject});
  }
  if (out_tick_ >= 0 && simulation_.get_tick() % every_ != 0) return false;
  begin_tick();
  return true;
}

bool Selection::look_at_end() {
  if (out_tick_ == simulation_.get_tick()) return false;
  begin_tick();
  return true;
}

void Selection::begin_tick() {
  out_tick_ = simulation_.get_tick();
  events_are_out_ = true;
  if (scenario_.clearance.empty()) return;
  for (std::size_t i = 0; i < poses_.size(); ++i) {
    const unlatch::BodyState& body = simulation_.state().bodies[i];
    poses_[i].p_WB = {body.p.x, body.p.y, body.p.z};
    poses_[i].q_WB = {body.q.w, body.q.x, body.q.y, body.q.z};
  }
  clearances_.update(simulation_.get_time(), poses_);
}

const JointMode& Selection::get_mode(std::size_t joint) const {
  return scenario_.model.joints[joint].modes[static_cast<std::size_t>(simulation_.state().joints[joint].mode)];
}

std::span<const double> Selection::get_modal(std::size_t body) const {
  return get_modal_coordinates(simulation_.plan(), simulation_.state(), static_cast<int>(body));
}

}  // namespace unlatch::tools
