#include <algorithm>

#include "tools/common/text.h"
#include "tools/unlatch/results/report.h"

namespace unlatch::tools {
namespace {

constexpr double kStayedLong_s = 0.1;  // beyond what a late command or a dispersed tail-off explains

std::string to_seconds(double time) { return format("%.3f s", time); }

void add_still_held(const RunReport& report, std::vector<std::string>& verdicts) {
  const Model& model = report.scenario.model;
  for (std::size_t i = 0; i < model.joints.size(); ++i) {
    const Joint& joint = model.joints[i];
    const auto& mode = joint.modes[static_cast<std::size_t>(report.simulation.state().joints[i].mode)];
    const auto is_free = [](const JointMode& candidate) { return candidate.rows == 0; };
    if (is_free(mode) || std::none_of(joint.modes.begin(), joint.modes.end(), is_free)) continue;
    verdicts.push_back(get_body_name(model, joint.follower, "the ground") + " stayed on " +
                       get_body_name(model, joint.base, "the ground") + ": " + joint.name + " is still in mode '" +
                       mode.name + "' at the end");
  }
}

// Compares the bodies that leave the same base. A body has left it when the last of the joints between the two is free.
void add_late_leavers(const std::vector<hil::TipOff>& tip_offs, std::vector<std::string>& verdicts) {
  const auto of_same_pair = [](const hil::TipOff& a, const hil::TipOff& b) {
    return a.body == b.body && a.base == b.base;
  };
  std::vector<hil::TipOff> leavers;
  for (const hil::TipOff& tip_off : tip_offs) {
    std::erase_if(leavers, [&](const hil::TipOff& earlier) { return of_same_pair(earlier, tip_off); });
    leavers.push_back(tip_off);  // in the order of time
  }
  for (const hil::TipOff& leaver : leavers) {
    const hil::TipOff& first = *std::find_if(leavers.begin(), leavers.end(),
                                             [&](const hil::TipOff& other) { return other.base == leaver.base; });
    const double later = leaver.time - first.time;
    if (later < kStayedLong_s) continue;
    verdicts.push_back(leaver.body + " stayed on " + leaver.base + " " + to_seconds(later) + " longer than " +
                       first.body + ", the first to leave it");
  }
}

}  // namespace

std::vector<std::string> build_verdicts(const RunReport& report) {
  std::vector<std::string> verdicts;
  if (report.analysis.tip_offs.empty()) return verdicts;
  add_still_held(report, verdicts);
  add_late_leavers(report.analysis.tip_offs, verdicts);
  for (const hil::Clearance& clearance : report.analysis.clearances()) {
    if (clearance.smallest > 0) continue;
    verdicts.push_back(clearance.name_a + " and " + clearance.name_b +
                       " touch at t = " + to_seconds(clearance.touch.value_or(clearance.time)));
  }
  return verdicts;
}

}  // namespace unlatch::tools
