// Contacts of the language, and their results in a run, against closed forms.
#include <cmath>
#include <map>

#include "hil/analysis/accuracy.h"
#include "hil/notices/forecast.h"
#include "tests/hil/analysed_run.h"

namespace unlatch::test {
namespace {

constexpr double kLocated = 1e-6;  // s, also for a peak: located inside the step
constexpr double kAudited = 1e-6;  // of an impact's energy loss: RK4 with eight sub-steps a millisecond

// A ball of 2 kg flies with 3 m/s at a wall of 10^9 kg: k = 2e5 N/m without damping is 316 rad/s, half a period 9.93
// ms.
std::string build_blow(const std::string& law, const std::string& rest = "", double gap = 0.3) {
  return R"(unlatch: 1
name: blow
step: {dt: 1 ms, until: 0.2, contact_substeps: 8}
bodies:
  wall: {mass: 1e9, inertia: [1e9, 1e9, 1e9], shape: [{name: face, box: {size: [2, 10, 10]}}]}
  ball: {mass: 2, inertia: [1, 1, 1], position: [)" +
         std::to_string(1.5 + gap) + R"(, 0, 0], velocity: [-3, 0, 0], shape: [{sphere: {radius: 0.5}}]}
contacts:
  blow: {between: [wall.face, ball], )" +
         law + "}\n" + rest;
}

const hil::RunNotice* find_notice(const AnalysedRun& run, const std::string& name) {
  for (const hil::RunNotice& notice : run.analysis.accuracy().get())
    if (notice.name == name) return &notice;
  return nullptr;
}

TEST(Contacts, ABlowHasItsForceImpulseAndTimes) {
  const AnalysedRun run(
      build_blow("stiffness: 0.2 MN/m",
                 "requirements:\n"
                 "  - {id: force, contact: {name: blow}, at_most: 1 kN}\n"
                 "  - {id: impulse, contact: {name: blow, value: impulse}, take: final, at_most: 20 N s}\n"
                 "  - {id: touch, time: {event: lift:blow, after: touch:blow}, at_most: 1 s}\n"));
  const double omega = std::sqrt(2e5 / 2), half = std::acos(-1.0) / omega;
  const std::vector<hil::ContactRecord> contacts = run.analysis.list_contacts();
  ASSERT_EQ(contacts.size(), 1u);
  EXPECT_NEAR(*contacts[0].touch, 0.1, 1e-9);
  EXPECT_NEAR(*contacts[0].lift, 0.1 + half, kLocated);
  EXPECT_NEAR(contacts[0].duration, half, kLocated);
  EXPECT_EQ(contacts[0].touches, 1);
  EXPECT_NEAR(contacts[0].peak_force, 3 * std::sqrt(2e5 * 2), 1e-3);
  EXPECT_NEAR(contacts[0].peak_time, 0.1 + half / 2, 1e-5);
  EXPECT_NEAR(contacts[0].depth, 3 / omega, 1e-7);
  EXPECT_NEAR(contacts[0].totals.impulse, 12, 1e-5);
  EXPECT_NEAR(contacts[0].totals.dissipated, 0, 1e-6);
  EXPECT_NEAR(run.judge("force").value, contacts[0].peak_force, 1e-1);
  EXPECT_FALSE(run.judge("force").is_met());
  EXPECT_NEAR(run.judge("impulse").value, 12, 1e-5);
  EXPECT_NEAR(run.judge("touch").value, half, kLocated);
  EXPECT_EQ(run.analysis.timeline.size(), 2u);
  EXPECT_EQ(find_notice(run, "contact"), nullptr);
}

TEST(Contacts, EstimatedErrorsBoundTheTrueOnesOfABlow) {
  const auto list = [](const std::string& dt) {
    std::string text = build_blow("stiffness: 0.2 MN/m");
    text.replace(text.find("dt: 1 ms"), 8, "dt: " + dt);
    const AnalysedRun run(text);
    return hil::list_values(run.scenario, *run.simulation, run.analysis);
  };
  const std::vector<hil::NamedValue> full = list("2 ms"), half = list("1 ms"), quarter = list("0.5 ms");
  const AnalysedRun run(build_blow("stiffness: 0.2 MN/m"));
  const hil::AccuracyReport report = hil::compare_steps(run.scenario, *run.simulation, full, half, quarter);
  EXPECT_EQ(report.mismatch, "");
  const double omega = std::sqrt(2e5 / 2), swing = std::acos(-1.0) / omega;
  const std::map<std::string, double> truths{{"first touch of blow", 0.1},
                                             {"last lift of blow", 0.1 + swing},
                                             {"peak force of blow", 3 * std::sqrt(2e5 * 2)},
                                             {"greatest depth of blow", 3 / omega},
                                             {"impulse of blow", 12}};
  std::size_t found = 0;
  for (const hil::AccuracyEntry& entry : report.entries) {
    const auto truth = truths.find(entry.value.what);
    if (truth == truths.end()) continue;
    ++found;
    EXPECT_LT(std::abs(entry.value.value - truth->second), 3 * entry.error + 1e-10 * truth->second) << truth->first;
    EXPECT_LT(entry.error, 1e-3 * truth->second) << truth->first;
  }
  EXPECT_EQ(found, truths.size());
}

TEST(Contacts, TheAuditExplainsTheEnergyThatABlowTakes) {
  const AnalysedRun run(build_blow("stiffness: 0.2 MN/m, restitution: {coefficient: 0.5, speed: 3 m/s}"));
  const hil::EnergyBalance& energy = run.analysis.accuracy().get_energy();
  EXPECT_NEAR(energy.contacts, -0.5 * 2 * 9 * 0.75, 1e-4);
  EXPECT_LT(std::abs(energy.unexplained), kAudited * 6.75);
}

TEST(Contacts, OneThatIsClosedAtTheStartIsToldAndIsNoTouch) {
  const std::string text = build_blow("stiffness: 0.2 MN/m", "", -0.001);
  const AnalysedRun run(text);
  EXPECT_TRUE(run.analysis.list_contacts()[0].closed_at_start);
  EXPECT_FALSE(run.analysis.list_contacts()[0].touch.has_value());
  ASSERT_NE(find_notice(run, "contact"), nullptr);
  EXPECT_NE(find_notice(run, "contact")->text.find("closed at the start"), std::string::npos);
  const auto at_start = hil::build_simulation(run.scenario);
  bool found = false;
  for (const hil::Finding& finding : hil::find_surprises(run.scenario, *at_start))
    found = found || (finding.name == "contact" && finding.where == "contact 'blow'");
  EXPECT_TRUE(found);
}

TEST(Contacts, AStepThatDoesNotResolveABlowIsTold) {
  const AnalysedRun run(build_blow("stiffness: 2000 MN/m"));  // √(k/m)·h = 3.95
  ASSERT_NE(find_notice(run, "contact"), nullptr);
  EXPECT_NE(find_notice(run, "contact")->text.find("sqrt(k/m)·h"), std::string::npos);
}

TEST(Contacts, EventsWaitForContactsAndClearances) {
  const AnalysedRun run(
      build_blow("stiffness: 0.2 MN/m",
                 "events:\n"
                 "  - {name: near, when: {clearance: {between: [wall, ball]}, below: 15 cm}}\n"
                 "  - {name: hit, when: {contact: blow}, then: [{switch: {element: blow, to: false}}]}\n"));
  ASSERT_GE(run.analysis.timeline.size(), 3u);
  EXPECT_EQ(run.analysis.timeline[0].name, "near");
  EXPECT_NEAR(run.analysis.timeline[0].time, 0.05, 1e-9);
  EXPECT_EQ(run.analysis.timeline[1].name, "hit");
  EXPECT_NEAR(run.simulation->state().bodies[1].v.x, -3, 1e-9) << "switched off at once, it pushes no more";
}

}  // namespace
}  // namespace unlatch::test
