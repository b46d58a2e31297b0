// Loops eliminated where they close, on the way of the backward pass, in time linear in the number of bodies where the
// ways of few loops overlap. In the terms of loop_rows.h: with A, b the block and load of a body, F the unit wrenches of
// loops' rows there, c their targets and Λ what the pivots outboard of the body have given, the accelerations a and
// multipliers μ are stationary in
//   ½ aᵀ A a − bᵀ a − μᵀ (Fᵀ a − c) − ½ μᵀ Λ μ.
// A freedom s of the joint, with the pivot d and β = sᵀ F, adds β βᵀ / d to Λ and takes β sᵀb / d from c. A loop whose two
// ways have met at the body is complete: its rows are eliminated, the most independent first,
//   A += F Λ⁻¹ Fᵀ,   b += F Λ⁻¹ c,   and likewise for the F, c and Λ of loops that pass on,
// so that the way to the root carries only the loops that are open. Blocks of Λ are dense; which are there is compiled
// (kernel/tree/loop_clusters.h). Accelerations and multipliers come back in the forward pass. (Baraff 1996 leaves such
// rows to the end; closing each where it is complete is the local elimination of Jain, Multibody Syst. Dyn. 2012, and of
// Sathya and Carpentier, IEEE T-RO 2024.) Compiled once per instruction set, see kernel/simd/pack.h.
#pragma once

#include <algorithm>
#include <bit>

#include "kernel/solver/loop_columns.h"

namespace unlatch::UNLATCH_ISA {

template <class T>
class LoopClusters {
 public:
  LoopClusters(const PlanData& plan, Evaluation& ev) : plan_(plan), ev_(ev) {}

  // --- Before the backward pass
  void begin_factor() const {
    std::fill(ev_.cluster_matrix.begin(), ev_.cluster_matrix.end(), 0.0);
    for (ClosureWork& c : ev_.closures) std::fill(c.own, c.own + kEight, 0.0);
    for (const LoopSlot& slot : plan_.loop_slots) {
      double* F = get_numbers(slot);
      std::fill(F, F + 6 * kEight, 0.0);
      if (slot.side == 0) continue;
      const ClosureWork& c = ev_.closures[at(slot.closure)];
      for (int r = 0; r < c.count; ++r) {
        const LoopRow& row = ev_.loop_rows[at(c.first + r)];
        const Spatial& w = slot.side > 0 ? row.on_follower : row.on_base;
        const double numbers[6] = {w.lin.x, w.lin.y, w.lin.z, w.ang.x, w.ang.y, w.ang.z};
        for (int i = 0; i < 6; ++i) F[i * kEight + r] = numbers[i];
      }
    }
  }

  // --- Backward pass: before a group is eliminated, and after
  template <bool kFactor>
  void close(std::size_t g) const {
    for_nodes(g, [&](const ClusterNode& node) {
      for (int i = 0; i < node.closing; ++i) close_one<kFactor>(plan_.loop_slots[at(node.first_slot + i)].closure);
    });
  }
  template <bool kFactor>
  void close_at_ground() const {
    for (std::size_t e = 0; e < plan_.closures.size(); ++e)
      if (plan_.closures[e].node == kNone) close_one<kFactor>(static_cast<int>(e));
  }
  template <bool kFactor>
  void pass(std::size_t g, bool biased) const {
    for_nodes(g, [&](const ClusterNode& node) {
      if (node.closing == node.slots) return;
      if (is_by_freedoms(node)) {
        if constexpr (kFactor) pass_freedoms(node);
        pass_loads_by_freedoms(node, biased);
      } else {
        if constexpr (kFactor) pass_rows(node);
        pass_loads_by_rows(node);
      }
    });
  }

