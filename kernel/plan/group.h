// Where the blocks of eight bodies and of groups are, and typed access to them, several lanes at once. The drawing is
// in blocks.h.
#pragma once

#include "kernel/plan/blocks.h"

namespace unlatch {

// --- Blocks of eight bodies ------------------------------------------------------------------------------------------

struct BodyEight {
  std::int32_t body, shared;  // its blocks, in numbers from the beginning of Evaluation::blocks
  std::int32_t constants;     // its BodyConstants, in PlanData::body_constants
  std::uint8_t used;          // bit i: lane i belongs to a group
  std::uint8_t filled;        // bit i: it has a body
  bool loaded;                // some body has a load that is fixed in it: there is an AppliedBlock

  // From one lane on.
  UNLATCH_INLINE BodyBlock<Wide<kEight>>& get_body(double* blocks, int lane) const {
    return as_block<BodyBlock, kEight>(blocks + body + lane);
  }
  UNLATCH_INLINE AppliedBlock<Wide<kEight>>& get_applied(double* blocks, int lane) const {
    return as_block<AppliedBlock, kEight>(blocks + body + kAppliedAfterBody * kEight + lane);
  }
  UNLATCH_INLINE SharedBlock<Wide<kEight>>& get_shared(double* blocks, int lane) const {
    return as_block<SharedBlock, kEight>(blocks + shared + lane);
  }
  UNLATCH_INLINE const BodyConstants<Wide<kEight>>& get_constants(const double* all, int lane) const {
    return as_block<BodyConstants, kEight>(all + constants + lane);
  }
  constexpr int count_body_numbers() const {
    return (kAppliedAfterBody + (loaded ? kNumbers<AppliedBlock> : 0)) * kEight;
  }
};

// --- Groups of joints and nodes --------------------------------------------------------------------------------------

// Relation of a group to its parents.
enum class ParentLink : std::uint8_t {
  kRoot,        // they have none
  kSiblings,    // one parent for the whole group
  kContiguous,  // the parents are the lanes of one group, in the same order
  kGather,      // anywhere in the levels above
};

enum class BodyKind : std::uint8_t {
  kRigid,
  kFlexible,  // solved by kernel/solver/flexible_solver.h
  kMarker,    // outboard of its flexible body, which solves it too
};

// The body of its joint that each child of a group is.
enum class ChildSide : std::uint8_t { kFollower, kBase, kMixed };

// True of a mode in which the child is eliminated through the joint's freedoms: one with three rows or more, and any
// mode of a joint with implicit springs, which act on freedoms. The freedoms are the rows that do not hold, because the
// three point–plane rows have perpendicular axes, and so have the three rotation rows.
constexpr bool is_by_freedoms(RowSet rows, RowSet compliant) {
  const RowSet without_one = static_cast<RowSet>(rows & (rows - 1));
  return (without_one & (without_one - 1)) != 0 || compliant != 0;
}

// Axes whose direction in the follower a mode remembers, bit a for axis a: of three rotation rows all, of two the free
// one. The orientation residual is measured by them.
constexpr std::uint8_t get_carried_axes(RowSet rows) {
  const RowSet rotation = rows & kRotationRows;
  if (rotation == kRotationRows) return 0b111;
  for (int a = 0; a < 3; ++a)
    if (rotation == (kRotationRows & ~row_bit(kRotX + a))) return static_cast<std::uint8_t>(1u << a);
  return 0;
}

struct alignas(64) Group {
  std::int32_t first;         // of its lanes, in PlanData::lane_nodes and PlanData::lane_parents
  std::int32_t body, shared;  // where the first lane's blocks are, in numbers from the beginning of Evaluation::blocks
  std::int32_t joint, solver;
  std::int32_t constants;  // its JointConstants, in PlanData::joint_constants
  std::int32_t begins;     // group whose SubtreeBlocks it begins, being the first to add to all of them; or kNone
  std::uint8_t size;       // numbers per lane from its SolverBlock on
  std::uint8_t width;      // 1, 2, 4 or 8
  std::uint8_t count;      // lanes in use
  ParentLink link;
  BodyKind kind;
  ChildSide side;
  bool siblings_begin : 1, siblings_end : 1;  // first and last group of one parent's, in the order of the backward pass
  bool leaf : 1;                              // nothing is outboard of any of its bodies
  bool has_joint : 1;                         // to the parent or the ground
  bool shared_axes : 1;                       // one frame for point–plane and rotation rows
  bool universal : 1;
  bool may_be_by_rows : 1;  // some mode has fewer than three rows, or a lane is empty
  RowSet freedoms;          // of its modes with three rows or more, together
  RowSet rows;              // of its modes with one or two rows, together
  RowSet compliant;         // freedoms with springs that are integrated implicitly
  std::uint8_t carried;     // bit a: some mode remembers the direction of axis a in the follower

  struct {  // positions of optional parts, in numbers per lane: from the JointBlock on,
    std::int16_t crossed, carried;
    std::uint8_t rotation_axes, free;                          // and from the SolverBlock on
    std::uint8_t freedoms[kRows], rows[kRows], pivots[kRows];  // of those in `freedoms`, `rows` and `compliant`
  } at;
};
static_assert(sizeof(Group) == 64, "a cache line: the solver reads one for each group");
static_assert(kNumbers<SolverBlock> + 9 + kNumbers<FreeBlock> +
                      kRows * (kNumbers<FreedomBlock> + kNumbers<RowBlock> + 1) <
                  256,
              "positions of optional parts are bytes");

// Numbers from the SolverBlock on that the solver reads or writes of a group. The first group of a block of eight has
// the SharedBlock before its own.
struct SolverRange {
  std::int32_t first, end;
};
constexpr SolverRange get_solver_range(const Group& group) {
  const bool first_of_eight = group.shared % kEight == 0;
  return {
      -(group.leaf ? 0 : kSubtreeBeforeSolver * group.width) - (first_of_eight ? kNumbers<SharedBlock> * kEight : 0),
      group.size * group.width};
}

// Parts of a group's blocks. `Lanes` says what of them is seen: WideLanes, several lanes, or OneLane (lanes.h).
template <class Lanes>
class GroupParts {
 public:
  UNLATCH_INLINE GroupParts(const Group& group, double* joint, double* solver, Lanes lanes)
      : group_(group), joint_(joint), solver_(solver), lanes_(lanes) {}

