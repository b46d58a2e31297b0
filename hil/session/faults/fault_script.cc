#include "hil/session/faults/fault_script.h"

#include <algorithm>
#include <cmath>

#include "hil/run/simulation/model_messages.h"
#include "hil/scenario/yaml/yaml_reader.h"

namespace unlatch::hil {

const std::vector<std::string> kFaultNames{"drop", "delay", "duplicate", "reorder", "corrupt", "freeze",
                                           "kill", "stick", "bias",      "dead",    "jam"};

namespace {

using Kind = Fault::Kind;

constexpr double kMaxTick = 1e12;
constexpr double kMaxCopies = 8, kMaxBits = 64, kMaxTime = 3600;

class FaultReader {
 public:
  FaultReader(const Scenario& scenario, Mistakes& mistakes) : scenario_(scenario), mistakes_(mistakes) {
    for (std::size_t i = 0; i < kMessageKinds; ++i) {
      messages_.emplace_back(get_kind_name(static_cast<MessageKind>(i)));
    }
    for (const CatalogMessage& item : build_catalog(scenario.model)) {
      if (item.kind == static_cast<int>(CatalogKind::kSensor)) values_.emplace_back(get_name(item.name));
    }
    for (const Channel& channel : scenario.model.channels) channels_.push_back(channel.name);
  }

  void read(const YamlNode& root, FaultScript& script) {
    YamlMap top(root, "the fault script", mistakes_);
    if (!root.is_mapping()) return;
    top.read_header("unlatch_faults");
    script.seed = static_cast<std::uint64_t>(whole(top, "seed", 0, 0, 9e15));
    if (const YamlNode* list = top.require("faults")) {
      if (!list->is_sequence())
        mistakes_.add(list->mark, "faults is not a list", "begin each with a dash: `- drop: {message: State}`");
      for (const YamlNode& item : list->items) script.faults.push_back(read_fault(item));
    }
    top.finish();
  }

 private:
  Fault read_fault(const YamlNode& node) {
    Fault fault;
    YamlMap map(node, "a fault", mistakes_);
    const std::string name = map.only_one_of(kFaultNames, "to say what happens");
    const auto at = std::find(kFaultNames.begin(), kFaultNames.end(), name);
    bool single = false;
    if (const YamlNode* ticks = map.find("ticks")) single = read_ticks(*ticks, fault);
    if (at != kFaultNames.end()) {
      fault.kind = static_cast<Kind>(at - kFaultNames.begin());
      read_action(*map.find(name), name, fault);
      if (fault.is_of_messages()) {
        fault.probability = map.number("probability", "", 1.0);
        if (!(fault.probability > 0 && fault.probability <= 1))
          mistakes_.add(map.node().find("probability")->mark, "this is no probability", "more than 0, at most 1");
        const double all = single && fault.probability == 1 ? 1 : kMaxTick;
        fault.count = static_cast<std::int64_t>(whole(map, "count", all, 1, kMaxTick));
      }
    }
    map.finish();
    return fault;
  }

  // Ticks of a fault. True for a single tick.
  bool read_ticks(const YamlNode& node, Fault& fault) {
    const auto tick = [&](const YamlNode& item) {
      const double number = read_number(item, "", 0, mistakes_);
      if (!(number >= 0 && number <= kMaxTick) || number != std::floor(number))
        mistakes_.add(item.mark, "this is no tick", "a whole number from 0; ticks are simulated time over dt");
      return static_cast<std::int64_t>(std::clamp(number, 0.0, kMaxTick));
    };
    if (!node.is_sequence()) {
      fault.first_tick = fault.last_tick = tick(node);
      return true;
    }
    if (node.items.size() != 2) {
      mistakes_.add(node.mark, "ticks is neither one tick nor two", "write 120, [100, 200] or [100, end]");
      return false;
    }
    fault.first_tick = tick(node.items[0]);
    if (!(node.items[1].is_scalar() && node.items[1].text == "end")) fault.last_tick = tick(node.items[1]);
    if (fault.last_tick < fault.first_tick)
      mistakes_.add(node.mark, "these ticks end before they begin", "write the earlier one first");
    return false;
  }

