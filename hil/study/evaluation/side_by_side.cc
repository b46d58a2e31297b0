#include "hil/study/evaluation/side_by_side.h"

#include <algorithm>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

namespace unlatch::hil {

void run_side_by_side(std::size_t count, int jobs, const std::atomic<bool>& stop,
                      const std::function<void(std::size_t)>& work) {
  std::atomic<std::size_t> next{0};
  std::atomic<bool> failed{false};
  std::mutex mutex;
  std::exception_ptr error;
  const auto take = [&] {
    try {
      for (std::size_t i = 0; !failed.load() && !stop.load() && (i = next.fetch_add(1)) < count;) work(i);
    } catch (...) {
      const std::scoped_lock lock(mutex);
      if (!error) error = std::current_exception();
      failed = true;
    }
  };
  {
    std::vector<std::jthread> threads;
    const std::size_t used = std::min(count, static_cast<std::size_t>(std::max(1, jobs)));
    for (std::size_t i = 1; i < used; ++i) threads.emplace_back(take);
    take();
  }
  if (error) std::rethrow_exception(error);
}

void run_shares_side_by_side(std::size_t count, std::size_t most, int jobs, const std::atomic<bool>& stop,
                             const std::function<void(std::size_t, std::size_t)>& work) {
  const auto threads = static_cast<std::size_t>(std::max(1, jobs));
  const std::size_t share = std::clamp<std::size_t>((count + threads - 1) / threads, 1, most);
  run_side_by_side((count + share - 1) / share, jobs, stop,
                   [&](std::size_t i) { work(i * share, std::min(share, count - i * share)); });
}

}  // namespace unlatch::hil
