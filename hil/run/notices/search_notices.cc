// What the search for events within a step left open.
#include <algorithm>
#include <set>

#include "hil/run/audit/dependence.h"
#include "hil/run/notices/format.h"
#include "hil/run/notices/notices.h"
#include "hil/run/notices/resolution.h"
#include "hil/scenario/base/index.h"
#include "unlatch/model/law_places.h"
#include "unlatch/readings.h"

namespace unlatch::hil {
namespace {

constexpr double kYielded = 1e-6;  // of the speeds in a blow: reported above it

// Name of a guard: an index into the model's events, then into its contacts.
const std::string& get_guard_name(const Model& model, int guard) {
  const std::size_t i = at(guard), events = model.events.size();
  return i < events ? model.events[i].name : model.contacts[i - events].name;
}

// Bodies that a law pushes, or a pusher, a stop or a cord with a table over its travel.
std::vector<int> list_cornered_bodies(const Model& model) {
  std::set<int> bodies;
  for (const std::vector<int>& own : list_bodies_of_laws(model)) bodies.insert(own.begin(), own.end());
  for (std::size_t i = 0; i < model.one_sided.size(); ++i) {
    if (model.one_sided[i].travels.empty()) continue;
    const std::vector<int> own = list_element_bodies(model, get_first_one_sided(model) + static_cast<int>(i));
    bodies.insert(own.begin(), own.end());
  }
  return {bodies.begin(), bodies.end()};
}

}  // namespace

void NoticeWatch::watch_search(const StepReport& report) {
  const OpenSearch& open = report.open;
  if (report.postponed > 0 && !postponed_) {
    postponed_ = true;
    add("search", "",
        format("a step had more instants with events than its %d: the rest were left to the next tick",
               simulation_.plan().get_options().max_splits),
        list_all_bodies(scenario_.model));
  }
  if (report.settled > 0 && !settled_) {
    settled_ = true;
    const Contact& contact = scenario_.model.contacts[at(report.settling)];
    add("contact", contact.name,
        format("its bounces ended, and those of other rigid contacts: the next flight would be shorter than %.3g s",
               contact.settle.value_or(0.5 * dt_)));
  }
  if (report.yielded > kYielded) {
    const std::vector<int> bodies = list_contact_bodies(scenario_.model, report.yielding);
    this->report(
        yielded_, "contact", scenario_.model.contacts[at(report.yielding)].name, report.yielded,
        [&] {
          return format(
              "a blow on several rough feet, whose places contradict each other, is found to %.0e of its "
              "speeds only; a smaller step would do",
              report.yielded);
        },
        bodies);
  }
  if (open.unlocated > 0 && !unlocated_) {
    unlocated_ = true;
    add("search", get_guard_name(scenario_.model, open.guard),
        format("its instant is known to %.2g s only: the tries of a step ran out; a smaller step would do",
               open.interval),
        list_all_bodies(scenario_.model));
  }
  if (open.corners > 0 && !cornered_) {
    cornered_ = true;
    add("search", "", "a step passed more corners of forces than it may be split at; a smaller step would do",
        list_cornered_bodies(scenario_.model));
  }
  if (open.unseen > 0 && !unseen_) {
    unseen_ = true;
    add("search", scenario_.model.contacts[at(open.contact)].name,
        format("it may have touched and parted again within a step, up to %.2g m deep: the looks of a step ran out; a "
               "smaller step would do",
               open.depth),
        list_contact_bodies(scenario_.model, open.contact));
  }
}

void NoticeWatch::report_unseen(const UnseenClearance& unseen) {
  const std::size_t event = at(unseen.event);
  passed_.resize(scenario_.model.events.size());
  report(
      passed_[event], "search", get_guard_name(scenario_.model, unseen.event), -unseen.value,
      [&] {
        return format(
            "its distance fell to %.6g m within a step, at %.6f s, and rose again: it did not act, because no "
            "tick shows it; a smaller step would do",
            unseen.value, unseen.time);
      },
      list_all_bodies(scenario_.model));
}

void NoticeWatch::report_unseen(const UnseenCrossing& unseen) {
  const std::size_t event = at(unseen.event);
  passed_.resize(scenario_.model.events.size());
  const double length = unseen.until - unseen.from;
  report(
      passed_[event], "search", get_guard_name(scenario_.model, unseen.event), 1 / length,
      [&] {
        return format(
            "its condition became true within a step, at %.6f s, and false again %.3g s later: it did not act, because "
            "no tick shows it; a step of %.3g s would do",
            unseen.from, length, kRoundedDown * length);
      },
      list_all_bodies(scenario_.model));
}

void NoticeWatch::report_unseen(const UnseenEngagement& unseen) {
  const Model& model = scenario_.model;
  const Event& event = model.events[at(unseen.event)];
  passed_.resize(model.events.size());
  const double length = unseen.until - unseen.from;
  report(
      passed_[at(unseen.event)], "search", event.subject, 1 / length,
      [&] {
        return format(
            "its event %s was due within a step, at %.6f s, and undone %.3g s later: it did not act, because no tick "
            "shows it; a step of %.3g s would do",
            event.name.c_str(), unseen.from, length, kRoundedDown * length);
      },
      list_element_bodies(model, get_first_one_sided(model) + unseen.force));
}

void NoticeWatch::report_lost(const LostTrigger& lost) {
  lost_.resize(scenario_.model.events.size());
  if (lost_[at(lost.event)]) return;
  lost_[at(lost.event)] = true;
  const Event& event = scenario_.model.events[at(lost.event)];
  add("delay", event.name + (event.subject.empty() ? "" : ":" + event.subject),
      format("its condition became true again at %.6g s, while its delay of %.6g s ran: it does not act for that, nor "
             "for others that come so",
             lost.time, event.delay));
}

void NoticeWatch::report_unsearched(const UnsearchedEvent& unsearched) {
  add("search", get_guard_name(scenario_.model, unsearched.event),
      "its condition is looked at where steps end, and not within them: it reads " + unsearched.reads, {});
}

}  // namespace unlatch::hil
