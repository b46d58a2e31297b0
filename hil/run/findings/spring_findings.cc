#include <algorithm>

#include "hil/run/findings/finding_parts.h"
#include "hil/run/notices/format.h"
#include "hil/run/notices/notices.h"
#include "hil/scenario/base/index.h"
#include "unlatch/readings.h"

namespace unlatch::hil {
namespace {

bool frees_with(const Event& event, int joint, const Model& model, int element) {
  bool frees = false, switches = false;
  for (const Action& action : event.then) {
    const bool is_switch = action.kind == Action::Kind::kSwitch || action.kind == Action::Kind::kRamp;
    if (action.kind == Action::Kind::kSetMode && action.subject == joint)
      frees = model.joints[at(joint)].modes[at(action.mode)].rows == 0;
    if (is_switch && action.subject == element && action.value == 0) switches = true;
  }
  return frees && !switches;
}

}  // namespace

void add_coincident_point_findings(const Model& model, std::vector<Finding>& findings) {
  auto element = static_cast<int>(model.loads.size());
  for (const PointSpring& s : model.point_springs) {
    const double length = calc_element_start(model, element++).length, force = s.stiffness * s.free_length;
    if (length > kCoincident || force == 0) continue;
    findings.push_back({"direction", quoted("element", s.name),
                        format("its two points coincide, to %.1g m, with %.4g N in it: the force has no direction, and "
                               "rounding picks one or none; move one of the points along the line of the force",
                               length, force)});
  }
  element = get_first_one_sided(model);
  for (const OneSided& f : model.one_sided) {
    const ElementStart start = calc_element_start(model, element++);
    if (f.joint != kNone || f.guide || f.kind == OneSided::Kind::kCord) continue;
    if (start.length > kCoincident || start.force == 0) continue;
    findings.push_back(
        {"direction", quoted("element", f.name),
         format("its two points coincide, to %.1g m, with %.4g N in it: the force has no direction; give "
                "it a `guide`, or move one of the points along the line of the force",
                start.length, start.force)});
  }
}

void add_freed_spring_findings(const Scenario& scenario, std::vector<Finding>& findings) {
  const Model& model = scenario.model;
  const auto first = static_cast<int>(model.loads.size() + model.point_springs.size());
  for (std::size_t i = 0; i < model.joint_springs.size(); ++i) {
    const JointSpring& s = model.joint_springs[i];
    const auto& meant = scenario.springs_while_free;
    if (std::find(meant.begin(), meant.end(), s.name) != meant.end()) continue;
    const Joint& joint = model.joints[at(s.joint)];
    // A joint without rows in any mode exists for its springs only.
    const bool ever_holds =
        std::any_of(joint.modes.begin(), joint.modes.end(), [](const JointMode& mode) { return mode.rows != 0; });
    const bool stays = std::any_of(model.events.begin(), model.events.end(), [&](const Event& event) {
      return frees_with(event, s.joint, model, first + static_cast<int>(i));
    });
    if (!ever_holds || !stays) continue;
    findings.push_back({"free_spring", quoted("element", s.name),
                        "acts on after joint '" + joint.name +
                            "' is set free; switch it off in that event, or say `while_free: true`"});
  }
}

}  // namespace unlatch::hil
