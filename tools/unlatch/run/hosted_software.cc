#include "tools/unlatch/run/hosted_software.h"

#include <algorithm>
#include <sstream>

#include "hil/run/simulation/model_messages.h"
#include "hil/scenario/base/module.h"
#include "hil/scenario/language/scenario_sources.h"
#include "tools/fmu/controller.h"
#include "tools/fsw/separation_sequence.h"
#include "tools/program/command_line.h"

namespace unlatch::tools {
namespace {

std::unique_ptr<fsw::ControlLaw> open_fmu(const std::string& path, const fmu::NameMap& names) {
  using Open = fsw::ControlLaw*(const char*, const fmu::NameMap&);
  return std::unique_ptr<fsw::ControlLaw>(
      hil::find_function<Open>("unlatch-controller", "unlatch_open_controller")(path.c_str(), names));
}

std::string trim(const std::string& text) {
  const std::size_t begin = text.find_first_not_of(" \t\r"), end = text.find_last_not_of(" \t\r");
  return begin == std::string::npos ? "" : text.substr(begin, end - begin + 1);
}

// VARIABLE=NAME; `where`: for messages.
void read_mapping(const std::string& line, const std::string& where, fmu::NameMap& names) {
  const std::size_t mark = line.find('=');
  const std::string variable = trim(line.substr(0, mark)),
                    name = mark == std::string::npos ? "" : trim(line.substr(mark + 1));
  if (variable.empty() || name.empty())
    refuse_option("--map", where + "'" + line +
                               "' is no VARIABLE=NAME, for example In1=gyro.x; NAME - leaves an input unconnected");
  if (!names.emplace(variable, name).second) refuse_option("--map", where + "'" + variable + "' is mapped twice");
}

// Names of all mappings, and of lines of files that are named instead of one.
fmu::NameMap read_maps(const std::vector<std::string>& maps) {
  fmu::NameMap names;
  for (const std::string& text : maps) {
    if (text.find('=') != std::string::npos) {
      read_mapping(text, "", names);
      continue;
    }
    std::istringstream lines;
    try {
      lines.str(hil::read_text_file(text, "map", std::size_t{1} << 20));
    } catch (const hil::ScenarioError& error) {
      refuse_option("--map",
                    "'" + text + "' is neither VARIABLE=NAME nor a file of such lines: " + error.mistakes.at(0).what);
    }
    int number = 0;
    for (std::string line; std::getline(lines, line);) {
      ++number;
      line = trim(line.substr(0, line.find('#')));
      if (!line.empty()) read_mapping(line, text + ":" + std::to_string(number) + ": ", names);
    }
  }
  return names;
}

// Those of one participant: with its name in front, and where there is but one FMU also without.
fmu::NameMap select_names(const fmu::NameMap& all, const std::string& participant, bool is_alone) {
  fmu::NameMap names;
  for (const auto& [variable, name] : all) {
    if (variable.starts_with(participant + ":"))
      names.emplace(variable.substr(participant.size() + 1), name);
    else if (is_alone)
      names.emplace(variable, name);
  }
  return names;
}

// The vehicle as the simulator's messages will describe it.
fsw::Vehicle describe_vehicle(const hil::Scenario& scenario) {
  const std::vector<hil::CatalogMessage> catalog = hil::build_catalog(scenario.model);
  hil::HelloMessage hello;
  for (const hil::CatalogMessage& item : catalog) {
    hello.body_count += item.kind == static_cast<int>(hil::CatalogKind::kBody) ? 1 : 0;
    hello.channel_count += item.kind == static_cast<int>(hil::CatalogKind::kChannel) ? 1 : 0;
    hello.sensor_count += item.kind == static_cast<int>(hil::CatalogKind::kSensor) ? 1 : 0;
  }
  fsw::Vehicle vehicle;
  vehicle.begin(hello);
  for (const hil::CatalogMessage& item : catalog) vehicle.learn(item);
  return vehicle;
}

}  // namespace

HostedSoftware::HostedSoftware(const std::vector<std::string>& fmus, const std::vector<std::string>& maps,
                               const hil::Scenario& scenario) {
  const fmu::NameMap mapped = read_maps(maps);
  if (!mapped.empty() && fmus.empty()) refuse_option("--map", "it names variables of an FMU: give one by --fmu");
  const std::vector<std::string>& required = scenario.flight_software.required;
  for (const std::string& name : required) members_.push_back({name, nullptr, nullptr, {}});
  for (const std::string& text : fmus) {
    const std::size_t mark = text.find('=');
    const bool named = mark != std::string::npos && std::ranges::count(required, text.substr(0, mark)) > 0;
    if (!named && required.size() != 1) {
      std::string names;
      for (const std::string& name : required) names += (names.empty() ? "" : ", ") + name;
      refuse_option("--fmu", required.empty() ? "the scenario requires no flight software; name it in " +
                                                    std::string("flight_software.required")
                                              : "several are required; give NAME=FILE with one of: " + names);
    }
    const auto member = std::ranges::find(members_, named ? text.substr(0, mark) : required.front(), &Member::name);
    if (member->law) refuse_option("--fmu", "two FMUs for '" + member->name + "'");
    try {
      member->law =
          open_fmu(named ? text.substr(mark + 1) : text, select_names(mapped, member->name, fmus.size() == 1));
      const std::string missing = member->law->attach(describe_vehicle(scenario));
      if (!missing.empty()) refuse_option("--fmu", "the scenario lacks, " + missing);
    } catch (const fsw::ControlError& error) {
      refuse_option("--fmu", error.what());
    }
  }
  for (Member& member : members_)
    if (!member.law) member.law = std::make_unique<fsw::SeparationSequence>();
}

HostedSoftware::~HostedSoftware() { stop(); }

void HostedSoftware::start(bridge::InprocHub& hub) {
  for (Member& member : members_) member.port = hub.open(bridge::Role::kParticipant);
  for (Member& member : members_) member.thread = std::jthread([this, &member] { run(member); });
}

void HostedSoftware::stop() {
  stop_.store(true);
  for (Member& member : members_)
    if (member.thread.joinable()) member.thread.join();
}

// An exception ends this flight software alone; the session looks for it.
void HostedSoftware::run(Member& member) {
  try {
    fsw::ParticipantClient(*member.port, *member.law, member.name).run(kPatience_s, stop_);
  } catch (const std::exception& error) {
    const std::lock_guard lock(mutex_);
    if (failure_.empty()) failure_ = "flight software '" + member.name + "': " + error.what();
  }
}

std::string HostedSoftware::get_failure() const {
  const std::lock_guard lock(mutex_);
  return failure_;
}

}  // namespace unlatch::tools
