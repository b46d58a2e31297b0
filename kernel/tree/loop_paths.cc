#include "kernel/tree/loop_paths.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <vector>

#include "kernel/model/from_eigen.h"

namespace unlatch {
namespace {

// A joint is small beside the structure that it holds: it turns back as much as one of its rows at this part of the
// distance between joints.
constexpr double kJointSize = 0.1;
// m: joints nearer to each other are at one point, where no length enters the split.
constexpr double kOnePoint = 1e-9;

class LoopPaths {
 public:
  LoopPaths(const Model& model, std::span<const LoopNode> loop_nodes, PlanDraft& plan)
      : model_(model), plan_(plan), mesh_of_(model.joints.size()) {
    for (std::size_t j = 0; j < mesh_of_.size(); ++j) mesh_of_[j] = static_cast<int>(j);
    ring_of_.assign(model.joints.size(), kNone);
    node_of_.assign(plan.bodies.size(), kNone);
    for (std::size_t k = 0; k < plan.nodes.size(); ++k) node_of_[at(plan.nodes[k].body)] = static_cast<std::int32_t>(k);
    loop_node_of_.assign(plan.nodes.size(), kNone);
    for (std::size_t i = 0; i < loop_nodes.size(); ++i)
      loop_node_of_[at(loop_nodes[i].node)] = static_cast<std::int32_t>(i);
  }

  void compile() {
    for (const std::int32_t loop : plan_.loops) add_path(loop);
    build_meshes();
    for (std::size_t j = 0; j < model_.joints.size(); ++j) {
      plan_.joints[j].share = std::sqrt(model_.joints[j].share);
      plan_.joints[j].turning_share = plan_.joints[j].share * model_.joints[j].share_length.value_or(1);
    }
    for (const LoopMesh& mesh : plan_.meshes) set_lengths(mesh);
  }

 private:
  std::int32_t find_node(std::int32_t body) const { return body == kGround ? kNone : node_of_[at(body)]; }

  // Parents stand before their children, so that the later of two nodes is not above the other.
  void add_path(std::int32_t loop) {
    std::int32_t follower = find_node(plan_.joints[at(loop)].follower), base = find_node(plan_.joints[at(loop)].base);
    std::vector<std::int32_t> from_follower, from_base;
    while (follower != base) {
      std::int32_t& outer = follower > base ? follower : base;
      (follower > base ? from_follower : from_base).push_back(outer);
      outer = plan_.nodes[at(outer)].parent;
    }
    LoopPath path{static_cast<std::int32_t>(plan_.path_nodes.size()), 0, 0, kNone};
    for (const std::int32_t node : from_follower) add_node(loop, node);
    path.base_first = static_cast<std::int32_t>(plan_.path_nodes.size());
    for (const std::int32_t node : from_base) add_node(loop, node);
    path.end = static_cast<std::int32_t>(plan_.path_nodes.size());
    plan_.loop_paths.push_back(path);
  }

  void add_node(std::int32_t loop, std::int32_t node) {
    const std::int32_t joint = plan_.nodes[at(node)].joint;
    std::int32_t ring = kNone;
    if (joint != kNone) {
      mesh_of_[at(find_mesh(joint))] = find_mesh(loop);
      if (ring_of_[at(joint)] == kNone) {
        ring_of_[at(joint)] = static_cast<std::int32_t>(plan_.ring_joints.size());
        plan_.ring_joints.push_back(joint);
        int most = 0;
        for (const JointMode& mode : model_.joints[at(joint)].modes) most = std::max(most, std::popcount(mode.rows));
        plan_.ring_rows += most;
      }
      ring = ring_of_[at(joint)];
    }
    plan_.path_nodes.push_back({loop_node_of_[at(node)], ring});
  }

  int find_mesh(int joint) {
    while (mesh_of_[at(joint)] != joint) joint = mesh_of_[at(joint)] = mesh_of_[at(mesh_of_[at(joint)])];
    return joint;
  }

  void build_meshes() {
    std::vector<std::vector<std::int32_t>> joints(model_.joints.size());
    std::vector<bool> in_loop(model_.joints.size(), false);
    for (const std::int32_t loop : plan_.loops) in_loop[at(loop)] = true;
    for (const std::int32_t joint : plan_.ring_joints) in_loop[at(joint)] = true;
    for (std::size_t j = 0; j < in_loop.size(); ++j)
      if (in_loop[j]) joints[at(find_mesh(static_cast<int>(j)))].push_back(static_cast<std::int32_t>(j));
    std::vector<std::int32_t> number(model_.joints.size(), kNone);
    for (std::size_t j = 0; j < in_loop.size(); ++j) {
      const auto mesh = at(find_mesh(static_cast<int>(j)));
      if (!in_loop[j] || number[mesh] != kNone) continue;
      number[mesh] = static_cast<std::int32_t>(plan_.meshes.size());
      plan_.meshes.push_back(
          {static_cast<std::int32_t>(plan_.mesh_joints.size()), static_cast<std::int32_t>(joints[mesh].size())});
      plan_.mesh_joints.insert(plan_.mesh_joints.end(), joints[mesh].begin(), joints[mesh].end());
    }
    for (std::size_t l = 0; l < plan_.loops.size(); ++l)
      plan_.loop_paths[l].mesh = number[at(find_mesh(plan_.loops[l]))];
  }

  Vec3 get_point(std::int32_t j) const {
    const Joint& joint = model_.joints[at(j)];
    if (joint.base == kGround) return to_vec(joint.point_base);
    const BodyState& base = plan_.bodies[at(joint.base)].initial;
    return base.p + rotation_matrix(base.q) * to_vec(joint.point_base);
  }

  // Joints that state no length: by the root mean square distance of the mesh's joints from their middle, at the start.
  void set_lengths(const LoopMesh& mesh) {
    const auto begin = plan_.mesh_joints.begin() + mesh.first, end = begin + mesh.count;
    Vec3 sum{0, 0, 0};
    for (auto j = begin; j != end; ++j) sum += get_point(*j);
    const Vec3 middle = (1.0 / mesh.count) * sum;
    double squares = 0;
    for (auto j = begin; j != end; ++j) {
      const Vec3 away = get_point(*j) - middle;
      squares += dot(away, away);
    }
    const double distance = std::sqrt(squares / mesh.count);
    const double length = distance > kOnePoint ? kJointSize * distance : 1;
    for (auto j = begin; j != end; ++j)
      if (!model_.joints[at(*j)].share_length) plan_.joints[at(*j)].turning_share *= length;
  }

  const Model& model_;
  PlanDraft& plan_;
  std::vector<int> mesh_of_;                // per joint: another of its mesh, or itself
  std::vector<std::int32_t> ring_of_;       // per joint: its place among the ring's
  std::vector<std::int32_t> node_of_;       // per body
  std::vector<std::int32_t> loop_node_of_;  // per node
};

}  // namespace

void compile_loop_paths(const Model& model, std::span<const LoopNode> loop_nodes, PlanDraft& plan) {
  if (!plan.loops.empty()) LoopPaths(model, loop_nodes, plan).compile();
}

}  // namespace unlatch
