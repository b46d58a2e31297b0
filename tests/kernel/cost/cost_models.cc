// Plans for tools/cost.
//   cost_models images FOLDER FIRST COUNT   writes images of random systems with these seeds; prints their names
//   cost_models work LANES IMAGE...         prints the work of each plan, by its units
//   cost_models steps IMAGE TICKS           steps a plan; prints of each step what it has done: its StepCounts
//   cost_models bound TARGET                of each line "IMAGE COUNTS..." prints the bound of a step that has done it
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <fstream>
#include <iostream>
#include <map>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "kernel/cost/step_counts.h"
#include "kernel/cost/work.h"
#include "tests/support/contact_models.h"
#include "tests/support/image_file.h"
#include "tests/support/random_elements.h"
#include "tests/support/rigid_models.h"
#include "tests/support/simulation.h"
#include "unlatch/cost/step_cost.h"
#include "unlatch/plan_image.h"

namespace {

using namespace unlatch;

// One to eight balls that stick to an incline, some with a second body on a ball joint: the parts of their steps are
// implicit in the forces of contacts, which they are seldom in other random systems.
Model build_sticking_balls(std::uint64_t seed) {
  test::Random random(seed);
  Model model;
  model.name = "balls";
  model.gravity.uniform = {0.125 * test::kGravity, 0, -test::kGravity};
  model.surfaces.push_back({"floor", kGround, {test::build_floor()}});
  const int balls = 1 + random.below(8);
  for (int i = 0; i < balls; ++i) {
    const int body = static_cast<int>(model.bodies.size());
    const std::string name = "ball" + std::to_string(i);
    model.bodies.push_back(test::box(name, random.uniform(0.5, 4), 0.025, 0.025, 0.025));
    const Vec3 place{2.0 * i, 0, 0.25 - 1e-4 * random.uniform()};
    model.bodies.back().p_WB = {place.x, place.y, place.z};
    model.surfaces.push_back({name, body, {test::build_sphere(0.25)}});
    Contact contact = test::touch(name, 0, i + 1, 1e5);
    contact.damping = 50;
    contact.friction = 0.6;
    contact.slip_speed = 1e-5;
    model.contacts.push_back(contact);
    if (!random.chance(0.3)) continue;
    model.bodies.push_back(test::box(name + "'s", 0.5, 0.01, 0.01, 0.01));
    model.bodies.back().p_WB = {place.x, 0.5, place.z};
    Joint joint;
    joint.name = name;
    joint.base = body;
    joint.follower = body + 1;
    joint.point_base = {0, 0.25, 0};
    joint.point_follower = {0, -0.25, 0};
    joint.modes = {{"held", kPointRows}};
    model.joints.push_back(joint);
  }
  return model;
}

// One to four bodies on one to three round feet that fall upon a rigid floor, some with friction or rebound, some
// with a second body on a hinge.
Model build_rigid_bodies(std::uint64_t seed) {
  test::Random random(seed);
  Model model;
  model.name = "rigid";
  model.gravity.uniform = {random.chance(0.5) ? 1.0 : 0.0, 0, -test::kGravity};
  model.surfaces.push_back({"floor", kGround, {test::build_floor()}});
  const int bodies = 1 + random.below(4);
  for (int i = 0; i < bodies; ++i) {
    const int body = static_cast<int>(model.bodies.size());
    const std::string name = "body" + std::to_string(i);
    model.bodies.push_back(test::box(name, random.uniform(0.5, 4), 0.25, 0.25, 0.25));
    const Vec3 place{4.0 * i, 0, 0.5 + 0.02 * random.uniform()};
    model.bodies.back().p_WB = {place.x, place.y, place.z};
    model.bodies.back().v_WB = {random.uniform(), 0.2 * random.uniform(), 0};
    Surface surface{name, body, {}};
    const int feet = 1 + random.below(3);
    for (int k = 0; k < feet; ++k) {
      const double angle = 2.1 * k;
      surface.shapes.push_back(test::build_sphere(0.125, {0.4 * std::cos(angle), 0.4 * std::sin(angle), -0.375}));
    }
    model.surfaces.push_back(surface);
    Contact contact = test::touch_rigidly(name, 0, i + 1, random.chance(0.4) ? 0.5 : 0.0);
    if (random.chance(0.5)) contact.friction = random.uniform(0.1, 0.8);
    model.contacts.push_back(contact);
    if (!random.chance(0.3)) continue;
    model.bodies.push_back(test::box(name + "'s", 0.5, 0.01, 0.01, 0.01));
    model.bodies.back().p_WB = {place.x, 0.5, place.z};
    model.bodies.back().v_WB = model.bodies[static_cast<std::size_t>(body)].v_WB;
    Joint joint;
    joint.name = name;
    joint.base = body;
    joint.follower = body + 1;
    joint.point_base = {0, 0.25, 0};
    joint.point_follower = {0, -0.25, 0};
    joint.modes = {{"held", kPointRows}};
    model.joints.push_back(joint);
  }
  return model;
}

// Of ten seeds one is of balls, and one of rigid contacts.
Model build_system(std::uint64_t seed) {
  constexpr std::uint64_t kEvery = 10, kRigid = 5;
  if (seed % kEvery == 0) return build_sticking_balls(seed);
  return seed % kEvery == kRigid ? build_rigid_bodies(seed) : test::build_random_system(seed);
}

int write_images(const std::string& folder, std::uint64_t first, std::uint64_t count) {
  for (std::uint64_t seed = first; seed < first + count; ++seed) {
    const PlanResult compiled = compile_plan(build_system(seed), {.dt = 0.001});
    if (!compiled.plan) {
      std::fprintf(stderr, "seed %llu: %s: %s\n", static_cast<unsigned long long>(seed),
                   compiled.errors.front().where.c_str(), compiled.errors.front().what.c_str());
      return 1;
    }
    const std::span<const std::byte> image = compiled.plan->get_image();
    const std::string name = "random" + std::to_string(seed);
    std::ofstream file(folder + "/" + name + ".plan", std::ios::binary);
    file.write(reinterpret_cast<const char*>(image.data()), static_cast<std::streamsize>(image.size()));
    if (!file) return 1;
    std::printf("%s\n", name.c_str());
  }
  return 0;
}

// A plan and the memory that it lies in.
struct OpenedImage {
  explicit OpenedImage(const std::string& path) : image(test::read_image(path)) {
    OpenedPlan opened = open_plan(image.get(), memory);
    if (!opened.plan) throw std::runtime_error(path + ": " + get_status_text(opened.status));
    plan = opened.plan;
  }
  test::ImageMemory image;
  PlanMemory memory;
  std::optional<Plan> plan;
};

int print_steps(const char* path, std::int64_t ticks) {
  const OpenedImage own(path);
  const Plan& plan = *own.plan;
  test::Block state_memory(plan.get_state_bytes()), workspace_memory(plan.get_workspace_bytes());
  State state(plan, state_memory.get());
  Workspace workspace(plan, workspace_memory.get());
  init_state(plan, state);
  for (std::int64_t tick = 0; tick < ticks; ++tick) {
    const std::vector<EventState> before(state.events.begin(), state.events.end());
    const StepReport report = step(plan, {plan.get_initial_commands()}, state, workspace);
    if (report.status != StepStatus::kOk) break;
    const std::int64_t waits = cost::count_waits(get_data(plan), before, state.events, report.events);
    std::printf("%d %zu %lld %lld %lld\n", report.substeps, report.audits.size(), static_cast<long long>(waits),
                static_cast<long long>(cost::count_jumps(get_data(plan), report.events)),
                static_cast<long long>(cost::count_timed(get_data(plan), report.events, waits)));
  }
  return 0;
}

int print_bounds(const char* name) {
  const CostTarget* target = find_cost_target(name);
  if (target == nullptr) throw std::runtime_error(std::string("there is no target ") + name);
  std::map<std::string, std::unique_ptr<OpenedImage>> images;
  std::string path;
  StepCounts counts;
  while (std::cin >> path >> counts.integrations >> counts.rounds >> counts.waits >> counts.jumps >> counts.timed) {
    std::unique_ptr<OpenedImage>& own = images[path];
    if (!own) own = std::make_unique<OpenedImage>(path);
    const StepCost cost = calc_step_cost(*own->plan, *target, get_counted_limits(*own->plan, counts));
    if (cost.unmeasured.empty())
      std::printf("%.17g\n", cost.instructions);
    else
      std::printf("unmeasured\n");
  }
  return 0;
}

int print_work(int lanes, char** first, char** end) {
  for (char** path = first; path != end; ++path) {
    const OpenedImage own(*path);
    const cost::Work work = cost::count_work(*own.plan, lanes);
    std::printf("%s", *path);
    for (const double count : work.counts) std::printf(" %.17g", count);
    std::printf("\n");
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    const std::string verb = argc > 1 ? argv[1] : "";
    if (verb == "images" && argc == 5)
      return write_images(argv[2], std::strtoull(argv[3], nullptr, 10), std::strtoull(argv[4], nullptr, 10));
    if (verb == "steps" && argc == 4) return print_steps(argv[2], std::atoll(argv[3]));
    if (verb == "bound" && argc == 3) return print_bounds(argv[2]);
    if (verb == "work" && argc > 3) return print_work(std::atoi(argv[2]), argv + 3, argv + argc);
    std::fprintf(stderr,
                 "cost_models images FOLDER FIRST COUNT | work LANES IMAGE... | steps IMAGE TICKS | bound TARGET\n");
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
  }
  return 1;
}
