#include "tools/unlatch/studies/campaign_flights.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <filesystem>

#include "tools/program/exit_codes.h"

namespace unlatch::tools {
namespace {

namespace fs = std::filesystem;

// This program with other arguments, without its standard output; its exit code.
int call(const std::vector<std::string>& arguments) {
  std::vector<const char*> pointers{"unlatch"};
  for (const std::string& argument : arguments) pointers.push_back(argument.c_str());
  pointers.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
  pid_t process = -1;
  const int failed =
      posix_spawn(&process, "/proc/self/exe", &actions, nullptr, const_cast<char**>(pointers.data()), environ);
  posix_spawn_file_actions_destroy(&actions);
  if (failed != 0) return kExitEnvironment;
  int status = 0;
  while (waitpid(process, &status, 0) < 0 && errno == EINTR) {
  }
  return WIFEXITED(status) ? WEXITSTATUS(status) : kExitFailed;
}

// Options --set of the campaign's run.
std::vector<std::string> list_options(const CampaignData& data) {
  std::vector<std::string> options;
  for (const Json& text : data.manifest.at("set")) options.insert(options.end(), {"--set", text.get<std::string>()});
  const std::string file = data.manifest.at("campaign_file");
  if (hil::load_campaign(file).text != data.manifest.at("campaign_text").get<std::string>())
    throw hil::ResultError(file + " is not the campaign file of these results any more; its samples cannot be flown");
  return options;
}

bool is_valid(const CampaignData& data, std::int64_t sample) {
  const std::size_t row = data.table->find(sample);
  return row < data.rows && data.table->get_sample(row) == sample &&
         data.table->get_status(row) != hil::SampleStatus::kInvalid;
}

}  // namespace

Json fly_samples(const CampaignData& data, const std::string& folder, const std::vector<std::int64_t>& samples,
                 const std::string& page) {
  const std::vector<std::string> options = list_options(data);
  Json pages = Json::object();
  for (const std::int64_t sample : samples) {
    if (!is_valid(data, sample)) continue;  // nothing to see
    const std::string number = std::to_string(sample);
    fs::path target = page;
    target.replace_filename(target.stem().string() + "-" + number + ".html");
    const std::string log = target.string() + ".log";
    std::vector<std::string> run{
        "run", data.manifest.at("campaign_file"), "--sample", number, "--results", folder, "--log", log};
    run.insert(run.end(), options.begin(), options.end());
    const int flown = call(run);  // 1: it does not meet a requirement, as is to be seen
    const bool done =
        flown <= kExitFailed && call({"report", log, "--out", target.string()}) <= kExitFailed && fs::exists(target);
    std::error_code ignored;
    fs::remove(log, ignored);
    if (!done) throw hil::ResultError("sample " + number + " could not be flown again");
    pages[number] = target.filename().string();
  }
  return pages;
}

}  // namespace unlatch::tools
