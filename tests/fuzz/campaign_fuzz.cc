// Campaigns and optimisation problems, over a small scenario. Of an accepted one three samples are drawn, and one of
// them makes a scenario that is stepped.
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>

#include "hil/study/campaign/campaign.h"
#include "hil/study/optimize/problem/problem.h"
#include "tests/fuzz/fuzz.h"

using namespace unlatch;

namespace {

// Folder with small.yaml and samples.csv, which inputs name; removed at the end.
class Folder {
 public:
  Folder() {
    std::filesystem::create_directories(path_);
    std::ofstream(path_ / "small.yaml") << fuzz::kSmallScenario;
    std::ofstream(path_ / "samples.csv") << "mass,push\n100,5000\n101,4900\n";
  }
  ~Folder() { std::filesystem::remove_all(path_); }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  [[nodiscard]] std::string get_path() const { return path_.string(); }

 private:
  const std::filesystem::path path_ =
      std::filesystem::temp_directory_path() / ("unlatch-fuzz-" + std::to_string(getpid()));
};

// Returns true if the text names a file outside the folder: a device might block.
bool names_another_file(const std::string& text) {
  for (const char* beginning : {" /", "\t/", "\n/", "\"/", "'/", "[/", "{/", ",/", ":/", ".."})
    if (text.find(beginning) != std::string::npos) return true;
  return false;
}

void fly_a_little(const hil::Campaign& campaign, const std::vector<double>& inputs) {
  try {
    const auto simulation = hil::build_simulation(campaign.tree->read(hil::make_settings(campaign, inputs)));
    fuzz::step_a_little(*simulation);
  } catch (const hil::ScenarioError& error) {
    fuzz::require(!error.mistakes.empty(), "a refusal without a mistake");
  }
}

// Outputs of the first steps: a number for each column.
void observe_a_little(const hil::Campaign& campaign, const std::vector<double>& inputs) {
  if (campaign.chosen.is_empty()) return;
  fuzz::require(campaign.chosen.count() <= hil::kMostChosen, "more columns than a table may have");
  try {
    const hil::Scenario scenario = campaign.tree->read(hil::make_settings(campaign, inputs));
    const auto simulation = hil::build_simulation(scenario);
    hil::OutputTracker tracker(campaign.chosen, scenario, *simulation);
    tracker.look();
    for (int i = 0; i < 3 && simulation->step().status == StepStatus::kOk; ++i) tracker.look();
    fuzz::require(tracker.finish(true).size() == list_columns(campaign.chosen).size(), "another number of columns");
  } catch (const hil::ScenarioError& error) {
    fuzz::require(!error.mistakes.empty(), "a refusal without a mistake");
  }
}

void draw_some(const hil::Campaign& campaign) {
  const std::int64_t count = campaign.failure ? campaign.failure->samples : campaign.plan.samples;
  for (const std::int64_t sample : {std::int64_t{0}, count / 2, count - 1}) {
    const std::vector<double> inputs = hil::draw_inputs(campaign, sample);
    fuzz::require(inputs.size() == hil::list_inputs(campaign).size(), "a sample with another number of inputs");
    fuzz::require(std::all_of(inputs.begin(), inputs.end(), [](double x) { return std::isfinite(x); }),
                  "an input that is not finite");
    fuzz::require(inputs == hil::draw_inputs(campaign, sample), "a sample that is another one the second time");
    if (sample == count / 2) {
      fly_a_little(campaign, inputs);
      observe_a_little(campaign, inputs);
    }
  }
}

}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const Folder folder;
  const std::string text = fuzz::to_text(data, size);
  if (names_another_file(text)) return 0;
  try {
    if (text.find("unlatch_optimize") != std::string::npos) {
      const hil::OptimizeProblem problem = hil::load_optimize_problem_text(text, "fuzz.yaml", folder.get_path());
      fuzz::require(!problem.variables.empty() && !problem.objectives.empty(), "a problem with nothing to search");
    } else {
      draw_some(hil::load_campaign_text(text, "fuzz.yaml", folder.get_path()));
    }
  } catch (const hil::ScenarioError& error) {
    fuzz::require(!error.mistakes.empty(), "a refusal without a mistake");
  }
  return 0;
}
