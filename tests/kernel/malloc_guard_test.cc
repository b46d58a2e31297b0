#include "tests/support/malloc_guard.h"

#include <gtest/gtest.h>
#include <stdlib.h>

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <thread>
#include <vector>

namespace unlatch::test::malloc_guard_test {
namespace {

// Keeps the compiler from removing an unused allocation.
void use(void* memory) { asm volatile("" : : "r"(memory) : "memory"); }

class MallocGuard : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!kCountsAllocations) GTEST_SKIP() << "this build's sanitizer owns malloc";
  }
};

TEST_F(MallocGuard, CountsEveryWayToAllocate) {
  const AllocationCount count;
  void* memory = malloc(10);
  use(memory);
  EXPECT_EQ(count.get(), 1);
  memory = realloc(memory, 100000);
  use(memory);
  EXPECT_EQ(count.get(), 2);
  free(memory);
  memory = calloc(3, 8);
  use(memory);
  free(memory);
  EXPECT_EQ(count.get(), 3);
  memory = aligned_alloc(64, 128);
  use(memory);
  free(memory);
  EXPECT_EQ(count.get(), 4);
  EXPECT_EQ(posix_memalign(&memory, 64, 128), 0);
  EXPECT_EQ(reinterpret_cast<std::uintptr_t>(memory) % 64, 0u);
  free(memory);
  EXPECT_EQ(count.get(), 5);
}

TEST_F(MallocGuard, CountsWhatCxxAllocates) {
  const AllocationCount count;
  std::vector<double> vector(3);
  use(vector.data());
  EXPECT_EQ(count.get(), 1);
  Eigen::VectorXd dynamic = Eigen::VectorXd::Zero(7);
  use(dynamic.data());
  EXPECT_EQ(count.get(), 2);
  struct alignas(128) Wide {
    double x[16];
  };
  const auto wide = std::make_unique<Wide>();
  use(wide.get());
  EXPECT_EQ(count.get(), 3);
}

TEST_F(MallocGuard, CountsNothingWhereNothingIsAllocated) {
  const AllocationCount count;
  Eigen::Matrix3d fixed = Eigen::Matrix3d::Identity();
  use(fixed.data());
  free(nullptr);
  EXPECT_EQ(count.get(), 0);
}

TEST_F(MallocGuard, CountsThisThreadOnly) {
  long inside = 0, outside = 0;
  std::thread other([&] {
    const AllocationCount count;
    for (int i = 0; i < 5; ++i) use(std::make_unique<double>().get());
    inside = count.get();
  });
  const AllocationCount count;
  other.join();
  outside = count.get();
  EXPECT_EQ(inside, 5);
  EXPECT_EQ(outside, 0);
}

}  // namespace
}  // namespace unlatch::test::malloc_guard_test
