// Plan images: used wherever they lie, and refused when anything about them is wrong.
#include "kernel/plan/plan_image.h"

#include <gtest/gtest.h>

#include <cstring>

#include "tests/golden/golden_models.h"
#include "tests/support/malloc_guard.h"
#include "tests/support/random.h"
#include "tests/support/simulation.h"
#include "tests/support/small_models.h"

namespace unlatch::test::plan_image_test {
namespace {

constexpr std::uint64_t kSeed = 48;

// A copy of an image at a place of its own.
class Copy {
 public:
  explicit Copy(std::span<const std::byte> image) : block_(image.size()) {
    std::memcpy(block_.get().data(), image.data(), image.size());
  }
  std::span<std::byte> get() { return block_.get(); }
  ImageHeader& header() { return *reinterpret_cast<ImageHeader*>(get().data()); }
  // Corrects the checksum, so that what lies behind it is looked at.
  void seal() { header().checksum = calc_words_hash(get().subspan(kImageChecked)); }
  ImageStatus open() {
    PlanMemory memory;
    return open_plan(get(), memory).status;
  }

 private:
  Block block_;
};

Plan compile(const GoldenModel& golden) { return compile_or_throw(golden.model, {.dt = golden.dt}); }
Plan compile_first() { return compile(build_golden_models().front()); }

std::uint64_t fly(const Plan& plan, int ticks) {
  Block state_memory(plan.get_state_bytes()), workspace_memory(plan.get_workspace_bytes());
  State state(plan, state_memory.get());
  Workspace workspace(plan, workspace_memory.get());
  init_state(plan, state);
  for (int i = 0; i < ticks; ++i)
    if (step(plan, {plan.get_initial_commands()}, state, workspace).status != StepStatus::kOk) return 0;
  return calc_hash(state);
}

TEST(PlanImage, StepsWithTheSameBitsWhereverItLies) {
  constexpr int kTicks = 150;
  for (const GoldenModel& golden : build_golden_models()) {
    const Plan plan = compile(golden);
    Copy copy(plan.get_image());
    PlanMemory memory;
    const OpenedPlan opened = open_plan(copy.get(), memory);
    ASSERT_TRUE(opened.plan) << golden.model.name << ": " << get_status_text(opened.status);
    EXPECT_EQ(opened.plan->get_hash(), plan.get_hash());
    EXPECT_EQ(opened.plan->get_state_bytes(), plan.get_state_bytes());
    const std::uint64_t hash = fly(plan, kTicks);
    EXPECT_NE(hash, 0u) << golden.model.name;
    EXPECT_EQ(fly(*opened.plan, kTicks), hash) << golden.model.name;
  }
}

TEST(PlanImage, HoldsTheCommandsOfTheStart) {
  for (const GoldenModel& golden : build_golden_models()) {
    const Plan plan = compile(golden);
    const std::span<const double> commands = plan.get_initial_commands();
    ASSERT_EQ(commands.size(), golden.model.channels.size());
    for (std::size_t i = 0; i < commands.size(); ++i) EXPECT_EQ(commands[i], golden.model.channels[i].initial);
  }
}

#if !defined(__clang__)  // which leaves the bytes between members as they come
TEST(PlanImage, HasTheSameBytesWhenTheModelIsCompiledAgain) {
  const Plan first = compile_first(), second = compile_first();
  const std::span<const std::byte> a = first.get_image(), b = second.get_image();
  ASSERT_EQ(a.size(), b.size());
  EXPECT_EQ(std::memcmp(a.data(), b.data(), a.size()), 0);
}
#endif

TEST(PlanImage, OpensWithoutAllocating) {
  if (!kCountsAllocations) GTEST_SKIP() << "this build's sanitizer owns malloc";
  const Plan plan = compile_first();
  Copy copy(plan.get_image());
  PlanMemory memory;
  const AllocationCount count;
  EXPECT_TRUE(open_plan(copy.get(), memory).plan);
  EXPECT_EQ(count.get(), 0);
}

TEST(PlanImage, IsRefusedWhenItIsCutAnywhere) {
  const Plan plan = compile_first();
  Copy copy(plan.get_image());
  PlanMemory memory;
  for (std::size_t size = 0; size < copy.get().size(); size += size < sizeof(ImageHeader) ? 1 : 61)
    EXPECT_EQ(open_plan(copy.get().first(size), memory).status, ImageStatus::kTruncated) << size;
}

TEST(PlanImage, IsRefusedWhenAnyBitIsWrong) {
  const Plan plan = compile_first();
  Copy copy(plan.get_image());
  Random random(kSeed);
  constexpr int kTrials = 5000;
  for (int i = 0; i < kTrials; ++i) {
    const int place = random.below(i % 2 == 0 ? static_cast<int>(copy.get().size()) : 256);
    std::byte& wrong = copy.get()[static_cast<std::size_t>(place)];
    const std::byte mask{static_cast<unsigned char>(1u << random.below(8))};
    wrong ^= mask;
    EXPECT_NE(copy.open(), ImageStatus::kOk) << "seed " << kSeed << ", byte " << place;
    wrong ^= mask;
  }
  EXPECT_EQ(copy.open(), ImageStatus::kOk);
}

TEST(PlanImage, NamesWhatIsWrong) {
  const Plan plan = compile_first();
  const auto open = [&](const auto& change) {
    Copy copy(plan.get_image());
    change(copy.header());
    copy.seal();
    return copy.open();
  };
  EXPECT_EQ(open([](ImageHeader&) {}), ImageStatus::kOk);
  EXPECT_EQ(open([](ImageHeader& h) { h.magic[0] = 'X'; }), ImageStatus::kNoImage);
  EXPECT_EQ(open([](ImageHeader& h) { h.byte_order = 0x04030201; }), ImageStatus::kByteOrder);
  EXPECT_EQ(open([](ImageHeader& h) { ++h.version; }), ImageStatus::kVersion);
  EXPECT_EQ(open([](ImageHeader& h) { ++h.layout; }), ImageStatus::kLayout);
  EXPECT_EQ(open([](ImageHeader& h) { h.bytes += 8; }), ImageStatus::kTruncated);
  EXPECT_EQ(open([](ImageHeader& h) { h.bytes = 8; }), ImageStatus::kRange);
  for (std::size_t list = 0; list < kPlanLists; ++list) {
    EXPECT_EQ(open([&](ImageHeader& h) { h.lists[list].offset += 1; }), ImageStatus::kRange) << list;
    EXPECT_EQ(open([&](ImageHeader& h) { h.lists[list].offset = 0xFFFFFFC0u; }), ImageStatus::kRange) << list;
    EXPECT_EQ(open([&](ImageHeader& h) { h.lists[list].count = 0xFFFFFFFFu; }), ImageStatus::kRange) << list;
  }
  Copy shifted(plan.get_image());
  PlanMemory memory;
  EXPECT_EQ(open_plan(shifted.get().subspan(8), memory).status, ImageStatus::kMisaligned);
}

}  // namespace
}  // namespace unlatch::test::plan_image_test
