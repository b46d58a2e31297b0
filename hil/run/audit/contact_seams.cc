#include "hil/run/audit/contact_seams.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "hil/run/motion/contact_history.h"
#include "hil/scenario/base/index.h"
#include "unlatch/contacts.h"

namespace unlatch::hil {
namespace {

constexpr double kPointRadius = 1e-9;  // m
constexpr double kOnSurface = 1e-6;    // m: a point that is nearer to a shape lies on it
constexpr double kOneNormal = 0.9;     // cosine of the angle between the normals of one surface, at least

geometry::ShapeGroup build_point() {
  geometry::Shape point;
  point.radius = kPointRadius;
  return geometry::build_group("", {&point, 1});
}

geometry::Placement get_placement(const State& state, int body) {
  if (body == kGround) return {};
  return {state.bodies[at(body)].p, rotation_matrix(state.bodies[at(body)].q)};
}

}  // namespace

ContactSeams::ContactSeams(const Simulation& simulation) : simulation_(simulation), point_(build_point()) {
  const std::vector<Contact>& contacts = simulation.model().contacts;
  for (std::size_t c = 0; c < contacts.size(); ++c) {
    if (contacts[c].rigid) continue;
    watch(static_cast<int>(c), true);
    watch(static_cast<int>(c), false);
  }
  std::ranges::stable_sort(pairs_, {}, &Pair::sphere);
}

void ContactSeams::watch(int contact, bool balls_are_base) {
  const Model& model = simulation_.model();
  const Contact& own = model.contacts[at(contact)];
  const Surface &base = model.surfaces[at(own.base)], &follower = model.surfaces[at(own.follower)];
  const Surface &balls = balls_are_base ? base : follower, &other = balls_are_base ? follower : base;
  int number = -1;
  for (const auto& [i, k] : list_contact_pairs(model, own)) {
    ++number;
    const geometry::Shape &ball = balls.shapes[at(balls_are_base ? i : k)],
                          &shape = other.shapes[at(balls_are_base ? k : i)];
    using enum geometry::ShapeKind;
    if (ball.kind != kSphere || shape.kind == kSphere) continue;
    pairs_.push_back({contact,
                      number,
                      {balls.body, other.body, ball.from.x, ball.from.y, ball.from.z, ball.radius},
                      geometry::build_group("", {&ball, 1}),
                      geometry::build_group("", {&shape, 1})});
  }
}

void ContactSeams::add(const Pair& shallow, double part) {
  const auto own = std::ranges::find(found_, shallow.contact, &ContactSeam::contact);
  if (own == found_.end())
    found_.push_back({shallow.contact, part});
  else
    own->part = std::max(own->part, part);
}

std::span<const ContactSeam> ContactSeams::update() {
  found_.clear();
  const Plan& plan = simulation_.plan();
  const State& state = simulation_.state();
  const auto is_closed = [&](const Pair& pair) {
    return get_contact_pairs(plan, state, pair.contact)[at(pair.number)].closed != 0;
  };
  for (auto a = pairs_.begin(); a != pairs_.end(); ++a)
    for (auto b = a + 1; b != pairs_.end() && b->sphere == a->sphere; ++b) {
      if (!is_closed(*a) || !is_closed(*b)) continue;
      const geometry::Placement ball = get_placement(state, a->sphere.body),
                                surface = get_placement(state, a->sphere.surface);
      const geometry::Distance of_a = geometry::calc_distance(a->ball, ball, a->surface, surface).least,
                               of_b = geometry::calc_distance(b->ball, ball, b->surface, surface).least;
      if (!(of_a.distance < 0 && of_b.distance < 0) || dot(of_a.normal, of_b.normal) < kOneNormal) continue;
      const bool a_is_deep = of_a.distance < of_b.distance;
      const Pair &deep = a_is_deep ? *a : *b, &shallow = a_is_deep ? *b : *a;
      const geometry::Distance &most = a_is_deep ? of_a : of_b, &least = a_is_deep ? of_b : of_a;
      const geometry::Placement witness{least.on_b, kIdentity3};
      if (geometry::calc_distance(point_, witness, deep.surface, surface).least.distance < kOnSurface)
        add(shallow, least.distance / most.distance);
    }
  return found_;
}

}  // namespace unlatch::hil
