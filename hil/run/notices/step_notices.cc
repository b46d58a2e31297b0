// Tables and laws: where they are left, and what the steps pass over. And what is known at the end of a run, or so far:
// the audit of the step, that of implicit springs and modes, and laws that rise until then.
#include <algorithm>

#include "hil/run/audit/dependence.h"
#include "hil/run/audit/speed_readers.h"
#include "hil/run/audit/step_audit.h"
#include "hil/run/motion/law_watch.h"
#include "hil/run/notices/format.h"
#include "hil/run/notices/notices.h"
#include "hil/run/notices/resolution.h"
#include "hil/run/notices/table_exit.h"
#include "hil/scenario/base/index.h"
#include "unlatch/model/law_places.h"
#include "unlatch/readings.h"

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
  if (const double rate = steps_->get_feedback(error.body); rate > 0)
    return format(
        "the steps make an error of some %.2g %s in its %s, which changed by %.3g %s: its forces depend on its motion, "
        "and that feedback is not resolved (h times its rate is %.3g); a step of %.3g s resolves it",
        error.error, part.unit, part.name, error.change, part.unit, dt_ * rate, kRoundedDown * kAccurate / rate);
  return format(
      "the steps make an error of some %.2g %s in its %s, which changed by %.3g %s, as %lld of %lld steps show "
      "that were taken again as two halves: a smaller step would do",
      error.error, part.unit, part.name, error.change, part.unit, static_cast<long long>(steps_->get_compared()),
      static_cast<long long>(steps_->get_ticks()));
}

// Tables that are left where this is a notice.
void NoticeWatch::watch_tables() {
  const std::span<const TableExit> exits = simulation_.workspace().table_exits;
  for (std::size_t i = 0; i < exits.size(); ++i) {
    const TableExit& exit = exits[i];
    if (exit.axis == kNone || exit.end != TableAxis::End::kNotice) continue;
    const Table& table = scenario_.model.tables[i];
    const std::vector<double>& knots = table.axes[at(exit.axis)].knots;
    const double beyond = std::max(knots.front() - exit.value, exit.value - knots.back());
    report(left_[i], "table", table.name, beyond / (knots.back() - knots.front()),
           [&] { return describe_exit(table, exit) + ": the value at the end holds"; });
  }
}

// Tables that a step skips cells of.
void NoticeWatch::watch_cells(const StepReport& step) {
  for (const SkippedCells& skipped : cells_.update(get_law_places(simulation_.workspace()), !step.events.empty())) {
    const Table& table = scenario_.model.tables[at(skipped.table)];
    const std::string& axis = table.axes[at(skipped.axis)].name;
    report(
        skipped_[at(skipped.table)], "cell", table.name, skipped.cells,
        [&] {
          return format(
              "a step passes %.0f whole cells of its axis %s, from %.4g to %.4g: a smaller step, or a coarser table, "
              "would do",
              skipped.cells, axis.empty() ? std::to_string(skipped.axis + 1).c_str() : axis.c_str(), skipped.from,
              skipped.to);
        },
        skipped.bodies);
  }
}

// Laws that a step passes over.
void NoticeWatch::watch_laws() {
  if (!begun_ || laws_->is_empty()) return;
  for (const PassedOver& passed : laws_->update(simulation_.get_motion(), simulation_.get_inputs())) {
    const Law& law = scenario_.model.laws[at(passed.law)];
    report(
        passed_over_[at(passed.law)], "law", law.name, passed.error, [&] { return hil::describe(law, passed); },
        passed.bodies);
  }
}

// Errors of the steps that their halves do not show.
void NoticeWatch::watch_feedback() {
  if (!begun_) return;
  for (const FeedbackError& error : feedback_.update(workspace_))
    steps_->add_feedback(error.body, error.error, error.rate);
}

const std::string& NoticeWatch::get_subject(const ImplicitError& error) const {
  return error.element == kNone ? scenario_.model.bodies[at(error.body)].name
                                : scenario_.model.element_name(error.element);
}

