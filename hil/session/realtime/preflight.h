// Fitness of this machine for hard real time: facts read from the operating system, or measured, and the cost of each.
// Nothing is changed.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace unlatch::hil {

// Facts as found; empty texts and absent numbers: unknown.
struct MachineFacts {
  std::string kernel;           // "6.1.0-rt7 #1 SMP PREEMPT_RT …": release and version
  std::string preemption_mode;  // PREEMPT_DYNAMIC: none, voluntary, full or lazy
  int cpus = 0;
  std::map<std::string, int> governors;           // name → number of CPUs; empty: no frequency scaling to be seen
  std::string isolated_cpus, full_tickless_cpus;  // "2-3"
  std::string clock_source;
  std::optional<std::int64_t> timer_resolution_ns;
  std::optional<std::int64_t> memlock_bytes;  // -1: no limit
  std::optional<std::int64_t> rtprio;
  bool may_lock = false, may_prioritise = false;            // CAP_IPC_LOCK, CAP_SYS_NICE
  std::optional<std::int64_t> rt_runtime_us, rt_period_us;  // -1 us: no throttling
  std::string huge_pages;                                   // always, madvise, never
  std::optional<std::int64_t> swap_kb;
  std::optional<std::int64_t> idle_exit_us;  // exit time of the deepest idle state that is not disabled
  bool may_forbid_idle = false;              // may write /dev/cpu_dma_latency, as a run in real time does
  std::optional<bool> smt;
  bool virtual_machine = false;
  std::optional<std::int64_t> stolen_ms;  // CPU time that the host has taken since boot
  std::optional<std::int64_t> smi_count;  // system management interrupts since boot

  // Measurements on one CPU.
  std::optional<double> core_stretch;         // 90th percentile of run time over its minimum
  std::optional<double> interruptions_per_s;  // rate of interruptions above kInterruption_ns
  std::optional<std::int64_t> longest_interruption_ns;
};
constexpr std::int64_t kInterruption_ns = 5000;

// `root` stands before /proc and /sys; limits, capabilities and clocks are this process's.
MachineFacts read_machine_facts(const std::string& root = "");

// Works for `seconds` on `cpu` (-1: any), in a thread like the cyclic one, and notes interruptions. Returns the
// requests that were refused to that thread.
std::vector<std::string> try_machine(MachineFacts& facts, int cpu = -1, double seconds = 0.5);

struct PreflightCheck {
  enum class Verdict { kGood, kCosts, kMissing, kUnknown };
  std::string name;
  Verdict verdict = Verdict::kGood;
  std::string found;  // fact as found
  std::string cost;   // its cost; empty if none
  std::string mend;   // remedy; empty if there is no need
};
extern const char* const kVerdictNames[4];  // good, costs, missing, unknown

std::vector<PreflightCheck> judge(const MachineFacts& facts);

// The commands that mend what judge() finds, as a shell script for root; what commands cannot mend stands in comments.
// `cpu`: of the cyclic thread, to be isolated; -1: the last one.
std::string print_fixes(const MachineFacts& facts, int cpu = -1);

}  // namespace unlatch::hil
