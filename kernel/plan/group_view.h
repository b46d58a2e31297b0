// Views of blocks for code on packs: loops over blocks of eight bodies and over groups of joints, as wide as the
// instruction set allows, and the way from a group to its parents. Compiled once per instruction set, see
// kernel/simd/pack.h.
#pragma once

#include "kernel/plan/evaluation.h"
#include "kernel/plan/lanes.h"
#include "kernel/simd/wide_packs.h"

namespace unlatch::UNLATCH_ISA {

// --- Bodies, eight side by side --------------------------------------------------------------------------------------

// Some lanes of a block of eight.
template <class Pack>
struct BodyView {
  using T = Pack;
  const BodyEight& eight;
  BodyBlock<Wide<kEight>>& body;
  SharedBlock<Wide<kEight>>& shared;
  const BodyConstants<Wide<kEight>>& constants;
  AppliedBlock<Wide<kEight>>& applied;  // there only if eight.loaded
};

// Calls run<Pack>() with the widest pack that this build has for the lanes that are in use.
template <int kWidest, class Run>
UNLATCH_INLINE void for_used_lanes(const BodyEight& eight, const Run& run) {
  // NOLINTNEXTLINE(bugprone-branch-clone): alike for the width at hand only
  constexpr int kFour = kWidest < 4 ? kWidest : 4, kTwo = kWidest < 2 ? kWidest : 2;
  if (eight.used > 0xf) return run.template operator()<Pack<kWidest>>();
  if (eight.used > 3) return run.template operator()<Pack<kFour>>();
  if (eight.used > 1) return run.template operator()<Pack<kTwo>>();
  return run.template operator()<Pack<1>>();
}

// Calls stage(BodyView) for every block of eight, part by part.
template <int kWidest, class Stage>
UNLATCH_INLINE void for_bodies(const PlanData& plan, Evaluation& ev, const Stage& stage) {
  double* blocks = ev.blocks.data();
  const double* constants = plan.body_constants.data();
  const BodyEight* end = plan.eights.data() + plan.eights.size();
  for (const BodyEight* eight = plan.eights.data(); eight != end; ++eight)
    for_used_lanes<kWidest>(*eight, [&]<class T>() {
      for (int lane = 0; eight->used >> lane != 0; lane += T::kWidth)
        stage(BodyView<T>{*eight, eight->get_body(blocks, lane), eight->get_shared(blocks, lane),
                          eight->get_constants(constants, lane), eight->get_applied(blocks, lane)});
    });
}

// --- Groups ----------------------------------------------------------------------------------------------------------

// Some lanes of a group of width kWidth, from `lane` on: their blocks, constants and parents.
template <class Pack, int W>
struct GroupView {
  using T = Pack;
  static constexpr int kWidth = W;

  const PlanData& plan;
  Evaluation& ev;
  const Group& group;
  const GroupModes& modes;
  int lane;
  GroupBlocks<W> blocks;
  GroupConstants<W> constants;
  const Place* parents;  // of these lanes

  UNLATCH_INLINE GroupView(const PlanData& of, Evaluation& in, std::size_t g, int first)
      : plan(of),
        ev(in),
        group(plan.groups[g]),
        modes(ev.modes[g]),
        lane(first),
        blocks(group, ev.blocks.data(), first),
        constants(group, plan.solver_constants.data(), plan.joint_constants.data(), first),
        parents(plan.lane_parents.data() + group.first + first) {}