  // --- Forward pass
  void find_multipliers_at_ground() const {
    for (std::size_t e = plan_.closures.size(); e-- > 0;)
      if (plan_.closures[e].node == kNone) find_multipliers(static_cast<int>(e), nullptr);
  }
  // What the open loops add to the loads of a group, before its accelerations are computed.
  void add_reactions(std::size_t g) const {
    for_nodes(g, [&](const ClusterNode& node) {
      const LaneParts parts = get_parts(node);
      for_passing(node, [&](const LoopSlot& slot) {
        const ClosureWork& c = ev_.closures[at(slot.closure)];
        const double* next = get_numbers(slot) + 6 * kEight;
        if (is_by_freedoms(node)) {
          for_freedoms(node, [&](int r, int k) {
            double* beta = parts.freedom(r).find(&FreedomBlock<double>::beta);
            *beta += combine(next + k * kEight, c);
          });
          return;
        }
        next += count_freedoms(node) * kEight;
        Spatial add{{combine(next, c), combine(next + kEight, c), combine(next + 2 * kEight, c)},
                    {combine(next + 3 * kEight, c), combine(next + 4 * kEight, c), combine(next + 5 * kEight, c)}};
        parts.free().add(&FreeBlock<double>::response, add);
        next += 6 * kEight;
        for_rows(node, [&](int r, int k) {
          const LaneOf<RowBlock<double>> own = parts.row(r);
          *own.find(&RowBlock<double>::mu) += own.read(&RowBlock<double>::inverse_pivot) * combine(next + k * kEight, c);
        });
      });
    });
  }
  // Multipliers of the loops that close at a group, and the reactions of the others in its joints.
  void finish(std::size_t g, bool multipliers) const {
    for_nodes(g, [&](const ClusterNode& node) {
      if (node.closing > 0) {
        const Spatial a = read(ev_.blocks.data(), node.place, &SharedBlock<double>::acceleration);
        for (int i = node.closing; i-- > 0;) find_multipliers(plan_.loop_slots[at(node.first_slot + i)].closure, &a);
      }
      if (multipliers && plan_.groups[at(node.group)].has_joint && node.closing < node.slots) add_to_joint(node);
    });
  }
  void store_multipliers() const {
    for (std::size_t e = 0; e < plan_.closures.size(); ++e) {
      const ClosureWork& c = ev_.closures[e];
      for (int r = 0; r < c.count; ++r) {
        const LoopRow& row = ev_.loop_rows[at(c.first + r)];
        ev_.multipliers.get(at(row.joint), at(row.row)) = c.mu[r];
      }
    }
  }

