// Measurements for facts that no file has: other users of the core, and interruptions.
#include <algorithm>
#include <thread>
#include <vector>

#include "hil/session/realtime/clock.h"
#include "hil/session/realtime/preflight.h"
#include "hil/session/realtime/real_time.h"
#include "hil/session/realtime/yardsticks.h"

namespace unlatch::hil {
namespace {

template <class Work>
std::int64_t time(Work&& work) {
  const std::int64_t begin_ns = get_monotonic_ns();
  work();
  return get_monotonic_ns() - begin_ns;
}

// The ninth decile, in multiples of the least.
double calc_stretch(std::vector<std::int64_t>& times) {
  const auto ninth = times.begin() + static_cast<std::ptrdiff_t>(times.size() * 9 / 10);
  std::nth_element(times.begin(), ninth, times.end());
  return static_cast<double>(*ninth) / static_cast<double>(*std::min_element(times.begin(), ninth + 1));
}

}  // namespace

std::vector<std::string> try_machine(MachineFacts& facts, int cpu, double seconds) {
  std::vector<std::int64_t> sums, multiplications;  // ns each
  const auto capacity = static_cast<std::size_t>(seconds * 1e6);
  sums.reserve(capacity);
  multiplications.reserve(capacity);
  std::vector<std::string> refused;
  std::jthread([&] {
    refused = request_real_time({.cpu = cpu});
    const std::int64_t end_ns = get_monotonic_ns() + static_cast<std::int64_t>(seconds * 1e9);
    do {
      sums.push_back(time([] { add_side_by_side(); }));
      multiplications.push_back(time([] { multiply_in_turn(); }));
    } while (get_monotonic_ns() < end_ns && sums.size() < capacity);
  }).join();

  // A slower clock stretches both alike, a neighbour only the sums, which fill the core.
  facts.core_stretch = calc_stretch(sums) / calc_stretch(multiplications);
  std::int64_t interruptions = 0, longest_ns = 0, total_ns = 0;
  for (const auto* times : {&sums, &multiplications}) {
    const std::int64_t least_ns = *std::min_element(times->begin(), times->end());
    for (const std::int64_t ns : *times) {
      const std::int64_t more_ns = ns - 2 * least_ns;  // a neighbour makes it twice as long at most
      if (more_ns > kInterruption_ns) ++interruptions;
      longest_ns = std::max(longest_ns, more_ns);
      total_ns += ns;
    }
  }
  facts.interruptions_per_s = static_cast<double>(interruptions) * 1e9 / static_cast<double>(total_ns);
  facts.longest_interruption_ns = std::max(longest_ns, std::int64_t{0});
  return refused;
}

}  // namespace unlatch::hil