  void read_action(const YamlNode& node, const std::string& name, Fault& fault) {
    switch (fault.kind) {
      case Kind::kFreeze:
      case Kind::kKill:
        return read_participant_fault(node, name, fault);
      case Kind::kStick:
        return read_sensor(node, fault);
      case Kind::kBias: {
        YamlMap map(node, name, mistakes_);
        if (const YamlNode* sensor = map.require("sensor")) read_sensor(*sensor, fault);
        fault.offset = map.number("by", "");
        return map.finish();
      }
      case Kind::kDead:
      case Kind::kJam:
        fault.channel = read_choice(node, "channel", channels_, mistakes_);
        if (fault.channel >= 0) fault.subject = node.text;
        return;
      default:
        return read_message_fault(node, name, fault);
    }
  }

  void read_participant_fault(const YamlNode& node, const std::string& name, Fault& fault) {
    const std::vector<std::string>& required = scenario_.flight_software.required;
    const YamlNode* participant = &node;
    if (node.is_mapping()) {
      YamlMap map(node, name, mistakes_);
      participant = map.require("participant");
      if (fault.kind == Kind::kFreeze) fault.time_ns = read_time(map, "time");
      map.finish();
    }
    if (participant != nullptr && read_choice(*participant, "required participant", required, mistakes_) >= 0)
      fault.subject = fault.participant = participant->text;
  }

  // Values of a sensor by its name, or one of them.
  void read_sensor(const YamlNode& node, Fault& fault) {
    for (std::size_t i = 0; i < values_.size(); ++i) {
      if (values_[i] == node.text || values_[i].starts_with(node.text + "."))
        fault.values.push_back(static_cast<int>(i));
    }
    fault.subject = node.text;
    if (!node.is_scalar() || fault.values.empty()) read_choice(node, "sensor", values_, mistakes_);
  }

  void read_message_fault(const YamlNode& node, const std::string& name, Fault& fault) {
    YamlMap map(node, name, mistakes_);
    const int message = map.choice("message", "message", messages_);
    if (message >= 0) fault.message = static_cast<MessageKind>(message);
    fault.subject = get_kind_name(fault.message);
    if (const YamlNode* participant = map.find("participant")) {
      fault.participant = read_name(*participant, mistakes_);
      fault.subject += " " + fault.participant;
      if (message >= 0 && is_from_simulator(fault.message))
        mistakes_.add(participant->mark, "the simulator publishes a " + fault.subject + " for all participants at once",
                      "leave `participant` out, or name HelloAck, Command or StepAck");
    }
    if (fault.kind == Kind::kDelay) {
      const std::string by = map.only_one_of({"ticks", "time"}, "to say by how much");
      if (by == "ticks") fault.delay_ticks = static_cast<std::int64_t>(whole(map, "ticks", 1, 1, kMaxTick));
      if (by == "time") fault.time_ns = read_time(map, "time");
    }
    if (fault.kind == Kind::kDuplicate) fault.copies = static_cast<int>(whole(map, "copies", 1, 1, kMaxCopies));
    if (fault.kind == Kind::kCorrupt) fault.bits = static_cast<int>(whole(map, "bits", 1, 1, kMaxBits));
    map.finish();
  }

  std::int64_t read_time(YamlMap& map, const std::string& key) {
    if (map.find(key) == nullptr) return 0;
    const double time = map.number(key, "s");
    if (!(time > 0 && time <= kMaxTime))
      mistakes_.add(map.node().find(key)->mark, "this time is not usable", "more than 0, at most 3600 s of wall time");
    return std::llround(time * 1e9);
  }

  double whole(YamlMap& map, const std::string& key, double fallback, double least, double most) {
    const double number = map.number(key, "", fallback);
    if (number >= least && number <= most && number == std::floor(number)) return number;
    mistakes_.add(
        map.node().find(key)->mark, key + " is not usable",
        "a whole number from " + std::to_string(std::llround(least)) + " to " + std::to_string(std::llround(most)));
    return least;
  }

  const Scenario& scenario_;
  Mistakes& mistakes_;
  std::vector<std::string> messages_, values_, channels_;
};

}  // namespace

FaultScript load_faults(const std::string& path, const Scenario& scenario) {
  return load_faults_text(read_text_file(path, "fault script"), path, scenario);
}

FaultScript load_faults_text(const std::string& text, const std::string& file, const Scenario& scenario) {
  FaultScript script;
  Mistakes mistakes(file, {});
  try {
    FaultReader(scenario, mistakes).read(parse_yaml(text), script);
  } catch (const YamlError& error) {
    mistakes.add(error.mark, error.what(), error.mend);
  }
  mistakes.throw_if_any();
  return script;
}

}  // namespace unlatch::hil