 private:
  double* get_numbers(const LoopSlot& slot) const { return ev_.cluster_columns.data() + slot.numbers; }
  double* get_block(std::int32_t block) const {
    return ev_.cluster_matrix.data() + static_cast<std::ptrdiff_t>(block) * kBlockNumbers;
  }
  LaneParts get_parts(const ClusterNode& node) const {
    return {plan_.groups[at(node.group)], ev_.blocks.data(), node.place};
  }
  // Children before parents.
  template <class Run>
  void for_nodes(std::size_t g, const Run& run) const {
    for (std::int32_t i = plan_.group_clusters[g + 1]; i-- > plan_.group_clusters[g];) run(plan_.cluster_nodes[at(i)]);
  }
  template <class Run>
  void for_passing(const ClusterNode& node, const Run& run) const {
    for (int i = node.closing; i < node.slots; ++i) run(plan_.loop_slots[at(node.first_slot + i)]);
  }
  static bool is_set(double mask) { return __builtin_bit_cast(std::uint64_t, mask) != 0; }
  template <class M>
  M read_solver(const ClusterNode& node, M SolverBlock<double>::*member) const {
    return read(ev_.blocks.data(), node.place, member);
  }
  bool is_by_freedoms(const ClusterNode& node) const {
    const GroupModes& modes = ev_.modes[at(node.group)];
    return modes.by_freedoms && (!plan_.groups[at(node.group)].may_be_by_rows ||
                                 is_set(read_solver(node, &SolverBlock<double>::by_freedoms)));
  }
  int count_freedoms(const ClusterNode& node) const {
    return std::popcount(static_cast<unsigned>(plan_.groups[at(node.group)].freedoms));
  }
  // Freedoms that the mode has, each with its place among those of all modes.
  template <class Run>
  void for_freedoms(const ClusterNode& node, const Run& run) const {
    const unsigned all = plan_.groups[at(node.group)].freedoms;
    const LaneParts parts = get_parts(node);
    for (unsigned left = ev_.modes[at(node.group)].freedoms; left != 0; left &= left - 1) {
      const int r = std::countr_zero(left);
      if (is_set(parts.freedom(r).read(&FreedomBlock<double>::mask)))
        run(r, std::popcount(all & ((1u << static_cast<unsigned>(r)) - 1)));
    }
  }
  template <class Run>
  void for_rows(const ClusterNode& node, const Run& run) const {
    const unsigned all = plan_.groups[at(node.group)].rows;
    const LaneParts parts = get_parts(node);
    for (unsigned left = ev_.modes[at(node.group)].rows; left != 0; left &= left - 1) {
      const int r = std::countr_zero(left);
      if (is_set(parts.row(r).read(&RowBlock<double>::mask)))
        run(r, std::popcount(all & ((1u << static_cast<unsigned>(r)) - 1)));
    }
  }
  template <class Run>
  static void for_lanes(const Run& run) {
    for (int c = 0; c < kEight; c += T::kWidth) run(c);
  }
  static SpatialT<T> load_spatial(const double* F, int c) {
    const auto get = [&](int i) { return load<T>(F + i * kEight + c); };
    return {{get(0), get(1), get(2)}, {get(3), get(4), get(5)}};
  }
  static void store_spatial(double* F, int c, const SpatialT<T>& a) {
    const T numbers[6] = {a.lin.x, a.lin.y, a.lin.z, a.ang.x, a.ang.y, a.ang.z};
    for (int i = 0; i < 6; ++i) store(F + i * kEight + c, numbers[i]);
  }
  static double combine(const double* lanes, const ClosureWork& c) {
    double sum = 0;
    for (int r = 0; r < c.count; ++r) sum += lanes[r] * c.mu[r];
    return sum;
  }
  // block += scale x yᵀ
  static void add_outer_block(double* block, int rows, double scale, const double* x, const double* y) {
    for_lanes([&](int c) {
      const T lanes = load<T>(y + c);
      for (int r = 0; r < rows; ++r) {
        double* row = block + r * kEight + c;
        store(row, load<T>(row) + T(scale * x[r]) * lanes);
      }
    });
  }
  // Of one pivot, or a part of it: `x`, `y`: positions behind a slot's numbers.
  void give(const ClusterNode& node, double scale, int x, int y) const {
    const std::int32_t* pair = plan_.loop_pairs.data() + node.first_pair;
    for (int i = node.closing; i < node.slots; ++i) {
      const LoopSlot& a = plan_.loop_slots[at(node.first_slot + i)];
      ClosureWork& own = ev_.closures[at(a.closure)];
      const double* left = get_numbers(a) + x;
      for (int j = i; j < node.slots; ++j, ++pair) {
        if (own.count == 0) continue;
        const LoopSlot& b = plan_.loop_slots[at(node.first_slot + j)];
        add_outer_block(get_block(*pair), own.count, scale, left, get_numbers(b) + y);
      }
      const double* right = get_numbers(a) + y;
      for (int r = 0; r < own.count; ++r) own.own[r] += (scale * left[r]) * right[r];
    }
  }
  // Moved to the parent's origin, and added to what is there.
  void hand_on(const ClusterNode& node, const LoopSlot& slot, int c, SpatialT<T> F) const {
    if (slot.parent == kNone) return;
    F.ang += cross(spread<T>(read_solver(node, &SolverBlock<double>::offset)), F.lin);
    double* to = get_numbers(plan_.loop_slots[at(slot.parent)]);
    store_spatial(to, c, load_spatial(to, c) + F);
  }

  Spatial read_freedom(const ClusterNode& node, int r) const {
    if (r < kRotX) return {column(read_solver(node, &SolverBlock<double>::axes), r), {0, 0, 0}};
    const Vec3 axis = column(get_parts(node).rotation_axes().read(), r - kRotX);
    return {cross(read_solver(node, &SolverBlock<double>::arm_child), axis), axis};
  }

  void pass_freedoms(const ClusterNode& node) const {
    using Freedom = FreedomBlock<double>;
    SpatialT<T> s[kRows], U[kRows];
    double inverse[kRows];
    int place[kRows], count = 0;
    for_freedoms(node, [&](int r, int k) {
      const LaneOf<Freedom> own = get_parts(node).freedom(r);
      s[count] = spread<T>(read_freedom(node, r));
      U[count] = spread<T>(own.read(&Freedom::U));
      inverse[count] = own.read(&Freedom::inverse_pivot);
      place[count++] = (6 + k) * kEight;
    });
    for_passing(node, [&](const LoopSlot& slot) {
      double* numbers = get_numbers(slot);
      for_lanes([&](int c) {
        SpatialT<T> F = load_spatial(numbers, c);
        for (int k = 0; k < count; ++k) {
          const T beta = dot(s[k], F);
          store(numbers + place[k] + c, beta);
          F = F - (beta * T(inverse[k])) * U[k];
        }
        hand_on(node, slot, c, F);
      });
    });
    for (int k = 0; k < count; ++k) give(node, inverse[k], place[k], place[k]);
  }

