#include "library/fmi/instance.h"

#include <strings.h>

#include <cmath>
#include <cstring>
#include <fstream>
#include <map>
#include <mutex>
#include <span>
#include <sstream>

#include "hil/scenario/text/number_text.h"

namespace unlatch::fmi {
namespace {

std::string read_file(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  text << file.rdbuf();
  return file ? text.str() : std::string();
}

constexpr const char* kOfRun = "run ";  // begins what is logged of the run, not of the scenario

std::mutex table_mutex;
std::map<void*, std::unique_ptr<Instance>>& get_table() {
  static std::map<void*, std::unique_ptr<Instance>> table;
  return table;
}

}  // namespace

std::unique_ptr<Instance> Instance::create(const std::string& resources, const char* token, Log log) {
  std::unique_ptr<Instance> made(new Instance(std::move(log)));
  made->text_ = read_file(resources + "/scenario.yaml");
  if (made->text_.empty()) {
    made->refuse(resources + "/scenario.yaml cannot be read");
    return nullptr;
  }
  std::istringstream lines(read_file(resources + "/overrides.txt"));
  for (std::string line; std::getline(lines, line);) made->overrides_.push_back(line);
  if (token == nullptr || calc_token(made->text_, made->overrides_) != token) {
    made->refuse("the instantiation token is not that of this FMU's description");
    return nullptr;
  }
  if (!made->load({})) return nullptr;
  for (const Variable& variable : made->variables_)
    if (variable.causality == Variable::Causality::kParameter) made->starts_.push_back(variable.start);
  made->parameters_ = made->starts_;
  made->first_parameter_ = made->variables_.size() - made->starts_.size();
  return made;
}

bool Instance::load(const std::vector<double>& parameters) {
  std::vector<std::string> lines = overrides_;
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    const Variable& variable = variables_[first_parameter_ + i];
    if (!(parameters[i] == starts_[i]))
      lines.push_back(variable.name + "=" + hil::write_number(parameters[i]) + " " + variable.unit);
  }
  std::vector<const char*> pointers;
  for (const std::string& line : lines) pointers.push_back(line.c_str());
  unlatch_options options{};
  options.size = sizeof options;
  options.overrides = pointers.data();
  options.override_count = pointers.size();
  unlatch_simulation* made = nullptr;
  std::size_t pairs = 0;
  // Clearances are computed if the scenario watches some.
  for (const std::uint32_t flags : {UNLATCH_NOTICE, UNLATCH_JUDGE}) {
    options.flags = flags;
    if (made != nullptr) (void)unlatch_close(made);
    if (unlatch_load_text(text_.data(), text_.size(), "scenario.yaml", &options, &made) != UNLATCH_OK)
      return refuse_of_library("loading the scenario");
    if (unlatch_count(made, UNLATCH_CLEARANCE, &pairs) != UNLATCH_OK || pairs == 0) break;
  }
  std::vector<Variable> variables = list_variables(made);
  bool good = !variables.empty() || refuse_of_library("listing the variables");
  if (good && !variables_.empty() && variables.size() != variables_.size())
    good = refuse("with these parameters the scenario has another number of variables");
  for (const auto& [reference, value] : inputs_set_)
    if (good && unlatch_set_channel(made, reference - 1, value) != UNLATCH_OK)
      good = refuse_of_library("setting an input again");
  if (!good) {
    (void)unlatch_close(made);
    return false;
  }
  if (simulation_ != nullptr) (void)unlatch_close(simulation_);
  simulation_ = made;
  variables_ = std::move(variables);
  parameters_ = parameters;
  (void)unlatch_get_scenario(simulation_, nullptr, &dt_, nullptr);
  return true;
}

Instance::~Instance() {
  if (simulation_ != nullptr) (void)unlatch_close(simulation_);
}

bool Instance::refuse(const std::string& why) const {
  if (log_) log_(kError, why.c_str());
  return false;
}

void Instance::log_findings() {
  const unlatch_finding* findings = nullptr;
  std::size_t count = 0;
  if (unlatch_get_findings(simulation_, &findings, &count) != UNLATCH_OK) return;
  for (const unlatch_finding& finding : std::span(findings, count)) {
    warned_ = warned_ || finding.unresolved != 0;
    const std::string what = std::string(finding.name) + " " + finding.subject;
    if (!logged_.insert((finding.of_run != 0 ? kOfRun : "scenario ") + what).second) continue;
    std::string text = what + ": " + finding.text;
    if (finding.of_run != 0) text = "t = " + hil::write_number(finding.time) + " s: " + text;
    if (finding.unresolved != 0) text += "; results that depend on it are unresolved";
    if (log_) log_(kWarning, text.c_str());
  }
}

bool Instance::end_initialization(Phase to) {
  if (!move(Phase::kInitialization, to, "leaving initialization mode")) return false;
  log_findings();
  return true;
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
  stop_time_ = std::numeric_limits<double>::infinity();
  inputs_set_.clear();
  if (parameters_ != starts_) {
    if (!load(starts_)) return false;
  } else if (unlatch_reset(simulation_) != UNLATCH_OK) {
    return refuse_of_library("resetting");
  }
  logged_.clear();
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
    const bool is_parameter = references[i] >= first_parameter_;
    values[i] = data != nullptr ? *data : is_parameter ? parameters_[references[i] - first_parameter_] : get_time();
  }
  return true;
}

