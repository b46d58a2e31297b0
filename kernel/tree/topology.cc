#include "kernel/tree/topology.h"

#include <algorithm>
#include <bit>
#include <compare>
#include <cstdint>
#include <limits>
#include <map>
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
  bool are_joined(int a, int b) { return find(a) == find(b); }

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
    const int near = !places.empty()         ? places[at(j)]
                     : joint.base == kGround ? -1
                                             : std::min(distance[at(joint.base)], distance[at(joint.follower)]);
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

// How two bodies hang together: by a joint, through a body that is eliminated before both, or as a flexible body and
// its marker (neither).
struct Link {
  int joint = kNone, through = kNone;
};

// Eliminates bodies, those of fewest neighbours first, each leaving its neighbours connected; the ground is the last. A
// tree whose ways follow this order leaves few loops open at a body.
class MinimumDegree {
 public:
  explicit MinimumDegree(const Model& model)
      : ground_(static_cast<int>(model.bodies.size())),
        links_(model.bodies.size() + 1),
        around_(model.bodies.size() + 1),
        places_(model.bodies.size() + 1, ground_) {
    for (int j = 0; j < static_cast<int>(model.joints.size()); ++j) {
      const Joint& joint = model.joints[at(j)];
      connect(joint.base == kGround ? ground_ : joint.base, joint.follower, {j, kNone});
    }
    for (int b = 0; b < ground_; ++b)
      if (model.bodies[at(b)].marker) connect(b, model.bodies[at(b)].marker->body, {});
    eliminate();
  }

  // Places of the joints: first those on the ways of the bodies, in their order, to that of their neighbours which is
  // eliminated next.
  std::vector<int> place_joints(const Model& model) const {
    Groups groups(at(ground_) + 1);
    std::vector<int> order(at(ground_)), places(model.joints.size(), static_cast<int>(model.joints.size()));
    for (int b = 0; b < ground_; ++b) order[at(b)] = b;
    std::sort(order.begin(), order.end(),
              [&](int a, int b) { return std::pair(places_[at(a)], a) < std::pair(places_[at(b)], b); });
    int next = 0;
    for (const int b : order) {
      const auto parent =
          std::min_element(around_[at(b)].begin(), around_[at(b)].end(),
                           [&](const auto& x, const auto& y) { return places_[at(x.first)] < places_[at(y.first)]; });
      if (parent == around_[at(b)].end()) continue;
      std::vector<Way> ways{{b, parent->first, parent->second}};
      while (!ways.empty()) {
        const Way way = ways.back();
        ways.pop_back();
        if (groups.are_joined(way.from, way.to)) continue;
        if (way.link.through == kNone) {
          groups.join(way.from, way.to);
          if (way.link.joint != kNone) places[at(way.link.joint)] = next++;
          continue;
        }
        for (const int end : {way.to, way.from}) ways.push_back({way.link.through, end, find(way.link.through, end)});
      }
    }
    return places;
  }

 private:
  struct Way {
    int from, to;
    Link link;
  };
  static constexpr std::size_t kDense = 64;  // neighbours: what is left is one dense block, in any order

  void connect(int a, int b, Link link) {
    if (a == b) return;
    links_[at(a)].emplace(b, link);
    links_[at(b)].emplace(a, link);
  }
  void eliminate() {
    std::set<std::pair<std::size_t, int>> left;
    for (int b = 0; b < ground_; ++b) left.insert({links_[at(b)].size(), b});
    for (int next = 0; !left.empty() && left.begin()->first <= kDense; ++next) {
      const int b = left.begin()->second;
      left.erase(left.begin());
      places_[at(b)] = next;
      around_[at(b)].assign(links_[at(b)].begin(), links_[at(b)].end());
      for (const auto& [a, link] : around_[at(b)]) {
        left.erase({links_[at(a)].size(), a});
        links_[at(a)].erase(b);
        for (const auto& [other, same] : around_[at(b)])
          if (other != a) links_[at(a)].emplace(other, Link{kNone, b});
        if (a != ground_) left.insert({links_[at(a)].size(), a});
      }
    }
  }
  Link find(int eliminated, int neighbour) const {
    const auto& around = around_[at(eliminated)];
    return std::lower_bound(around.begin(), around.end(), neighbour, [](const auto& x, int n) { return x.first < n; })
        ->second;
  }

  int ground_;
  std::vector<std::map<int, Link>> links_;                 // per body, the ground behind them: those that are left
  std::vector<std::vector<std::pair<int, Link>>> around_;  // likewise: when it was eliminated
  std::vector<int> places_;                                // likewise, in the order of elimination
};

}  // namespace

Topology compile_topology(const Model& model, const std::vector<RowSet>& compliant, int root) {
  Topology shallow = grow_tree(model, compliant, root, {});
  if (shallow.loops.size() < 2) return shallow;
  Topology narrow = grow_tree(model, compliant, root, MinimumDegree(model).place_joints(model));
  const std::int64_t cost = estimate_cost(model, narrow, kNoLimit);
  return estimate_cost(model, shallow, cost) <= cost ? shallow : narrow;
}

}  // namespace unlatch