  void pass_rows(const ClusterNode& node) const {
    using Row = RowBlock<double>;
    const FreeFactor free = get_parts(node).free().read(&FreeBlock<double>::factor);
    const auto spread3 = [](const Factor3T<double>& f) {
      return Factor3T<T>{T(f.l10), T(f.n20), T(f.l21), T(f.i0), T(f.i1), T(f.i2)};
    };
    const FreeFactorT<T> f{
        spread3(free.M), {spread<T>(free.W.x), spread<T>(free.W.y), spread<T>(free.W.z)}, spread3(free.K)};
    const int reply = (6 + count_freedoms(node)) * kEight, along = reply + 6 * kEight;
    SpatialT<T> w[kRows];
    double inverse[kRows];
    int place[kRows], count = 0;
    for_rows(node, [&](int r, int k) {
      const LaneOf<Row> own = get_parts(node).row(r);
      w[count] = spread<T>(own.read(&Row::wrench));
      inverse[count] = own.read(&Row::inverse_pivot);
      place[count++] = along + k * kEight;
    });
    for_passing(node, [&](const LoopSlot& slot) {
      double* numbers = get_numbers(slot);
      for_lanes([&](int c) {
        const SpatialT<T> response = solve_free(f, load_spatial(numbers, c));
        store_spatial(numbers + reply, c, response);
        const T o(0.0);
        SpatialT<T> F{{o, o, o}, {o, o, o}};
        for (int k = 0; k < count; ++k) {
          const T part = dot(w[k], response);
          store(numbers + place[k] + c, part);
          F = F + (part * T(inverse[k])) * w[k];
        }
        hand_on(node, slot, c, F);
      });
    });
    for (int i = 0; i < 6; ++i) give(node, 1, i * kEight, reply + i * kEight);
    for (int k = 0; k < count; ++k) give(node, -inverse[k], place[k], place[k]);
  }

  static double dot_column(const double* F, int r, const Spatial& a) {
    return ((F[r] * a.lin.x + F[kEight + r] * a.lin.y) + F[2 * kEight + r] * a.lin.z) +
           ((F[3 * kEight + r] * a.ang.x + F[4 * kEight + r] * a.ang.y) + F[5 * kEight + r] * a.ang.z);
  }

  void pass_loads_by_freedoms(const ClusterNode& node, bool biased) const {
    using Freedom = FreedomBlock<double>;
    double reply[kRows];
    int place[kRows], count = 0;
    for_freedoms(node, [&](int r, int k) {
      const LaneOf<Freedom> own = get_parts(node).freedom(r);
      reply[count] = own.read(&Freedom::beta) * own.read(&Freedom::inverse_pivot);
      place[count++] = (6 + k) * kEight;
    });
    const bool moves = biased && plan_.groups[at(node.group)].has_joint;
    const Spatial bias = moves ? read_solver(node, &SolverBlock<double>::bias) : Spatial{{0, 0, 0}, {0, 0, 0}};
    for_passing(node, [&](const LoopSlot& slot) {
      ClosureWork& c = ev_.closures[at(slot.closure)];
      const double* numbers = get_numbers(slot);
      for (int r = 0; r < c.count; ++r) {
        for (int k = 0; k < count; ++k) c.target[r] -= numbers[place[k] + r] * reply[k];
        if (moves) c.target[r] -= dot_column(numbers, r, bias);
      }
    });
  }
  void pass_loads_by_rows(const ClusterNode& node) const {
    const LaneParts parts = get_parts(node);
    const Spatial response = parts.free().read(&FreeBlock<double>::response);
    const int along = (6 + count_freedoms(node) + 6) * kEight;
    for_passing(node, [&](const LoopSlot& slot) {
      ClosureWork& c = ev_.closures[at(slot.closure)];
      const double* numbers = get_numbers(slot);
      for (int r = 0; r < c.count; ++r) c.target[r] -= dot_column(numbers, r, response);
      for_rows(node, [&](int row, int k) {
        const double mu = parts.row(row).read(&RowBlock<double>::mu);
        for (int r = 0; r < c.count; ++r) c.target[r] += numbers[along + k * kEight + r] * mu;
      });
    });
  }

