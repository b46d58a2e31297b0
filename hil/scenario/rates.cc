#include "hil/scenario/rates.h"

#include <algorithm>

namespace unlatch::hil {
namespace {

// Index of the first value of each sensor, in the order of the model.
std::vector<std::int32_t> find_first_values(const Model& model) {
  std::vector<std::int32_t> first{0};
  for (const Sensor& sensor : model.sensors) first.push_back(first.back() + sensor_width(sensor.kind));
  return first;
}

// All indices below `count` that are in no part.
std::vector<std::int32_t> find_rest(const auto& parts, std::size_t count) {
  std::vector<bool> taken(count, false);
  for (const auto& part : parts) {
    for (const std::int32_t place : part.places) taken[static_cast<std::size_t>(place)] = true;
  }
  std::vector<std::int32_t> rest;
  for (std::size_t i = 0; i < count; ++i) {
    if (!taken[i]) rest.push_back(static_cast<std::int32_t>(i));
  }
  return rest;
}

}  // namespace

std::uint64_t calc_hash(const Rates& rates, std::uint64_t plan_hash) noexcept {
  const auto add = [&plan_hash](std::int64_t number) {
    plan_hash = (plan_hash ^ static_cast<std::uint64_t>(number)) * 0x9E3779B97F4A7C15u;
    plan_hash ^= plan_hash >> 32;
  };
  for (const RateGroup& group : rates.groups) {
    add(group.rate.every);
    add(group.rate.phase);
    for (const std::vector<int>* list : {&group.channels, &group.sensors}) {
      add(static_cast<std::int64_t>(list->size()));
      for (const int index : *list) add(index);
    }
  }
  return plan_hash;
}

SampleAndHold::SampleAndHold(const Model& model, const Rates& rates, std::span<const double> channels,
                             std::span<const double> sensors)
    : channels_(channels.begin(), channels.end()), sensors_(sensors.begin(), sensors.end()), states_(rates.states) {
  const std::vector<std::int32_t> first = find_first_values(model);
  for (const RateGroup& group : rates.groups) {
    if (!group.channels.empty()) {
      channel_parts_.push_back({group.rate, {group.channels.begin(), group.channels.end()}});
    }
    if (group.sensors.empty()) continue;
    Part& part = sensor_parts_.emplace_back();
    part.rate = group.rate;
    for (const int sensor : group.sensors) {
      const auto at = static_cast<std::size_t>(sensor);
      for (std::int32_t place = first[at]; place < first[at + 1]; ++place) part.places.push_back(place);
    }
  }
  channel_parts_.push_back({{}, find_rest(channel_parts_, channels_.size())});
  sensor_parts_.push_back({{}, find_rest(sensor_parts_, sensors_.size())});
}

void SampleAndHold::renew(const std::vector<Part>& parts, std::int64_t tick, std::span<const double> from,
                          std::span<double> to) noexcept {
  if (parts.size() == 1) {  // without groups the rest is all of them
    std::copy(from.begin(), from.end(), to.begin());
    return;
  }
  for (const Part& part : parts) {
    if (!part.rate.is_due(tick)) continue;
    for (const std::int32_t place : part.places) {
      to[static_cast<std::size_t>(place)] = from[static_cast<std::size_t>(place)];
    }
  }
}

void SampleAndHold::latch(std::int64_t tick, std::span<const double> commanded) noexcept {
  renew(channel_parts_, tick, commanded, channels_);
}

void SampleAndHold::restore(std::span<const double> channels, std::span<const double> sensors) noexcept {
  std::copy(channels.begin(), channels.end(), channels_.begin());
  std::copy(sensors.begin(), sensors.end(), sensors_.begin());
}

void SampleAndHold::sample(std::int64_t tick, std::span<const double> measured) noexcept {
  renew(sensor_parts_, tick, measured, sensors_);
}

}  // namespace unlatch::hil
