// golden_campaigns [--lanes NAME] FILE...: prints the hash of each campaign's first samples, inputs and results
// included, as `unlatch campaign --samples 0:8` prints it. The name in the output is the file's folder and stem:
// boosters/campaign.
#include <algorithm>
#include <atomic>
#include <exception>
#include <filesystem>
#include <vector>

#include "hil/study/campaign/samples/result_file.h"
#include "tests/golden/golden_run.h"

namespace {

using namespace unlatch;

constexpr std::int64_t kSamples = hil::SampleEvaluator::kSideBySide;  // all lanes of a bundle are filled

void print_campaign_hash(const char* name, const std::string& file, InstructionSet set) {
  const hil::Campaign campaign = hil::load_campaign(file);
  const hil::SampleEvaluator evaluator(*campaign.tree, campaign.chosen);
  const std::int64_t count = std::min(kSamples, campaign.plan.samples);
  std::vector<hil::SampleTask> tasks;
  std::vector<hil::SampleRecord> records;
  for (std::int64_t i = 0; i < count; ++i) {
    records.push_back({i, draw_inputs(campaign, i), {}});
    tasks.push_back({make_settings(campaign, records.back().inputs), {}});
    tasks.back().run.instruction_set = set;
  }
  const std::atomic<bool> never{false};
  const std::vector<hil::SampleResult> results = evaluator.evaluate(tasks, never);
  std::uint64_t hash = 0;
  for (std::size_t i = 0; i < records.size(); ++i) {
    records[i].result = results[i];
    hash = hil::add_to_hash(hash, hil::calc_hash(records[i]));
  }
  std::printf("%s 0:%" PRId64 " %016" PRIx64 "\n", name, count, hash);
}

}  // namespace

int main(int argc, char** argv) {
  int first = 0;
  const InstructionSet set = test::read_instruction_set(argc, argv, first);
  bool all = true;
  for (int i = first; i < argc; ++i) {
    const std::filesystem::path file = argv[i];
    const std::string name = (file.parent_path().filename() / file.stem()).string();
    try {
      print_campaign_hash(name.c_str(), file.string(), set);
    } catch (const std::exception& error) {
      std::fprintf(stderr, "%s: %s\n", name.c_str(), error.what());
      all = false;
    }
  }
  return all ? 0 : 1;
}
