#include "kernel/tree/topology.h"

#include <algorithm>
#include <bit>
#include <compare>
#include <cstdint>
#include <limits>
#include <set>
#include <utility>

namespace unlatch {
namespace {

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

// Bodies that hang together, and whether one of them is held to the ground: union–find with path halving.
class Groups {
 public:
  explicit Groups(std::size_t bodies) : group_(bodies), held_(bodies, false) {
    for (std::size_t b = 0; b < bodies; ++b) group_[b] = static_cast<int>(b);
  }
  // False if a joint between the two, base kGround included, would close a loop.
  bool join(int base, int follower) {
    const int f = find(follower), b = base == kGround ? kGround : find(base);
    if (b == f || (held_[at(f)] && (b == kGround || held_[at(b)]))) return false;
    if (b == kGround) {
      held_[at(f)] = true;
    } else {
      group_[at(f)] = b;
      held_[at(b)] = held_[at(b)] || held_[at(f)];
    }
    return true;
  }

 private:
  int find(int b) {
    while (group_[at(b)] != b) b = group_[at(b)] = group_[at(group_[at(b)])];
    return b;
  }
  std::vector<int> group_;
  std::vector<bool> held_;
};

// Number of joints from the ground to each body; from `root` or the first body where nothing leads to the ground.
std::vector<int> measure_distances(const Model& model, int root) {
  std::vector<std::vector<int>> neighbours(model.bodies.size());
  std::vector<int> distance(model.bodies.size(), kNone), order;
  const auto start = [&](int body) {
    if (body == kNone || distance[at(body)] != kNone) return;
    distance[at(body)] = 0;
    order.push_back(body);
  };
  const auto connect = [&](int a, int b) {
    neighbours[at(a)].push_back(b);
    neighbours[at(b)].push_back(a);
  };
  for (int b = 0; b < static_cast<int>(model.bodies.size()); ++b)
    if (model.bodies[at(b)].marker) connect(b, model.bodies[at(b)].marker->body);
  for (const Joint& joint : model.joints) {
    if (joint.base == kGround)
      start(joint.follower);
    else
      connect(joint.base, joint.follower);
  }
  std::size_t walked = 0;
  const auto walk = [&] {
    for (; walked < order.size(); ++walked)
      for (const int next : neighbours[at(order[walked])])
        if (distance[at(next)] == kNone) {
          distance[at(next)] = distance[at(order[walked])] + 1;
          order.push_back(next);
        }
  };
  walk();
  start(root);
  for (int b = 0; b < static_cast<int>(model.bodies.size()); ++b) {
    walk();
    start(b);
  }
  return distance;
}

// Joints in the order in which they may become edges. One that closes a loop is to let go if one of them does, to have
// few rows, and to lie where the two ways from the ground meet, so that the tree is shallow and has lanes side by side;
// springs to be integrated implicitly need edges.
//
// `places`: per joint, its place in another order than that of distances; empty: by distances.
std::vector<int> rank_joints(const Model& model, const std::vector<RowSet>& compliant, int root,
                             const std::vector<int>& places) {
  const std::vector<int> distance = places.empty() ? measure_distances(model, root) : std::vector<int>();
  struct Rank {
    int may_go, free, distance, joint;  // may_go, free: rows that it lacks in its loosest mode, and in its tightest
    auto operator<=>(const Rank&) const = default;  // NOLINT(modernize-use-nullptr): of what the compiler writes
  };
  std::vector<Rank> ranks;
  for (int j = 0; j < static_cast<int>(model.joints.size()); ++j) {
    const Joint& joint = model.joints[at(j)];
    int most = 0, least = kRows;
    for (const JointMode& mode : joint.modes) {
      most = std::max(most, std::popcount(mode.rows));
      least = std::min(least, std::popcount(mode.rows));
    }
    const int near = !places.empty() ? places[at(j)] : joint.base == kGround ? -1 : std::min(distance[at(joint.base)], distance[at(joint.follower)]);
    ranks.push_back({compliant[at(j)] != 0 ? -1 : kRows - least, kRows - most, near, j});
  }
  std::sort(ranks.begin(), ranks.end());
  std::vector<int> order;
  order.reserve(ranks.size());
  for (const Rank& rank : ranks) order.push_back(rank.joint);
  return order;
}

// Finds which bodies belong together; joints that would close a loop do not become edges.
Graph build_graph(const Model& model, const std::vector<RowSet>& compliant, int root, const std::vector<int>& places) {
  const std::size_t bodies = model.bodies.size();
  Graph graph{std::vector<std::vector<Edge>>(bodies), std::vector<int>(bodies, kNone), {}};
  Groups groups(bodies);
  const auto connect = [&](int joint, int base, int follower) {
    graph.edges[at(base)].push_back({joint, follower});
    graph.edges[at(follower)].push_back({joint, base});
  };
  for (int marker = 0; marker < static_cast<int>(bodies); ++marker) {
    if (!model.bodies[at(marker)].marker) continue;
    const int body = model.bodies[at(marker)].marker->body;
    groups.join(body, marker);
    connect(kNone, body, marker);
  }
  std::vector<bool> edge(model.joints.size(), false);
  for (const int j : rank_joints(model, compliant, root, places))
    if (may_hold(model.joints[at(j)], compliant[at(j)]))
      edge[at(j)] = groups.join(model.joints[at(j)].base, model.joints[at(j)].follower);
  for (int j = 0; j < static_cast<int>(model.joints.size()); ++j) {
    const Joint& joint = model.joints[at(j)];
    if (!edge[at(j)]) {
      if (may_hold(joint, 0)) graph.loops.push_back(j);  // a joint that only carries springs closes no loop
    } else if (joint.base == kGround) {
      graph.ground[at(joint.follower)] = j;
    } else {
      connect(j, joint.base, joint.follower);
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

Topology grow_tree(const Model& model, const std::vector<RowSet>& compliant, int root, const std::vector<int>& places) {
  const Graph graph = build_graph(model, compliant, root, places);
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
    topology.nodes.push_back({chosen, kNone, graph.ground[at(chosen)], 1, true});
  }
  for (std::size_t k = 0; k < topology.nodes.size(); ++k) {
    const TreeNode node = topology.nodes[k];
    for (const Edge& edge : graph.edges[at(node.body)]) {
      if (node.parent != kNone && edge.neighbour == topology.nodes[at(node.parent)].body) continue;
      const bool follows = edge.joint == kNone || model.joints[at(edge.joint)].follower == edge.neighbour;
      const std::int8_t side = follows ? 1 : -1;
      topology.nodes[k].leaf = false;
      topology.nodes.push_back({edge.neighbour, static_cast<std::int32_t>(k), edge.joint, side, true});
    }
  }
  return topology;
}

constexpr std::int64_t kNoLimit = std::numeric_limits<std::int64_t>::max();

// Loops that are open at the nodes, squared and summed: what eliminating them costs. `limit`: beyond it the sum is not
// completed.
std::int64_t estimate_cost(const Model& model, const Topology& topology, std::int64_t limit) {
  std::vector<int> node_of(model.bodies.size(), kNone);
  for (std::size_t k = 0; k < topology.nodes.size(); ++k) node_of[at(topology.nodes[k].body)] = static_cast<int>(k);
  std::vector<std::int64_t> open(topology.nodes.size(), 0);
  std::int64_t cost = 0;
  for (const std::int32_t loop : topology.loops) {
    const Joint& joint = model.joints[at(loop)];
    int a = node_of[at(joint.follower)], b = joint.base == kGround ? kNone : node_of[at(joint.base)];
    while (a != b && cost <= limit) {
      int& outer = a > b ? a : b;
      cost += 2 * open[at(outer)]++ + 1;
      outer = topology.nodes[at(outer)].parent;
    }
  }
  return cost;
}

// The order in which bodies of fewest neighbours are eliminated, each leaving its neighbours connected: places of the
// bodies in it.
std::vector<int> find_minimum_degree(const Model& model) {
  const std::size_t bodies = model.bodies.size();
  std::vector<std::set<int>> neighbours(bodies);
  const auto connect = [&](int a, int b) {
    if (a == b) return;
    neighbours[at(a)].insert(b);
    neighbours[at(b)].insert(a);
  };
  for (const Joint& joint : model.joints)
    if (joint.base != kGround) connect(joint.base, joint.follower);
  for (int b = 0; b < static_cast<int>(bodies); ++b)
    if (model.bodies[at(b)].marker) connect(b, model.bodies[at(b)].marker->body);
  std::set<std::pair<std::size_t, int>> left;
  for (int b = 0; b < static_cast<int>(bodies); ++b) left.insert({neighbours[at(b)].size(), b});
  std::vector<int> places(bodies, 0);
  for (int next = 0; !left.empty(); ++next) {
    const int b = left.begin()->second;
    left.erase(left.begin());
    places[at(b)] = next;
    const std::vector<int> around(neighbours[at(b)].begin(), neighbours[at(b)].end());
    if (around.size() > 64) break;  // the rest is one dense block: any order
    for (const int a : around) {
      left.erase({neighbours[at(a)].size(), a});
      neighbours[at(a)].erase(b);
      for (const int other : around)
        if (other != a) neighbours[at(a)].insert(other);
      left.insert({neighbours[at(a)].size(), a});
    }
  }
  return places;
}

// Places of the joints, if each body's parent is to be that of its neighbours which is eliminated next after it.
std::vector<int> place_joints(const Model& model) {
  const std::vector<int> body_places = find_minimum_degree(model);
  const int bodies = static_cast<int>(model.bodies.size());
  std::vector<int> chosen(model.bodies.size(), kNone), places(model.joints.size(), 0);
  const auto split = [&](const Joint& joint) {
    const bool follower_first = body_places[at(joint.follower)] < body_places[at(joint.base)];
    return follower_first ? std::pair(joint.follower, joint.base) : std::pair(joint.base, joint.follower);
  };
  for (std::size_t j = 0; j < model.joints.size(); ++j) {
    if (model.joints[j].base == kGround) continue;
    const auto [first, second] = split(model.joints[j]);
    int& best = chosen[at(first)];
    if (best == kNone || body_places[at(second)] < body_places[at(split(model.joints[at(best)]).second)])
      best = static_cast<int>(j);
  }
  for (std::size_t j = 0; j < model.joints.size(); ++j) {
    if (model.joints[j].base == kGround) {
      places[j] = -1;
      continue;
    }
    const int first = split(model.joints[j]).first;
    places[j] = body_places[at(first)] + (chosen[at(first)] == static_cast<int>(j) ? 0 : bodies);
  }
  return places;
}

}  // namespace

Topology compile_topology(const Model& model, const std::vector<RowSet>& compliant, int root) {
  Topology shallow = grow_tree(model, compliant, root, {});
  if (shallow.loops.size() < 2) return shallow;
  Topology narrow = grow_tree(model, compliant, root, place_joints(model));
  const std::int64_t cost = estimate_cost(model, narrow, kNoLimit);
  return estimate_cost(model, shallow, cost) <= cost ? shallow : narrow;
}

}  // namespace unlatch
