#include "tools/unlatch/studies/campaign_flights.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

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

// Options --set of the campaign's run: the overrides beyond those of its own file.
std::vector<std::string> list_options(const CampaignData& data) {
  const std::string file = data.manifest.at("campaign_file");
  const std::vector<std::string> all = data.manifest.at("overrides");
  const hil::Campaign campaign = hil::load_campaign(file);
  const std::size_t own = campaign.tree->get_nominal().overrides.size();
  if (campaign.text != data.manifest.at("campaign_text").get<std::string>() || own > all.size())
    throw hil::ResultError(file + " is not the campaign file of these results any more; its samples cannot be flown");
  std::vector<std::string> options;
  for (std::size_t i = own; i < all.size(); ++i) options.insert(options.end(), {"--set", all[i]});
  return options;
}

}  // namespace

Json fly_samples(const CampaignData& data, const std::string& folder, const std::vector<std::int64_t>& samples,
                 const std::string& page) {
  const std::vector<std::string> options = list_options(data);
  Json pages = Json::object();
  for (const std::int64_t sample : samples) {
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
