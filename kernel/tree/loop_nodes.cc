#include "kernel/tree/loop_nodes.h"

#include <algorithm>
#include <bit>
#include <vector>

namespace unlatch {
namespace {

constexpr int kPadding = 8;  // columns come in multiples of the widest pack
constexpr int kSpatial = 6;  // rows of loads at a body

// The largest number of rows that the loops' joints can hold at once.
int count_rows(const Model& model, const PlanDraft& plan) {
  int rows = 0;
  for (const std::int32_t joint : plan.loops) {
    int most = 0;
    for (const JointMode& mode : model.joints[at(joint)].modes) most = std::max(most, std::popcount(mode.rows));
    rows += most;
  }
  return rows;
}

class LoopOrder {
 public:
  explicit LoopOrder(PlanDraft& plan) : plan_(plan), node_of_(plan.bodies.size(), kNone), loops_(plan.nodes.size()) {
    for (std::size_t k = 0; k < plan.nodes.size(); ++k) node_of_[at(plan.nodes[k].body)] = static_cast<int>(k);
    for (std::size_t l = 0; l < plan.loops.size(); ++l) {
      const PlanJoint& joint = plan.joints[at(plan.loops[l])];
      for (const bool follower : {true, false}) {
        const std::int32_t body = follower ? joint.follower : joint.base;
        if (body != kGround) loops_[at(node_of_[at(body)])].push_back({static_cast<std::int32_t>(l), follower});
      }
    }
  }

  void compile() {
    find_way();
    place_modes();
    for (std::size_t k = 0; k < plan_.nodes.size(); ++k)
      if (on_way_[k] && plan_.nodes[k].parent == kNone) walk(static_cast<int>(k));
    fill_groups();
    plan_.loop_load_rows = rows_;
  }

 private:
  // Nodes with loops at or beyond them, and their children that are such nodes.
  void find_way() {
    on_way_.assign(plan_.nodes.size(), false);
    children_.resize(plan_.nodes.size());
    for (std::size_t k = plan_.nodes.size(); k-- > 0;) {
      if (!loops_[k].empty()) on_way_[k] = true;
      const std::int32_t parent = plan_.nodes[k].parent;
      if (!on_way_[k] || parent == kNone) continue;
      on_way_[at(parent)] = true;
      children_[at(parent)].push_back(static_cast<int>(k));
    }
  }

  // The modal loads of flexible bodies on the way come first.
  void place_modes() {
    modal_of_.assign(plan_.flexible.size(), 0);
    for (std::size_t f = 0; f < plan_.flexible.size(); ++f) {
      if (!on_way_[at(node_of_[at(plan_.flexible[f].body)])]) continue;
      modal_of_[f] = rows_;
      rows_ += plan_.flexible[f].modes;
    }
    plan_.loop_modal_rows = rows_;
  }

  // Children before parents; a subtree is finished before its sibling begins, so that few loads wait at a time.
  void walk(int root) {
    struct Visit {
      int node;
      std::size_t next;  // child
      std::int32_t loads;
    };
    std::vector<Visit> stack{{root, 0, kNone}};
    while (!stack.empty()) {
      Visit& visit = stack.back();
      const std::vector<int>& children = children_[at(visit.node)];
      if (visit.next < children.size()) {
        stack.push_back({children[visit.next++], 0, kNone});
        continue;
      }
      const Visit done = visit;
      stack.pop_back();
      const bool opens = done.loads == kNone;
      const std::int32_t loads = opens ? take_loads() : done.loads;
      std::int32_t parent_loads = kNone;
      if (!stack.empty()) {
        // The first child's loads become the parent's.
        if (stack.back().loads == kNone) stack.back().loads = loads;
        parent_loads = stack.back().loads;
      }
      add(done.node, loads, parent_loads, opens);
      if (parent_loads != loads) free_.push_back(loads);
    }
  }

  std::int32_t take_loads() {
    if (free_.empty()) {
      free_.push_back(rows_);
      rows_ += kSpatial;
    }
    const std::int32_t loads = free_.back();
    free_.pop_back();
    return loads;
  }

  void add(int node, std::int32_t loads, std::int32_t parent_loads, bool opens) {
    const PlanBody& body = plan_.bodies[at(plan_.nodes[at(node)].body)];
    LoopNode out{};
    out.node = node;
    out.place = plan_.places[at(plan_.nodes[at(node)].body)];
    out.loads = loads;
    out.parent_loads = parent_loads;
    out.opens = opens;
    out.first_end = static_cast<std::int32_t>(plan_.loop_ends.size());
    out.ends = static_cast<std::int32_t>(loops_[at(node)].size());
    out.modal = body.flexible == kNone ? 0 : modal_of_[at(body.flexible)];
    for (std::size_t i = 0; i < plan_.markers.size() && body.flexible != kNone; ++i)
      if (plan_.markers[i].body == plan_.nodes[at(node)].body) out.marker = static_cast<std::int32_t>(i);
    plan_.loop_ends.insert(plan_.loop_ends.end(), loops_[at(node)].begin(), loops_[at(node)].end());
    plan_.loop_nodes.push_back(out);
  }

  void fill_groups() {
    std::vector<std::int32_t> group_of(plan_.nodes.size());
    for (std::size_t g = 0; g < plan_.groups.size(); ++g)
      for (int lane = 0; lane < plan_.groups[g].count; ++lane)
        group_of[at(plan_.lane_nodes[at(plan_.groups[g].first + lane)])] = static_cast<std::int32_t>(g);
    for (LoopNode& node : plan_.loop_nodes) node.group = group_of[at(node.node)];
  }

  PlanDraft& plan_;
  std::vector<int> node_of_;                 // per body
  std::vector<std::vector<LoopEnd>> loops_;  // per node: at its body
  std::vector<bool> on_way_;
  std::vector<std::vector<int>> children_;
  std::vector<std::int32_t> modal_of_;  // per flexible body
  std::vector<std::int32_t> free_;      // loads that nobody needs any more
  std::int32_t rows_ = 0;
};

}  // namespace

std::span<const LoopNode> compile_loop_nodes(const Model& model, const LaidOutDraft& draft) {
  PlanDraft& plan = draft.plan;
  if (plan.loops.empty()) return {};
  plan.loop_rows = count_rows(model, plan);
  plan.loop_columns = (plan.loop_rows + kPadding - 1) / kPadding * kPadding;
  LoopOrder(plan).compile();
  return plan.loop_nodes;
}

}  // namespace unlatch
