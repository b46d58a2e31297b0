#include "kernel/tree/loop_clusters.h"

#include <algorithm>
#include <set>
#include <utility>
#include <vector>

#include "kernel/tree/loop_storage.h"

namespace unlatch {
namespace {

constexpr std::size_t kFewestLoops = 2;

class Clusters {
 public:
  explicit Clusters(PlanDraft& plan)
      : plan_(plan), node_of_(plan.bodies.size(), kNone), passing_(plan.nodes.size()), closing_(plan.nodes.size()) {
    for (std::size_t k = 0; k < plan.nodes.size(); ++k) node_of_[at(plan.nodes[k].body)] = static_cast<int>(k);
  }

  void compile() {
    group_of_.resize(plan_.nodes.size());
    for (std::size_t g = 0; g < plan_.groups.size(); ++g)
      for (int lane = 0; lane < plan_.groups[g].count; ++lane)
        group_of_[at(plan_.lane_nodes[at(plan_.groups[g].first + lane)])] = static_cast<int>(g);
    for (std::size_t l = 0; l < plan_.loops.size(); ++l) find_way(static_cast<int>(l));
    for (std::size_t k = 0; k < plan_.nodes.size(); ++k)
      if ((!passing_[k].empty() || !closing_[k].empty()) && plan_.groups[at(group_of_[k])].kind != BodyKind::kRigid)
        return;  // a flexible body on the way
    find_order();
    place_blocks();
    place_nodes();
  }

 private:
  int find_node(int body) const { return body == kGround ? kNone : node_of_[at(body)]; }

  // Parents stand before their children, so that the later of two nodes is not above the other.
  void find_way(int loop) {
    const PlanJoint& joint = plan_.joints[at(plan_.loops[at(loop)])];
    int a = find_node(joint.follower), b = find_node(joint.base);
    while (a != b) {
      int& outer = a > b ? a : b;
      passing_[at(outer)].push_back(loop);
      outer = plan_.nodes[at(outer)].parent;
    }
    (a == kNone ? at_ground_ : closing_[at(a)]).push_back(loop);
  }

  // Minimum degree among the loops that close at one node.
  void find_order() {
    neighbours_.resize(plan_.loops.size());
    for (std::size_t k = plan_.nodes.size(); k-- > 0;) {
      eliminate(closing_[k], static_cast<int>(k));
      connect(passing_[k]);
    }
    eliminate(at_ground_, kNone);
  }
  void connect(const std::vector<int>& clique) {
    for (const int a : clique)
      for (const int b : clique)
        if (a != b) neighbours_[at(a)].insert(b);
  }
  void eliminate(const std::vector<int>& loops, int node) {
    std::set<std::pair<std::size_t, int>> left;
    for (const int l : loops) left.insert({neighbours_[at(l)].size(), l});
    const std::set<int> here(loops.begin(), loops.end());
    while (!left.empty()) {
      const int l = left.begin()->second;
      left.erase(left.begin());
      const std::vector<int> links(neighbours_[at(l)].begin(), neighbours_[at(l)].end());
      for (const int m : links) {
        if (here.count(m) != 0) left.erase({neighbours_[at(m)].size(), m});
        neighbours_[at(m)].erase(l);
        for (const int other : links)
          if (other != m) neighbours_[at(m)].insert(other);
        if (here.count(m) != 0) left.insert({neighbours_[at(m)].size(), m});
      }
      order_.push_back({l, node});
    }
  }

  // neighbours_ of each loop are those that were left when it was eliminated.
  void place_blocks() {
    closure_of_.resize(plan_.loops.size());
    for (std::size_t e = 0; e < order_.size(); ++e) closure_of_[at(order_[e].first)] = static_cast<int>(e);
    for (const auto& [loop, node] : order_) {
      LoopClosure c{};
      c.loop = loop;
      c.joint = plan_.loops[at(loop)];
      c.non_tree = plan_.joints[at(c.joint)].non_tree;
      c.on_follower = c.on_base = kNone;
      c.node = node;  // of the tree, for now
      c.slot = kNone;
      c.block = plan_.cluster_blocks++;
      c.first_link = static_cast<std::int32_t>(plan_.loop_links.size());
      std::vector<int> later;
      for (const int m : neighbours_[at(loop)]) later.push_back(closure_of_[at(m)]);
      std::sort(later.begin(), later.end());
      c.links = static_cast<std::int32_t>(later.size());
      for (const int m : later) plan_.loop_links.push_back({m, plan_.cluster_blocks++, kNone});
      plan_.closures.push_back(c);
    }
    for (LoopClosure& c : plan_.closures) {
      std::vector<int> later;
      for (int i = 0; i < c.links; ++i) later.push_back(plan_.loop_links[at(c.first_link + i)].closure);
      c.first_pair = add_pairs(later);
    }
  }
  std::int32_t find_block(int e, int m) const {
    const LoopClosure& c = plan_.closures[at(e)];
    if (e == m) return c.block;
    const auto first = plan_.loop_links.begin() + c.first_link;
    return std::lower_bound(first, first + c.links, m, [](const LoopLink& l, int n) { return l.closure < n; })->block;
  }
  std::int32_t add_pairs(const std::vector<int>& sorted) {
    const auto first = static_cast<std::int32_t>(plan_.loop_pairs.size());
    for (std::size_t i = 0; i < sorted.size(); ++i)
      for (std::size_t j = i; j < sorted.size(); ++j) plan_.loop_pairs.push_back(find_block(sorted[i], sorted[j]));
    return first;
  }

