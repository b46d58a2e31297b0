#include "tools/report/structure.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <numeric>

#include "hil/scenario/quantities.h"
#include "tools/common/shape_json.h"
#include "unlatch/inertia.h"
#include "unlatch/readings.h"

namespace unlatch::tools {
namespace {

using Json = nlohmann::ordered_json;
using tools::to_json;

constexpr std::size_t kMostPairs = 40;  // the nearest ones; a page with hundreds of curves shows none

Json to_json(const Eigen::Vector3d& v) { return Json::array({v.x(), v.y(), v.z()}); }
template <class Q>
Json to_json_attitude(const Q& q) {
  return Json::array({q.w(), q.x(), q.y(), q.z()});
}
Json to_json(const Eigen::Matrix3d& m) {
  return Json::array(
      {to_json(Eigen::Vector3d(m.col(0))), to_json(Eigen::Vector3d(m.col(1))), to_json(Eigen::Vector3d(m.col(2)))});
}

// For a body without a shape: the homogeneous box of its mass and inertia. About an axis its inertia is m (b² + c²)/12,
// so the edge along x has a² = 6 (Iyy + Izz − Ixx)/m.
geometry::Shape build_equivalent_box(const Body& body) {
  const auto [principal, axes] = calc_principal_axes(body.inertia);
  const Eigen::Vector3d squares = 6 / body.mass * (principal.sum() - 2 * principal.array()).matrix();
  const double least = 1e-3 * std::sqrt(squares.maxCoeff());  // a thin rod stays visible
  geometry::Shape box{.kind = geometry::ShapeKind::kBox};
  const Eigen::Vector3d size = squares.cwiseMax(least * least).cwiseSqrt();
  const Eigen::Quaterniond q(axes);
  box.size = {size.x(), size.y(), size.z()};
  box.q_BS = {q.w(), q.x(), q.y(), q.z()};
  return box;
}

Json build_bodies(const hil::Scenario& scenario, const FrameLayout& layout) {
  Json list = Json::array();
  for (std::size_t i = 0; i < scenario.model.bodies.size(); ++i) {
    const Body& body = scenario.model.bodies[i];
    Json shapes = Json::array();
    for (const hil::BodyShape& part : scenario.shapes[i]) shapes.push_back(build_shape_json(part));
    if (shapes.empty() && body.mass > 0) shapes.push_back(build_shape_json(build_equivalent_box(body)));
    list.push_back({{"name", body.name},
                    {"mass", body.mass},
                    {"inertia", to_json(body.inertia)},
                    {"assumed", scenario.shapes[i].empty()},
                    {"shapes", shapes},
                    {"modal", body.flexible ? body.flexible->frequencies.size() : 0},
                    {"modal_column", layout.modal[i]},
                    {"column", layout.bodies + kBodyColumns * i}});
  }
  return list;
}

Json build_joints(const hil::Scenario& scenario, const hil::RunAnalysis& analysis, const FrameLayout& layout) {
  Json list = Json::array();
  for (std::size_t i = 0; i < scenario.model.joints.size(); ++i) {
    const Joint& joint = scenario.model.joints[i];
    Json modes = Json::array(), peaks = Json::array();
    for (const JointMode& mode : joint.modes) modes.push_back({{"name", mode.name}, {"rows", mode.rows}});
    for (std::size_t row = 0; row < kRows; ++row) {
      const hil::PeakReaction peak = analysis.get_peak(i, row);
      peaks.push_back({{"value", peak.value}, {"t", peak.time}});
      if (peak.is_uncertain()) peaks.back()["uncertainty"] = peak.uncertainty;
      if (peak.at_ticks) peaks.back()["at_ticks"] = true;
    }
    list.push_back({{"name", joint.name},
                    {"base", joint.base},
                    {"follower", joint.follower},
                    {"point_base", to_json(joint.point_base)},
                    {"point_follower", to_json(joint.point_follower)},
                    {"axes", to_json(joint.axes)},
                    {"modes", modes},
                    {"peaks", peaks},
                    {"column", layout.joints + kJointColumns * i}});
  }
  return list;
}

Json build_loads(const Model& model, const FrameLayout& layout) {
  Json list = Json::array();
  for (std::size_t i = 0; i < model.loads.size(); ++i) {
    const Load& load = model.loads[i];
    list.push_back({{"name", load.name},
                    {"body", load.body},
                    {"torque", load.kind == Load::Kind::kTorque},
                    {"world", load.frame == Load::Frame::kWorld},
                    {"point", to_json(load.point)},
                    {"direction", to_json(load.direction)},
                    {"column", layout.loads + i}});
  }
  return list;
}

Json build_springs(const Model& model, const FrameLayout& layout) {
  Json list = Json::array();
  for (std::size_t i = 0; i < model.point_springs.size(); ++i) {
    const PointSpring& spring = model.point_springs[i];
    list.push_back({{"name", spring.name},
                    {"base", spring.base},
                    {"follower", spring.follower},
                    {"point_base", to_json(spring.point_base)},
                    {"point_follower", to_json(spring.point_follower)},
                    {"push_only", spring.push_only},
                    {"free_length", spring.free_length},
                    {"column", layout.springs + kSpringColumns * i}});
  }
  return list;
}

// `between`: the ends of a pusher or cord that acts along the line between two points, else null. `drum`: what a cord
// is wound on, axes of the base, the anchor along the first.
Json build_one_sided(const Model& model, const FrameLayout& layout) {
  constexpr const char* kKinds[] = {"pusher", "stop", "cord"};
  const Model placed = place_markers(model);
  Json list = Json::array();
  for (std::size_t i = 0; i < model.one_sided.size(); ++i) {
    const OneSided& force = model.one_sided[i];
    Json one{{"name", force.name},
             {"kind", kKinds[static_cast<std::size_t>(force.kind)]},
             {"angle", force.joint != kNone && force.axis >= kRotX},
             {"between", nullptr},
             {"drum", nullptr},
             {"column", layout.one_sided + kOneSidedColumns * i}};
    if (force.joint == kNone)
      one["between"] = {{"base", force.base},
                        {"follower", force.follower},
                        {"point_base", to_json(force.point_base)},
                        {"point_follower", to_json(force.point_follower)}};
    if (force.drum) {
      const CordDrum drum = place_drum(placed, force);
      one["drum"] = {{"centre", to_json(drum.centre)},
                     {"axes", Json::array({to_json(drum.axes.x), to_json(drum.axes.y), to_json(drum.axes.z)})},
                     {"radius", drum.radius}};
    }
    list.push_back(std::move(one));
  }
  return list;
}

Json build_contacts(const Model& model, const FrameLayout& layout) {
  Json list = Json::array();
  for (std::size_t i = 0; i < model.contacts.size(); ++i)
    list.push_back({{"name", model.contacts[i].name}, {"column", layout.contacts + kContactColumns * i}});
  return list;
}

// Pairs with a clearance; of many, those that come nearest.
Json build_pairs(const hil::RunAnalysis& analysis, const FrameLayout& layout) {
  const std::vector<hil::Clearance>& clearances = analysis.clearances();
  std::vector<std::size_t> order(clearances.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return clearances[a].smallest < clearances[b].smallest; });
  order.resize(std::min(order.size(), kMostPairs));
  std::sort(order.begin(), order.end());
  Json list = Json::array();
  for (const std::size_t i : order) {
    list.push_back({{"a", clearances[i].a},
                    {"b", clearances[i].b},
                    {"name", clearances[i].name_a + " – " + clearances[i].name_b},
                    {"method", hil::get_method_name(clearances[i].method)},
                    {"min", clearances[i].smallest},
                    {"t", clearances[i].time},
                    {"column", layout.pairs + i}});
  }
  return list;
}

Json build_sensors(const Model& model, std::size_t column) {
  Json list = Json::array();
  for (const Sensor& sensor : model.sensors) {
    const auto width = static_cast<std::size_t>(sensor_width(sensor.kind));
    list.push_back({{"name", sensor.name},
                    {"kind", static_cast<int>(sensor.kind)},
                    {"unit", hil::get_unit(model, sensor)},
                    {"width", width},
                    {"column", column}});
    column += width;
  }
  return list;
}

Json build_requirements(const hil::Scenario& scenario, const FrameLayout& layout) {
  Json list = Json::array();
  for (std::size_t i = 0; i < scenario.requirements.size(); ++i)
    list.push_back({{"id", scenario.requirements[i].id}, {"column", layout.requirements + i}});
  return list;
}

}  // namespace