  UNLATCH_INLINE decltype(auto) joint() const { return lanes_.template get<JointBlock>(joint_); }
  UNLATCH_INLINE decltype(auto) crossed() const { return lanes_.get_number(find(joint_, group_.at.crossed)); }
  UNLATCH_INLINE decltype(auto) carried() const {
    return lanes_.template get<CarriedBlock>(find(joint_, group_.at.carried));
  }
  UNLATCH_INLINE decltype(auto) carried_axis(int k) const {  // the k-th of those in Group::carried
    return lanes_.template get<Vec3T>(find(joint_, group_.at.carried + kAxesAfterCarried + kNumbers<Vec3T> * k));
  }

  UNLATCH_INLINE decltype(auto) subtree() const {
    return lanes_.template get<SubtreeBlock>(find(solver_, -kSubtreeBeforeSolver));
  }
  UNLATCH_INLINE decltype(auto) solver() const { return lanes_.template get<SolverBlock>(solver_); }
  UNLATCH_INLINE decltype(auto) axis(int r) const {  // of row r
    const std::ptrdiff_t axes = r < kRotX ? get_index(&SolverBlock<double>::axes)
                                          : group_.at.rotation_axes - kNumbers<Vec3T> * static_cast<int>(kRotX);
    return lanes_.template get<Vec3T>(find(solver_, axes + kNumbers<Vec3T> * r));
  }
  UNLATCH_INLINE decltype(auto) rotation_axes() const {
    return lanes_.template get<Mat3T>(find(solver_, group_.at.rotation_axes));
  }
  UNLATCH_INLINE decltype(auto) free() const { return lanes_.template get<FreeBlock>(find(solver_, group_.at.free)); }
  UNLATCH_INLINE decltype(auto) freedom(int r) const {
    return lanes_.template get<FreedomBlock>(find(solver_, group_.at.freedoms[r]));
  }
  UNLATCH_INLINE decltype(auto) row(int r) const {
    return lanes_.template get<RowBlock>(find(solver_, group_.at.rows[r]));
  }
  UNLATCH_INLINE decltype(auto) pivot(int r) const { return lanes_.get_number(find(solver_, group_.at.pivots[r])); }

 private:
  UNLATCH_INLINE double* find(double* block, std::ptrdiff_t position) const {
    return block + position * lanes_.get_width();
  }

  const Group& group_;
  double *joint_, *solver_;
  [[no_unique_address]] Lanes lanes_;
};

// Parts from some lane on, of a group that is W wide.
template <int W>
struct WideLanes {
  template <template <class> class Block>
  UNLATCH_INLINE Block<Wide<W>>& get(double* numbers) const {
    return as_block<Block, W>(numbers);
  }
  template <template <class> class Block>
  UNLATCH_INLINE const Block<Wide<W>>& get(const double* numbers) const {
    return as_block<Block, W>(numbers);
  }
  UNLATCH_INLINE Wide<W>& get_number(double* number) const { return *reinterpret_cast<Wide<W>*>(number); }
  static constexpr std::ptrdiff_t get_width() { return W; }
};

// The blocks of a group from one lane on, and those of its bodies; W is its width.
template <int W>
class GroupBlocks : public GroupParts<WideLanes<W>> {
 public:
  UNLATCH_INLINE GroupBlocks(const Group& group, double* blocks, int lane)
      : GroupParts<WideLanes<W>>(group, blocks + group.joint + lane, blocks + group.solver + lane, {}),
        body_(blocks + group.body + lane),
        shared_(blocks + group.shared + lane) {}

  UNLATCH_INLINE BodyBlock<Wide<kEight>>& body() const { return as_block<BodyBlock, kEight>(body_); }
  UNLATCH_INLINE SharedBlock<Wide<kEight>>& shared() const { return as_block<SharedBlock, kEight>(shared_); }

 private:
  double *body_, *shared_;
};

// Constants of a group's joints and of the solver. Number: const double, or double where they are written.
template <class Lanes, class Number>
class ConstantParts {
 public:
  // `solver`: PlanData::solver_constants, `joint`: PlanData::joint_constants.
  UNLATCH_INLINE ConstantParts(const Group& group, Number* solver, Number* joint, int lane, Lanes lanes = {})
      : solver_(solver + kNumbers<SolverConstants> * group.first + lane),
        joint_(joint + group.constants + lane),
        lanes_(lanes) {}

  UNLATCH_INLINE decltype(auto) solver() const { return lanes_.template get<SolverConstants>(solver_); }
  UNLATCH_INLINE decltype(auto) joint() const { return lanes_.template get<JointConstants>(joint_); }
  UNLATCH_INLINE decltype(auto) rotation() const {
    return lanes_.template get<RotationConstants>(joint_ + kRotationAfterJoint * lanes_.get_width());
  }

 private:
  Number *solver_, *joint_;
  [[no_unique_address]] Lanes lanes_;
};
template <int W>
using GroupConstants = ConstantParts<WideLanes<W>, const double>;

}  // namespace unlatch
