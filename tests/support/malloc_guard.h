// Counter of heap allocations of a piece of code: it replaces malloc and its relatives in the executable that links it;
// operator new and Eigen use these as well.
//
//   AllocationCount count;
//   step(...);
//   EXPECT_EQ(count.get(), 0);
//
// glibc only. In a build with a sanitizer, which has its own malloc, it is inactive: then kCountsAllocations is false,
// and a test that needs the count skips itself.
#pragma once

namespace unlatch::test {

extern const bool kCountsAllocations;

// Number of calls of malloc, calloc, realloc, memalign, aligned_alloc and posix_memalign by this thread since its
// construction.
class AllocationCount {
 public:
  AllocationCount();
  long get() const;

 private:
  long start_;
};

}  // namespace unlatch::test
