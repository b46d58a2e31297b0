// The split of redundant_rows.h where loops are eliminated where they close (loop_clusters.h), in time linear like that
// elimination. With changes ν of the loops' multipliers, statics give those of the tree's joints, T ν, and nothing
// accelerates if Λ ν = 0: by the factor of Λ, each independent row's ν follows from those eliminated later,
//   ν_p = −Σ z ν,   z = row of Lᵀ.
// Minimises Σ (λ + change)² / k over ν in the order of elimination, with the blocks of Λ: independent rows are
// substituted, redundant ones are pivots, not below 1 in units in which every k is 1.
#include <algorithm>
#include <cmath>

#include "kernel/joints/kinematics.h"
#include "kernel/solver/loop_rows.h"
#include "kernel/solver/redundant_rows.h"

namespace unlatch {
namespace {

constexpr int kW = kEight;

double get_scale(const PlanData& plan, int joint, int row) {
  const PlanJoint& j = plan.joints[at(joint)];
  return row < kRotX ? j.share : j.turning_share;
}

class ClusterSplit {
 public:
  ClusterSplit(const PlanData& plan, const State& state, Evaluation& ev) : plan_(plan), state_(state), ev_(ev) {}

  void run() const {
    begin();
    for (std::size_t i = plan_.cluster_nodes.size(); i-- > 0;) carry(plan_.cluster_nodes[i]);
    for (std::size_t e = 0; e < plan_.closures.size(); ++e) eliminate(static_cast<int>(e));
    for (std::size_t e = plan_.closures.size(); e-- > 0;) substitute(static_cast<int>(e));
    store();
  }
  // Largest multiplier of the loops' rows, in units in which every k is 1.
  double calc_largest() const {
    double largest = 0;
    for (const ClosureWork& c : ev_.closures)
      for (int r = 0; r < c.count; ++r)
        largest = std::max(largest, std::abs(get_multiplier(c, r) / get_scale_of(c, r)));
    return largest;
  }

 private:
  double* get_block(std::int32_t block) const {
    return ev_.split_matrix.data() + static_cast<std::ptrdiff_t>(block) * kBlockNumbers;
  }
  const double* get_factor(std::int32_t block) const {
    return ev_.cluster_matrix.data() + static_cast<std::ptrdiff_t>(block) * kBlockNumbers;
  }
  double* get_columns(int slot) const {
    return ev_.split_columns.data() + static_cast<std::ptrdiff_t>(slot) * kBlockNumbers;
  }
  const LoopRow& get_row(const ClosureWork& c, int r) const { return ev_.loop_rows[at(c.first + r)]; }
  double get_scale_of(const ClosureWork& c, int r) const {
    return get_scale(plan_, get_row(c, r).joint, get_row(c, r).row);
  }

  double get_multiplier(const ClosureWork& c, int r) const {
    return ev_.multipliers.get(at(get_row(c, r).joint), at(get_row(c, r).row));
  }

  void begin() const {
    std::fill(ev_.split_matrix.begin(), ev_.split_matrix.end(), 0.0);
    std::fill(ev_.split_columns.begin(), ev_.split_columns.end(), 0.0);
    for (std::size_t e = 0; e < plan_.closures.size(); ++e) {
      ClosureWork& c = ev_.closures[e];
      double* own = get_block(plan_.closures[e].block);
      for (int r = 0; r < kW; ++r) c.gradient[r] = c.change[r] = 0;
      for (int r = 0; r < c.count; ++r) {
        c.gradient[r] = get_multiplier(c, r) / get_scale_of(c, r);
        own[r * kW + r] = 1;
      }
    }
    for (std::size_t i = 0; i < plan_.loop_slots.size(); ++i) {
      const LoopSlot& slot = plan_.loop_slots[i];
      if (slot.side == 0) continue;
      const ClosureWork& c = ev_.closures[at(slot.closure)];
      for (int r = 0; r < c.count; ++r) {
        const Spatial& w = slot.side > 0 ? get_row(c, r).on_follower : get_row(c, r).on_base;
        const double numbers[6] = {w.lin.x, w.lin.y, w.lin.z, w.ang.x, w.ang.y, w.ang.z};
        for (int n = 0; n < 6; ++n) get_columns(static_cast<int>(i))[n * kW + r] = get_scale_of(c, r) * numbers[n];
      }
    }
  }

