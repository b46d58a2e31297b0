// Events: their conditions are complete, and the subjects of conditions and actions exist.
#include <algorithm>
#include <set>

#include "kernel/model/validate.h"
#include "unlatch/quantities.h"

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

  void check_condition(const Condition& condition) {
    using Kind = Condition::Kind;
    if (!std::isfinite(condition.threshold)) report("a threshold is not finite", "give a finite value", "when");
    if (condition.kind == Kind::kAll || condition.kind == Kind::kAny) {
      if (condition.parts.empty()) report("an all or any without parts", "give at least one condition", "when");
    } else if (condition.kind == Kind::kNot) {
      if (condition.parts.size() != 1)
        report("a not with no part or with several", "give exactly one condition", "when");
    } else if (condition.kind != Kind::kQuantity) {
      check_quantity(model, get_quantity(model, condition), true, where, "when", errors);
    } else {
      check_subject("quantity", condition.subject, model.quantities.size(), "when");
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
      report("it sets a mode that joint '" + joint.name + "' does not have", "the index of one of its modes", "then");
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
