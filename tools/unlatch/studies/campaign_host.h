// `unlatch campaign` in a program of several processes: one of them writes, the others run samples for it. All of them
// have the same command line and read the same files.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>

#include "hil/study/campaign/samples/result_file.h"
#include "tools/program/command_line.h"

namespace unlatch::tools {

struct CampaignTask {
  const hil::Campaign& campaign;
  const hil::SampleEvaluator& evaluator;
  std::int64_t first = 0, last = 0;  // samples, to before the last
  int jobs = 1;                      // threads of this process
  const std::atomic<bool>& stop;     // a signal may set it
};

struct CampaignHost {
  const std::atomic<bool>& (*catch_signals)() = nullptr;  // called before the samples; for the task's `stop`
  // The process that writes runs those samples of the task that the results lack; `finished` is called after each.
  std::function<void(const CampaignTask&, hil::ResultFile&, const std::function<void()>& finished)> run;
  // The other processes, in which `run` is empty, only evaluate samples and write nothing.
  std::function<void(const CampaignTask&)> evaluate;
};

// The verb `campaign` of such a program, without `merge` and `report`.
void add_hosted_campaign(Command app, int& exit_code, const CampaignHost& host);

}  // namespace unlatch::tools
