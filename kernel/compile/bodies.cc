#include "kernel/compile/bodies.h"

#include <optional>
#include <span>
#include <vector>

#include "kernel/dynamics/flexible.h"
#include "kernel/model/from_eigen.h"
#include "kernel/plan/plan_lists.h"
#include "unlatch/frequencies.h"

namespace unlatch {
namespace {

void write(std::span<Vec3> to, const Eigen::Matrix3Xd& columns) {
  for (std::size_t k = 0; k < to.size(); ++k) to[k] = to_vec(columns.col(static_cast<Eigen::Index>(k)));
}
void write(std::span<Moment> to, const std::vector<Eigen::Matrix3d>& matrices) {
  for (std::size_t k = 0; k < to.size(); ++k) {
    const Eigen::Matrix3d& m = matrices[k];
    to[k] = {m(0, 0), m(0, 1), m(0, 2), m(1, 0), m(1, 1), m(1, 2), m(2, 0), m(2, 1), m(2, 2)};
  }
}

// Room for so many numbers more in PlanDraft::modal.
double* add_numbers(PlanDraft& plan, int count) {
  const std::size_t begin = plan.modal.size();
  plan.modal.resize(begin + at(count));
  return plan.modal.data() + begin;
}

// Some mode swings faster than the step resolves.
bool has_stiff_mode(const FlexibleBody& body, double dt) { return (body.frequencies.array() * dt > kResolved).any(); }

// `markers`: the bodies that are its markers.
void compile_flexible(const Model& model, int body, const std::vector<int>& markers, PlanDraft& plan) {
  const FlexibleBody& shape = *model.bodies[at(body)].flexible;
  const auto m = static_cast<std::int32_t>(shape.frequencies.size());
  PlanFlexible out{body,
                   m,
                   static_cast<std::int32_t>(plan.markers.size()),
                   0,
                   static_cast<std::int32_t>(plan.initial_auxiliary.size()),
                   static_cast<std::int32_t>(plan.modal.size()),
                   plan.modal_work,
                   kNone,
                   has_stiff_mode(shape, plan.options.dt),
                   model.bodies[at(body)].mass,
                   to_sym(model.bodies[at(body)].inertia)};
  const ModalShapeOf<Writable> to = place_shape(m, add_numbers(plan, get_shape_size(m)));
  write(to.momentum, shape.momentum);
  write(to.first, shape.first);
  write(to.second, shape.second);
  for (int k = 0; k < m; ++k) {
    to.stiffness[at(k)] = shape.frequencies[k] * shape.frequencies[k];
    to.damping[at(k)] = 2 * shape.damping[k] * shape.frequencies[k];
  }
  for (const Eigen::VectorXd* start : {&shape.initial, &shape.initial_rate})
    for (Eigen::Index k = 0; k < m; ++k) plan.initial_auxiliary.push_back(start->size() == 0 ? 0 : (*start)[k]);
  for (const int i : markers) {
    const std::optional<Marker>& marker = model.bodies[at(i)].marker;
    plan.markers.push_back({i, static_cast<std::int32_t>(plan.flexible.size()),
                            static_cast<std::int32_t>(plan.modal.size()), to_vec(marker->position), true});
    const MarkerShapeOf<Writable> to_marker = place_marker_shape(m, add_numbers(plan, get_marker_shape_size(m)));
    write(to_marker.displacement, marker->shape);
    write(to_marker.turn, marker->turn);
    plan.bodies[at(i)].flexible = static_cast<std::int32_t>(plan.flexible.size());
    ++out.markers;
  }
  plan.bodies[at(body)].flexible = static_cast<std::int32_t>(plan.flexible.size());
  plan.modal_work += get_work_size(m) + out.markers * get_marker_size(m);
  plan.flexible.push_back(out);
}

// Finds, in the tree, the marker by which each flexible body is held, and the markers that hold nothing. Computes the
// initial motion of the markers.
void place_flexible(std::span<const TreeNode> nodes, PlanDraft& plan) {
  std::vector<std::int32_t> marker_of(plan.bodies.size(), kNone);
  for (std::size_t i = 0; i < plan.markers.size(); ++i) marker_of[at(plan.markers[i].body)] = static_cast<int>(i);
  for (const TreeNode& node : nodes) {
    const std::int32_t marker = marker_of[at(node.body)];
    if (marker != kNone) plan.markers[at(marker)].bare = node.leaf;
    const PlanBody& body = plan.bodies[at(node.body)];
    if (body.flexible != kNone && marker == kNone && node.parent != kNone)
      plan.flexible[at(body.flexible)].inboard = marker_of[at(nodes[at(node.parent)].body)];
  }
  for (const PlanMarker& marker : plan.markers) {
    const PlanFlexible& carrier = plan.flexible[at(marker.flexible)];
    const double* coordinates = plan.initial_auxiliary.data() + carrier.auxiliary;
    plan.bodies[at(marker.body)].initial = calc_marker_state(
        get_view(plan), marker, plan.bodies[at(carrier.body)].initial, coordinates, coordinates + carrier.modes);
  }
}

PlanBody compile_body(const Body& body, PlanDraft& plan) {
  PlanBody out{body.mass, {to_vec(body.p_WB), to_quat(body.q_WB), to_vec(body.v_WB), to_vec(body.w_WB_B)}};
  if (!body.law && !body.flexible && !body.marker) return out;
  out.mass = 0;  // these have no constant mass: it is added when it is computed
  if (!body.law) return out;
  out.varying = static_cast<std::int32_t>(plan.varying.size());
  plan.varying.push_back({static_cast<std::int32_t>(plan.bodies.size()),
                          static_cast<std::int32_t>(plan.mass_knots.size()),
                          static_cast<std::int32_t>(body.law->knots.size()), body.law->of == MassLaw::Of::kBurnt,
                          body.law->jet_damping, to_vec(body.law->exit)});
  for (const MassLaw::Knot& knot : body.law->knots)
    plan.mass_knots.push_back({knot.at, knot.mass, to_vec(knot.centre), to_sym(knot.inertia)});
  return out;
}

// Bodies whose block is not diag(mass, inertia) are no leaves for the solver, even if nothing is outboard of them.
void mark_blocks(const Model& model, std::span<TreeNode> nodes) {
  for (TreeNode& node : nodes)
    if (model.bodies[at(node.body)].law || model.bodies[at(node.body)].flexible) node.leaf = false;
}

}  // namespace

DraftWithBodies compile_bodies(const Model& model, std::span<TreeNode> nodes, PlanDraft& plan) {
  for (const Body& body : model.bodies) plan.bodies.push_back(compile_body(body, plan));
  plan.initial_auxiliary.assign(plan.varying.size(), 0.0);  // burnt masses come before modal coordinates and contacts
  std::vector<std::vector<int>> markers(model.bodies.size());
  for (std::size_t b = 0; b < model.bodies.size(); ++b)
    if (model.bodies[b].marker) markers[at(model.bodies[b].marker->body)].push_back(static_cast<int>(b));
  for (int b = 0; b < static_cast<int>(model.bodies.size()); ++b)
    if (model.bodies[at(b)].flexible) compile_flexible(model, b, markers[at(b)], plan);
  plan.rigid = plan.flexible.empty() && plan.varying.empty();
  place_flexible(nodes, plan);
  mark_blocks(model, nodes);
  return {plan};
}

}  // namespace unlatch
