// Counts what a piece of code takes from the heap, by standing in front of malloc and its relatives in the executable
// that links it; operator new and Eigen end there as well.
//
//   AllocationCount count;
//   step(...);
//   EXPECT_EQ(count.get(), 0);
//
// glibc only. A build with a sanitizer that brings its own malloc leaves it alone: then kCountsAllocations is false,
// and a test that needs the count skips itself.
#pragma once

namespace unlatch::test {

extern const bool kCountsAllocations;

// Calls of malloc, calloc, realloc, memalign, aligned_alloc and posix_memalign by this thread since it was made.
class AllocationCount {
 public:
  AllocationCount();
  long get() const;

 private:
  long start_;
};

}  // namespace unlatch::test
