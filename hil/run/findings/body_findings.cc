#include <algorithm>
#include <set>
#include <utility>

#include "hil/run/findings/finding_parts.h"
#include "hil/run/notices/format.h"
#include "hil/scenario/base/index.h"
#include "hil/scenario/shapes/clearance.h"
#include "hil/scenario/text/count.h"
#include "unlatch/inertia.h"

namespace unlatch::hil {

void add_inertia_findings(const Model& model, std::vector<Finding>& findings) {
  constexpr double kRounding = 1e-9;  // relative
  for (const Body& body : model.bodies) {
    if (body.marker || !(body.inertia.trace() > 0)) continue;
    const Eigen::Vector3d m = calc_principal_moments(body.inertia);
    if (m[0] + m[1] >= m[2] * (1 - kRounding)) continue;
    findings.push_back({"inertia", quoted("body", body.name),
                        format("its largest principal moment exceeds the sum of the others by %.2g of it: a plate's, "
                               "rounded; no body has that, and it is taken as it is",
                               1 - (m[0] + m[1]) / m[2])});
  }
}

void add_overlap_findings(const Scenario& scenario, std::vector<Finding>& findings) {
  const Model& model = scenario.model;
  if (scenario.clearance.empty()) return;
  std::vector<Pose> poses;
  for (int b = 0; b < static_cast<int>(model.bodies.size()); ++b) poses.push_back(get_start_pose(model, b));
  ClearanceMonitor monitor(scenario.clearance, scenario.shapes, scenario.ground_shapes);
  monitor.update(0, poses);
  for (const Clearance& c : monitor.get()) {
    if (c.now > 0) continue;
    const std::string where = quoted("body", model.bodies[at(c.b == kGround ? c.a : c.b)].name);
    if (c.method == DistanceMethod::kMesh && c.now == 0) {
      findings.push_back({"overlap", where,
                          c.name_b + " touches or crosses " + c.name_a +
                              " at the start; their smallest clearance is 0: triangles have no depth. Leave out faces "
                              "that mate by `except`"});
      continue;
    }
    findings.push_back(
        {"overlap", where,
         c.name_b + format(" touches or overlaps %s at the start, by %.4g m: their smallest clearance is that "
                           "or less. Leave out faces that mate by `except`",
                           c.name_a.c_str(), -c.now)});
  }
}

void add_unwatched_overlap_findings(const Scenario& scenario, std::vector<Finding>& findings) {
  constexpr double kTouching = 1e-6;  // relative to the smaller body: mated faces
  constexpr std::size_t kMost = 10;
  const Model& model = scenario.model;
  std::set<std::pair<int, int>> meet;
  // Markers count as the flexible body that carries them.
  const auto get_structure = [&](int body) {
    const bool carried = body != kGround && model.bodies[at(body)].marker.has_value();
    return carried ? model.bodies[at(body)].marker->body : body;
  };
  const auto let_meet = [&](int a, int b) { meet.insert(std::minmax(get_structure(a), get_structure(b))); };
  for (const ClearancePair& pair : scenario.clearance) let_meet(pair.a.body, pair.b.body);
  for (const Contact& contact : model.contacts)
    let_meet(model.surfaces[at(contact.base)].body, model.surfaces[at(contact.follower)].body);
  for (const Joint& joint : model.joints) let_meet(joint.base, joint.follower);

  struct Solid {
    int body;
    geometry::ShapeGroup group;
    geometry::Placement place;
  };
  std::vector<Solid> solids;
  const auto get_name = [&](int body) { return body == kGround ? std::string("ground") : model.bodies[at(body)].name; };
  for (int b = kGround; b < static_cast<int>(model.bodies.size()); ++b) {
    std::vector<geometry::Shape> shapes;
    for (const BodyShape& shape : get_shapes(scenario, b))
      if (!shape.mesh) shapes.push_back(shape.shape);  // meshes have no depth
    const Pose pose = b == kGround ? Pose{} : get_start_pose(model, b);
    if (!shapes.empty()) solids.push_back({b, geometry::build_group(get_name(b), shapes), to_placement(pose)});
  }
  std::size_t count = 0;
  for (std::size_t k = 0; k < solids.size(); ++k) {
    for (std::size_t i = 0; i < k; ++i) {
      const Solid &a = solids[i], &b = solids[k];
      const std::pair<int, int> pair = std::minmax(get_structure(a.body), get_structure(b.body));
      if (pair.first == pair.second || meet.contains(pair) ||
          geometry::calc_lower_bound(a.group, a.place, b.group, b.place) > 0)
        continue;
      const double depth = -geometry::calc_distance(a.group, a.place, b.group, b.place).least.distance;
      if (!(depth > kTouching * std::min(a.group.bound, b.group.bound)) || ++count > kMost) continue;
      findings.push_back(
          {"overlap", quoted("body", model.bodies[at(b.body)].name),
           format("lies %.4g m within '%s' at the start, to which nothing joins it: move one of them, or "
                  "make the shapes smaller",
                  depth, get_name(a.body).c_str())});
    }
  }
  if (count > kMost)
    findings.push_back(
        {"overlap", "bodies", hil::count(count - kMost, "more pair") + " within each other at the start"});
}

}  // namespace unlatch::hil
