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

// Shapes that differ in nothing else are as good as one.
bool is_same(const geometry::Shape& a, const geometry::Shape& b) {
  const auto is_at = [](const auto& x, const auto& y) { return x.x == y.x && x.y == y.y && x.z == y.z; };
  return a.kind == b.kind && is_at(a.from, b.from) && is_at(a.to, b.to) && a.radius == b.radius &&
         is_at(a.size, b.size) && a.points.size() == b.points.size() &&
         std::equal(a.points.begin(), a.points.end(), b.points.begin(), is_at);
}

geometry::Placement get_placement(const State& from, const State& to, bool halfway, int body) {
  if (body == kGround) return {};
  const BodyState &a = from.bodies[at(body)], &b = to.bodies[at(body)];
  if (!halfway) return {b.p, rotation_matrix(b.q)};
  Quat q{a.q.w + b.q.w, a.q.x + b.q.x, a.q.y + b.q.y, a.q.z + b.q.z};
  const double size = std::sqrt(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z);
  q = {q.w / size, q.x / size, q.y / size, q.z / size};
  return {0.5 * (a.p + b.p), rotation_matrix(q)};
}

}  // namespace

ContactSeams::ContactSeams(const Simulation& simulation) : simulation_(simulation), point_(build_point()) {
  const std::vector<Contact>& contacts = simulation.model().contacts;
  for (std::size_t c = 0; c < contacts.size(); ++c) {
    if (contacts[c].rigid) continue;
    watch(static_cast<int>(c), true);
    watch(static_cast<int>(c), false);
  }
  std::ranges::stable_sort(pairs_, {}, &Pair::pushed);
}

// The number of a shape among those that were met; two contacts may have the same one.
std::size_t ContactSeams::find_shape(int body, const geometry::Shape& shape) {
  const auto found =
      std::ranges::find_if(shapes_, [&](const auto& one) { return one.first == body && is_same(one.second, shape); });
  if (found != shapes_.end()) return static_cast<std::size_t>(found - shapes_.begin());
  shapes_.emplace_back(body, shape);
  return shapes_.size() - 1;
}

void ContactSeams::watch(int contact, bool own_is_base) {
  const Model& model = simulation_.model();
  const Contact& own = model.contacts[at(contact)];
  const Surface &base = model.surfaces[at(own.base)], &follower = model.surfaces[at(own.follower)];
  const Surface &pushed = own_is_base ? base : follower, &other = own_is_base ? follower : base;
  int number = -1;
  for (const auto& [i, k] : list_contact_pairs(model, own)) {
    ++number;
    const geometry::Shape &one = pushed.shapes[at(own_is_base ? i : k)], &shape = other.shapes[at(own_is_base ? k : i)];
    if (shape.kind == geometry::ShapeKind::kSphere) continue;  // two spheres have no surface in common
    pairs_.push_back({contact,
                      number,
                      {pushed.body, other.body, find_shape(pushed.body, one)},
                      geometry::build_group("", {&one, 1}),
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
  const std::span<const MotionKnot> knots = simulation_.get_motion();
  if (knots.empty()) look({simulation_.state(), simulation_.state()});
  for (std::size_t i = 1; i < knots.size(); ++i) {
    const MotionKnot &from = knots[i - 1], &to = knots[i];
    if (!to.begins) look({from.state, to.state, true});
    look({to.state, to.state});
  }
  return found_;
}

void ContactSeams::look(const Instant& instant) {
  const auto is_closed = [&](const Pair& pair) {
    return get_contact_pairs(simulation_.plan(), instant.from, pair.contact)[at(pair.number)].closed != 0;
  };
  for (auto a = pairs_.begin(); a != pairs_.end(); ++a)
    for (auto b = a + 1; b != pairs_.end() && b->pushed == a->pushed; ++b) {
      if (!is_closed(*a) || !is_closed(*b)) continue;
      const auto place = [&](int body) { return get_placement(instant.from, instant.to, instant.halfway, body); };
      const geometry::Placement own = place(a->pushed.body), surface = place(a->pushed.surface);
      const geometry::Distance of_a = geometry::calc_distance(a->own, own, a->surface, surface).least,
                               of_b = geometry::calc_distance(b->own, own, b->surface, surface).least;
      if (!(of_a.distance < 0 && of_b.distance < 0) || dot(of_a.normal, of_b.normal) < kOneNormal) continue;
      const bool a_is_deep = of_a.distance < of_b.distance;
      const Pair &deep = a_is_deep ? *a : *b, &shallow = a_is_deep ? *b : *a;
      const geometry::Distance &most = a_is_deep ? of_a : of_b, &least = a_is_deep ? of_b : of_a;
      const geometry::Placement witness{least.on_b, kIdentity3};
      if (geometry::calc_distance(point_, witness, deep.surface, surface).least.distance < kOnSurface)
        add(shallow, least.distance / most.distance);
    }
}

}  // namespace unlatch::hil