std::string NoticeWatch::describe(const ImplicitError& error) const {
  const double step = kRoundedDown * dt_ * std::min(kAccurate / error.size, 0.5);
  if (error.element == kNone && error.of_speed)
    return format(
        "its modes are not resolved (dt·omega up to %.3g), and how fast it deforms is wrong by some %.2g of its "
        "largest change; a step of %.3g s resolves them",
        error.size, error.error / error.change, step);
  if (error.element == kNone)
    return format(
        "the modes that the step does not resolve (dt·omega up to %.3g) keep their mean, not their overshoot: %.2g of "
        "the largest change of all modal forces; a step of %.3g s resolves them",
        error.size, error.error / error.change, step);
  const bool angular = describe_element(scenario_.model, error.element).angular;
  if (error.of_speed)
    return format(
        "its period is not resolved (h times its rate is %.3g), and the speed of its joint is wrong by some %.2g %s, "
        "of "
        "%.3g %s that it changed by; a step of %.3g s resolves it",
        error.size, error.error, angular ? "rad/s" : "m/s", error.change, angular ? "rad/s" : "m/s", step);
  return format(
      "its period is not resolved (h times its rate is %.3g), so that it keeps its mean, not its overshoot: some %.2g "
      "%s "
      "of %.3g %s that its force changed by; a step of %.3g s resolves it",
      error.size, error.error, angular ? "N m" : "N", error.change, angular ? "N m" : "N", step);
}

std::vector<int> NoticeWatch::list_bodies(const ImplicitError& error) const {
  return error.element == kNone ? std::vector<int>{error.body} : list_element_bodies(scenario_.model, error.element);
}

// Something but a requirement on the joint reads the speed that is wrong.
bool NoticeWatch::is_read(const ImplicitError& error) const {
  return !error.of_speed || SpeedReaders(scenario_.model, error.element, error.body).is_read(simulation_.state());
}

void NoticeWatch::add_unresolved(const ImplicitError& error, UnresolvedBodies& unresolved) const {
  const bool passed = error.until != ImplicitError::kNever;
  const std::string cause = "overshoot " + get_subject(error) + (passed ? format(", until %.6g s", error.until) : "") +
                            ": " + describe(error);
  const std::vector<int> bodies = list_bodies(error);
  if (!is_read(error))
    return unresolved.add_speed(SpeedReaders(scenario_.model, error.element, error.body), cause, error.from,
                                error.until);
  if (!passed) return unresolved.add(bodies, cause, error.from);
  for (const int body : bodies) unresolved.add_passed(body, cause, error.from, error.until, links_);
}

std::vector<RunNotice> NoticeWatch::get() const {
  std::vector<RunNotice> notices = notices_;
  const double time = simulation_.get_time();
  for (const PassedOver& passed : laws_->list_rising())
    if (passed_over_[at(passed.law)].number < 0) {
      const Law& law = scenario_.model.laws[at(passed.law)];
      notices.push_back({time, "law", law.name, hil::describe(law, passed), time, true});
    }
  const ImplicitError* before = nullptr;
  const std::vector<ImplicitError> unresolved = implicit_.list_unresolved();
  for (const ImplicitError& error : unresolved) {
    // One notice of a subject: that of its force, if it has both.
    if (before == nullptr || before->element != error.element || before->body != error.body)
      notices.push_back({error.time, "overshoot", get_subject(error), describe(error), error.time, is_read(error)});
    before = &error;
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
  for (const ImplicitError& error : implicit_.list_unresolved()) add_unresolved(error, unresolved);
  for (const ImplicitError& error : implicit_.list_passed()) add_unresolved(error, unresolved);
  unresolved.spread(links_);
  return unresolved;
}

UnresolvedBodies NoticeWatch::get_doubtful(double part) const {
  UnresolvedBodies doubtful(scenario_.model);
  for (const StepError& error : steps_->list_errors(part)) {
    const int bodies[] = {error.body};
    doubtful.add(
        bodies,
        format("step %s: its error, some %.2g %% of the motion, may be more than the margin; a smaller step decides",
               scenario_.model.bodies[at(error.body)].name.c_str(), 100 * error.error / error.change),
        0);
  }
  doubtful.spread(links_);
  return doubtful;
}

}  // namespace unlatch::hil