  // Axis of row r, world axes.
  UNLATCH_INLINE Vec3T<T> get_axis(int r) const { return load<T>(blocks.axis(r)); }
};

// Calls run<Pack, W>() with the widest pack that this build has for a group, and the group's width.
template <int kWidest, class Run>
UNLATCH_INLINE void for_width(const Group& group, const Run& run) {
  // NOLINTNEXTLINE(bugprone-branch-clone): alike for the width at hand only
  constexpr int kFour = kWidest < 4 ? kWidest : 4, kTwo = kWidest < 2 ? kWidest : 2;
  switch (group.width) {
    case 8:
      return run.template operator()<Pack<kWidest>, 8>();
    case 4:
      return run.template operator()<Pack<kFour>, 4>();
    case 2:
      return run.template operator()<Pack<kTwo>, 2>();
    default:
      return run.template operator()<Pack<1>, 1>();
  }
}

// --- Parents ---------------------------------------------------------------------------------------------------------

// Members of the parents' bodies for the lanes of a group: where the parents are neighbours in their block of eight,
template <class Pack>
struct ContiguousParents {
  using T = Pack;
  const double *body, *shared;
  UNLATCH_INLINE T get_number(BodyBlock<double>*, std::ptrdiff_t i) const { return load<T>(body + i * kEight); }
  UNLATCH_INLINE T get_number(SharedBlock<double>*, std::ptrdiff_t i) const { return load<T>(shared + i * kEight); }
};
// where all lanes have one parent,
template <class Pack>
struct CommonParent {
  using T = Pack;
  const double *body, *shared;
  UNLATCH_INLINE T get_number(BodyBlock<double>*, std::ptrdiff_t i) const { return T(body[i * kEight]); }
  UNLATCH_INLINE T get_number(SharedBlock<double>*, std::ptrdiff_t i) const { return T(shared[i * kEight]); }
};
// and where they are anywhere.
template <class Pack>
struct GatheredParents {
  using T = Pack;
  const double* blocks;
  const Place* places;
  UNLATCH_INLINE T get_number(BodyBlock<double>*, std::ptrdiff_t i) const {
    return gather<T>([&](int lane) { return blocks[places[lane].body + i * kEight]; });
  }
  UNLATCH_INLINE T get_number(SharedBlock<double>*, std::ptrdiff_t i) const {
    return gather<T>([&](int lane) { return blocks[places[lane].shared + i * kEight]; });
  }
};

// A vector or matrix of them, from number `first` of the block on, whose members they are in order.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wmissing-braces"
template <class M, class Block, class Parents, std::size_t... I>
UNLATCH_INLINE M collect_numbers(const Parents& parents, std::ptrdiff_t first, std::index_sequence<I...>) {
  return M{parents.get_number(static_cast<Block*>(nullptr), first + static_cast<std::ptrdiff_t>(I))...};
}
#pragma GCC diagnostic pop
template <template <class> class M, class Block, class Parents>
UNLATCH_INLINE M<typename Parents::T> collect_numbers(const Parents& parents, std::ptrdiff_t first) {
  return collect_numbers<M<typename Parents::T>, Block>(parents, first,
                                                        std::make_index_sequence<std::size_t{kNumbers<M>}>{});
}
template <class Parents, class Block, template <class> class M>
UNLATCH_INLINE auto load(const Parents& parents, M<double> Block::*member) {
  return collect_numbers<M, Block>(parents, get_index(member));
}
// A member of a member.
template <class Parents, class Block, class Part, template <class> class M>
UNLATCH_INLINE auto load(const Parents& parents, Part Block::*part, M<double> Part::*member) {
  return collect_numbers<M, Block>(parents, get_index(part) + get_index(member));
}

// Calls read(parents): the way to them is chosen once.
template <class V, class Read, class T = typename V::T>
UNLATCH_INLINE auto visit_parents(const V& view, const Read& read) {
  const double* blocks = view.ev.blocks.data();
  const double *body = blocks + view.parents[0].body, *shared = blocks + view.parents[0].shared;
  if (view.group.link == ParentLink::kContiguous) return read(ContiguousParents<T>{body, shared});
  if (view.group.link == ParentLink::kSiblings) return read(CommonParent<T>{body, shared});
  return read(GatheredParents<T>{blocks, view.parents});
}

}  // namespace unlatch::UNLATCH_ISA