  void place_nodes() {
    std::vector<std::int32_t> cluster_of(plan_.nodes.size(), kNone);
    plan_.group_clusters.assign(plan_.groups.size() + 1, 0);
    for (std::size_t k = 0; k < plan_.nodes.size(); ++k) {
      if (passing_[k].empty() && closing_[k].empty()) continue;
      cluster_of[k] = static_cast<std::int32_t>(plan_.cluster_nodes.size());
      add_node(static_cast<int>(k), cluster_of);
    }
    std::size_t next = 0;
    for (std::size_t g = 0; g <= plan_.groups.size(); ++g) {
      while (next < plan_.cluster_nodes.size() && plan_.cluster_nodes[next].group < static_cast<int>(g)) ++next;
      plan_.group_clusters[g] = static_cast<std::int32_t>(next);
    }
    mark_first();
    plan_.first_at_ground = static_cast<std::int32_t>(plan_.closures.size() - at_ground_.size());
    for (LoopClosure& c : plan_.closures) {
      if (c.node == kNone) continue;
      c.node = cluster_of[at(c.node)];
      const ClusterNode& node = plan_.cluster_nodes[at(c.node)];
      c.slot = find_slot(node, closure_of_[at(c.loop)]);
      for (int i = 0; i < c.links; ++i) {
        LoopLink& link = plan_.loop_links[at(c.first_link + i)];
        link.slot = find_slot(node, link.closure);
      }
    }
  }
  // The last slots are the first that are handed on.
  void mark_first() {
    std::vector<bool> begun(plan_.loop_slots.size(), false);
    for (const LoopClosure& c : plan_.closures)
      for (const std::int32_t slot : {c.on_follower, c.on_base})
        if (slot != kNone) begun[at(slot)] = true;
    for (std::size_t i = plan_.loop_slots.size(); i-- > 0;) {
      LoopSlot& slot = plan_.loop_slots[i];
      if (slot.parent == kNone) continue;
      slot.begins = begun[at(slot.parent)] ? 0 : 1;
      begun[at(slot.parent)] = true;
    }
  }
  std::int32_t find_slot(const ClusterNode& node, int closure) const {
    for (int i = 0; i < node.slots; ++i)
      if (plan_.loop_slots[at(node.first_slot + i)].closure == closure) return node.first_slot + i;
    return kNone;
  }

  void add_node(int k, const std::vector<std::int32_t>& cluster_of) {
    ClusterNode node{};
    const std::int32_t body = plan_.nodes[at(k)].body, parent = plan_.nodes[at(k)].parent;
    node.node = k;
    node.group = group_of_[at(k)];
    node.place = plan_.places[at(body)];
    node.first_slot = static_cast<std::int32_t>(plan_.loop_slots.size());
    std::vector<int> closing, passing;
    for (const int l : closing_[at(k)]) closing.push_back(closure_of_[at(l)]);
    for (const int l : passing_[at(k)]) passing.push_back(closure_of_[at(l)]);
    std::sort(closing.begin(), closing.end());
    std::sort(passing.begin(), passing.end());
    node.closing = static_cast<std::int32_t>(closing.size());
    node.slots = static_cast<std::int32_t>(closing.size() + passing.size());
    const SlotRows rows(plan_.groups[at(node.group)]);
    for (std::size_t i = 0; i < closing.size() + passing.size(); ++i) {
      const bool passes = i >= closing.size();
      const int e = passes ? passing[i - closing.size()] : closing[i];
      LoopClosure& closure = plan_.closures[at(e)];
      const PlanJoint& joint = plan_.joints[at(closure.joint)];
      const auto slot = static_cast<std::int32_t>(plan_.loop_slots.size());
      if (joint.follower == body) closure.on_follower = slot;
      if (joint.base == body) closure.on_base = slot;
      std::int32_t to = kNone;
      if (passes && parent != kNone) to = find_slot(plan_.cluster_nodes[at(cluster_of[at(parent)])], e);
      plan_.loop_slots.push_back({e, to, 0, plan_.cluster_numbers});
      plan_.cluster_numbers += (passes ? rows.count() : SlotRows::kWrenches) * kEight;
    }
    node.first_pair = add_pairs(passing);
    plan_.cluster_nodes.push_back(node);
  }

  PlanDraft& plan_;
  std::vector<int> node_of_;                         // per body
  std::vector<int> group_of_;                        // per node
  std::vector<std::vector<int>> passing_, closing_;  // per node: loops
  std::vector<int> at_ground_;
  std::vector<std::set<int>> neighbours_;   // per loop
  std::vector<std::pair<int, int>> order_;  // loops, and the nodes where they close
  std::vector<int> closure_of_;             // per loop
};

}  // namespace

void compile_clusters(const LaidOutDraft& draft) {
  if (draft.plan.loops.size() >= kFewestLoops) Clusters(draft.plan).compile();
}

}  // namespace unlatch
