// Commands that mend what preflight finds.
#include <algorithm>
#include <vector>

#include "hil/session/realtime/preflight.h"

namespace unlatch::hil {
namespace {

using Lines = std::vector<std::string>;

// CPUs from 0 on without one of them: "0-2", "0,2-3".
std::string list_others(int cpus, int without) {
  const auto range = [](int first, int last) {
    return first == last ? std::to_string(first) : std::to_string(first) + "-" + std::to_string(last);
  };
  std::string text;
  if (without > 0) text = range(0, without - 1);
  if (without + 1 < cpus) text += (text.empty() ? "" : ",") + range(without + 1, cpus - 1);
  return text;
}

// Lines of a file that the script writes.
Lines write_file(const std::string& name, const Lines& content) {
  Lines lines{"cat > " + name + " <<'END'"};
  lines.insert(lines.end(), content.begin(), content.end());
  lines.push_back("END");
  return lines;
}

// Until the next boot.
Lines fix_now(const PreflightCheck& check) {
  const std::string& name = check.name;
  if (check.verdict == PreflightCheck::Verdict::kUnknown) return {};
  if (name == "governor") return {"cpupower frequency-set -g performance"};
  if (name == "real-time throttling") return {"echo -1 > /proc/sys/kernel/sched_rt_runtime_us"};
  if (name == "transparent huge pages") return {"echo madvise > /sys/kernel/mm/transparent_hugepage/enabled"};
  if (name == "swap") return {"swapoff -a"};
  if (name == "idle states") return {"cpupower idle-set -D 10"};
  return {};
}

// Words of the kernel's command line.
std::string fix_at_boot(const std::string& name, const MachineFacts& facts, int cpu) {
  if (name == "isolated CPUs" && facts.cpus > 1) {
    const std::string own = std::to_string(cpu);
    return "isolcpus=managed_irq,domain," + own + " nohz_full=" + own + " rcu_nocbs=" + own +
           " irqaffinity=" + list_others(facts.cpus, cpu);
  }
  if (name == "clock source") return "tsc=reliable clocksource=tsc";
  if (name == "hyper-threading" && !facts.virtual_machine) return "nosmt";
  return "";
}

class Script {
 public:
  Script(const MachineFacts& facts, int cpu) : facts_(facts), cpu_(cpu < 0 ? std::max(facts.cpus - 1, 0) : cpu) {
    for (const PreflightCheck& check : judge(facts))
      if (check.verdict != PreflightCheck::Verdict::kGood && !check.mend.empty()) checks_.push_back(check);
  }

  std::string print() {
    add({"#!/bin/sh", "# Mends what `unlatch preflight` has found on this machine. Read it, then run it as root.",
         "set -eu"});
    add_now();
    add_limits();
    add_boot();
    add_rest();
    if (checks_.empty()) add({"# There is nothing to mend."});
    return text_;
  }

 private:
  void add(const Lines& lines) {
    for (const std::string& line : lines) text_ += line + "\n";
  }
  void add_heading(const std::string& text) { add({"", "# --- " + text}); }
  void add_finding(const PreflightCheck& check) {
    add({"# " + check.name + ": " + check.found});
    is_mended_.push_back(check.name);
  }

  void add_now() {
    bool first = true;
    for (const PreflightCheck& check : checks_) {
      const Lines lines = fix_now(check);
      if (lines.empty()) continue;
      if (first) add_heading("At once, until the next boot");
      first = false;
      add_finding(check);
      add(lines);
    }
  }

  void add_limits() {
    Lines limits;
    for (const PreflightCheck& check : checks_) {
      const bool memory = check.name == "locked memory";
      if (!memory && check.name != "real-time priority") continue;
      if (limits.empty()) add_heading("For the group unlatch-bench, at its next login: adduser USER unlatch-bench");
      add_finding(check);
      limits.push_back(memory ? "@unlatch-bench - memlock unlimited" : "@unlatch-bench - rtprio 99");
    }
    if (limits.empty()) return;
    add({"groupadd --force unlatch-bench"});
    add(write_file("/etc/security/limits.d/unlatch.conf", limits));
  }

  void add_boot() {
    std::string words;
    for (const PreflightCheck& check : checks_) {
      const std::string own = fix_at_boot(check.name, facts_, cpu_);
      if (check.name != "kernel" && own.empty()) continue;
      if (!has_boot_) add_heading("At the next boot (Debian)");
      has_boot_ = true;
      add_finding(check);
      if (check.name == "kernel") add({"apt-get install --yes linux-image-rt-amd64"});
      words += own.empty() ? "" : " " + own;
    }
    if (words.empty()) return;
    add({"mkdir -p /etc/default/grub.d"});
    add(write_file("/etc/default/grub.d/unlatch.cfg",
                   {"GRUB_CMDLINE_LINUX_DEFAULT=\"$GRUB_CMDLINE_LINUX_DEFAULT" + words + "\""}));
    add({"update-grub"});
    if (words.find("isolcpus") != std::string::npos)
      add({"# Then: unlatch hil SCENARIO --pace realtime --cpu " + std::to_string(cpu_)});
  }

  // What no command mends.
  void add_rest() {
    bool first = true;
    for (const PreflightCheck& check : checks_) {
      if (std::find(is_mended_.begin(), is_mended_.end(), check.name) != is_mended_.end()) continue;
      if (first) add_heading("By hand");
      first = false;
      add({"# " + check.name + ": " + check.found, "#   " + check.mend});
    }
  }

  const MachineFacts& facts_;
  const int cpu_;
  std::vector<PreflightCheck> checks_;
  Lines is_mended_;
  bool has_boot_ = false;
  std::string text_;
};

}  // namespace

std::string print_fixes(const MachineFacts& facts, int cpu) { return Script(facts, cpu).print(); }

}  // namespace unlatch::hil