  // The row whose pivot is largest beside its own entry, ties to the earlier, to the place `rank` of the order.
  bool find_pivot(ClosureWork& c, const double* D) const {
    double largest = kRedundant;
    int best = kNone;
    for (int k = c.rank; k < c.count; ++k) {
      const int r = c.order[k];
      const double pivot = D[r * kEight + r];
      if (pivot > largest * c.own[r] && pivot > kHeldByTree * ev_.loop_rows[at(c.first + r)].free) {
        largest = pivot / c.own[r];
        best = k;
      }
    }
    if (best != kNone) std::swap(c.order[c.rank], c.order[best]);
    return best != kNone;
  }

  template <bool kFactor>
  void close_one(int e) const {
    const LoopClosure& plan = plan_.closures[at(e)];
    ClosureWork& c = ev_.closures[at(e)];
    if (c.count == 0) return;
    if constexpr (kFactor) factor(plan, c);
    reduce_target(plan, c);
    if (plan.slot == kNone) return;
    const double* F = get_numbers(plan_.loop_slots[at(plan.slot)]);
    const LaneOf<SubtreeLane> body = get_lane<SubtreeLane>(ev_.blocks.data(), plan_.cluster_nodes[at(plan.node)].place);
    Spatial load = body.read(&SubtreeLane::load);
    for (int k = 0; k < c.rank; ++k) {
      const Spatial phi = get_column(F, c.order[k]);
      load = load + (c.target[c.order[k]] * c.inverse[k]) * phi;
    }
    body.write(&SubtreeLane::load, load);
    if constexpr (kFactor) {
      Articulated A = body.read(&SubtreeLane::A);
      for (int k = 0; k < c.rank; ++k) A = downdated(A, -c.inverse[k], get_column(F, c.order[k]));
      body.write(&SubtreeLane::A, A);
    }
  }
  static Spatial get_column(const double* F, int r) {
    return {{F[r], F[kEight + r], F[2 * kEight + r]}, {F[3 * kEight + r], F[4 * kEight + r], F[5 * kEight + r]}};
  }

  void factor(const LoopClosure& plan, ClosureWork& c) const {
    double* D = get_block(plan.block);
    const LoopLink* links = plan_.loop_links.data() + plan.first_link;
    for (int r = 0; r < c.count; ++r) c.order[r] = r;
    const int most = std::min(c.count, c.start_rank);
    for (c.rank = 0; c.rank < most && find_pivot(c, D); ++c.rank) {
      const int p = c.order[c.rank];
      const double* row = D + p * kEight;
      const double inverse = 1 / row[p];
      c.inverse[c.rank] = inverse;
      double part[kEight] = {};
      for (int k = c.rank + 1; k < c.count; ++k) part[c.order[k]] = row[c.order[k]] * inverse;
      for (int k = c.rank + 1; k < c.count; ++k) {
        const int r = c.order[k];
        subtract(D + r * kEight, part[r], row);
        for (int i = 0; i < plan.links; ++i) {
          double* V = get_block(links[i].block);
          subtract(V + r * kEight, part[r], V + p * kEight);
        }
      }
      if (plan.slot == kNone) continue;
      double* F = get_numbers(plan_.loop_slots[at(plan.slot)]);
      for (int i = 0; i < 6; ++i) subtract(F + i * kEight, F[i * kEight + p], part);
    }
    update_links(plan, c, links);
  }
  static void subtract(double* to, double scale, const double* lanes) {
    for_lanes([&](int c) { store(to + c, load<T>(to + c) - T(scale) * load<T>(lanes + c)); });
  }
  void update_links(const LoopClosure& plan, const ClosureWork& c, const LoopLink* links) const {
    const std::int32_t* pair = plan_.loop_pairs.data() + plan.first_pair;
    const double* F = plan.slot == kNone ? nullptr : get_numbers(plan_.loop_slots[at(plan.slot)]);
    for (int i = 0; i < plan.links; ++i) {
      const double* left = get_block(links[i].block);
      const int rows = ev_.closures[at(links[i].closure)].count;
      for (int j = i; j < plan.links; ++j, ++pair) {
        if (rows == 0) continue;
        double* block = get_block(*pair);
        const double* right = get_block(links[j].block);
        for (int k = 0; k < c.rank; ++k)
          add_outer_block(block, rows, -c.inverse[k], left + c.order[k] * kEight, right + c.order[k] * kEight);
      }
      if (F == nullptr) continue;
      double* to = get_numbers(plan_.loop_slots[at(links[i].slot)]);
      for (int k = 0; k < c.rank; ++k)
        for (int n = 0; n < 6; ++n)
          subtract(to + n * kEight, F[n * kEight + c.order[k]] * c.inverse[k], left + c.order[k] * kEight);
    }
  }
  void reduce_target(const LoopClosure& plan, ClosureWork& c) const {
    const double* D = get_block(plan.block);
    const LoopLink* links = plan_.loop_links.data() + plan.first_link;
    for (int k = 0; k < c.rank; ++k) {
      const int p = c.order[k];
      const double reply = c.target[p] * c.inverse[k];
      for (int j = k + 1; j < c.count; ++j) c.target[c.order[j]] -= D[p * kEight + c.order[j]] * reply;
      for (int i = 0; i < plan.links; ++i)
        subtract(ev_.closures[at(links[i].closure)].target, reply, get_block(links[i].block) + p * kEight);
    }
  }

