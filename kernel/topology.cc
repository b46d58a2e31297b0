#include "kernel/topology.h"

#include <algorithm>

namespace unlatch {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

struct Edge {
  int joint, neighbour;  // joint: kNone between a flexible body and its marker
};

struct Graph {
  std::vector<std::vector<Edge>> edges;  // per body
  std::vector<int> ground;               // per body: the joint that holds it to the ground, or kNone
  std::vector<std::int32_t> loops;
};

bool may_hold(const Joint& joint, RowSet compliant) {
  return compliant != 0 ||
         std::any_of(joint.modes.begin(), joint.modes.end(), [](const JointMode& mode) { return mode.rows != 0; });
}

// Finds which bodies belong together; joints that would close a loop do not become edges.
Graph build_graph(const Model& model, const std::vector<RowSet>& compliant) {
  const int bodies = static_cast<int>(model.bodies.size());
  Graph graph{std::vector<std::vector<Edge>>(at(bodies)), std::vector<int>(at(bodies), kNone), {}};
  std::vector<int> group(at(bodies) + 1);  // union–find with path halving
  for (std::size_t b = 0; b < group.size(); ++b) group[b] = static_cast<int>(b);
  const auto find = [&](int b) {
    while (group[at(b)] != b) b = group[at(b)] = group[at(group[at(b)])];
    return b;
  };
  std::vector<bool> held(at(bodies), false);  // per group representative: one of its bodies is held to the ground
  for (int marker = 0; marker < bodies; ++marker) {
    if (!model.bodies[at(marker)].marker) continue;
    const int body = model.bodies[at(marker)].marker->body;
    group[at(marker)] = body;
    graph.edges[at(body)].push_back({kNone, marker});
    graph.edges[at(marker)].push_back({kNone, body});
  }
  for (int j = 0; j < static_cast<int>(model.joints.size()); ++j) {
    const Joint& joint = model.joints[at(j)];
    if (!may_hold(joint, compliant[at(j)])) continue;
    const int f = find(joint.follower);
    const int b = joint.base == kGround ? kGround : find(joint.base);
    if (b == f || (b == kGround && held[at(f)]) || (b != kGround && held[at(b)] && held[at(f)])) {
      const bool rows = may_hold(joint, 0);
      if (rows) graph.loops.push_back(j);  // a joint that only carries springs closes no loop
    } else if (b == kGround) {
      held[at(f)] = true;
      graph.ground[at(joint.follower)] = j;
    } else {
      group[at(f)] = b;
      held[at(b)] = held[at(b)] || held[at(f)];
      graph.edges[at(joint.base)].push_back({j, joint.follower});
      graph.edges[at(joint.follower)].push_back({j, joint.base});
    }
  }
  return graph;
}

// Bodies reached from `start`, nearest first, and for each the one it was reached from.
std::vector<int> walk(const Graph& graph, int start, std::vector<int>& reached_from) {
  std::vector<int> order{start};
  reached_from[at(start)] = kNone;
  for (std::size_t i = 0; i < order.size(); ++i)
    for (const Edge& edge : graph.edges[at(order[i])])
      if (edge.neighbour != reached_from[at(order[i])]) {
        reached_from[at(edge.neighbour)] = order[i];
        order.push_back(edge.neighbour);
      }
  return order;
}

// The middle of a longest path of the tree: the farthest from anywhere, the farthest from there, and half the way back.
int find_middle(const Graph& graph, int start, std::vector<int>& reached_from) {
  const int end = walk(graph, start, reached_from).back();
  const int other = walk(graph, end, reached_from).back();
  std::vector<int> path;
  for (int b = other; b != kNone; b = reached_from[at(b)]) path.push_back(b);
  return path[(path.size() - 1) / 2];
}

}  // namespace

Topology compile_topology(const Model& model, const std::vector<RowSet>& compliant, int root) {
  const Graph graph = build_graph(model, compliant);
  const std::size_t bodies = model.bodies.size();
  std::vector<int> reached_from(bodies, kNone);
  std::vector<bool> seen(bodies, false);

  Topology topology{{}, graph.loops};
  for (int b = 0; b < static_cast<int>(bodies); ++b) {
    if (seen[at(b)]) continue;
    int chosen = kNone;
    for (const int member : walk(graph, b, reached_from)) {
      seen[at(member)] = true;
      if (graph.ground[at(member)] != kNone ||
          (member == root && (chosen == kNone || graph.ground[at(chosen)] == kNone)))
        chosen = member;
    }
    if (chosen == kNone) chosen = find_middle(graph, b, reached_from);
    topology.nodes.push_back({chosen, kNone, graph.ground[at(chosen)], 1.0, true});
  }
  for (std::size_t k = 0; k < topology.nodes.size(); ++k) {
    const PlanNode node = topology.nodes[k];
    for (const Edge& edge : graph.edges[at(node.body)]) {
      if (node.parent != kNone && edge.neighbour == topology.nodes[at(node.parent)].body) continue;
      const bool follows = edge.joint == kNone || model.joints[at(edge.joint)].follower == edge.neighbour;
      const double side = follows ? 1.0 : -1.0;
      topology.nodes[k].leaf = false;
      topology.nodes.push_back({edge.neighbour, static_cast<std::int32_t>(k), edge.joint, side, true});
    }
  }
  return topology;
}

}  // namespace unlatch
