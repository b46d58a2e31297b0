#include "kernel/step/bundle.h"

#include <algorithm>
#include <array>
#include <cstring>

#include "kernel/elements/compliance.h"
#include "kernel/events/corner_marks.h"
#include "kernel/events/corners.h"
#include "kernel/events/events.h"
#include "kernel/events/guards.h"
#include "kernel/integration/integrator.h"
#include "kernel/integration/load_state.h"
#include "kernel/quantities/quantities.h"
#include "unlatch/bundle.h"
#include "unlatch/step.h"

namespace unlatch {
namespace {

// Calls `act` with each part of a member's state, its header left out, and with the place of that part in the joined
// state.
template <class Act>
void for_parts(const BundleMember& member, const State& own, const State& joined, const Act& act) {
  const auto list = [&](const auto& from, const auto& to, Stretch s) {
    if (s.count > 0)
      act(std::as_writable_bytes(from.subspan(at(s.own), at(s.count))),
          std::as_writable_bytes(to.subspan(at(s.joined), at(s.count))));
  };
  const auto whole = [&](const auto& from, const auto& to, std::int32_t first) {
    list(from, to, {0, first, static_cast<std::int32_t>(from.size())});
  };
  whole(own.bodies, joined.bodies, member.body);
  whole(own.joints, joined.joints, member.joint);
  for (const Stretch& kind : member.elements) list(own.elements, joined.elements, kind);
  whole(own.events, joined.events, member.event);
  whole(own.signals, joined.signals, member.signal);
  for (const Stretch& part : member.auxiliary) list(own.auxiliary, joined.auxiliary, part);
  whole(own.contacts, joined.contacts, member.pair);
  whole(own.engaged, joined.engaged, member.one_sided);
  whole(own.bearings, joined.bearings, member.bearing);
}

// Copies a member's state into the joined one. True if that was different.
bool copy_in(const BundleMember& member, const State& own, const State& joined) {
  bool differs = false;
  for_parts(member, own, joined, [&](std::span<std::byte> from, std::span<std::byte> to) {
    if (std::memcmp(from.data(), to.data(), from.size()) == 0) return;
    std::memcpy(to.data(), from.data(), from.size());
    differs = true;
  });
  return differs;
}

void copy_out(const BundleMember& member, const State& joined, const State& own) {
  for_parts(member, own, joined, [](std::span<std::byte> to, std::span<std::byte> from) {
    std::memcpy(to.data(), from.data(), from.size());
  });
}

// One step of several runs side by side.
class SideBySide {
 public:
  SideBySide(BundleData& data, std::span<BundleRun> runs)
      : data_(data),
        plan_(get_data(data.plan)),
        inputs_{data.commands},
        kept_(get_data(data.workspace).kept),
        search_(get_data(data.workspace).search),
        ev_(kept_.evaluation),
        state_(kept_.state),
        runs_(runs) {
    for (std::size_t m = 0; m < runs.size(); ++m) stays_[m] = runs[m].goes_on;
  }

  void step() {
    if (!begin() || !integrate_all()) stays_.fill(false);
    for (std::size_t m = 0; m < runs_.size(); ++m) {
      BundleRun& run = runs_[m];
      if (stays_[m])
        finish(m);
      else if (run.goes_on)
        run.report = unlatch::step(*run.plan, run.inputs, *run.state, *run.workspace, run.log);
    }
  }

 private:
  Instant get_instant(double t) const { return {plan_, inputs_, state_, t}; }

