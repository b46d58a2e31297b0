#include "hil/run/notices/notices.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

#include "hil/run/audit/dependence.h"
#include "hil/run/audit/step_audit.h"
#include "hil/run/motion/law_watch.h"
#include "hil/run/notices/contact_resolution.h"
#include "hil/run/notices/format.h"
#include "hil/run/notices/friction_resolution.h"
#include "hil/run/notices/resolution.h"
#include "hil/run/notices/table_exit.h"
#include "hil/scenario/base/from_eigen.h"
#include "hil/scenario/base/index.h"
#include "unlatch/contacts.h"
#include "unlatch/readings.h"
#include "unlatch/redundancy.h"

namespace unlatch::hil {
namespace {

constexpr std::size_t kAlignment = 64;
constexpr double kDrift = 1e-9;  // m or rad: a thousand times a projection's residual, plus rounding of the positions
constexpr double kNorm = 1e-12;  // norm error of a quaternion, which every step normalises

std::string describe_size(const char* what, double size) {
  return format("%s %.3g: %s, the step resolves %.2g", what, size,
                size > kStable ? "beyond what is stable" : "not resolved accurately", kAccurate);
}

}  // namespace

NoticeWatch::NoticeWatch(const Scenario& scenario, const Simulation& simulation, bool audits)
    : scenario_(scenario),
      simulation_(simulation),
      dt_(simulation.plan().get_options().dt),
      steps_(std::make_unique<StepAudit>(simulation)),
      implicit_(simulation),
      feedback_(simulation),
      unresolved_(scenario.model),
      links_(scenario.model),
      turning_(scenario.model.bodies.size()),
      stiff_(static_cast<std::size_t>(scenario.model.element_count())),
      sticking_(static_cast<std::size_t>(scenario.model.element_count())),
      touching_(scenario.model.contacts.size()),
      jumping_(scenario.model.contacts.size()),
      doubled_(scenario.model.contacts.size()),
      impulses_(scenario.model.contacts.size()),
      denormal_(scenario.model.bodies.size()),
      restless_(scenario.model.channels.size()),
      pointless_(scenario.model.point_springs.size()),
      pointless_sided_(scenario.model.one_sided.size()),
      profile_notices_(scenario.model.loads.size()),
      left_(scenario.model.tables.size()),
      skipped_(scenario.model.tables.size()),
      beside_(scenario.model.one_sided.size()),
      passed_over_(scenario.model.laws.size()),
      cells_(scenario.model),
      jumps_(simulation),
      seams_(simulation),
      laws_(std::make_unique<LawWatch>(scenario.model, simulation.plan())),
      courses_(scenario.model.channels.size()),
      memory_(simulation.plan().get_workspace_bytes() + kAlignment) {
  void* first = memory_.data();
  std::size_t space = memory_.size();
  const std::size_t bytes = simulation.plan().get_workspace_bytes();
  if (audits) audit_.emplace(simulation);
  for (const Load& load : scenario.model.loads) profiles_.emplace_back(load.profile);
  workspace_ =
      Workspace(simulation.plan(), {static_cast<std::byte*>(std::align(kAlignment, bytes, first, space)), bytes});
}

NoticeWatch::~NoticeWatch() = default;

void NoticeWatch::add(std::string name, std::string subject, std::string text, std::span<const int> unresolved) {
  const double time = simulation_.get_time();
  if (!unresolved.empty()) add_unresolved(unresolved, name + (subject.empty() ? "" : " " + subject) + ": " + text);
  notices_.push_back({time, std::move(name), std::move(subject), std::move(text), time, !unresolved.empty()});
}

// What is seen at a tick was so within the step before it.
void NoticeWatch::add_unresolved(std::span<const int> bodies, const std::string& cause) {
  unresolved_.add(bodies, cause, begun_ ? simulation_.get_time() - dt_ : simulation_.get_time());
}

std::string NoticeWatch::describe_unresolved() const {
  std::string text;
  std::size_t count = 0;
  for (const RunNotice& notice : get()) {
    if (!notice.unresolved) continue;
    ++count;
    if (count == 1) text = notice.name + (notice.subject.empty() ? "" : " " + notice.subject) + ": " + notice.text;
  }
  return count > 1 ? text + format("; and %zu more", count - 1) : text;
}

void NoticeWatch::update(const StepReport& report) {
  const std::optional<StepAudit::Repeated> repeated = steps_->update(report);
  if (audit_) audit_->update(report);
  watch_links(report);
  watch_bodies();
  if (!begun_) {
    if (simulation_.begins_unresolved())
      add("start", "", "it goes on from a state to which the step of an earlier run had not resolved the way",
          list_all_bodies(scenario_.model));
    for (std::size_t b = 0; b < scenario_.model.bodies.size(); ++b) {
      const Body& body = scenario_.model.bodies[b];
      if (!body.flexible || body.flexible->frequencies.size() == 0) continue;
      const double size = dt_ * body.flexible->frequencies.maxCoeff();
      if (size > kAccurate) {
        const int bodies[] = {static_cast<int>(b)};
        const bool implicit = size > kResolved;
        add("mode", body.name,
            implicit ? format("dt·omega %.3g of its fastest mode: integrated implicitly, which damps it", size)
                     : describe_size("dt·omega of its fastest mode", size),
            implicit || size <= kUnresolvedSize ? std::span<const int>{} : std::span<const int>(bodies));
      }
    }
  }
  if (!begun_ || !report.events.empty()) watch_springs();
  watch_feedback();
  implicit_.update();
  if (repeated) implicit_.compare(repeated->plan, repeated->state, repeated->workspace, repeated->between);
  watch_tables();
  watch_cells(report);
  watch_laws();
  watch_directions();
  watch_guides();
  watch_profiles();
  watch_contacts();
  watch_jumps();
  watch_seams();
  watch_friction(!begun_ || !report.events.empty());
  watch_commands();
  watch_loops(report);
  if (audit_) watch_drift();
  watch_search(report);
  begun_ = true;
}

void NoticeWatch::watch_links(const StepReport& report) {
  if (begun_ && report.events.empty()) return;
  if (begun_)
    for (const MotionKnot& knot : simulation_.get_motion()) links_.update(knot.state, knot.time);
  links_.update(simulation_.state(), simulation_.get_time());
}

void NoticeWatch::watch_bodies() {
  const double limit = kAccurate / dt_;
  for (std::size_t b = 0; b < turning_.size(); ++b) {
    const BodyState& state = simulation_.state().bodies[b];
    const double rate2 = dot(state.w, state.w);
    if (rate2 > limit * limit) {
      const int bodies[] = {static_cast<int>(b)};
      const double size = std::sqrt(rate2) * dt_;
      this->report(
          turning_[b], "rotation", scenario_.model.bodies[b].name, size, [&] { return describe_size("|w|·dt", size); },
          size > kUnresolvedSize ? std::span<const int>(bodies) : std::span<const int>{});
    }
    const Quat& q = state.q;
    const double excess = q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z - 1;
    if (std::abs(excess) > 2 * kNorm && !denormal_[b]) {
      denormal_[b] = true;
      add("norm", scenario_.model.bodies[b].name, format("the norm of its quaternion is off by %.3g", 0.5 * excess));
    }
  }
}

// Watches springs. Modes, switches and poses determine their rates; the first two change at events.
void NoticeWatch::watch_springs() {
  if (scenario_.model.element_count() == static_cast<int>(scenario_.model.loads.size())) return;
  const std::vector<ElementFrequency> frequencies =
      calc_frequencies(simulation_.plan(), simulation_.state(), workspace_);
  implicit_.set_rates(frequencies);
  feedback_.set_rates(frequencies);
  for (const ElementFrequency& e : frequencies) {
    const auto i = static_cast<std::size_t>(e.element);
    const ElementState& state = simulation_.state().elements[i];
    const double size = dt_ * std::max(e.omega, e.decay) * (state.from == 0 && state.to == 0 ? 0 : 1);
    if (size <= kAccurate) continue;
    const char* const what = e.omega > e.decay ? "dt·omega" : "dt·decay";
    const auto describe = [&] {
      return e.implicit
                 ? format("%s %.3g: integrated implicitly, of second order; damps what the step does not resolve", what,
                          size)
                 : describe_size(what, size);
    };
    report(
        stiff_[i], "spring", scenario_.model.element_name(e.element), size, describe,
        e.implicit || size <= kUnresolvedSize ? std::vector<int>{} : list_element_bodies(scenario_.model, e.element));
  }
}

// Watches the profiles of loads that are on: the step's impulse, and time constants.
void NoticeWatch::watch_profiles() {
  const double time = simulation_.get_time();
  for (std::size_t i = 0; i < profiles_.size(); ++i) {
    const Load& load = scenario_.model.loads[i];
    const ElementState& state = simulation_.state().elements[i];
    if (state.from == 0 && state.to == 0) continue;
    const int bodies[] = {load.body};
    const double s = time - state.switched_on;
    if (load.profile.kind == Profile::Kind::kExponential && s >= 0 && load.profile.initial != load.profile.final) {
      const double size = dt_ / load.profile.tau;
      if (size > kAccurate)
        report(
            profile_notices_[i], "profile", load.name, size,
            [&] { return describe_size("dt over the time constant", size); }, bodies);
    }
    if (const double frequency = find_frequency(load.profile); dt_ * frequency > kSineAngle)
      report(
          profile_notices_[i], "profile", load.name, dt_ * frequency,
          [&] {
            return format(
                "its sine of %.4g rad/s turns by %.3g rad in a step, which resolves %.2g: a step of %.3g s would do",
                frequency, dt_ * frequency, kSineAngle, kRoundedDown * kUnresolvedSize / frequency);
          },
          bodies);
    if (!begun_) continue;
    const double error = profiles_[i].add(std::max(s - dt_, 0.0), s);
    if (error > kProfileError)
      report(
          profile_notices_[i], "profile", load.name, error,
          [&] {
            return format(
                "the step misses %.3g of its impulse, between its ticks; a smaller step, or events at its "
                "corners, would do",
                error);
          },
          bodies);
  }
}

void NoticeWatch::watch_directions() {
  for (std::size_t i = 0; i < pointless_.size(); ++i) {
    const PointSpring& spring = scenario_.model.point_springs[i];
    const SpringReading reading = calc_point_spring(simulation_.plan(), simulation_.state(), static_cast<int>(i));
    const double force = spring.stiffness * spring.free_length * reading.scale;
    if (pointless_[i] || reading.length > kCoincident || force == 0) continue;
    pointless_[i] = true;
    add("direction", spring.name,
        format("its two points coincide, to %.1g m, with %.4g N in it: the force has no direction", reading.length,
               force),
        list_element_bodies(scenario_.model, static_cast<int>(scenario_.model.loads.size() + i)));
  }
  for (std::size_t i = 0; i < pointless_sided_.size(); ++i) {
    const OneSided& force = scenario_.model.one_sided[i];
    if (pointless_sided_[i] || force.joint != kNone || force.guide || force.kind == OneSided::Kind::kCord) continue;
    const double length =
        norm(calc_point(force.follower, force.point_follower) - calc_point(force.base, force.point_base));
    if (length > kCoincident) continue;
    const OneSidedReading reading = calc_one_sided(simulation_.plan(), simulation_.workspace(), static_cast<int>(i));
    if (reading.scale == 0) continue;
    pointless_sided_[i] = true;
    add("direction", force.name,
        format("its two points coincide, to %.1g m: its force has no direction; give it a `guide`, or move one of the "
               "points along the line of the force",
               length),
        list_element_bodies(scenario_.model, get_first_one_sided(scenario_.model) + static_cast<int>(i)));
  }
}

void NoticeWatch::watch_guides() {
  for (std::size_t i = 0; i < beside_.size(); ++i) {
    const OneSided& force = scenario_.model.one_sided[i];
    if (!force.guide || simulation_.state().engaged[i] == 0) continue;
    if (calc_one_sided(simulation_.plan(), simulation_.workspace(), static_cast<int>(i)).scale == 0) continue;
    const Vec3 line = calc_point(force.follower, force.point_follower) - calc_point(force.base, force.point_base);
    const Vec3 guide =
        calc_point(force.base, force.point_base + *force.guide) - calc_point(force.base, force.point_base);
    const double beside = norm(line - dot(line, guide) * guide);
    if (beside <= force.stroke) continue;
    const int bodies[] = {force.follower, force.base};
    report(
        beside_[i], "beside", force.name, beside,
        [&] {
          return format(
              "it pushes %.4g m beside its guide, farther than its stroke: its follower has come back, but not onto "
              "it; switch it off at its `stroke_end`",
              beside);
        },
        std::span(bodies).first(force.base == kGround ? 1 : 2));
  }
}

Vec3 NoticeWatch::calc_point(int body, const Eigen::Vector3d& point) const {
  if (body == kGround) return to_vec3(point);
  const BodyState& state = simulation_.state().bodies[at(body)];
  return state.p + rotation_matrix(state.q) * to_vec3(point);
}

void NoticeWatch::watch_contacts() {
  const int parts = get_most_contact_substeps(scenario_.model);
  for (std::size_t i = 0; i < touching_.size(); ++i) {
    const Contact& contact = scenario_.model.contacts[i];
    if (contact.rigid) continue;  // no step resolves it the better
    const ContactReading reading = calc_contact(simulation_.plan(), simulation_.state(), static_cast<int>(i));
    if (!begun_ && reading.closed)
      add("contact", contact.name, format("it is closed at the start, %.3g m deep", reading.depth));
    const double impulse = get_contact_totals(simulation_.plan(), simulation_.state(), static_cast<int>(i)).impulse;
    const double gained = impulse - impulses_[i];
    impulses_[i] = impulse;
    ContactRates rates = calc_rates(scenario_.model, simulation_.state(), contact, reading);
    // A blow that began and ended within the step: its impulse changed the speed by what it came with, or more. How
    // fast it slipped is not known.
    if (!reading.closed && gained > 0)
      rates = {estimate_rates(scenario_.model, contact, gained * calc_least_mobility(scenario_.model, contact)).omega,
               0};
    const double size = dt_ / parts * rates.calc_need();
    if (!(size > 1)) continue;
    report(
        touching_[i], "contact", contact.name, size, [&] { return hil::describe_unresolved(rates, dt_, parts); },
        list_contact_bodies(scenario_.model, static_cast<int>(i)));
  }
}

void NoticeWatch::watch_jumps() {
  for (const ContactJumpSum& jump : jumps_.update()) {
    const double part = jump.calc_part();
    if (!(part > kJumpNotice)) continue;
    const Contact& contact = scenario_.model.contacts[at(jump.contact)];
    report(
        jumping_[at(jump.contact)], "jump", contact.name, part,
        [&] {
          return format(
              "its point jumps along a face or a straight line, up to %.3g m from one tick to the next (%d in all); "
              "%.2g of the rotation depends on which end bears the force; give the body feet: spheres at its "
              "corners or ends, each a shape of its surface",
              jump.way, jump.count, part);
        },
        part > kJumpFailure ? list_contact_bodies(scenario_.model, jump.contact) : std::vector<int>{});
  }
}

void NoticeWatch::watch_seams() {
  for (const ContactSeam& seam : seams_.update()) {
    const Contact& contact = scenario_.model.contacts[at(seam.contact)];
    report(
        doubled_[at(seam.contact)], "seam", contact.name, seam.part,
        [&] {
          return format(
              "two shapes of one surface push a shape at one point, the second one at %.2g of the first one's depth: "
              "each adds its force; give the surface one shape there, a box or a hull over both",
              seam.part);
        },
        seam.part > kSeamFailure ? list_contact_bodies(scenario_.model, seam.contact) : std::vector<int>{});
  }
}

// Watches friction. Modes determine the mobilities; reactions and speeds determine the friction.
void NoticeWatch::watch_friction(bool modes_are_new) {
  if (!has_friction(scenario_.model)) return;
  if (modes_are_new) mobilities_ = calc_mobilities(simulation_.plan(), simulation_.state(), workspace_);
  for (const FrictionRate& rate : calc_friction_rates(simulation_, mobilities_)) {
    const auto i = static_cast<std::size_t>(rate.element);
    const double size = dt_ * rate.decay;
    if (!(size > kAccurate)) continue;
    report(
        sticking_[i], "friction", scenario_.model.element_name(rate.element), size,
        [&] { return hil::describe_unresolved(rate, dt_); }, list_element_bodies(scenario_.model, rate.element));
  }
}

// Watches commands. Half a period is the time between two reversals. Three quick ones in succession are an oscillation.
void NoticeWatch::watch_commands() {
  constexpr int kOscillates = 3;
  constexpr double kPi = 3.14159265358979323846;
  const std::span<const double> values = simulation_.get_inputs();
  for (std::size_t c = 0; c < courses_.size(); ++c) {
    Course& course = courses_[c];
    const double change = values[c] - course.value;
    course.value = values[c];
    if (begun_ && change != 0) links_.add_command(simulation_.get_time() - dt_);
    if (!begun_ || change == 0 || restless_[c]) continue;
    const int direction = change > 0 ? 1 : -1;
    const bool turns = course.direction == -direction;
    course.direction = direction;
    if (!turns) continue;
    const std::int64_t tick = simulation_.get_tick();
    const double size = kPi / static_cast<double>(std::max<std::int64_t>(tick - course.turned, 1));
    course.quick_turns = course.turned >= 0 && size > kAccurate ? course.quick_turns + 1 : 0;
    course.turned = tick;
    if (course.quick_turns < kOscillates) continue;
    restless_[c] = true;
    add("command", scenario_.model.channels[c].name,
        format("its loop swings at dt·omega %.3g: the delay of a tick and the hold turn its phase by %.0f deg", size,
               1.5 * size * 180 / kPi));
  }
}

// Rows that are redundant only nearly: which they are changes only with their number and with events.
void NoticeWatch::watch_loops(const StepReport& report) {
  const bool changed = !begun_ || report.redundant != redundant_ || !report.events.empty();
  redundant_ = report.redundant;
  if (!changed || nearly_redundant_) return;
  for (const RedundantRows& rows :
       list_redundant_rows(simulation_.plan(), simulation_.state(), simulation_.workspace())) {
    if (rows.nearly == 0) continue;
    nearly_redundant_ = true;
    add("redundant", scenario_.model.joints[at(rows.joints.front())].name,
        format("%d of the rows of its closed loops follow from the others only nearly, and are not held: give points "
               "and axes with all their digits, so that axes that should be parallel are",
               rows.nearly));
  }
}

void NoticeWatch::watch_drift() {
  if (drifted_ || scenario_.model.joints.empty()) return;
  double farthest = 1;
  for (const BodyState& body : simulation_.state().bodies) farthest = std::max(farthest, norm(body.p));
  constexpr double kRoundings = 64;
  const double limit = kDrift + kRoundings * std::numeric_limits<double>::epsilon() * farthest;
  const double drift = calc_drift(simulation_.plan(), simulation_.state(), simulation_.workspace());
  if (drift <= limit) return;
  drifted_ = true;
  add("drift", "", format("a joint's rows are off by %.3g m or rad, beyond %.3g", drift, limit));
}

}  // namespace unlatch::hil
