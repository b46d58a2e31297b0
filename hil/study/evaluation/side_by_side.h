// Independent pieces of work on several threads.
#pragma once

#include <atomic>
#include <cstddef>
#include <functional>

namespace unlatch::hil {

// Calls work(0) … work(count - 1), at most `jobs` at a time: each thread, this one included, takes the next free piece.
// `stop`, which another thread may set, abandons the rest; so does an exception: the first is rethrown here, after all
// threads have ended.
void run_side_by_side(std::size_t count, int jobs, const std::atomic<bool>& stop,
                      const std::function<void(std::size_t)>& work);

// Does the same in shares of successive pieces, of `most` pieces, or fewer so that each thread has its part:
// work(first, number).
void run_shares_side_by_side(std::size_t count, std::size_t most, int jobs, const std::atomic<bool>& stop,
                             const std::function<void(std::size_t, std::size_t)>& work);

}  // namespace unlatch::hil