  // The joined state and its evaluation at the beginning, with the commands, as begin_step() in step.cc. False if it
  // cannot be evaluated.
  bool begin() {
    bool differs = !kept_.valid, any = false;
    kept_.valid = false;
    for (std::size_t m = 0; m < runs_.size(); ++m) {
      const BundleMember& member = data_.members[m];
      std::copy(runs_[m].inputs.commands.begin(), runs_[m].inputs.commands.end(),
                data_.commands.begin() + member.channel);
      differs |= copy_in(member, *runs_[m].state, state_);
      if (runs_[m].goes_on && !any) state_.header->tick = runs_[m].state->header->tick;
      any |= runs_[m].goes_on;
    }
    begin_ = plan_.get_time(state_.header->tick), end_ = plan_.get_time(state_.header->tick + 1);
    for (std::size_t m = 0; m < runs_.size(); ++m)
      stays_[m] = stays_[m] && runs_[m].state->header->tick == state_.header->tick;
    const bool repeated = !differs && kept_.has_commands(data_.commands);
    if (!begin_evaluation(get_instant(begin_), differs ? Changed::kState : Changed::kCommands, repeated)) return false;
    rearm(plan_, state_, ev_);
    const bool stiff = is_stiff(plan_, state_, 0.5 * (begin_ + end_));
    for (std::size_t m = 0; m < runs_.size(); ++m)
      stays_[m] = stays_[m] && begins_quietly(m) &&
                  is_stiff(get_data(*runs_[m].plan), *runs_[m].state, 0.5 * (begin_ + end_)) == stiff;
    log_beginning();
    return true;
  }
  bool begin_evaluation(const Instant& now, Changed changed, bool repeated) {
    const bool evaluates = changed != Changed::kCommands || plan_.commanded_loads;
    if (evaluates && evaluate(now, changed, ev_) != kNone) return false;
    const bool kept = !evaluates && (!plan_.commanded_events || (repeated && keeps_guards(plan_)));
    if (!kept) update_guards(now, ev_, search_.stack);
    return true;
  }

  // The guards of a member's events and of its pairs of shapes.
  struct Guards {
    std::span<const double> events, pairs;
  };
  Guards get_guards(std::size_t m, std::span<const double> all) const {
    const BundleMember& member = data_.members[m];
    const State& own = *runs_[m].state;
    return {all.subspan(at(member.event), own.events.size()),
            get_pair_guards(plan_, all).subspan(at(member.pair), own.contacts.size())};
  }
  std::span<const EventState> get_events(std::size_t m) const {
    return state_.events.subspan(at(data_.members[m].event), runs_[m].state->events.size());
  }

  // What a member's bodies have burnt.
  std::span<const double> get_burnt(std::size_t m, std::span<const double> all) const {
    return all.subspan(at(data_.members[m].auxiliary[0].joined), get_data(*runs_[m].plan).varying.size());
  }

  // True if no event of the member is due at the beginning of the step (compare is_due() in events.cc), no pending
  // event becomes due in it, no contact is closed, no corner whose time is known lies in it, and, where its motion is
  // logged, none at its ends.
  bool begins_quietly(std::size_t m) const {
    const PlanData& own = get_data(*runs_[m].plan);
    const Guards guards = get_guards(m, ev_.guards);
    const std::span<const EventState> events = get_events(m);
    const double slack = plan_.get_slack();
    for (std::size_t e = 0; e < events.size(); ++e) {
      if (events[e].phase == EventPhase::kPending && events[e].due <= end_ + slack) return false;
      if (events[e].phase == EventPhase::kArmed && guards.events[e] >= -(own.events[e].by_time ? slack : 0.0))
        return false;
    }
    if (std::any_of(guards.pairs.begin(), guards.pairs.end(), [](double guard) { return guard >= 0; })) return false;
    const std::span<const ContactState> pairs = runs_[m].state->contacts;
    if (std::any_of(pairs.begin(), pairs.end(), [](const ContactState& pair) { return pair.closed != 0; }))
      return false;
    if (own.time_corners && find_time_corner(own, *runs_[m].state, begin_, end_) < end_) return false;
    return runs_[m].log == nullptr || !mark_times(own, *runs_[m].state, begin_, end_).any();  // its own step logs it
  }

  // The whole step as one sub-step. False if that fails.
  bool integrate_all() {
    if (std::none_of(stays_.begin(), stays_.end(), [](bool stays) { return stays; })) return false;
    std::copy(ev_.guards.begin(), ev_.guards.end(), search_.guards_low.begin());
    std::copy(ev_.pair_rates.begin(), ev_.pair_rates.end(), search_.rates_low.begin());
    std::copy_n(ev_.law_places.begin(), search_.places_low.size(), search_.places_low.begin());
    std::copy(ev_.altitudes.begin(), ev_.altitudes.end(), search_.altitudes_low.begin());
    std::copy(ev_.travels.begin(), ev_.travels.end(), search_.travels_low.begin());
    const Instant end = get_instant(end_);
    const SubstepStart start = begin_substep(get_instant(begin_), Contacts::kExplicit, ev_);
    if (integrate(end, start, end_, ev_) != kNone || evaluate(end, Changed::kVelocities, ev_) != kNone) return false;
    update_guards(end, ev_, search_.stack);
    for (std::size_t m = 0; m < runs_.size(); ++m) stays_[m] = stays_[m] && passes_quietly(m);
    store_substep(plan_, ev_, state_);
    rearm(plan_, state_, ev_);
    update_readings(end, ev_);
    ++state_.header->tick;
    kept_.keep(data_.commands);
    return kept_.valid = is_finite(state_, ev_.sensors);
  }