bool Instance::set(const std::uint32_t* references, std::size_t count, const double* values, std::size_t value_count) {
  if (value_count != count || (count > 0 && (references == nullptr || values == nullptr)))
    return refuse("setting values: null, or another number of values than of references");
  if (phase_ == Phase::kTerminated) return refuse("setting values is not allowed after termination");
  for (std::size_t i = 0; i < count; ++i) {
    if (!may_set(references[i])) return false;
  }
  std::vector<double> parameters = parameters_;
  for (std::size_t i = 0; i < count; ++i)
    if (references[i] >= first_parameter_) parameters[references[i] - first_parameter_] = values[i];
  if (parameters != parameters_ && !load(parameters)) return false;
  for (std::size_t i = 0; i < count; ++i) {
    if (references[i] >= first_parameter_) continue;
    if (unlatch_set_channel(simulation_, references[i] - 1, values[i]) != UNLATCH_OK)
      return refuse_of_library("setting an input");
    inputs_set_[references[i]] = values[i];
  }
  return true;
}

bool Instance::may_set(std::uint32_t reference) const {
  using enum Variable::Causality;
  const auto causality = reference < variables_.size() ? variables_[reference].causality : kOutput;
  if (causality == kInput) return true;
  const bool is_early = phase_ == Phase::kInstantiated || phase_ == Phase::kInitialization;
  if (causality == kParameter && is_early) return true;
  return refuse(
      "value reference " + std::to_string(reference) +
      (causality == kParameter ? " is a parameter: it is set before the run alone" : " is no input and no parameter"));
}

double Instance::get_time() const {
  double time = 0;
  (void)unlatch_get_time(simulation_, &time);
  return time;
}

bool Instance::step(double time, double size, bool stops, bool& stopped) {
  constexpr double kSameTime = 1e-6;  // relative to a tick: deviation of importers' sums of step sizes
  stopped = false;
  if (phase_ != Phase::kStep) return refuse("a step is not allowed now");
  std::int64_t tick = 0;
  (void)unlatch_get_tick(simulation_, &tick);
  const double end = (time + size) / dt_;
  if (!(size >= 0) || !(std::abs(time / dt_ - static_cast<double>(tick)) < kSameTime * std::max(1.0, end)))
    return refuse("the step does not begin at the present time, or has a negative size");
  if (!(std::abs(end - std::round(end)) < kSameTime * std::max(1.0, end)))
    return refuse("the step is no whole number of the internal steps of " + hil::write_number(dt_) + " s");
  if (end > stop_time_ / dt_ + kSameTime * std::max(1.0, end))
    return refuse("the step ends after the stop time of " + hil::write_number(stop_time_) + " s");
  const auto ticks = static_cast<std::uint64_t>(std::llround(end) - tick);
  std::uint64_t done = 0;
  const unlatch_status status = unlatch_advance(simulation_, ticks, stops ? UNLATCH_STOP_AT_EVENTS : 0, &done);
  if (status < 0) return refuse_of_library("stepping");
  log_findings();
  stopped = status == UNLATCH_EVENT;
  return true;
}

// Saves the state of the library, the parameters, and the phase.
bool Instance::save(std::vector<std::byte>& state) {
  std::size_t needed = 0;
  if (unlatch_save(simulation_, nullptr, 0, &needed) != UNLATCH_OK) return refuse_of_library("saving");
  const std::size_t length = parameters_.size() * sizeof(double);
  state.resize(needed + length + 1);
  if (length > 0) std::memcpy(&state[needed], parameters_.data(), length);
  state.back() = static_cast<std::byte>(phase_);
  return unlatch_save(simulation_, state.data(), needed, &needed) == UNLATCH_OK || refuse_of_library("saving");
}

bool Instance::restore(const std::byte* state, std::size_t size) {
  const std::size_t length = starts_.size() * sizeof(double);
  if (state == nullptr || size < length + 1 || state[size - 1] > static_cast<std::byte>(Phase::kTerminated))
    return refuse("restoring: this is no state of this FMU");
  std::vector<double> parameters(starts_.size());
  if (length > 0) std::memcpy(parameters.data(), state + size - 1 - length, length);
  const std::vector<double> before = parameters_;
  if (parameters != before && !load(parameters)) return false;
  if (unlatch_restore(simulation_, state, size - 1 - length) != UNLATCH_OK) {
    refuse_of_library("restoring");
    if (parameters != before) (void)load(before);
    return false;
  }
  phase_ = static_cast<Phase>(state[size - 1]);
  std::erase_if(logged_, [](const std::string& what) { return what.starts_with(kOfRun); });
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
  const bool is_uri = strncasecmp(path.c_str(), "file:", 5) == 0;  // schemes have no case: RFC 3986, 3.1
  if (is_uri) {
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
