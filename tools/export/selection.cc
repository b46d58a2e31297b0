#include "tools/export/selection.h"

#include <algorithm>
#include <set>
#include <stdexcept>

namespace unlatch::tools {

std::vector<hil::SelectedOutputs> keep_bodies(std::vector<hil::SelectedOutputs> groups, const hil::Scenario& scenario,
                                              std::span<const hil::Output> list,
                                              const std::vector<std::string>& bodies) {
  for (const std::string& name : bodies)
    if (std::ranges::none_of(scenario.model.bodies, [&name](const Body& body) { return body.name == name; }))
      throw std::invalid_argument("there is no body '" + name + "' in scenario '" + scenario.name + "'");
  if (bodies.empty()) return groups;
  for (hil::SelectedOutputs& group : groups)
    std::erase_if(group.outputs, [&](std::size_t i) {
      return list[i].group == "body" && std::ranges::find(bodies, list[i].of) == bodies.end();
    });
  return groups;
}

Selection::Selection(const hil::Scenario& scenario, const hil::Simulation& simulation,
                     std::vector<hil::SelectedOutputs> groups, std::int64_t last_tick, hil::SensorsShown shown,
                     const hil::RunAnalysis* analysis)
    : scenario_(scenario),
      simulation_(simulation),
      reader_(scenario, simulation, shown),
      groups_(std::move(groups)),
      last_tick_(last_tick),
      analysis_(analysis),
      is_due_(reader_.list().size()),
      values_(reader_.count_values()) {
  std::set<std::size_t> all;
  for (const hil::SelectedOutputs& group : groups_) all.insert(group.outputs.begin(), group.outputs.end());
  outputs_.assign(all.begin(), all.end());
}

bool Selection::look(const StepReport& report, std::span<const hil::EventMessage> session) {
  if (events_are_out_) events_.clear();
  events_are_out_ = false;
  if (analysis_ != nullptr)
    while (seen_ < analysis_->timeline.size()) events_.push_back(analysis_->timeline[seen_++]);
  for (const FiredEvent& fired : report.events) {
    if (analysis_ != nullptr) break;
    const unlatch::Event& event = scenario_.model.events[static_cast<std::size_t>(fired.event)];
    events_.push_back({fired.time, event.name, event.subject});
  }
  for (const hil::EventMessage& event : session)
    events_.push_back({event.time, std::string(hil::get_name(event.name)), std::string(hil::get_name(event.subject))});
  if (!session.empty()) std::ranges::stable_sort(events_, {}, &hil::TimelineEntry::time);
  return begin_tick(out_tick_ < 0 || simulation_.get_tick() == last_tick_);
}

bool Selection::look_at_end() { return out_tick_ != simulation_.get_tick() && begin_tick(true); }

bool Selection::begin_tick(bool all) {
  const std::int64_t tick = simulation_.get_tick();
  bool any = all;
  std::fill(is_due_.begin(), is_due_.end(), false);
  for (const hil::SelectedOutputs& group : groups_) {
    if (!all && !group.rate.is_due(tick)) continue;
    any = true;
    for (const std::size_t i : group.outputs) is_due_[i] = true;
  }
  if (!any) return false;
  due_.clear();
  for (const std::size_t i : outputs_)
    if (is_due_[i]) due_.push_back(i);
  reader_.read(due_, values_);
  out_tick_ = tick;
  events_are_out_ = true;
  return true;
}

}  // namespace unlatch::tools
