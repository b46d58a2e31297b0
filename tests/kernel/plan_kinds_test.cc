// Images of plans with rigid contacts, with flexible bodies in loops, with laws, air and masses: they fly with the bits
// of their plans, and a number of them that leads elsewhere is refused.
#include <gtest/gtest.h>

#include <cstring>
#include <functional>
#include <string>
#include <vector>

#include "kernel/joints/residuals.h"
#include "kernel/plan/plan_image.h"
#include "tests/support/law_models.h"
#include "tests/support/modal_model.h"
#include "tests/support/rigid_models.h"
#include "tests/support/simulation.h"

namespace unlatch::test::plan_kinds_test {
namespace {

using geometry::ShapeKind;

// A plan's image at a place of its own, opened, with its numbers to be changed where they stand.
class Image {
 public:
  explicit Image(const Plan& plan) : block_(plan.get_image().size()) {
    std::memcpy(block_.get().data(), plan.get_image().data(), plan.get_image().size());
    opened_ = open_plan(block_.get(), memory_);
  }
  const Plan* get_plan() const { return opened_.plan ? &*opened_.plan : nullptr; }
  const PlanData& data() const { return get_data(*opened_.plan); }
  PlanNumbers& numbers() { return reinterpret_cast<ImageHeader*>(block_.get().data())->numbers; }
  // `at`: a number in a list of the image.
  template <class T>
  void set(const T& at, std::type_identity_t<T> value) {
    const std::byte* const place = reinterpret_cast<const std::byte*>(&at);
    const std::span<std::byte> all = block_.get();
    ASSERT_TRUE(place >= all.data() && place + sizeof(T) <= all.data() + all.size()) << "not of the image";
    std::memcpy(all.data() + (place - all.data()), &value, sizeof(T));
  }
  // Once its checksum is that of what it holds.
  ImageStatus reopen() {
    ImageHeader& header = *reinterpret_cast<ImageHeader*>(block_.get().data());
    header.checksum = calc_words_hash(block_.get().subspan(kImageChecked));
    PlanMemory memory;
    return open_plan(block_.get(), memory).status;
  }

