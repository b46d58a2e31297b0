// What is known at the end of a run, or so far: the audit of the step, and laws that rise until then.
#include "hil/run/audit/step_audit.h"
#include "hil/run/motion/law_watch.h"
#include "hil/run/notices/format.h"
#include "hil/run/notices/notices.h"
#include "hil/run/notices/table_exit.h"
#include "hil/scenario/base/index.h"

namespace unlatch::hil {
namespace {

struct PartName {
  const char *name, *unit;
};
constexpr PartName kPartNames[kMotionParts] = {
    {"place", "m"},
    {"velocity", "m/s"},
    {"place relative to the centre of mass", "m"},
    {"velocity relative to the centre of mass", "m/s"},
    {"attitude", "rad"},
    {"rate", "rad/s"},
};

}  // namespace

std::string NoticeWatch::describe(const StepError& error) const {
  const PartName part = kPartNames[static_cast<int>(error.part)];
  return format(
      "the steps make an error of some %.2g %s in its %s, which changed by %.3g %s, as %lld of %lld steps show "
      "that were taken again as two halves: a smaller step would do",
      error.error, part.unit, part.name, error.change, part.unit, static_cast<long long>(steps_->get_compared()),
      static_cast<long long>(steps_->get_ticks()));
}

std::vector<RunNotice> NoticeWatch::get() const {
  std::vector<RunNotice> notices = notices_;
  const double time = simulation_.get_time();
  for (const PassedOver& passed : laws_->list_rising())
    if (passed_over_[at(passed.law)].number < 0) {
      const Law& law = scenario_.model.laws[at(passed.law)];
      notices.push_back({time, "law", law.name, hil::describe(law, passed), time, true});
    }
  for (const StepError& error : steps_->list_unresolved())
    notices.push_back(
        {error.time, "step", scenario_.model.bodies[at(error.body)].name, describe(error), error.time, true});
  return notices;
}

UnresolvedBodies NoticeWatch::get_unresolved() const {
  UnresolvedBodies unresolved = unresolved_;
  for (const PassedOver& passed : laws_->list_rising()) {
    const Law& law = scenario_.model.laws[at(passed.law)];
    unresolved.add(passed.bodies, "law " + law.name + ": " + hil::describe(law, passed), simulation_.get_time() - dt_);
  }
  for (const StepError& error : steps_->list_unresolved()) {
    const int bodies[] = {error.body};
    unresolved.add(bodies, "step " + scenario_.model.bodies[at(error.body)].name + ": " + describe(error), error.from);
  }
  for (const StepError& error : steps_->list_passed())
    unresolved.add_passed(error.body,
                          format("step %s, until %.6g s: %s", scenario_.model.bodies[at(error.body)].name.c_str(),
                                 error.until, describe(error).c_str()),
                          error.from, error.until, links_);
  unresolved.spread(links_);
  return unresolved;
}

}  // namespace unlatch::hil
