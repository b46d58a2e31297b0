#include "tools/unlatch/run/hosted_software.h"

#include <algorithm>

#include "hil/run/simulation/model_messages.h"
#include "hil/scenario/modules/module.h"
#include "tools/fsw/separation_sequence.h"
#include "tools/program/command_line.h"

namespace unlatch::tools {
namespace {

std::unique_ptr<fsw::ControlLaw> open_fmu(const std::string& path) {
  using Open = fsw::ControlLaw*(const char*);
  return std::unique_ptr<fsw::ControlLaw>(
      hil::find_function<Open>("unlatch-controller", "unlatch_open_controller")(path.c_str()));
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

HostedSoftware::HostedSoftware(const std::vector<std::string>& fmus, const hil::Scenario& scenario) {
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
      member->law = open_fmu(named ? text.substr(mark + 1) : text);
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