nlohmann::ordered_json build_structure(const hil::Scenario& scenario, const hil::RunAnalysis& analysis,
                                       const FrameLayout& layout) {
  const Model& model = scenario.model;
  Json channels = Json::array(), points = Json::array(), ground = Json::array();
  for (const hil::BodyShape& part : scenario.ground_shapes) ground.push_back(build_shape_json(part));
  for (std::size_t i = 0; i < model.channels.size(); ++i) {
    const Channel& channel = model.channels[i];
    channels.push_back({{"name", channel.name}, {"unit", channel.unit}, {"column", layout.channels + i}});
  }
  for (std::size_t i = 0; i < scenario.points.size(); ++i) {
    const hil::TracedPoint& point = scenario.points[i];
    points.push_back({{"name", point.name},
                      {"body", point.body},
                      {"seen_from", point.seen_from},
                      {"column", layout.points + kPointColumns * i}});
  }
  return {{"gravity", to_json(model.gravity.uniform)},
          {"ground_shapes", ground},
          {"bodies", build_bodies(scenario, layout)},
          {"joints", build_joints(scenario, analysis, layout)},
          {"loads", build_loads(model, layout)},
          {"springs", build_springs(model, layout)},
          {"one_sided", build_one_sided(model, layout)},
          {"contact_curves", build_contacts(model, layout)},
          {"pairs", build_pairs(analysis, layout)},
          {"pairs_in_all", analysis.clearances().size()},
          {"channels", channels},
          {"sensors", build_sensors(model, layout.sensors)},
          {"received", layout.received_values > 0 ? build_sensors(model, layout.received) : Json::array()},
          {"points", points},
          {"requirements", build_requirements(scenario, layout)}};
}

}  // namespace unlatch::tools