 private:
  Block block_;
  PlanMemory memory_;
  OpenedPlan opened_;
};

std::uint64_t fly(const Plan& plan, int ticks) {
  Block state_memory(plan.get_state_bytes()), workspace_memory(plan.get_workspace_bytes());
  State state(plan, state_memory.get());
  Workspace workspace(plan, workspace_memory.get());
  init_state(plan, state);
  for (int i = 0; i < ticks; ++i) {
    const StepReport report = step(plan, {plan.get_initial_commands()}, state, workspace);
    EXPECT_EQ(report.status, StepStatus::kOk) << get_status_text(report.status) << " at tick " << i;
    if (report.status != StepStatus::kOk) return 0;
  }
  return calc_hash(state);
}

void expect_the_same_flight(const Model& model, int ticks = 60) {
  const Plan plan = compile_or_throw(model, {});
  Image image(plan);
  ASSERT_NE(image.get_plan(), nullptr) << model.name;
  const std::uint64_t hash = fly(plan, ticks);
  EXPECT_NE(hash, 0u) << model.name;
  EXPECT_EQ(fly(*image.get_plan(), ticks), hash) << model.name;
}

// A change of one number, which makes an image that is refused.
struct Change {
  const char* what;
  std::function<void(Image& image, const PlanData& data)> make;
};
void expect_refused(const Model& model, const std::vector<Change>& changes) {
  const Plan plan = compile_or_throw(model, {});
  for (const Change& change : changes) {
    Image image(plan);
    ASSERT_NE(image.get_plan(), nullptr);
    EXPECT_EQ(image.reopen(), ImageStatus::kOk) << change.what;
    change.make(image, image.data());
    EXPECT_EQ(image.reopen(), ImageStatus::kRange) << change.what;
  }
}

geometry::Shape build_block() {
  geometry::Shape shape;
  shape.kind = ShapeKind::kBox;
  shape.from = {0, 0, -0.5};
  shape.size = {4, 4, 1};
  return shape;
}

// Two capsules that cross, one fixed, one of 1 kg that lies on it.
Model build_crossing() {
  Model model;
  model.name = "crossing";
  model.gravity.uniform = {0, 0, -kGravity};
  model.bodies = {box("rod", 1, 1e-3, 0.1, 0.1)};
  model.bodies[0].p_WB = {0, 0, 0.25};
  geometry::Shape peg = build_sphere(0.2, {0, -1, 0}), rod = build_sphere(0.05, {-0.8, 0, 0});
  peg.kind = rod.kind = ShapeKind::kCapsule;
  peg.to = {0, 1, 0}, rod.to = {0.8, 0, 0};
  model.surfaces = {{"peg", kGround, {peg}}, {"rod", 0, {rod}}};
  model.contacts = {touch_rigidly("rod on peg", 0, 1)};
  add_contact_events(model);
  return model;
}

TEST(PlanKinds, RigidContactsFlyFromImagesOfEveryPairThatHasARow) {
  expect_the_same_flight(build_rigid_feet());
  Model model = build_rigid_feet();
  model.name = "rough feet";
  model.contacts[0].friction = 0.5;
  model.bodies[0].v_WB = {0.5, 0.25, 0};
  expect_the_same_flight(model);
  model.name = "feet on a box";
  model.surfaces[0].shapes = {build_block()};
  expect_the_same_flight(model);
  model.name = "the feet are the base";
  std::swap(model.contacts[0].base, model.contacts[0].follower);
  expect_the_same_flight(model);
  expect_the_same_flight(build_crossing());
}

TEST(PlanKinds, ImagesOfRigidContactsWithoutARowOrWithTooManyAreRefused) {
  const auto set_kind = [](int shapes, ShapeKind kind) {
    return [=](Image& image, const PlanData& data) {
      image.set(data.shape_parts[at(data.shapes[at(shapes)].first)].kind, kind);
    };
  };
  expect_refused(build_rigid_feet(),
                 {{"a box on a half-space", set_kind(1, ShapeKind::kBox)},
                  {"a sphere in a tube", set_kind(0, ShapeKind::kHollow)},
                  {"one pair more", [](Image& image, const PlanData&) { ++image.numbers().rigid_pairs; }},
                  {"no pair", [](Image& image, const PlanData&) { image.numbers().rigid_pairs = 0; }},
                  {"a stiff contact with rows",
                   [](Image& image, const PlanData& data) { image.set(data.contacts[0].rigid, false); }}});
  expect_refused(build_crossing(), {{"a capsule on a box", set_kind(0, ShapeKind::kBox)}});
  Model model = build_rigid_feet();
  model.surfaces[1].shapes.clear();
  for (int i = 0; i < 30; ++i)
    model.surfaces[1].shapes.push_back(build_sphere(0.125, {0.25 * (i % 6) - 0.625, 0.25 * (i / 6) - 0.5, -0.125}));
  expect_the_same_flight(model, 3);
  expect_refused(model, {{"three rows for each of thirty pairs",
                          [](Image& image, const PlanData& data) { image.set(data.contacts[0].friction, 0.5); }}});
}

// A mast whose ends two ball joints hold, and a bar between two of its markers: two loops through a body that bends.
Model build_held_mast() {
  constexpr int kModes = 3;
  const ModalBody lumped = build_lattice_mast(3, kModes, Support::kFree);
  Model model;
  model.name = "held mast";
  model.gravity.uniform = {0, -9.81, 1};
  model.bodies = {build_flexible_body("mast", lumped)};
  for (const std::size_t particle : {std::size_t{0}, std::size_t{6}, std::size_t{9}, std::size_t{15}})
    model.bodies.push_back(
        build_marker("at" + std::to_string(particle), 0, lumped, particle, Eigen::Matrix3Xd::Zero(3, kModes)));
  model.bodies.push_back(box("bar", 2, 0.2, 0.3, 0.4));
  const Eigen::Vector3d a = model.bodies[2].marker->position, b = model.bodies[3].marker->position;
  model.bodies[5].p_WB = 0.5 * (a + b);
  const auto join = [&](const std::string& name, int base, int follower, const Eigen::Vector3d& at, RowSet rows) {
    Joint joint;
    joint.name = name;
    joint.base = base;
    joint.follower = follower;
    if (base == kGround) joint.point_base = at;
    if (follower == 5) joint.point_follower = at - model.bodies[5].p_WB;
    joint.modes = {{"held", rows}};
    model.joints.push_back(joint);
  };
  join("near", kGround, 1, model.bodies[1].marker->position, kPointRows);
  join("far", kGround, 4, model.bodies[4].marker->position, kPointRows);
  join("first", 2, 5, a, kPointRows);
  join("second", 3, 5, b, row_bit(kX) | row_bit(kY));
  return model;
}

TEST(PlanKinds, AFlexibleBodyInLoopsFliesFromItsImageAndItsRowsHold) {
  const Model model = build_held_mast();
  expect_the_same_flight(model, 200);
  Simulation s(model);
  ASSERT_EQ(s.data().loops.size(), 2u);
  for (int i = 0; i < 200; ++i) {
    ASSERT_EQ(s.advance().status, StepStatus::kOk);
    update_motion(s);
    ASSERT_LT(calc_drift(s.data(), s.state, s.evaluation()), 1e-9) << i;
  }
}

TEST(PlanKinds, ImagesOfFlexibleBodiesInLoopsThatLeadElsewhereAreRefused) {
  // The first node of the wanted kind of body.
  const auto find = [](const PlanData& data, bool marker) -> const LoopNode& {
    for (const LoopNode& node : data.loop_nodes) {
      const std::int32_t body = data.nodes[at(node.node)].body;
      const std::int32_t flexible = data.bodies[at(body)].flexible;
      if (flexible != kNone && (data.flexible[at(flexible)].body != body) == marker) return node;
    }
    throw std::out_of_range("no such node");
  };
  std::vector<Change> changes;
  for (const bool marker : {false, true}) {
    for (const std::int32_t modal : {-1, 1 << 20})
      changes.push_back({"its modal rows", [=](Image& i, const PlanData& d) { i.set(find(d, marker).modal, modal); }});
    changes.push_back({"no parent", [=](Image& i, const PlanData& d) {
                         const LoopNode& node = find(d, marker);
                         i.set(node.parent_loads, node.parent_loads == kNone ? 0 : kNone);
                       }});
  }
  for (const std::int32_t marker : {-1, 4})
    changes.push_back({"its marker", [=](Image& i, const PlanData& d) { i.set(find(d, true).marker, marker); }});
  changes.push_back({"columns that no pack fills", [](Image& i, const PlanData&) { ++i.numbers().loop_columns; }});
  changes.push_back({"fewer columns than rows", [](Image& i, const PlanData&) { i.numbers().loop_columns = 0; }});
  changes.push_back({"one row more", [](Image& i, const PlanData&) { ++i.numbers().loop_rows; }});
  changes.push_back({"a marker of no flexible body", [](Image& i, const PlanData& d) { i.set(d.markers[0].body, 5); }});
  changes.push_back(
      {"a marker that is its body", [](Image& i, const PlanData& d) { i.set(d.markers[0].body, d.flexible[0].body); }});
  changes.push_back({"held by no marker of its own",
                     [](Image& i, const PlanData& d) { i.set(d.flexible[0].inboard, std::int32_t{4}); }});
  changes.push_back(
      {"held before its markers", [](Image& i, const PlanData& d) { i.set(d.flexible[0].inboard, std::int32_t{-2}); }});
  expect_refused(build_held_mast(), changes);
}

// A ball under a law that reads a command, and two tables, one of them smooth and over two axes.
Model build_commanded() {
  using laws::constant;
  using laws::quantity;
  using laws::step_of;
  using Kind = LawStep::Kind;
  Model model =
      laws::build_pushed({step_of(Kind::kCommand, 1), quantity(0), constant(2), step_of(Kind::kTable, 0),
                          step_of(Kind::kMultiply), quantity(0), step_of(Kind::kTable, 1), step_of(Kind::kAdd)});
  model.name = "commanded";
  for (const double initial : {3.0, 5.0}) {
    Channel channel;
    channel.name = initial == 3 ? "other" : "thrust";
    channel.initial = initial;
    channel.maximum = 10;
    model.channels.push_back(channel);
  }
  const auto value = [](const std::vector<double>& at) { return 1 + at[0] * at[0] + 0.1 * at.back(); };
  model.tables = {laws::table_of({{-1, 0, 1, 2, 4}, {0, 1, 2, 3}}, value), laws::table_of({{-1, 0.5, 3}}, value)};
  model.tables[0].interpolation = Table::Interpolation::kSmooth;
  model.tables[1].name = "linear";
  return model;
}

TEST(PlanKinds, ALawThatReadsACommandFliesFromItsImage) {
  const Model model = build_commanded();
  expect_the_same_flight(model);
  // At x = 0 the force is 5 · (1 + 0.1 · 2) and what the linear table has at 0, which lies between its knots.
  Simulation s(model);
  ASSERT_EQ(evaluate_state(s), kNone);
  const double low = 1 + 1 - 0.1, high = 1 + 0.25 + 0.05;
  EXPECT_NEAR(s.workspace.accelerations[0].lin.x * 2, 5 * (1 + 0.2) + low + (high - low) * 1 / 1.5, 1e-12);
}

TEST(PlanKinds, ImagesOfLawsAndTablesThatLeadElsewhereAreRefused) {
  using Kind = LawStep::Kind;
  const auto find = [](const PlanData& data, Kind kind) -> const PlanLawStep& {
    for (const PlanLawStep& step : data.laws.steps)
      if (step.kind == kind) return step;
    throw std::out_of_range("no such step");
  };
  std::vector<Change> changes;
  for (const std::int32_t subject : {-1, 2})
    for (const Kind kind : {Kind::kCommand, Kind::kTable, Kind::kQuantity})
      changes.push_back(
          {"what a step reads", [=](Image& i, const PlanData& d) { i.set(find(d, kind).subject, subject); }});
  changes.push_back({"a step that takes more than there is",
                     [=](Image& i, const PlanData& d) { i.set(find(d, Kind::kCommand).kind, Kind::kAdd); }});
  changes.push_back({"a step that leaves more than one value",
                     [=](Image& i, const PlanData& d) { i.set(find(d, Kind::kAdd).kind, Kind::kConstant); }});
  for (const std::int32_t place : {-2, 99})
    changes.push_back({"where a step keeps its coordinates",
                       [=](Image& i, const PlanData& d) { i.set(find(d, Kind::kTable).place, place); }});
  for (const std::int32_t support : {1, 5, 6})
    changes.push_back(
        {"knots that a value takes in", [=](Image& i, const PlanData& d) { i.set(d.laws.axes[0].support, support); }});
  changes.push_back({"more than the axis has",
                     [](Image& i, const PlanData& d) { i.set(d.laws.axes.back().support, std::int32_t{4}); }});
  changes.push_back(
      {"a stride of nothing", [](Image& i, const PlanData& d) { i.set(d.laws.axes[0].stride, std::int32_t{0}); }});
  changes.push_back({"a last axis that skips values",
                     [](Image& i, const PlanData& d) { i.set(d.laws.axes[1].stride, std::int32_t{2}); }});
  for (const std::int32_t cells : {-1, 1 << 20})
    changes.push_back(
        {"cells of a smooth axis", [=](Image& i, const PlanData& d) { i.set(d.laws.axes[0].cells, cells); }});
  for (const std::int32_t count : {0, 7})
    changes.push_back(
        {"number of a table's axes", [=](Image& i, const PlanData& d) { i.set(d.laws.tables[0].axis_count, count); }});
  for (const std::int32_t count : {1, 65537})
    changes.push_back(
        {"number of an axis' knots", [=](Image& i, const PlanData& d) { i.set(d.laws.axes[0].count, count); }});
  changes.push_back({"its values", [](Image& i, const PlanData& d) { i.set(d.laws.tables[0].values, 1 << 20); }});
  changes.push_back(
      {"no parts", [](Image& i, const PlanData& d) { i.set(d.laws.axes[0].bucket_count, std::int32_t{0}); }});
  expect_refused(build_commanded(), changes);
}

// A tank that empties, in air, above a planet.
Model build_flying_tank() {
  Model model;
  model.name = "flying tank";
  model.bodies = {box("tank", 20, 3, 5, 6), box("bolted", 1, 0.1, 0.1, 0.1)};
  MassLaw law;
  law.of = MassLaw::Of::kBurnt;
  law.knots = {{0, 20, {0, 0, 0}, model.bodies[0].inertia}, {4, 16, {0.1, 0, 0}, 0.8 * model.bodies[0].inertia}};
  model.bodies[0].law = law;
  Load thrust;
  thrust.name = "thrust";
  thrust.profile.kind = Profile::Kind::kTable;
  thrust.profile.times = {0, 0.02, 1};
  thrust.profile.values = {0, 100, 300};
  thrust.consumption = 1e-3;
  model.loads = {thrust};
  model.environment.planet = Planet{};
  model.environment.atmosphere = Atmosphere{};
  Aerodynamics air{.name = "air", .body = 0, .area = 0.5, .terms = {}};
  air.terms = {{AeroTerm::Of::kDrag, kNone, 0.4, kNone}, {AeroTerm::Of::kPitch, 1, -2, kNone}};
  model.aerodynamics = {air};
  Start start;
  start.body = 0;
  start.altitude = 10e3;
  start.velocity = {100, 0, 30};
  start.origin = Start::Origin::kStart;
  model = place_start(model, start);
  model.bodies[1].p_WB = model.bodies[0].p_WB + Eigen::Vector3d(1, 0, 0);
  return model;
}

TEST(PlanKinds, ImagesOfAirMassesAndProfilesThatLeadElsewhereAreRefused) {
  expect_the_same_flight(build_flying_tank());
  std::vector<Change> changes;
  changes.push_back(
      {"air without a planet", [](Image& i, const PlanData&) { i.numbers().environment.exists = false; }});
  changes.push_back(
      {"forces of the air without air", [](Image& i, const PlanData&) { i.numbers().environment.has_air = false; }});
  changes.push_back({"number of an aerodynamic element",
                     [](Image& i, const PlanData& d) { i.set(d.aerodynamics[0].number, std::int32_t{1}); }});
  changes.push_back(
      {"a rate that there is not", [](Image& i, const PlanData& d) { i.set(d.aero_terms[1].rate, std::int32_t{3}); }});
  changes.push_back(
      {"terms behind the last", [](Image& i, const PlanData& d) { i.set(d.aerodynamics[0].count, std::int32_t{3}); }});
  changes.push_back(
      {"a mass law of another body", [](Image& i, const PlanData& d) { i.set(d.varying[0].body, std::int32_t{1}); }});
  changes.push_back(
      {"a mass law without knots", [](Image& i, const PlanData& d) { i.set(d.varying[0].count, std::int32_t{0}); }});
  changes.push_back(
      {"consumption of no tank", [](Image& i, const PlanData& d) { i.set(d.loads[0].varying, std::int32_t{kNone}); }});
  const auto find = [](const PlanData& d) -> const PlanProfile& { return d.profiles[at(d.loads[0].profile)]; };
  changes.push_back(
      {"a profile without points", [=](Image& i, const PlanData& d) { i.set(find(d).count, std::int32_t{0}); }});
  changes.push_back({"a profile with a kind that there is not",
                     [=](Image& i, const PlanData& d) { i.set(find(d).kind, static_cast<Profile::Kind>(9)); }});
  changes.push_back({"no rigid body", [](Image& i, const PlanData&) { i.numbers().rigid = true; }});
  changes.push_back({"nothing but what acts by itself", [](Image& i, const PlanData&) { i.numbers().plain = true; }});
  changes.push_back({"a step of no time", [](Image& i, const PlanData&) { i.numbers().options.dt = 0; }});
  changes.push_back({"a step of any time", [](Image& i, const PlanData&) { i.numbers().options.dt = HUGE_VAL; }});
  expect_refused(build_flying_tank(), changes);
}

}  // namespace
}  // namespace unlatch::test::plan_kinds_test
