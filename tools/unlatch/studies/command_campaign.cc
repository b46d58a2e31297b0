// unlatch campaign: many samples of a scenario, their results and statistics.
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <thread>

#include "hil/study/campaign/samples/campaign_step.h"
#include "hil/study/campaign/samples/runner.h"
#include "tools/campaign/campaign_data.h"
#include "tools/campaign/page.h"
#include "tools/campaign/review.h"
#include "tools/campaign/summary.h"
#include "tools/campaign/summary_text.h"
#include "tools/common/output.h"
#include "tools/common/terminal.h"
#include "tools/common/text.h"
#include "tools/pages/pages.h"
#include "tools/program/exit_codes.h"
#include "tools/program/interrupt.h"
#include "tools/unlatch/options/campaign_sample.h"
#include "tools/unlatch/studies/campaign_flights.h"
#include "tools/unlatch/studies/campaign_host.h"
#include "tools/unlatch/studies/verbs.h"

namespace unlatch::tools {
namespace {

namespace fs = std::filesystem;

struct CampaignOptions {
  std::vector<std::string> arguments;  // FILE; merge DIR...; report DIR
  std::string out, samples, json;
  std::vector<std::string> overrides;
  int jobs = 0, flights = -1;  // below 0: not said
  bool resume = false;
};

// A:B, either may be left out.
std::pair<std::int64_t, std::int64_t> read_range(const std::string& text, std::int64_t count) {
  if (text.empty()) return {0, count};
  const std::size_t colon = text.find(':');
  const auto read = [&](const std::string& part, std::int64_t fallback) {
    if (part.empty()) return fallback;
    char* end = nullptr;
    const long long value = std::strtoll(part.c_str(), &end, 10);
    if (*end != 0 || value < 0)
      refuse_option("--samples", "'" + part + "' is no number of a sample: write A:B, from A to before B");
    if (value > count)
      refuse_option("--samples", text + " goes beyond the campaign, which has " + hil::count(count, "sample") +
                                     ": write 0:" + std::to_string(count) + " or a part of it");
    return static_cast<std::int64_t>(value);
  };
  if (colon == std::string::npos)
    refuse_option("--samples", "'" + text + "' is no range: write A:B, from A to before B");
  const auto first = read(text.substr(0, colon), 0), last = read(text.substr(colon + 1), count);
  if (first >= last) refuse_option("--samples", text + " has no samples");
  return {first, last};
}

std::string describe_seconds(double seconds) {
  if (seconds < 90) return format("%.0f s", seconds);
  return seconds < 5400 ? format("%.0f min", seconds / 60) : format("%.1f h", seconds / 3600);
}

// Rate and time left: on a terminal one line that is overwritten, elsewhere a line a minute.
class CampaignProgress {
 public:
  // `ends_early`: there may be fewer.
  CampaignProgress(std::int64_t done, std::int64_t total, bool ends_early)
      : total_(total),
        ends_early_(ends_early),
        first_(done),
        done_(done),
        terminal_(is_terminal(stderr)),
        begin_(Clock::now()),
        shown_(begin_) {}

  void add_one() {
    ++done_;
    const auto now = Clock::now();
    const double wait = terminal_ ? 0.2 : 60;  // s
    if (std::chrono::duration<double>(now - shown_).count() < wait) return;
    shown_ = now;
    const double rate = calc_rate();
    std::fprintf(stderr, "%s%lld of %s%s, %.1f a second, %s left%s", terminal_ ? "\r\033[K" : "",
                 static_cast<long long>(done_), ends_early_ ? "at most " : "", count(total_, "sample").c_str(), rate,
                 describe_seconds(static_cast<double>(total_ - done_) / rate).c_str(), terminal_ ? "" : "\n");
    std::fflush(stderr);
  }
  void clear() const {
    if (terminal_) std::fputs("\r\033[K", stderr);
  }
  [[nodiscard]] bool is_complete() const { return done_ == total_; }
  [[nodiscard]] double calc_rate() const {  // samples a second
    const double seconds = std::chrono::duration<double>(Clock::now() - begin_).count();
    return seconds > 0 ? static_cast<double>(done_ - first_) / seconds : 0;
  }