  // Wrench on the child, at its origin, that a row of its joint carries with size −1.
  Spatial get_along(const ClusterNode& node, int r) const {
    const std::int32_t joint = plan_.nodes[at(node.node)].joint;
    const JointView view(plan_, ev_, joint);
    const bool follows = view.get_joint().child == view.get_joint().follower;
    const Vec3 axis = follows ? view.get_axis(r) : -view.get_axis(r);
    return r < kRotX ? Spatial{axis, {0, 0, 0}} : Spatial{-cross(axis, view.get_arm(follows)), axis};
  }
  static void resolve(const double* T, const Spatial& along, double scale, double* out) {
    for (int r = 0; r < kW; ++r)
      out[r] = scale * (((T[r] * along.lin.x + T[kW + r] * along.lin.y) + T[2 * kW + r] * along.lin.z) +
                        ((T[3 * kW + r] * along.ang.x + T[4 * kW + r] * along.ang.y) + T[5 * kW + r] * along.ang.z));
  }

  // From children to parents.
  void carry(const ClusterNode& node) const {
    const std::int32_t joint = plan_.nodes[at(node.node)].joint;
    const RowSet rows = joint == kNone ? RowSet{0} : get_active_rows(plan_, state_, joint);
    for (int r = 0; r < kRows; ++r)
      if (has_row(rows, r)) add_row(node, joint, r);
    const Vec3 arm = read(ev_.blocks.data(), node.place, &SolverLane::offset);
    for (int i = node.closing; i < node.slots; ++i) {
      const int slot = node.first_slot + i;
      const std::int32_t parent = plan_.loop_slots[at(slot)].parent;
      if (parent == kNone) continue;
      const double* from = get_columns(slot);
      double* to = get_columns(parent);
      for (int r = 0; r < kW; ++r) {
        const Vec3 force{from[r], from[kW + r], from[2 * kW + r]}, turn = cross(arm, force);
        const double add[6] = {force.x,           force.y,           force.z, from[3 * kW + r] + turn.x,
                               from[4 * kW + r] + turn.y, from[5 * kW + r] + turn.z};
        for (int n = 0; n < 6; ++n) to[n * kW + r] += add[n];
      }
    }
  }
  void add_row(const ClusterNode& node, std::int32_t joint, int r) const {
    const Spatial along = get_along(node, r);
    const double scale = get_scale(plan_, joint, r), load = ev_.multipliers.get(at(joint), at(r)) / scale;
    const std::int32_t* pair = plan_.loop_pairs.data() + node.first_pair;
    for (int i = node.closing; i < node.slots; ++i) {
      double left[kW], right[kW];
      resolve(get_columns(node.first_slot + i), along, -1 / scale, left);
      ClosureWork& c = ev_.closures[at(plan_.loop_slots[at(node.first_slot + i)].closure)];
      for (int k = 0; k < c.count; ++k) c.gradient[k] += left[k] * load;
      for (int j = i; j < node.slots; ++j, ++pair) {
        resolve(get_columns(node.first_slot + j), along, -1 / scale, right);
        double* block = get_block(*pair);
        for (int k = 0; k < c.count; ++k)
          for (int n = 0; n < kW; ++n) block[k * kW + n] += left[k] * right[n];
      }
    }
  }

  // z of the k-th pivot over the lanes of a link.
  void relate(const ClosureWork& c, int k, const LoopLink& link, double* z) const {
    const ClosureWork& other = ev_.closures[at(link.closure)];
    const int p = c.order[k];
    const double* V = get_factor(link.block) + p * kW;
    const double scale = c.inverse[k] / get_scale_of(c, p);
    for (int n = 0; n < kW; ++n) z[n] = n < other.count ? V[n] * scale * get_scale_of(other, n) : 0;
  }
  double relate_own(const LoopClosure& plan, const ClosureWork& c, int k, int r) const {
    const int p = c.order[k];
    return get_factor(plan.block)[p * kW + r] * c.inverse[k] * get_scale_of(c, r) / get_scale_of(c, p);
  }

