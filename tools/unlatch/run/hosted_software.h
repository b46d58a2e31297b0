// Flight software in the simulator's own process, each in a thread: controller FMUs, and for the required participants
// that have none the reference flight software.
#pragma once

#include <atomic>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "bridge/core/port.h"
#include "hil/scenario/scenario.h"
#include "tools/fsw/participant.h"

namespace unlatch::tools {

class HostedSoftware {
 public:
  // `fmus`: FILE, or NAME=FILE where several participants are required. An FMU that cannot be used, or that does not
  // fit the scenario, is a mistake of the option --fmu. `maps`: VARIABLE=NAME, or a file with such a line each; of one
  // of several FMUs PARTICIPANT:VARIABLE=NAME. Mistakes in them are those of the option --map.
  HostedSoftware(const std::vector<std::string>& fmus, const std::vector<std::string>& maps,
                 const hil::Scenario& scenario);
  ~HostedSoftware();
  HostedSoftware(const HostedSoftware&) = delete;
  HostedSoftware& operator=(const HostedSoftware&) = delete;

  void start(bridge::InprocHub& hub);
  void stop();
  // The first one that failed, and why; empty: none has. From any thread.
  [[nodiscard]] std::string get_failure() const;

 private:
  struct Member {
    std::string name;
    std::unique_ptr<fsw::ControlLaw> law;
    std::unique_ptr<bridge::Port> port;
    std::jthread thread;
  };
  void run(Member& member);

  static constexpr double kPatience_s = 60;
  std::vector<Member> members_;
  std::atomic<bool> stop_{false};
  mutable std::mutex mutex_;  // of `failure_`
  std::string failure_;
};

}  // namespace unlatch::tools
