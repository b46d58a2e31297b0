// Facts for preflight, from /proc, /sys and limits; and measurements of those that no file has: other users of the
// core, and interruptions.
#include <fcntl.h>
#include <sys/resource.h>
#include <sys/utsname.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <ctime>
#include <fstream>
#include <sstream>
#include <thread>
#include <vector>

#include "hil/session/realtime/clock.h"
#include "hil/session/realtime/preflight.h"
#include "hil/session/realtime/real_time.h"
#include "hil/session/realtime/yardsticks.h"

namespace unlatch::hil {
namespace {

// The first line of a file; empty if it cannot be read.
std::string read_line(const std::string& path) {
  std::ifstream file(path);
  std::string line;
  std::getline(file, line);
  return line;
}

std::optional<std::int64_t> to_number(const std::string& text) {
  std::int64_t value = 0;
  const auto result = std::from_chars(text.data(), text.data() + text.size(), value);
  if (result.ec != std::errc{} || result.ptr == text.data()) return std::nullopt;
  return value;
}

// "always [madvise] never" → madvise; also the kernel's "(full)".
std::string get_chosen(const std::string& line, char open, char close) {
  const std::size_t begin = line.find(open), end = line.find(close);
  return begin == std::string::npos || end < begin ? "" : line.substr(begin + 1, end - begin - 1);
}

// The words after "key:" or "key " at the beginning of a line.
std::string find_value(const std::string& path, const std::string& key) {
  std::ifstream file(path);
  for (std::string line; std::getline(file, line);) {
    if (!line.starts_with(key)) continue;
    const std::size_t begin = line.find_first_not_of(" \t:", key.size());
    return begin == std::string::npos ? "" : line.substr(begin);
  }
  return {};
}

void read_cpus(const std::string& root, MachineFacts& facts) {
  const std::string cpu = root + "/sys/devices/system/cpu/";
  facts.cpus = static_cast<int>(sysconf(_SC_NPROCESSORS_ONLN));
  for (int i = 0; i < facts.cpus; ++i) {
    const std::string governor = read_line(cpu + "cpu" + std::to_string(i) + "/cpufreq/scaling_governor");
    if (!governor.empty()) ++facts.governors[governor];
  }
  facts.isolated_cpus = read_line(cpu + "isolated");
  facts.full_tickless_cpus = read_line(cpu + "nohz_full");
  if (facts.full_tickless_cpus == "(null)") facts.full_tickless_cpus.clear();
  if (const auto active = to_number(read_line(cpu + "smt/active"))) facts.smt = *active != 0;
  for (int i = 0;; ++i) {
    const std::string state = cpu + "cpu0/cpuidle/state" + std::to_string(i);
    const auto latency = to_number(read_line(state + "/latency"));
    if (!latency) break;
    if (to_number(read_line(state + "/disable")).value_or(0) != 0) continue;
    facts.idle_exit_us = std::max(facts.idle_exit_us.value_or(0), *latency);
  }
}

std::optional<std::int64_t> read_limit(int resource) {
  rlimit limit{};
  if (getrlimit(static_cast<__rlimit_resource>(resource), &limit) != 0) return std::nullopt;
  return limit.rlim_cur == RLIM_INFINITY ? -1 : static_cast<std::int64_t>(limit.rlim_cur);
}

void read_privileges(MachineFacts& facts) {
  constexpr unsigned kIpcLock = 14, kSysNice = 23;  // bits of the capability mask
  facts.memlock_bytes = read_limit(RLIMIT_MEMLOCK);
  facts.rtprio = read_limit(RLIMIT_RTPRIO);
  const std::string mask = find_value("/proc/self/status", "CapEff");
  std::uint64_t capabilities = 0;
  std::from_chars(mask.data(), mask.data() + mask.size(), capabilities, 16);
  facts.may_lock = (capabilities >> kIpcLock & 1) != 0;
  facts.may_prioritise = (capabilities >> kSysNice & 1) != 0;
}

// Model-specific register 0x34 of Intel's processors counts them; root alone may read it.
std::optional<std::int64_t> read_smi_count(const std::string& root) {
  constexpr off_t kRegister = 0x34;
  if (find_value(root + "/proc/cpuinfo", "vendor_id") != "GenuineIntel") return std::nullopt;
  const int file = open((root + "/dev/cpu/0/msr").c_str(), O_RDONLY | O_CLOEXEC);
  if (file < 0) return std::nullopt;
  std::uint64_t value = 0;
  const ssize_t length = pread(file, &value, sizeof value, kRegister);
  close(file);
  if (length != static_cast<ssize_t>(sizeof value)) return std::nullopt;
  return static_cast<std::int64_t>(value & 0xffffffff);
}

// The eighth number of the line "cpu …", in clock ticks.
std::optional<std::int64_t> read_stolen_ms(const std::string& root) {
  std::istringstream words(find_value(root + "/proc/stat", "cpu "));
  std::int64_t value = 0;
  for (int i = 0; i < 8; ++i) {
    if (!(words >> value)) return std::nullopt;
  }
  return value * 1000 / sysconf(_SC_CLK_TCK);
}

template <class Work>
std::int64_t measure_ns(Work&& work) {
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

MachineFacts read_machine_facts(const std::string& root) {
  MachineFacts facts;
  facts.kernel = read_line(root + "/proc/sys/kernel/osrelease") + " " + read_line(root + "/proc/sys/kernel/version");
  if (read_line(root + "/sys/kernel/realtime") == "1" && facts.kernel.find("PREEMPT_RT") == std::string::npos) {
    facts.kernel += " PREEMPT_RT";
  }
  facts.preemption_mode = get_chosen(read_line(root + "/sys/kernel/debug/sched/preempt"), '(', ')');
  read_cpus(root, facts);
  facts.clock_source = read_line(root + "/sys/devices/system/clocksource/clocksource0/current_clocksource");
  if (timespec resolution{}; clock_getres(CLOCK_MONOTONIC, &resolution) == 0) {
    facts.timer_resolution_ns = resolution.tv_sec * 1'000'000'000 + resolution.tv_nsec;
  }
  read_privileges(facts);
  facts.rt_runtime_us = to_number(read_line(root + "/proc/sys/kernel/sched_rt_runtime_us"));
  facts.rt_period_us = to_number(read_line(root + "/proc/sys/kernel/sched_rt_period_us"));
  facts.huge_pages = get_chosen(read_line(root + "/sys/kernel/mm/transparent_hugepage/enabled"), '[', ']');
  facts.swap_kb = to_number(find_value(root + "/proc/meminfo", "SwapTotal"));
  facts.virtual_machine =
      (" " + find_value(root + "/proc/cpuinfo", "flags") + " ").find(" hypervisor ") != std::string::npos;
  facts.stolen_ms = read_stolen_ms(root);
  facts.smi_count = read_smi_count(root);
  facts.may_forbid_idle = access((root + "/dev/cpu_dma_latency").c_str(), W_OK) == 0;
  return facts;
}

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
      sums.push_back(measure_ns([] { add_side_by_side(); }));
      multiplications.push_back(measure_ns([] { multiply_in_turn(); }));
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