  // True if no guard crosses zero (compare crosses() in event_search.cc), no law and nothing that is burnt passes a
  // corner, and no pair of shapes can have touched.
  bool passes_quietly(std::size_t m) const {
    const PlanData& own = get_data(*runs_[m].plan);
    const double slack = plan_.get_slack();
    const Guards low = get_guards(m, search_.guards_low), high = get_guards(m, ev_.guards);
    const std::span<const EventState> events = get_events(m);
    for (std::size_t e = 0; e < events.size(); ++e)
      if (events[e].phase == EventPhase::kArmed && low.events[e] < 0 &&
          high.events[e] >= -(own.events[e].by_time ? slack : 0.0))
        return false;
    if (own.law_numbers.strict && leaves_table(m)) return false;  // its own step reports it
    if (own.place_corners) {
      const PassedPlaces places{get_own(m, get_corner_places(search_)), get_own(m, get_middle_places(ev_)),
                                get_own(m, get_corner_places(ev_))};
      if (find_corner(own, begin_, end_, places.at_begin, places.at_end).place != kNone ||
          passes_and_returns(own, begin_, end_, places))
        return false;
    }
    if (!own.varying.empty() &&
        find_burnt_knot(own, begin_, end_, get_burnt(m, state_.auxiliary), get_burnt(m, ev_.auxiliary.now)).mass !=
            kNone)
      return false;
    if (runs_[m].log != nullptr && (!own.laws.empty() || own.place_corners) &&
        mark_corners(own, *runs_[m].state, begin_, end_, get_course(m)).any())
      return false;  // its own step logs it
    const auto first = at(data_.members[m].pair);
    for (std::size_t i = 0; i < low.pairs.size(); ++i)
      if ((low.pairs[i] < 0 && high.pairs[i] >= 0) ||
          (search_.rates_low[first + i] < 0 && ev_.pair_rates[first + i] > 0))
        return false;
    return true;
  }

  // A member's part of what has corners; `all.laws` is empty where no law of any member has some.
  CornerPlaces get_own(std::size_t m, const CornerPlaces& all) const {
    const PlanData& own = get_data(*runs_[m].plan);
    const BundleMember& member = data_.members[m];
    CornerPlaces places;
    if (!all.laws.empty()) places.laws = all.laws.subspan(at(member.law_place), at(own.law_numbers.places));
    if (!own.air_corners.empty())
      places.altitudes = all.altitudes.subspan(at(member.aerodynamics), own.aerodynamics.size());
    if (!own.travels.empty()) places.travels = all.travels.subspan(at(member.one_sided), own.one_sided.size());
    return places;
  }

  CornerCourse get_course(std::size_t m) const {
    const auto branches = [&](std::span<const std::int32_t> all) {
      return all.subspan(at(data_.members[m].law_place), at(get_data(*runs_[m].plan).law_numbers.places));
    };
    return {get_own(m, get_corner_places(search_)), get_own(m, get_corner_places(ev_)), branches(ev_.branches_at_start),
            branches(ev_.branches)};
  }

  bool leaves_table(std::size_t m) const {
    const std::span<const TableExit> exits =
        ev_.table_exits.subspan(at(data_.members[m].table), get_data(*runs_[m].plan).laws.tables.size());
    return std::ranges::any_of(exits, [](const TableExit& exit) { return exit.end == TableAxis::End::kError; });
  }

