#include "hil/session/realtime/preflight.h"

#include <array>
#include <charconv>

namespace unlatch::hil {

const char* const kVerdictNames[4] = {"good", "costs", "missing", "unknown"};

namespace {

using Check = PreflightCheck;
using Verdict = PreflightCheck::Verdict;

constexpr std::int64_t kCoarse_ns = 1000;          // a high-resolution timer has 1 ns
constexpr std::int64_t kEnoughLocked = 512 << 20;  // bytes: a session over DDS maps some 300 MB
constexpr std::int64_t kPriority = 81;             // priority of the watchdog, above the cyclic thread's 80
constexpr std::int64_t kDeepIdle_us = 10;
constexpr double kAlone = 1.3;            // core_stretch of a core without another user
constexpr double kFewInterruptions = 10;  // interruptions per second: one in 10,000 steps of 10 us

Check good(std::string name, std::string found) { return {std::move(name), Verdict::kGood, std::move(found), "", ""}; }

Check judge_kernel(const MachineFacts& f) {
  const std::string found = f.kernel + (f.preemption_mode.empty() ? "" : ", preemption " + f.preemption_mode);
  if (f.kernel.find("PREEMPT_RT") != std::string::npos) return good("kernel", found);
  const bool preemptible = f.kernel.find("PREEMPT") != std::string::npos;
  const bool boot_mode = f.kernel.find("PREEMPT_DYNAMIC") != std::string::npos && f.preemption_mode != "full";
  return {
      "kernel", Verdict::kCosts, found,
      preemptible ? "not PREEMPT_RT: interrupt handlers and spinlocks delay a wake-up by up to milliseconds"
                  : "not preemptible: a system call of another process delays a wake-up by up to tens of milliseconds",
      boot_mode ? "boot a PREEMPT_RT kernel (Debian: linux-image-rt-amd64); at least preempt=full on the command line"
                : "boot a PREEMPT_RT kernel (Debian: linux-image-rt-amd64)"};
}

Check judge_governor(const MachineFacts& f) {
  if (f.governors.empty()) {
    return {"governor", f.virtual_machine ? Verdict::kUnknown : Verdict::kGood, "no frequency scaling to be seen",
            f.virtual_machine ? "the host may change the clock as it likes" : "",
            f.virtual_machine ? "set the governor performance on the host" : ""};
  }
  std::string found;
  for (const auto& [name, count] : f.governors) {
    found += (found.empty() ? "" : ", ") + name + " on " + std::to_string(count) + " CPUs";
  }
  if (f.governors.size() == 1 && f.governors.begin()->first == "performance") return good("governor", found);
  return {"governor", Verdict::kCosts, found, "a step after idling runs at a low clock, up to several times longer",
          "cpupower frequency-set -g performance"};
}

Check judge_isolation(const MachineFacts& f) {
  if (!f.isolated_cpus.empty()) {
    return good("isolated CPUs",
                f.isolated_cpus + (f.full_tickless_cpus.empty() ? "" : ", tickless " + f.full_tickless_cpus));
  }
  return {"isolated CPUs", Verdict::kCosts, "none of " + std::to_string(f.cpus),
          "other threads and interrupts run on the cyclic thread's CPU, some 10 us each and more",
          "boot with isolcpus=N nohz_full=N rcu_nocbs=N irqaffinity=<the others>, then `unlatch hil --cpu N`"};
}

Check judge_timer(const MachineFacts& f) {
  if (!f.timer_resolution_ns) return {"timer resolution", Verdict::kUnknown, "not to be found out", "", ""};
  const std::string found = std::to_string(*f.timer_resolution_ns) + " ns";
  if (*f.timer_resolution_ns <= kCoarse_ns) return good("timer resolution", found);
  return {"timer resolution", Verdict::kCosts, found, "every wake-up is late by up to that",
          "a kernel with CONFIG_HIGH_RES_TIMERS, without highres=off"};
}

Check judge_clock(const MachineFacts& f) {
  if (f.clock_source.empty()) return {"clock source", Verdict::kUnknown, "not to be found out", "", ""};
  if (f.clock_source == "tsc" || f.clock_source == "arch_sys_counter" || f.clock_source == "kvm-clock") {
    return good("clock source", f.clock_source);
  }
  return {"clock source", Verdict::kCosts, f.clock_source,
          "reading the clock is a system call of a microsecond or more, several times a tick",
          "tsc=reliable clocksource=tsc on the command line, if the processor's counter is invariant"};
}

Check judge_memlock(const MachineFacts& f) {
  const std::int64_t limit = f.memlock_bytes.value_or(0);
  if (f.may_lock) return good("locked memory", "CAP_IPC_LOCK");
  if (limit < 0 || limit >= kEnoughLocked)
    return good("locked memory", limit < 0 ? "no limit" : std::to_string(limit) + " bytes");
  return {"locked memory", Verdict::kMissing, "limit " + std::to_string(limit) + " bytes",
          "no mlockall: a page fault delays a step by microseconds, or by milliseconds from disk",
          "memlock unlimited in /etc/security/limits.d, or CAP_IPC_LOCK"};
}

Check judge_priority(const MachineFacts& f) {
  if (f.may_prioritise) return good("real-time priority", "CAP_SYS_NICE");
  const std::int64_t limit = f.rtprio.value_or(0);
  if (limit < 0 || limit >= kPriority)
    return good("real-time priority", limit < 0 ? "no limit" : "limit " + std::to_string(limit));
  return {"real-time priority", Verdict::kMissing, "limit " + std::to_string(limit),
          "no SCHED_FIFO: any busy process delays a tick by milliseconds",
          "rtprio 99 in /etc/security/limits.d, or CAP_SYS_NICE"};
}

Check judge_throttling(const MachineFacts& f) {
  if (!f.rt_runtime_us || !f.rt_period_us)
    return {"real-time throttling", Verdict::kUnknown, "not to be found out", "", ""};
  if (*f.rt_runtime_us < 0 || *f.rt_runtime_us >= *f.rt_period_us) return good("real-time throttling", "off");
  return {"real-time throttling", Verdict::kCosts,
          std::to_string(*f.rt_runtime_us) + " of " + std::to_string(*f.rt_period_us) + " us",
          "a real-time thread that needs more, as with a long spin, is stopped for the rest of the period",
          "leave it, or echo -1 > /proc/sys/kernel/sched_rt_runtime_us"};
}

Check judge_huge_pages(const MachineFacts& f) {
  if (f.huge_pages.empty()) return {"transparent huge pages", Verdict::kUnknown, "not to be found out", "", ""};
  if (f.huge_pages != "always") return good("transparent huge pages", f.huge_pages);
  return {"transparent huge pages", Verdict::kCosts, f.huge_pages,
          "khugepaged moves pages under a running step: some 100 us now and then",
          "echo madvise > /sys/kernel/mm/transparent_hugepage/enabled"};
}

Check judge_swap(const MachineFacts& f) {
  if (!f.swap_kb) return {"swap", Verdict::kUnknown, "not to be found out", "", ""};
  if (*f.swap_kb == 0) return good("swap", "none");
  const bool locked = judge_memlock(f).verdict == Verdict::kGood;
  return {"swap", locked ? Verdict::kGood : Verdict::kCosts, std::to_string(*f.swap_kb) + " kB",
          locked ? "" : "without locked memory a step may wait for the disk",
          locked ? "" : "swapoff -a, or lock memory"};
}

Check judge_idle(const MachineFacts& f) {
  if (!f.idle_exit_us) return {"idle states", Verdict::kUnknown, "not to be found out", "", ""};
  const std::string found = "deepest takes " + std::to_string(*f.idle_exit_us) + " us to leave";
  if (*f.idle_exit_us <= kDeepIdle_us) return good("idle states", found);
  if (f.may_forbid_idle) return good("idle states", found + "; held off while a run in real time lasts");
  return {
      "idle states", Verdict::kCosts, found, "that long on top of every wake-up",
      "grant writing /dev/cpu_dma_latency, cpupower idle-set -D " + std::to_string(kDeepIdle_us) + ", or timing.spin"};
}

std::string print_fixed(double value, int digits) {
  std::array<char, 32> text{};
  const auto end = std::to_chars(text.data(), text.data() + text.size(), value, std::chars_format::fixed, digits).ptr;
  return {text.data(), end};
}

// A virtual machine does not know of the other hardware thread of its core, but is slowed down by it.
Check judge_smt(const MachineFacts& f) {
  if (!f.smt && !f.core_stretch) return {"hyper-threading", Verdict::kUnknown, "not to be found out", "", ""};
  std::string found = f.smt ? *f.smt ? "on" : "off" : "unknown";
  if (f.core_stretch)
    found += "; work that fills a core takes up to " + print_fixed(*f.core_stretch, 2) + " times its least";
  const bool shared = f.core_stretch.value_or(1) >= kAlone;
  if (!f.smt.value_or(false) && !shared) return good("hyper-threading", found);
  return {"hyper-threading", Verdict::kCosts, found,
          shared ? "somebody is at work on the other hardware thread of this core: a step takes up to twice as long"
                 : "work on the sibling makes a step up to twice as long",
          f.virtual_machine ? "virtual CPUs pinned to cores of their own"
                            : "leave the sibling of the cyclic thread's CPU idle, or nosmt on the command line"};
}

Check judge_interruptions(const MachineFacts& f) {
  if (!f.interruptions_per_s) return {"interruptions", Verdict::kUnknown, "not tried", "", ""};
  const std::string found = print_fixed(*f.interruptions_per_s, 0) + " a second of more than " +
                            std::to_string(kInterruption_ns / 1000) + " us, the longest " +
                            std::to_string(f.longest_interruption_ns.value_or(0) / 1000) + " us";
  if (*f.interruptions_per_s <= kFewInterruptions) return good("interruptions", found);
  return {"interruptions", Verdict::kCosts, found,
          "one falls into each step of 10 us with a chance of " + print_fixed(*f.interruptions_per_s * 1e-3, 2) + " %",
          "isolated CPUs; whose they are: rtla osnoise, hwlatdetect"};
}

Check judge_below_kernel(const MachineFacts& f) {
  const std::string stolen = f.stolen_ms ? ", " + std::to_string(*f.stolen_ms) + " ms stolen since boot" : "";
  if (f.virtual_machine) {
    return {"below the kernel", Verdict::kCosts, "a virtual machine" + stolen,
            "the host stops it when it likes, for milliseconds, and nothing in here can prevent or see that",
            "bare metal, or pinned virtual CPUs on an isolated host"};
  }
  if (!f.smi_count) {
    return {"below the kernel", Verdict::kUnknown, "system management interrupts cannot be counted here",
            "the firmware may stop all CPUs for some 100 us",
            "hwlatdetect --duration=60 (rt-tests), as root; turn off legacy USB and power management in the firmware"};
  }
  if (*f.smi_count == 0) return good("below the kernel", "no system management interrupts since boot");
  return {"below the kernel", Verdict::kCosts,
          std::to_string(*f.smi_count) + " system management interrupts since boot",
          "each stops all CPUs for some 100 us",
          "turn off legacy USB and power management in the firmware; hwlatdetect shows them"};
}

}  // namespace

std::vector<PreflightCheck> judge(const MachineFacts& facts) {
  return {judge_kernel(facts),        judge_governor(facts),    judge_isolation(facts), judge_timer(facts),
          judge_clock(facts),         judge_memlock(facts),     judge_priority(facts),  judge_throttling(facts),
          judge_huge_pages(facts),    judge_swap(facts),        judge_idle(facts),      judge_smt(facts),
          judge_interruptions(facts), judge_below_kernel(facts)};
}

}  // namespace unlatch::hil
