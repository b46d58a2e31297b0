#include "tools/unlatch/options/pacing_options.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstring>

namespace unlatch::tools {
namespace {

constexpr std::int64_t kPatience_ns = 5'000'000'000;
constexpr std::string_view kDescriptor = "fd:";

int open_descriptor(const std::string& source) {
  const auto refuse = [&source](const std::string& why) -> int {
    refuse_option("--tick-source", "'" + source + "' " + why);
  };
  if (!source.starts_with(kDescriptor)) {
    const int descriptor = open(source.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    return descriptor >= 0 ? descriptor : refuse(std::string("cannot be opened: ") + std::strerror(errno));
  }
  int descriptor = -1;
  const char* const end = source.data() + source.size();
  const auto result = std::from_chars(source.data() + kDescriptor.size(), end, descriptor);
  if (result.ec != std::errc{} || result.ptr != end || fcntl(descriptor, F_GETFD) < 0) {
    return refuse("is no open descriptor: pass one on, as in fd:3");
  }
  return descriptor;
}

}  // namespace

std::string check_cpu(const std::string& text) {
  int cpu = -1;
  const char* const end = text.data() + text.size();
  const auto result = std::from_chars(text.data(), end, cpu);
  const long count = sysconf(_SC_NPROCESSORS_CONF);
  const std::string known = "this machine has CPUs 0 to " + std::to_string(count - 1);
  if (result.ec == std::errc::result_out_of_range) return "CPU " + text + " does not exist; " + known;
  if (result.ec != std::errc{} || result.ptr != end || cpu < 0)
    return "'" + text + "' is not the number of a CPU; " + known;
  return cpu < count ? "" : "CPU " + text + " does not exist; " + known;
}

void PacingOptions::add_overrides(std::vector<std::string>& overrides) const {
  if (!overruns.empty()) {
    const std::size_t equals = overruns.find('=');
    overrides.push_back(equals == std::string::npos ? "timing.overruns=" + overruns
                                                    : "timing.overruns={" + overruns.substr(0, equals) + ": " +
                                                          overruns.substr(equals + 1) + "}");
  }
  if (spin_us >= 0) overrides.push_back("timing.spin=" + std::to_string(spin_us) + " us");
  if (tick_times) overrides.push_back("timing.per_tick=true");
}

std::unique_ptr<hil::TickSource> PacingOptions::open_source(std::int64_t period_ns) const {
  if (source.empty()) return nullptr;
  return std::make_unique<hil::DescriptorTicks>(open_descriptor(source), period_ns, get_patience_ns());
}

std::int64_t PacingOptions::get_patience_ns() const { return source.empty() ? 0 : kPatience_ns; }

void add_pacing_options(Command command, PacingOptions& options) {
  const std::string group = "Real time";
  command
      .add_option("--overruns", options.overruns,
                  "reaction to a late tick: fail, slip, skip_output, catch_up or catch_up=TICKS")
      .type_name("POLICY")
      .group(group);
  command.add_option("--spin-us", options.spin_us, "time of busy waiting before each deadline, us")
      .type_name("MICROSECONDS")
      .within(0.0, 10000.0)
      .group(group);
  command
      .add_option("--tick-source", options.source,
                  "tick source in place of the clock: fd:N (timerfd, eventfd, pipe), or a FIFO or device FILE")
      .type_name("SOURCE")
      .group(group);
  command.add_option("--cpu", options.thread.cpu, "CPU of the cyclic thread")
      .type_name("NUMBER")
      .check(check_cpu)
      .group(group);
  command.add_option("--priority", options.thread.priority, "priority of the cyclic thread, SCHED_FIFO")
      .type_name("NUMBER")
      .within(1, 98)
      .default_shown()
      .group(group);
  command.add_flag("--tick-times", options.tick_times, "records the times of the parts of each tick").group(group);
}

}  // namespace unlatch::tools