  // A member's state at the end of the step, its outputs and its report.
  void finish(std::size_t m) {
    BundleRun& run = runs_[m];
    const BundleMember& member = data_.members[m];
    copy_out(member, state_, *run.state);
    run.state->header->tick = state_.header->tick;
    FinalEvaluation& own = get_data(*run.workspace).kept;
    own.valid = false;  // it has the outputs and readings of the new state, and nothing else
    std::memcpy(own.state.get_bytes().data(), run.state->get_bytes().data(), own.state.get_bytes().size());
    Evaluation& to = own.evaluation;
    for (std::size_t b = 0; b < to.places.size(); ++b)
      write(to.blocks.data(), to.places[b], &SharedBlock<double>::acceleration, get_acceleration(member, b));
    for (std::size_t i = 0; i < to.multipliers.size(); ++i)
      to.multipliers.get(i / kRows, i % kRows) = get_multiplier(member, i);
    copy_outputs(member, to.sensors, to.quantities);
    copy_readings(member, to);
    run.report = {};
    run.report.substeps = 1;
    add_knot(m, end_, false);
  }
  Spatial get_acceleration(const BundleMember& member, std::size_t body) const {
    return ev_.get_acceleration(member.body + static_cast<int>(body));
  }
  double get_multiplier(const BundleMember& member, std::size_t i) const {
    return ev_.multipliers[at(member.joint) * kRows + i];
  }
  void copy_outputs(const BundleMember& member, std::span<double> sensors, std::span<double> quantities) const {
    std::copy_n(ev_.sensors.begin() + member.sensor, sensors.size(), sensors.begin());
    std::copy_n(ev_.quantities.begin() + member.quantity, quantities.size(), quantities.begin());
  }
  // What readings of elements need beside the state, see calc_element() in elements/readings.cc.
  void copy_readings(const BundleMember& member, Evaluation& to) const {
    std::copy_n(ev_.load_sizes.begin() + member.load, to.load_sizes.size(), to.load_sizes.begin());
    std::copy_n(ev_.laws.begin() + member.law, to.laws.size(), to.laws.begin());
    std::copy_n(ev_.law_places.begin() + member.law_place, to.law_places.size(), to.law_places.begin());
    std::copy_n(ev_.table_exits.begin() + member.table, to.table_exits.size(), to.table_exits.begin());
    std::copy_n(ev_.friction_sizes.begin() + member.friction, to.friction_sizes.size(), to.friction_sizes.begin());
    for (std::size_t i = 0; i < member.coordinates.size(); ++i) {
      to.coordinates[i] = ev_.coordinates[at(member.coordinates[i])];
      to.speeds[i] = ev_.speeds[at(member.coordinates[i])];
    }
  }

  // Logs the beginning of the step. A run that takes the step alone writes its log anew.
  void log_beginning() {
    if (std::none_of(runs_.begin(), runs_.end(), [](const BundleRun& run) { return run.log != nullptr; })) return;
    update_readings(get_instant(begin_), ev_);
    for (std::size_t m = 0; m < runs_.size(); ++m) {
      if (!stays_[m] || runs_[m].log == nullptr) continue;
      runs_[m].log->clear();
      add_knot(m, begin_, true);
    }
  }
  void add_knot(std::size_t m, double time, bool begins) {
    if (runs_[m].log == nullptr) return;
    const BundleMember& member = data_.members[m];
    MotionKnot& knot = runs_[m].log->add();
    knot.time = time;
    knot.begins = begins;
    knot.corner = knot.reading_corner = false;
    *knot.state.header = {state_.header->tick, runs_[m].plan->get_hash()};
    copy_out(member, state_, knot.state);
    for (std::size_t b = 0; b < knot.accelerations.size(); ++b) knot.accelerations[b] = get_acceleration(member, b);
    for (std::size_t i = 0; i < knot.multipliers.size(); ++i) knot.multipliers[i] = get_multiplier(member, i);
    copy_outputs(member, knot.sensors, knot.quantities);
  }

  BundleData& data_;
  const PlanData& plan_;
  const Inputs inputs_;  // of all members
  FinalEvaluation& kept_;
  EventSearch& search_;
  Evaluation& ev_;
  State& state_;
  std::span<BundleRun> runs_;
  std::array<bool, Bundle::kMost> stays_{};  // by run: it takes this step side by side
  double begin_ = 0, end_ = 0;               // s
};

}  // namespace

void Bundle::step(std::span<BundleRun> runs) noexcept { SideBySide(*data_, runs).step(); }

}  // namespace unlatch