  // The quadratic form += u zᵀ + z uᵀ over what is left, and the gradient −= g z.
  void eliminate(int e) const {
    const LoopClosure& plan = plan_.closures[at(e)];
    ClosureWork& c = ev_.closures[at(e)];
    for (int k = 0; k < c.count; ++k) {
      const int p = c.order[k];
      const double* q = get_block(plan.block) + p * kW;
      const bool independent = k < c.rank;
      const double pivot = q[p], half = independent ? 0.5 * pivot : 0;
      double z[kW] = {}, u[kW] = {};
      for (int j = k + 1; j < c.count; ++j) {
        const int r = c.order[j];
        z[r] = independent ? relate_own(plan, c, k, r) : q[r] / pivot;
        u[r] = independent ? half * z[r] - q[r] : -0.5 * q[r];
      }
      for (int j = k + 1; j < c.count; ++j) {
        const int r = c.order[j];
        double* row = get_block(plan.block) + r * kW;
        for (int n = 0; n < kW; ++n) row[n] += u[r] * z[n] + z[r] * u[n];
        c.gradient[r] -= c.gradient[p] * z[r];
      }
      const std::int32_t* pair = plan_.loop_pairs.data() + plan.first_pair;
      for (int i = 0; i < plan.links; ++i) {
        double zi[kW], ui[kW];
        find_link(plan, c, k, i, half, pivot, zi, ui);
        double* across = get_block(plan_.loop_links[at(plan.first_link + i)].block);
        for (int j = k + 1; j < c.count; ++j) {
          const int r = c.order[j];
          for (int n = 0; n < kW; ++n) across[r * kW + n] += u[r] * zi[n] + z[r] * ui[n];
        }
        ClosureWork& other = ev_.closures[at(plan_.loop_links[at(plan.first_link + i)].closure)];
        for (int n = 0; n < other.count; ++n) other.gradient[n] -= c.gradient[p] * zi[n];
        for (int j = i; j < plan.links; ++j, ++pair) {
          double zj[kW], uj[kW];
          find_link(plan, c, k, j, half, pivot, zj, uj);
          double* block = get_block(*pair);
          for (int r = 0; r < other.count; ++r)
            for (int n = 0; n < kW; ++n) block[r * kW + n] += ui[r] * zj[n] + zi[r] * uj[n];
        }
      }
    }
  }
  void find_link(const LoopClosure& plan, const ClosureWork& c, int k, int i, double half, double pivot, double* z,
                 double* u) const {
    const LoopLink& link = plan_.loop_links[at(plan.first_link + i)];
    const double* q = get_block(link.block) + c.order[k] * kW;
    if (k < c.rank) {
      relate(c, k, link, z);
      for (int n = 0; n < kW; ++n) u[n] = half * z[n] - q[n];
      return;
    }
    for (int n = 0; n < kW; ++n) {
      z[n] = q[n] / pivot;
      u[n] = -0.5 * q[n];
    }
  }

  void substitute(int e) const {
    const LoopClosure& plan = plan_.closures[at(e)];
    ClosureWork& c = ev_.closures[at(e)];
    for (int k = c.count; k-- > 0;) {
      const int p = c.order[k];
      const bool independent = k < c.rank;
      const double* q = get_block(plan.block) + p * kW;
      double sum = independent ? 0 : c.gradient[p] / q[p];
      for (int j = k + 1; j < c.count; ++j) {
        const int r = c.order[j];
        sum += (independent ? relate_own(plan, c, k, r) : q[r] / q[p]) * c.change[r];
      }
      for (int i = 0; i < plan.links; ++i) {
        double z[kW], u[kW];
        find_link(plan, c, k, i, 0, q[p], z, u);
        const ClosureWork& other = ev_.closures[at(plan_.loop_links[at(plan.first_link + i)].closure)];
        for (int n = 0; n < other.count; ++n) sum += z[n] * other.change[n];
      }
      c.change[p] = -sum;
    }
  }

  void store() const {
    for (const ClosureWork& c : ev_.closures)
      for (int r = 0; r < c.count; ++r)
        ev_.multipliers.get(at(get_row(c, r).joint), at(get_row(c, r).row)) += get_scale_of(c, r) * c.change[r];
    for (const ClusterNode& node : plan_.cluster_nodes) {
      const std::int32_t joint = plan_.nodes[at(node.node)].joint;
      if (joint == kNone || node.closing == node.slots) continue;
      const RowSet rows = get_active_rows(plan_, state_, joint);
      for (int r = 0; r < kRows; ++r) {
        if (!has_row(rows, r)) continue;
        const Spatial along = get_along(node, r);
        double sum = 0;
        for (int i = node.closing; i < node.slots; ++i) {
          double part[kW];
          resolve(get_columns(node.first_slot + i), along, -1, part);
          const ClosureWork& c = ev_.closures[at(plan_.loop_slots[at(node.first_slot + i)].closure)];
          for (int k = 0; k < c.count; ++k) sum += part[k] * c.change[k];
        }
        ev_.multipliers.get(at(joint), at(r)) += sum;
      }
    }
  }

  const PlanData& plan_;
  const State& state_;
  Evaluation& ev_;
};

}  // namespace

void split_cluster_rows(const PlanData& plan, const State& state, Evaluation& ev) noexcept {
  // Where independent rows nearly follow from others, the multipliers before the split are large and cancel in it: a
  // second one begins with multipliers of the size of the result.
  constexpr double kCancels = 100;
  const ClusterSplit split(plan, state, ev);
  const double before = split.calc_largest();
  split.run();
  if (before > kCancels * split.calc_largest()) split.run();
}

}  // namespace unlatch
