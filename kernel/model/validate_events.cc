// Events: what they look at and what they do exists.
#include <algorithm>
#include <set>

#include "kernel/model/validate.h"

namespace unlatch {
namespace {

struct EventCheck {
  const Model& model;
  std::string where;
  ModelErrors& errors;

  void report(const std::string& what, const std::string& mend, const std::string& key) {
    errors.push_back({where, what, mend, key});
  }

  bool check_subject(const char* kind, int subject, std::size_t size, const std::string& key) {
    if (is_index(subject, size)) return true;
    report(std::string("the ") + kind + " that it names does not exist", std::string("the index of one ") + kind, key);
    return false;
  }

  void check_axis(int axis, int first, int last) {
    if (axis < first || axis > last)
      report("it names an axis that this kind of condition has not",
             std::string(kRowNames[first]) + " … " + kRowNames[last], "when");
  }

  // A reaction along a row that never holds would never fire.
  void check_row(const Condition& condition) {
    check_axis(condition.axis, kX, kRotZ);
    if (!is_index(condition.axis, kRows)) return;
    const std::vector<JointMode>& modes = model.joints[static_cast<std::size_t>(condition.subject)].modes;
    if (std::none_of(modes.begin(), modes.end(), [&](const JointMode& m) { return has_row(m.rows, condition.axis); }))
      report("no mode of joint '" + model.joints[static_cast<std::size_t>(condition.subject)].name + "' has the row " +
                 kRowNames[condition.axis],
             "look at a row that one of its modes has", "when");
  }

  void check_joint_condition(const Condition& condition) {
    using Kind = Condition::Kind;
    if (!check_subject("joint", condition.subject, model.joints.size(), "when")) return;
    const Joint& joint = model.joints[static_cast<std::size_t>(condition.subject)];
    if (condition.kind == Kind::kReaction) check_row(condition);
    if (condition.kind == Kind::kDisplacement) check_axis(condition.axis, kX, kZ);
    if (condition.kind == Kind::kAngle) check_axis(condition.axis, kRotX, kRotZ);
    if (condition.kind == Kind::kSpeed) check_axis(condition.axis, kX, kRotZ);
    if (condition.kind == Kind::kMode && !is_index(condition.axis, joint.modes.size()))
      report("it names a mode that joint '" + joint.name + "' has not", "the index of one of its modes", "when");
  }

  void check_condition(const Condition& condition) {
    using Kind = Condition::Kind;
    if (!std::isfinite(condition.threshold)) report("a threshold is not finite", "give a finite value", "when");
    switch (condition.kind) {
      case Kind::kTime:
        break;
      case Kind::kReaction:
      case Kind::kDisplacement:
      case Kind::kAngle:
      case Kind::kSpeed:
      case Kind::kMode:
        check_joint_condition(condition);
        break;
      case Kind::kForceSize:
      case Kind::kMomentSize:
        check_subject("joint", condition.subject, model.joints.size(), "when");
        break;
      case Kind::kOneSidedForce:
      case Kind::kEngaged:
      case Kind::kReach:
        check_subject("pusher, stop or cord", condition.subject, model.one_sided.size(), "when");
        break;
      case Kind::kWound:
      case Kind::kBearing:
        if (!is_index(condition.subject, model.one_sided.size()) ||
            !model.one_sided[static_cast<std::size_t>(condition.subject)].drum)
          report("it looks at how far a cord is wound that has no drum", "the index of a cord with a drum", "when");
        break;
      case Kind::kBodyRate:
        check_subject("body", condition.subject, model.bodies.size(), "when");
        break;
      case Kind::kBurnt:
        if (!is_index(condition.subject, model.bodies.size()) ||
            !model.bodies[static_cast<std::size_t>(condition.subject)].law)
          report("it looks at what a body burns that has no mass law", "the index of a body with a law", "when");
        break;
      case Kind::kSignal:
        check_subject("signal", condition.subject, model.signals.size(), "when");
        break;
      case Kind::kCommand:
        check_subject("channel", condition.subject, model.channels.size(), "when");
        break;
      case Kind::kDistance:
        check_shape_pair(model, where, condition.subject, condition.axis, "when", errors);
        break;
      case Kind::kClosed:
        check_subject("contact", condition.subject, model.contacts.size(), "when");
        break;
      case Kind::kAll:
      case Kind::kAny:
        if (condition.parts.empty()) report("an all or any without parts", "give at least one condition", "when");
        break;
      case Kind::kNot:
        if (condition.parts.size() != 1) report("a not that has not one part", "give exactly one condition", "when");
        break;
    }
    for (const Condition& part : condition.parts) check_condition(part);
  }

  void check_action(const Action& action) {
    using Kind = Action::Kind;
    if (!std::isfinite(action.value)) report("an action's value is not finite", "give a finite value", "then");
    if (!(action.duration >= 0) || !std::isfinite(action.duration))
      report("a ramp lasts " + show(action.duration) + " s", "0 or more, and finite", "then");
    if (action.kind == Kind::kRaise) check_subject("signal", action.subject, model.signals.size(), "then");
    if (action.kind == Kind::kSwitch || action.kind == Kind::kRamp)
      check_subject("element", action.subject, static_cast<std::size_t>(model.element_count()), "then");
    if (action.kind == Kind::kImpulse) check_subject("impulse", action.subject, model.impulses.size(), "then");
    if (action.kind == Kind::kEngage)
      check_subject("pusher, stop or cord", action.subject, model.one_sided.size(), "then");
    if (action.kind != Kind::kSetMode || !check_subject("joint", action.subject, model.joints.size(), "then")) return;
    const Joint& joint = model.joints[static_cast<std::size_t>(action.subject)];
    if (!is_index(action.mode, joint.modes.size()))
      report("it sets a mode that joint '" + joint.name + "' has not", "the index of one of its modes", "then");
  }
};

}  // namespace

void validate_events(const Model& model, ModelErrors& errors) {
  std::set<std::pair<std::string, std::string>> seen;
  for (const Event& event : model.events) {
    EventCheck check{model, quoted("event", event.name), errors};
    if (!event.subject.empty()) check.where += " of '" + event.subject + "'";
    if (event.name.empty()) check.report("it has no name", "give it one", "name");
    if (!seen.emplace(event.name, event.subject).second)
      check.report("more than one has this name and subject", "give each its own pair", "name");
    check.check_condition(event.when);
    if (!(event.delay >= 0) || !std::isfinite(event.delay))
      check.report("its delay is " + show(event.delay) + " s", "0 or more, and finite", "delay");
    if (event.crossing && !event.repeat)
      check.report("it acts once, and not where its guard holds at the start", "let it repeat, or act there", "repeat");
    for (const Action& action : event.then) check.check_action(action);
  }
}

}  // namespace unlatch
