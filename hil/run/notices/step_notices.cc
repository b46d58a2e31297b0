// What the audit of the step says at the end of a run, or so far.
#include "hil/run/audit/step_audit.h"
#include "hil/run/notices/format.h"
#include "hil/run/notices/notices.h"
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
  for (const StepError& error : steps_->list_unresolved())
    notices.push_back(
        {error.time, "step", scenario_.model.bodies[at(error.body)].name, describe(error), error.time, true});
  return notices;
}

UnresolvedBodies NoticeWatch::get_unresolved() const {
  UnresolvedBodies unresolved = unresolved_;
  for (const StepError& error : steps_->list_unresolved()) {
    const int bodies[] = {error.body};
    unresolved.add(bodies, "step " + scenario_.model.bodies[at(error.body)].name + ": " + describe(error), error.time,
                   simulation_.state());
  }
  return unresolved;
}

}  // namespace unlatch::hil
