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

// Of each sensor the rate of its group; one without is sampled at every tick.
std::vector<std::int64_t> list_of_sensors(const Model& model, const Rates& rates, std::int64_t Rate::*what) {
  std::vector<std::int64_t> list(model.sensors.size(), Rate{}.*what);
  for (const RateGroup& group : rates.groups)
    for (const int sensor : group.sensors) list[static_cast<std::size_t>(sensor)] = group.rate.*what;
  return list;
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
  return calc_hash(rates.errors, plan_hash);
}

SampleAndHold::SampleAndHold(const Model& model, const Rates& rates, std::span<const double> channels,
                             std::span<const double> sensors)
    : channels_(channels.begin(), channels.end()),
      sensors_(sensors.begin(), sensors.end()),
      every_(list_of_sensors(model, rates, &Rate::every)),
      phases_(list_of_sensors(model, rates, &Rate::phase)),
      measurement_(model, rates.errors, every_),
      measured_(measurement_.is_exact() ? 0 : sensors.size()),
      states_(rates.states) {
  measurement_.measure(0, phases_, sensors_, sensors_);
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

void SampleAndHold::restore(std::span<const double> channels, std::span<const double> sensors,
                            std::span<const double> memory) noexcept {
  std::copy(memory.begin(), memory.end(), measurement_.memory().begin());
  std::copy(channels.begin(), channels.end(), channels_.begin());
  std::copy(sensors.begin(), sensors.end(), sensors_.begin());
}

void SampleAndHold::sample(std::int64_t tick, std::span<const double> measured) noexcept {
  if (!measurement_.is_exact()) {
    std::copy(measured.begin(), measured.end(), measured_.begin());
    measurement_.measure(tick, phases_, sensors_, measured_);
    measured = measured_;
  }
  renew(sensor_parts_, tick, measured, sensors_);
}

}  // namespace unlatch::hil
