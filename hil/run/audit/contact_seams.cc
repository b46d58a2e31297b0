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
}

void ContactSeams::watch(int contact, bool balls_are_base) {
  const Model& model = simulation_.model();
  const Contact& own = model.contacts[at(contact)];
  const Surface &base = model.surfaces[at(own.base)], &follower = model.surfaces[at(own.follower)];
  const Surface &balls = balls_are_base ? base : follower, &other = balls_are_base ? follower : base;
  if (other.shapes.size() < 2) return;
  Watched watched{.contact = contact, .ball = balls.body, .surface = other.body, .pairs = {}};
  int number = -1;
  for (const auto& [i, k] : list_contact_pairs(model, own)) {
    ++number;
    const int sphere = balls_are_base ? i : k;
    const geometry::Shape &ball = balls.shapes[at(sphere)], &shape = other.shapes[at(balls_are_base ? k : i)];
    using enum geometry::ShapeKind;
    if (ball.kind == kSphere && shape.kind != kSphere)
      watched.pairs.push_back(
          {number, sphere, geometry::build_group("", {&ball, 1}), geometry::build_group("", {&shape, 1})});
  }
  std::ranges::stable_sort(watched.pairs, {}, &Pair::sphere);
  if (watched.pairs.size() > 1) watched_.push_back(std::move(watched));
}

std::span<const ContactSeam> ContactSeams::update() {
  found_.clear();
  for (const Watched& watched : watched_) {
    const std::span<const ContactState> states =
        get_contact_pairs(simulation_.plan(), simulation_.state(), watched.contact);
    const auto is_closed = [&](const Pair& pair) { return states[at(pair.number)].closed != 0; };
    double part = 0;
    for (auto a = watched.pairs.begin(); a != watched.pairs.end(); ++a)
      for (auto b = a + 1; b != watched.pairs.end() && b->sphere == a->sphere; ++b) {
        if (!is_closed(*a) || !is_closed(*b)) continue;
        const geometry::Placement ball = get_placement(simulation_.state(), watched.ball),
                                  surface = get_placement(simulation_.state(), watched.surface);
        const geometry::Distance of_a = geometry::calc_distance(a->ball, ball, a->surface, surface).least,
                                 of_b = geometry::calc_distance(b->ball, ball, b->surface, surface).least;
        if (!(of_a.distance < 0 && of_b.distance < 0) || dot(of_a.normal, of_b.normal) < kOneNormal) continue;
        const auto lies_on = [&](const Vec3& point, const Pair& pair) {
          return geometry::calc_distance(point_, {point, kIdentity3}, pair.surface, surface).least.distance <
                 kOnSurface;
        };
        const Pair& shallow = of_a.distance > of_b.distance ? *a : *b;
        const Vec3& witness = &shallow == &*a ? of_a.on_b : of_b.on_b;
        if (lies_on(witness, &shallow == &*a ? *b : *a))
          part = std::max(part, std::max(of_a.distance, of_b.distance) / std::min(of_a.distance, of_b.distance));
      }
    if (part > 0) found_.push_back({watched.contact, part});
  }
  return found_;
}

}  // namespace unlatch::hil
