#include "hil/run/analysis/accuracy.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <map>

#include "hil/run/notices/resolution.h"
#include "unlatch/model/law_places.h"

namespace unlatch::hil {
namespace {

constexpr double kRounding = 1e-13;  // relative to a value or its size: some hundred roundings, of thousands of ticks
constexpr double kLeastOrder = 0.5, kMostOrder = 4;
// Sizes below which a value is at rest: its error is compared with these, not with its own rounding.
constexpr double kStillLength = 1e-6, kStillSpeed = 1e-6, kStillRate = 1e-6;  // m, m/s, rad/s
constexpr double kUnloaded = 1e-9;                                            // of the largest reaction of all joints
constexpr double kOrderMissed = 1;  // an observed order this much below the method's shows that another error dominates

using Kind = NamedValue::Kind;

void add_times(const RunAnalysis& analysis, double length, std::vector<NamedValue>& values) {
  std::map<std::string, int> seen;
  for (const TimelineEntry& entry : analysis.timeline) {
    std::string what = "time of " + entry.name + (entry.subject.empty() ? "" : " " + entry.subject);
    if (const int count = ++seen[what]; count > 1) what += ", no. " + std::to_string(count);
    values.push_back({what, "s", Kind::kTime, entry.time, length, entry.time});
  }
}

void add_clearances(const RunAnalysis& analysis, std::vector<NamedValue>& values) {
  for (const Clearance& c : analysis.clearances()) {
    values.push_back({"smallest clearance " + c.name_a + " – " + c.name_b, "m", Kind::kClearance, c.smallest,
                      std::max(std::abs(c.smallest), kStillLength), c.time});
  }
}

void add_rates(const RunAnalysis& analysis, std::vector<NamedValue>& values) {
  for (const TipOff& tip_off : analysis.tip_offs) {
    const double size = std::max(norm(tip_off.w), kStillRate);
    const double components[3] = {tip_off.w.x, tip_off.w.y, tip_off.w.z};
    for (int i = 0; i < 3; ++i) {
      values.push_back({"rate of " + tip_off.body + " about " + "xyz"[i] + " at the release of " + tip_off.joint,
                        "rad/s", Kind::kRate, components[i], size, tip_off.time});
    }
  }
}

void add_separations(const Model& model, const RunAnalysis& analysis, std::vector<NamedValue>& values) {
  const auto get_name = [&model](int body) {
    return body == kGround ? std::string("ground") : model.bodies[static_cast<std::size_t>(body)].name;
  };
  for (const Separation& pair : analysis.list_separations()) {
    const std::string of = " of " + get_name(pair.base.body) + " – " + get_name(pair.follower.body);
    const double speed = std::max(std::hypot(pair.along, pair.across), kStillSpeed);
    const double rate = std::max(std::hypot(pair.relative.axial, pair.relative.transverse), kStillRate);
    values.push_back({"end of push" + of, "s", Kind::kSeparation, pair.end, pair.end, pair.end});
    values.push_back({"separation velocity" + of + ", along", "m/s", Kind::kSeparation, pair.along, speed, pair.end});
    values.push_back({"separation velocity" + of + ", across", "m/s", Kind::kSeparation, pair.across, speed, pair.end});
    values.push_back(
        {"relative rate" + of + ", axial", "rad/s", Kind::kSeparation, pair.relative.axial, rate, pair.end});
    values.push_back(
        {"relative rate" + of + ", transverse", "rad/s", Kind::kSeparation, pair.relative.transverse, rate, pair.end});
  }
}

void add_requirements(const Scenario& scenario, const RunAnalysis& analysis, std::vector<NamedValue>& values) {
  for (const Verdict& verdict : analysis.judge()) {
    if (!verdict.evaluated) continue;
    const Requirement& requirement = scenario.requirements[verdict.requirement];
    if (requirement.received) continue;  // samples and bits: the true value's accuracy is the step's
    values.push_back({"requirement " + requirement.id, requirement.unit, Kind::kRequirement, verdict.value,
                      std::max(std::abs(verdict.value), std::abs(verdict.limit)), verdict.time});
  }
}

// The largest reaction of the joint's rows from `first` on, three of them; N or N m.
double find_largest(const RunAnalysis& analysis, std::size_t joint, int first) {
  double largest = 0;
  for (int row = first; row < first + 3; ++row)
    largest = std::max(largest, std::abs(analysis.get_peak(joint, static_cast<std::size_t>(row)).value));
  return largest;
}

// A force is compared with the joint's forces; a moment with its moments, or its forces times their arm: what is zero
// but for rounding limits nothing.
void add_reactions(const Model& model, const RunAnalysis& analysis, std::vector<NamedValue>& values) {
  double largest_force = 0, largest_moment = 0, longest = 0;
  for (std::size_t j = 0; j < model.joints.size(); ++j) {
    longest = std::max(longest, calc_arm(model.joints[j]));
    largest_force = std::max(largest_force, find_largest(analysis, j, kX));
    largest_moment = std::max(largest_moment, find_largest(analysis, j, kRotX));
  }
  largest_moment =
      std::max(largest_moment, largest_force * longest);  // a structure that forces alone load has some, too
  for (std::size_t j = 0; j < model.joints.size(); ++j) {
    const double force = std::max(find_largest(analysis, j, kX), kUnloaded * largest_force);
    const double moment =
        std::max({find_largest(analysis, j, kRotX), force * calc_arm(model.joints[j]), kUnloaded * largest_moment});
    for (int row = 0; row < kRows; ++row) {
      const PeakReaction peak = analysis.get_peak(j, static_cast<std::size_t>(row));
      if (peak.value == 0) continue;
      values.push_back({"peak reaction " + model.joints[j].name + " " + kRowNames[row], row < kRotX ? "N" : "N m",
                        Kind::kReaction, peak.value, row < kRotX ? force : moment, peak.time});
    }
  }
}

void add_contacts(const RunAnalysis& analysis, double length, std::vector<NamedValue>& values) {
  for (const ContactRecord& contact : analysis.list_contacts()) {
    if (contact.touches == 0 && !contact.closed_at_start) continue;
    const std::string of = " of " + contact.name;
    const auto add = [&](const char* what, const char* unit, double value, double size, double time) {
      values.push_back({what + of, unit, Kind::kContact, value, size, time});
    };
    if (contact.touch) add("first touch", "s", *contact.touch, length, *contact.touch);
    if (contact.lift) add("last lift", "s", *contact.lift, length, *contact.lift);
    add("peak force", "N", contact.peak_force, contact.peak_force, contact.peak_time);
    add("greatest depth", "m", contact.depth, contact.depth, contact.peak_time);
    add("impulse", "N s", contact.totals.impulse, contact.totals.impulse, contact.peak_time);
    add("loss", "J", contact.totals.dissipated, contact.totals.dissipated, contact.peak_time);
  }
}

void add_poses(const Model& model, const Simulation& simulation, std::vector<NamedValue>& values) {
  const double time = simulation.get_time();
  for (std::size_t b = 0; b < model.bodies.size(); ++b) {
    const Body& body = model.bodies[b];
    if (body.marker) continue;  // its motion follows from its flexible body
    const BodyState& s = simulation.state().bodies[b];
    const double moved = norm(s.p - Vec3{body.p_WB.x(), body.p_WB.y(), body.p_WB.z()});
    const double p[3] = {s.p.x, s.p.y, s.p.z}, q[4] = {s.q.w, s.q.x, s.q.y, s.q.z};
    for (int i = 0; i < 3; ++i)
      values.push_back({"final position of " + body.name + " " + "xyz"[i], "m", Kind::kPose, p[i], moved, time});
    for (int i = 0; i < 4; ++i)
      values.push_back({"final attitude of " + body.name + " " + "wxyz"[i], "", Kind::kPose, q[i], 1, time});
  }
}

AccuracyEntry estimate(const NamedValue& full, const NamedValue& half, const NamedValue& quarter) {
  AccuracyEntry entry;
  entry.value = full;
  entry.half = half.value;
  entry.quarter = quarter.value;
  const double a = full.value - half.value, b = half.value - quarter.value;
  const double rounding = kRounding * std::max(full.size, std::abs(full.value));
  double order = kLeastOrder;
  if (a * b > 0) {
    entry.order = std::log2(a / b);
    order = std::clamp(*entry.order, kLeastOrder, kMostOrder);
  }
  entry.error = std::abs(full.value - quarter.value) + std::abs(b) / (std::exp2(order) - 1) + rounding;
  const bool is_rounding = std::abs(a) + std::abs(b) <= 4 * rounding;
  if (is_rounding) entry.order.reset();
  entry.settles = is_rounding;
  return entry;
}

// Order of the method: 2 if an implicit element acts at any time.
struct Method {
  double order = 4;
  std::string implicit;  // the element
  std::string stiff;     // an element beyond kAccurate, explicit
};

Method find_method(const Scenario& scenario, const Simulation& simulation) {
  Method method;
  const double dt = simulation.plan().get_options().dt;
  for (const SpringResolution& spring : calc_resolutions(simulation)) {
    const std::string& name = scenario.model.element_name(spring.element);
    if (spring.implicit && method.implicit.empty()) method.implicit = name;
    if (!spring.implicit && dt * spring.get_worst() > kAccurate && method.stiff.empty()) method.stiff = name;
  }
  for (const Body& body : scenario.model.bodies) {
    if (!body.flexible || body.flexible->frequencies.size() == 0) continue;
    if (dt * body.flexible->frequencies.maxCoeff() > kResolved) method.implicit = body.name;
  }
  if (!method.implicit.empty()) method.order = 2;
  return method;
}

// Time of a corner in a load's table that lies before `time` and not on a tick of all three runs, s, if the table has
// more points there than a step is split at; negative: none.
double find_corner(const Model& model, double time, double dt, std::string& load) {
  constexpr double kOnTick = 1e-6;
  for (const Load& candidate : model.loads) {
    if (candidate.profile.kind != Profile::Kind::kTable) continue;
    const std::vector<double>& times = candidate.profile.times;
    for (std::size_t i = static_cast<std::size_t>(kMostCorners); i < times.size(); ++i) {
      const double corner = times[i], ticks = corner / dt;
      if (corner - times[i - static_cast<std::size_t>(kMostCorners)] > dt) continue;
      if (corner <= 0 || corner >= time) continue;
      if (candidate.on && std::abs(ticks - std::round(ticks)) < kOnTick) continue;
      load = candidate.name;
      return corner;
    }
  }
  return -1;
}

std::string text(const char* pattern, double number, const std::string& name) {
  char line[200];
  std::snprintf(line, sizeof line, pattern, name.c_str(), number);
  return line;
}

// Returns the likely reason; the most specific one is tried first.
std::string find_reason(const Scenario& scenario, const Method& method, const AccuracyEntry& entry,
                        const std::vector<AccuracyEntry>& all, double dt) {
  if (!method.stiff.empty()) return "spring '" + method.stiff + "' is stiffer than the step resolves";
  const AccuracyEntry* mover = nullptr;
  for (const AccuracyEntry& other : all) {
    if (other.value.kind != Kind::kTime || other.settles || other.value.time > entry.value.time) continue;
    if (other.value.what == entry.value.what) continue;
    if (mover == nullptr || other.value.time < mover->value.time) mover = &other;
  }
  if (mover != nullptr) return text("an event that moves: %s, by some %.2g s", mover->error, mover->value.what);
  std::string load;
  if (const double corner = find_corner(scenario.model, entry.value.time, dt, load); corner >= 0)
    return text("a corner of the table of '%s', at %.6g s of its own time, inside a step", corner, load);
  if (entry.value.kind == Kind::kTime)
    return "an event is located by two iterations, from another part of a step each time";
  return "events or switches inside steps: their places in the step change with it";
}

}  // namespace

double calc_arm(const Joint& joint) {
  const double base = joint.base == kGround ? 0 : joint.point_base.norm();
  return std::max(base, joint.point_follower.norm());
}

std::vector<NamedValue> list_values(const Scenario& scenario, const Simulation& simulation,
                                    const RunAnalysis& analysis) {
  std::vector<NamedValue> values;
  add_times(analysis, simulation.get_time(), values);
  add_clearances(analysis, values);
  add_rates(analysis, values);
  add_separations(scenario.model, analysis, values);
  add_reactions(scenario.model, analysis, values);
  add_contacts(analysis, simulation.get_time(), values);
  add_poses(scenario.model, simulation, values);
  add_requirements(scenario, analysis, values);
  return values;
}

AccuracyReport compare_steps(const Scenario& scenario, const Simulation& simulation,
                             const std::vector<NamedValue>& full, const std::vector<NamedValue>& half,
                             const std::vector<NamedValue>& quarter) {
  AccuracyReport report;
  std::map<std::string, const NamedValue*> at_half, at_quarter;
  for (const NamedValue& value : half) at_half[value.what] = &value;
  for (const NamedValue& value : quarter) at_quarter[value.what] = &value;
  for (const NamedValue& value : full) {
    if (at_half.count(value.what) + at_quarter.count(value.what) < 2) {
      if (report.mismatch.empty())
        report.mismatch = value.what + ": it is there at the scenario's step, but not at its half and its quarter";
      continue;
    }
    report.entries.push_back(estimate(value, *at_half[value.what], *at_quarter[value.what]));
    at_half.erase(value.what);
  }
  if (!at_half.empty() && report.mismatch.empty())
    report.mismatch = at_half.begin()->first + ": it is there at half the scenario's step, but not at the whole";
  const Method method = find_method(scenario, simulation);
  for (AccuracyEntry& entry : report.entries)
    entry.settles = entry.settles || (entry.order && *entry.order >= method.order - kOrderMissed);
  const double dt = simulation.plan().get_options().dt;
  for (AccuracyEntry& entry : report.entries)
    if (!entry.settles) entry.reason = find_reason(scenario, method, entry, report.entries, dt);
  return report;
}

std::pair<double, std::string> estimate_step(const AccuracyReport& report, double dt, double tolerance, double most) {
  std::pair<double, std::string> least{most, ""};
  for (const AccuracyEntry& entry : report.entries) {
    if (entry.value.size <= 0) continue;
    const double order = std::clamp(entry.order.value_or(1), 1.0, kMostOrder);
    const double step = dt * std::pow(tolerance / entry.get_relative(), 1 / order);
    if (step < least.first) least = {step, entry.value.what};
  }
  return least;
}

double calc_largest_error(const AccuracyReport& report, const std::vector<NamedValue>& values) {
  std::map<std::string, const AccuracyEntry*> best;
  for (const AccuracyEntry& entry : report.entries) best[entry.value.what] = &entry;
  double largest = 0;
  for (const NamedValue& value : values) {
    const auto entry = best.find(value.what);
    if (entry == best.end()) return std::numeric_limits<double>::infinity();
    const double size = entry->second->value.size;
    if (size > 0) largest = std::max(largest, std::abs(value.value - entry->second->quarter) / size);
    best.erase(entry);
  }
  return best.empty() ? largest : std::numeric_limits<double>::infinity();
}

}  // namespace unlatch::hil