 private:
  using Clock = std::chrono::steady_clock;
  const std::int64_t total_;
  const bool ends_early_;
  const std::int64_t first_;
  std::int64_t done_;
  const bool terminal_;
  const Clock::time_point begin_;
  Clock::time_point shown_;
};

// Tables, summary, and what is printed. `interrupted`: without the Parquet table, whose writer needs a second to start.
Json finish(const std::string& folder, double rate, const std::string& json, bool interrupted) {
  const CampaignData data = read_campaign(folder);
  Json summary = build_summary(data);
  if (rate > 0) summary["samples_per_second"] = rate;
  write_csv(data, (fs::path(folder) / "samples.csv").string());
  const fs::path parquet = fs::path(folder) / "samples.parquet";
  std::error_code none;
  if (interrupted)
    fs::remove(parquet, none);  // of fewer samples
  else
    write_parquet(data, parquet.string());
  write_text(summary.dump(1, ' ', false, Json::error_handler_t::replace) + "\n",
             (fs::path(folder) / "summary.json").string());
  write_text(write_requirements_csv(summary), (fs::path(folder) / "requirements.csv").string());
  write_text(write_review(summary), (fs::path(folder) / "review.md").string());
  print_summary(get_people_stream(json), summary);
  write_json(summary, json);
  return summary;
}

// Exit code 1: a sample faulted or failed a requirement; of subset sampling, which looks for such samples, their
// probability may be above what is allowed.
int judge(const Json& summary) {
  if (summary.contains("rare"))
    return summary.at("rare").at("met").get<bool>() && summary.at("unresolved").empty() ? kExitDone : kExitFailed;
  bool sound = summary.at("statuses").at("done") == summary.at("samples");
  for (const Json& requirement : summary.at("requirements")) sound = sound && requirement.at("failed") == 0;
  return sound ? kExitDone : kExitFailed;
}

hil::ResultFile open_results(const CampaignOptions& options, const hil::ResultShape& shape, const Json& manifest) {
  const std::string path = get_results_path(options.out);
  constexpr std::uintmax_t kHeader = 32;  // bytes; killed before they were written, there is nothing yet
  const bool begun = fs::exists(path) && (!options.resume || fs::file_size(path) >= kHeader);
  if (begun && options.resume) {
    hil::ResultFile file = hil::ResultFile::open(path, true);
    if (!(file.shape() == shape))
      refuse_option("--resume", path + " is of another campaign, scenario or version; choose another folder");
    return file;
  }
  if (begun) refuse_option("--out", options.out + " has results; --resume continues them, or choose another folder");
  std::error_code error;
  fs::create_directories(options.out, error);
  if (error) throw OutputError(options.out + ": it cannot be made: " + error.message());
  write_text(manifest.dump(1), get_manifest_path(options.out));
  return hil::ResultFile::create(path, shape);
}

// Runs the task's samples in this process, on threads.
void run_here(const CampaignTask& task, hil::ResultFile& results, const std::function<void()>& finished) {
  run_samples(task.campaign, task.evaluator, task.first, task.last, task.jobs, results, task.stop, finished);
}

int run(const CampaignOptions& options, const CampaignHost& host) {
  hil::Campaign campaign = hil::load_campaign(options.arguments[0], options.overrides);
  for (const std::string& remark : campaign.remarks) std::fprintf(stderr, "note: %s\n", remark.c_str());
  const std::atomic<bool>& stop = host.catch_signals();
  if (!find_campaign_step(campaign, options.jobs, stop)) return kExitFailed;
  const hil::SampleEvaluator evaluator(*campaign.tree, campaign.chosen);
  if (campaign.failure && !options.samples.empty())
    refuse_option("--samples", "the levels of subset sampling follow from one another: run all, with --jobs or mpirun");
  const auto [first, last] = read_range(options.samples, campaign.plan.samples);
  const CampaignTask task{campaign, evaluator, first, last, options.jobs, stop};
  if (!host.run) {
    host.evaluate(task);
    return kExitDone;
  }
  std::optional<hil::ResultFile> results =
      open_results(options, get_shape(campaign, evaluator), build_manifest(campaign, evaluator, options.overrides));
  std::int64_t done = 0;
  for (const std::int64_t sample : results->samples()) done += sample >= first && sample < last ? 1 : 0;
  if (done > 0) std::fprintf(stderr, "%s already there\n", count(static_cast<std::size_t>(done), "sample").c_str());
  CampaignProgress progress(done, last - first, campaign.failure.has_value());
  host.run(task, *results, [&] { progress.add_one(); });
  results.reset();  // the tables read the folder anew
  progress.clear();
  const Json summary = finish(options.out, progress.calc_rate(), options.json, task.stop);
  const bool complete = campaign.failure ? summary.at("rare").at("finished").get<bool>() : progress.is_complete();
  if (!complete) std::fprintf(stderr, "interrupted; --resume continues, and writes samples.parquet at its end\n");
  return complete ? judge(summary) : kExitFailed;
}

int merge(const CampaignOptions& options) {
  const std::vector<std::string> folders(options.arguments.begin() + 1, options.arguments.end());
  if (folders.empty()) refuse_option("merge", "which folders? unlatch campaign merge DIR... --out DIR");
  if (fs::exists(get_results_path(options.out)))
    refuse_option("--out", options.out + " has results; choose another folder");
  merge_campaigns(folders, options.out);
  const Json summary = finish(options.out, 0, options.json, false);
  const bool complete = summary.contains("rare") ? summary.at("rare").at("finished").get<bool>()
                                                 : summary.at("samples") == summary.at("planned");
  if (complete) return judge(summary);
  std::fprintf(stderr, "incomplete: %lld of %s; run the missing ones with --resume, and merge again\n",
               summary.at("samples").get<long long>(), count(summary.at("planned").get<long long>(), "sample").c_str());
  return kExitFailed;
}

// Pages of the worst samples' flights. Without --flights a failure is a note, and the page does without them.
Json fly_worst(const CampaignOptions& options, const CampaignData& data, std::vector<std::int64_t> worst) {
  constexpr std::size_t kFlights = 10;
  const bool asked = options.flights >= 0;
  worst.resize(std::min(worst.size(), asked ? static_cast<std::size_t>(options.flights) : kFlights));
  if (worst.empty()) return Json::object();
  try {
    return fly_samples(data, options.arguments[1], worst, options.out);
  } catch (const std::runtime_error& error) {  // of the results, the campaign's file, or a flight
    if (asked) throw;
    std::fprintf(stderr, "note: no pages of the worst flights: %s\n", error.what());
    return Json::object();
  }
}

int report(const CampaignOptions& options) {
  if (options.arguments.size() != 2) refuse_option("report", "one folder: unlatch campaign report DIR --out page.html");
  if (!has_pages()) {
    std::fprintf(stderr, "unlatch campaign report: %s\n", kNoPages);
    return kExitEnvironment;
  }
  check_output(options.out);
  const CampaignData data = read_campaign(options.arguments[1]);
  const Json summary = build_summary(data);
  const std::string page =
      build_campaign_page(data, summary, options.arguments[1], fly_worst(options, data, summary.at("worst")));
  write_text(page, options.out);
  std::fprintf(stderr, "%s: %.1f MB\n", options.out.c_str(), static_cast<double>(page.size()) * 1e-6);
  return kExitDone;
}

int dispatch(const CampaignOptions& options, const CampaignHost& host) {
  try {
    if (options.arguments.size() > 1) refuse_option(options.arguments[1], "one campaign file at a time");
    return run(options, host);
  } catch (const hil::ResultError& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return kExitEnvironment;
  }
}

int dispatch_alone(const CampaignOptions& options) {
  try {
    if (options.arguments[0] == "merge") return merge(options);
    if (options.arguments[0] == "report") return report(options);
  } catch (const hil::ResultError& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return kExitEnvironment;
  }
  return dispatch(options, {catch_interrupts, run_here, {}});
}

constexpr const char* kSummary =
    "Runs many samples of a scenario with dispersed values: results, probabilities of failure, sensitivities. ";
constexpr const char* kPromise =
    "The same table to the last bit for any number of jobs, in any order, resumed or not, on one machine or several. "
    "Exit code 1: a sample faulted, failed a requirement or is unresolved; with `sampling: subset` instead: the upper "
    "end "
    "of the interval of the probability is above `at_most`, or there is no estimate.";

// Options that do not depend on the program.
void add_options(Command command, CampaignOptions& options) {
  command.add_option("--samples", options.samples, "only these, from A to before B, counted from 0").type_name("A:B");
  command.add_flag("--resume", options.resume, "continues what the folder has");
  command
      .add_option("--set", options.overrides,
                  "replaces one value of the scenario for all samples, after the campaign's own `set`; repeatable")
      .type_name("PATH=VALUE")
      .repeatable();
  command.add_json_option(options.json);
}

}  // namespace

void add_campaign(Command app, int& exit_code) {
  auto options = std::make_shared<CampaignOptions>();
  options->jobs = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  Command command = app.add_verb(
      "campaign",
      kSummary +
          std::string("`merge DIR...` puts folders of one campaign together; `report DIR` writes one HTML page. ") +
          kPromise +
          " On several machines: `mpirun unlatch-mpi campaign`, or --samples A:B on each of them, and merge; scripts "
          "for "
          "Slurm and GNU parallel are in hil/scenarios/cluster.",
      "unlatch campaign hil/scenarios/boosters/campaign.yaml --out boosters\n"
      "unlatch campaign report boosters --out boosters.html\n"
      "unlatch run hil/scenarios/boosters/campaign.yaml --sample 17 --log worst.log");
  command.add_option("FILE", options->arguments, "campaign file (.yaml); or merge and folders; or report and a folder")
      .required()
      .expected(1, 10000);
  command.add_option("--out", options->out, "folder of the results; of report: the page (.html)")
      .required()
      .type_name("DIR");
  command.add_option("--jobs", options->jobs, "threads (default: as many as the machine has)")
      .within(1, 1024)
      .type_name("N");
  command
      .add_option("--flights", options->flights,
                  "of report: flies so many of the worst samples again and writes a page of each beside this one, with "
                  "the bodies in motion; 0: none (default: 10)")
      .within(0, 10)
      .type_name("N");
  add_options(command, *options);
  command.callback([options, &exit_code] { exit_code = dispatch_alone(*options); });
}

void add_hosted_campaign(Command app, int& exit_code, const CampaignHost& host) {
  auto options = std::make_shared<CampaignOptions>();
  options->jobs = 1;
  Command command =
      app.add_verb("campaign",
                   kSummary +
                       std::string("Rank 0 hands out the samples and writes; every rank runs "
                                   "some, slow ones fewer. All of them must be able to read the files. ") +
                       kPromise,
                   "mpirun -n 64 unlatch-mpi campaign hil/scenarios/boosters/campaign.yaml --out boosters\n"
                   "mpirun -n 4 --map-by node:PE=16 unlatch-mpi campaign hil/scenarios/boosters/campaign.yaml "
                   "--jobs 16 --out boosters --resume\n"
                   "unlatch campaign report boosters --out boosters.html");
  command.add_option("FILE", options->arguments, "campaign file (.yaml)").required().expected(1, 10000);
  command.add_option("--out", options->out, "folder of the results, written by rank 0").required().type_name("DIR");
  command.add_option("--jobs", options->jobs, "threads of each rank").within(1, 1024).type_name("N").default_shown();
  add_options(command, *options);
  command.callback([options, host, &exit_code] {
    const std::string& verb = options->arguments[0];
    if (verb == "merge" || verb == "report") refuse_option(verb, "it needs no ranks: unlatch campaign " + verb);
    exit_code = dispatch(*options, host);
  });
}

}  // namespace unlatch::tools