  // μ, the last pivot first; `a`: acceleration of the body where the loop closes.
  void find_multipliers(int e, const Spatial* a) const {
    const LoopClosure& plan = plan_.closures[at(e)];
    ClosureWork& c = ev_.closures[at(e)];
    const double* D = get_block(plan.block);
    const LoopLink* links = plan_.loop_links.data() + plan.first_link;
    for (double& mu : c.mu) mu = 0;
    for (int k = c.rank; k-- > 0;) {
      const int p = c.order[k];
      double left = c.target[p];
      if (a != nullptr) left -= dot_column(get_numbers(plan_.loop_slots[at(plan.slot)]), p, *a);
      for (int i = 0; i < plan.links; ++i)
        left -= combine(get_block(links[i].block) + p * kEight, ev_.closures[at(links[i].closure)]);
      for (int j = k + 1; j < c.rank; ++j) left -= D[p * kEight + c.order[j]] * c.mu[c.order[j]];
      c.mu[p] = left * c.inverse[k];
    }
  }

  // The part of the open loops in the wrench that the joint puts on the child.
  void add_to_joint(const ClusterNode& node) const {
    Spatial sum{{0, 0, 0}, {0, 0, 0}};
    for_passing(node, [&](const LoopSlot& slot) {
      const ClosureWork& c = ev_.closures[at(slot.closure)];
      const double* F = get_numbers(slot);
      sum = sum + Spatial{{combine(F, c), combine(F + kEight, c), combine(F + 2 * kEight, c)},
                          {combine(F + 3 * kEight, c), combine(F + 4 * kEight, c), combine(F + 5 * kEight, c)}};
    });
    const std::int32_t joint = plan_.nodes[at(node.node)].joint;
    const double side = plan_.joints[at(joint)].child == plan_.joints[at(joint)].follower ? 1 : -1;
    const LaneParts parts = get_parts(node);
    const Mat3 n = read_solver(node, &SolverBlock<double>::axes), m = parts.rotation_axes().read();
    const Vec3 moment = sum.ang - cross(read_solver(node, &SolverBlock<double>::arm_child), sum.lin);
    const bool by_freedoms = is_by_freedoms(node);
    const Group& group = plan_.groups[at(node.group)];
    for (int r = 0; r < kRows; ++r) {
      const bool holds =
          by_freedoms ? !(has_row(group.freedoms, r) && has_row(ev_.modes[at(node.group)].freedoms, r) &&
                          is_set(parts.freedom(r).read(&FreedomBlock<double>::mask)))
                      : has_row(group.rows, r) && has_row(ev_.modes[at(node.group)].rows, r) &&
                            is_set(parts.row(r).read(&RowBlock<double>::mask));
      if (!holds) continue;
      const double size = r < kRotX ? dot(column(n, r), sum.lin) : dot(column(m, r - kRotX), moment);
      ev_.multipliers.get(at(joint), at(r)) -= side * size;
    }
  }

  const PlanData& plan_;
  Evaluation& ev_;
};

}  // namespace unlatch::UNLATCH_ISA
