#include "library/fmi/instance.h"

#include <cmath>
#include <cstring>
#include <fstream>
#include <map>
#include <mutex>
#include <sstream>

namespace unlatch::fmi {
namespace {

std::string read_file(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  text << file.rdbuf();
  return file ? text.str() : std::string();
}

std::mutex table_mutex;
std::map<void*, std::unique_ptr<Instance>>& get_table() {
  static std::map<void*, std::unique_ptr<Instance>> table;
  return table;
}

}  // namespace

std::unique_ptr<Instance> Instance::create(const std::string& resources, const char* token, Log log) {
  std::unique_ptr<Instance> made(new Instance(std::move(log)));
  const std::string text = read_file(resources + "/scenario.yaml");
  if (text.empty()) return made->refuse(resources + "/scenario.yaml cannot be read"), nullptr;
  std::vector<std::string> overrides;
  std::istringstream lines(read_file(resources + "/overrides.txt"));
  for (std::string line; std::getline(lines, line);) overrides.push_back(line);
  if (token == nullptr || calc_token(text, overrides) != token)
    return made->refuse("the instantiation token is not that of this FMU's description"), nullptr;
  std::vector<const char*> pointers;
  for (const std::string& line : overrides) pointers.push_back(line.c_str());
  unlatch_options options{};
  options.size = sizeof options;
  options.overrides = pointers.data();
  options.override_count = pointers.size();
  std::size_t pairs = 0;
  // Clearances are computed where the scenario watches some.
  for (const bool judges : {false, true}) {
    options.flags = judges ? UNLATCH_JUDGE : 0;
    if (made->simulation_ != nullptr) (void)unlatch_close(made->simulation_);
    made->simulation_ = nullptr;
    if (unlatch_load_text(text.data(), text.size(), "scenario.yaml", &options, &made->simulation_) != UNLATCH_OK)
      return made->refuse_of_library("loading the scenario"), nullptr;
    if (unlatch_count(made->simulation_, UNLATCH_CLEARANCE, &pairs) != UNLATCH_OK || pairs == 0) break;
  }
  made->variables_ = list_variables(made->simulation_);
  if (made->variables_.empty()) return made->refuse_of_library("listing the variables"), nullptr;
  (void)unlatch_get_scenario(made->simulation_, nullptr, &made->dt_, nullptr);
  return made;
}

Instance::~Instance() {
  if (simulation_ != nullptr) (void)unlatch_close(simulation_);
}

bool Instance::refuse(const std::string& why) const {
  if (log_) log_(why.c_str());
  return false;
}

bool Instance::refuse_of_library(const char* call) const {
  const unlatch_error* const error = unlatch_get_error(0);
  return refuse(std::string(call) + ": " + (error != nullptr ? error->text : "unknown error"));
}

bool Instance::move(Phase from, Phase to, const char* call) {
  if (phase_ != from) return refuse(std::string(call) + " is not allowed now");
  phase_ = to;
  return true;
}

bool Instance::terminate() {
  if (phase_ != Phase::kStep && phase_ != Phase::kEvent) return refuse("terminating is not allowed now");
  phase_ = Phase::kTerminated;
  return true;
}

bool Instance::reset() {
  if (unlatch_reset(simulation_) != UNLATCH_OK) return refuse_of_library("resetting");
  phase_ = Phase::kInstantiated;
  return true;
}

bool Instance::get(const std::uint32_t* references, std::size_t count, double* values, std::size_t value_count) {
  if (value_count != count || (count > 0 && (references == nullptr || values == nullptr)))
    return refuse("getting values: null, or another number of values than of references");
  for (std::size_t i = 0; i < count; ++i) {
    if (references[i] >= variables_.size())
      return refuse("value reference " + std::to_string(references[i]) + " is unknown");
    const double* const data = variables_[references[i]].data;
    values[i] = data != nullptr ? *data : get_time();
  }
  return true;
}

bool Instance::set(const std::uint32_t* references, std::size_t count, const double* values, std::size_t value_count) {
  if (value_count != count || (count > 0 && (references == nullptr || values == nullptr)))
    return refuse("setting values: null, or another number of values than of references");
  if (phase_ == Phase::kTerminated) return refuse("setting values is not allowed after termination");
  for (std::size_t i = 0; i < count; ++i) {
    if (references[i] >= variables_.size() || !variables_[references[i]].input)
      return refuse("value reference " + std::to_string(references[i]) + " is no input");
  }
  for (std::size_t i = 0; i < count; ++i) {
    if (unlatch_set_channel(simulation_, references[i] - 1, values[i]) != UNLATCH_OK)
      return refuse_of_library("setting an input");
  }
  return true;
}

double Instance::get_time() const {
  double time = 0;
  (void)unlatch_get_time(simulation_, &time);
  return time;
}

bool Instance::step(double time, double size, bool stops, bool& stopped) {
  constexpr double kSameTime = 1e-6;  // of a tick: what importers' sums of step sizes are off
  stopped = false;
  if (phase_ != Phase::kStep) return refuse("a step is not allowed now");
  std::int64_t tick = 0;
  (void)unlatch_get_tick(simulation_, &tick);
  const double end = (time + size) / dt_;
  if (!(size >= 0) || !(std::abs(time / dt_ - static_cast<double>(tick)) < kSameTime * std::max(1.0, end)))
    return refuse("the step does not begin at the present time, or has a negative size");
  if (!(std::abs(end - std::round(end)) < kSameTime * std::max(1.0, end)))
    return refuse("the step is no whole number of the internal steps of " + std::to_string(dt_) + " s");
  const auto ticks = static_cast<std::uint64_t>(std::llround(end) - tick);
  std::uint64_t done = 0;
  const unlatch_status status = unlatch_advance(simulation_, ticks, stops ? UNLATCH_STOP_AT_EVENTS : 0, &done);
  if (status < 0) return refuse_of_library("stepping");
  stopped = status == UNLATCH_EVENT;
  return true;
}

bool Instance::save(std::vector<std::byte>& state) {
  std::size_t needed = 0;
  if (unlatch_save(simulation_, nullptr, 0, &needed) != UNLATCH_OK) return refuse_of_library("saving");
  state.resize(needed + 1);
  state[needed] = static_cast<std::byte>(phase_);
  return unlatch_save(simulation_, state.data(), needed, &needed) == UNLATCH_OK || refuse_of_library("saving");
}

bool Instance::restore(const std::byte* state, std::size_t size) {
  if (state == nullptr || size == 0 || state[size - 1] > static_cast<std::byte>(Phase::kTerminated))
    return refuse("restoring: this is no state of this FMU");
  if (unlatch_restore(simulation_, state, size - 1) != UNLATCH_OK) return refuse_of_library("restoring");
  phase_ = static_cast<Phase>(state[size - 1]);
  return true;
}

Instance* find_instance(void* pointer) {
  const std::lock_guard lock(table_mutex);
  return get_table().contains(pointer) ? static_cast<Instance*>(pointer) : nullptr;
}

void* keep_instance(std::unique_ptr<Instance> instance) {
  if (!instance) return nullptr;
  const std::lock_guard lock(table_mutex);
  void* const key = instance.get();
  get_table()[key] = std::move(instance);
  return key;
}

void free_instance(void* pointer) {
  const std::lock_guard lock(table_mutex);
  get_table().erase(pointer);
}

std::string calc_token(const std::string& text, const std::vector<std::string>& overrides) {
  std::string token = "{";
  for (const std::uint64_t start : {14695981039346656037ull, 1099511628211ull}) {
    std::uint64_t hash = start;
    const auto add = [&hash](const std::string& part) {
      for (const char c : part + '\0') hash = (hash ^ static_cast<unsigned char>(c)) * 1099511628211ull;  // FNV-1a
    };
    add(text);
    for (const std::string& line : overrides) add(line);
    char digits[17];
    std::snprintf(digits, sizeof digits, "%016llx", static_cast<unsigned long long>(hash));
    token += digits;
  }
  return token + "}";
}

std::string read_uri(const char* uri) {
  std::string path = uri == nullptr ? "" : uri;
  if (path.starts_with("file:")) {
    path.erase(0, 5);
    if (path.starts_with("//")) path.erase(0, path.find('/', 2));
    std::string decoded;
    for (std::size_t i = 0; i < path.size(); ++i) {
      if (path[i] == '%' && i + 2 < path.size()) {
        decoded += static_cast<char>(std::strtol(path.substr(i + 1, 2).c_str(), nullptr, 16));
        i += 2;
      } else {
        decoded += path[i];
      }
    }
    path = decoded;
  }
  while (path.size() > 1 && path.back() == '/') path.pop_back();
  return path;
}

}  // namespace unlatch::fmi
