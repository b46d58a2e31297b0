#include "tools/fsw/separation_sequence.h"

namespace unlatch::fsw {
namespace {

constexpr std::int64_t kMs = 1'000'000;  // ns

// The cyclogram, from the separation command at t = 0.
constexpr std::int64_t kThrottle_ns = 100 * kMs;
constexpr std::int64_t kVerniersOff_ns = 250 * kMs;
constexpr std::int64_t kRuddersNeutral_ns = 300 * kMs;
constexpr std::int64_t kCutTies_ns = 450 * kMs;
constexpr std::int64_t kCutoff_ns = 500 * kMs;
constexpr std::int64_t kNozzleDelay_ns = 12 * kMs;  // from a booster's contact to its nozzle

constexpr double kSeparationThrottle = 0.84;  // of full thrust
constexpr double kClosed = 0.5;               // a contact that reads more has fired

}  // namespace

std::string SeparationSequence::attach(const Vehicle& vehicle) {
  *this = SeparationSequence{};
  std::string missing;
  const auto need = [&missing](int index, const std::string& name) {
    if (index < 0) missing += (missing.empty() ? "" : ", ") + name;
    return index;
  };
  verniers_ = need(vehicle.find_channel("verniers"), "channel verniers");
  for (int i = 1; i == 1 || vehicle.find_channel("nozzle" + std::to_string(i)) >= 0; ++i) {
    const std::string n = std::to_string(i);
    const auto channel = [&](const std::string& name) { return need(vehicle.find_channel(name), "channel " + name); };
    Booster booster{};
    booster.throttle = channel("throttle" + n);
    booster.rudder = channel("rudder" + n);
    booster.cut_ties = channel("cut_ties" + n);
    booster.cutoff = channel("cutoff" + n);
    booster.nozzle = channel("nozzle" + n);
    booster.contact = need(vehicle.find_sensor("kr" + n), "sensor kr" + n);
    boosters_.push_back(booster);
  }
  return missing;
}

void SeparationSequence::update(std::int64_t time_ns, const Vehicle& vehicle, Commands& commands) {
  // Each step of the cyclogram once, in order, at the first tick that reaches its time.
  if (next_step_ == 0 && time_ns >= kThrottle_ns) {
    for (const Booster& booster : boosters_) commands.set(booster.throttle, kSeparationThrottle);
    ++next_step_;
  }
  if (next_step_ == 1 && time_ns >= kVerniersOff_ns) {
    commands.set(verniers_, 0);
    ++next_step_;
  }
  if (next_step_ == 2 && time_ns >= kRuddersNeutral_ns) {
    for (const Booster& booster : boosters_) commands.set(booster.rudder, 0);
    ++next_step_;
  }
  if (next_step_ == 3 && time_ns >= kCutTies_ns) {
    for (const Booster& booster : boosters_) commands.set(booster.cut_ties, 1);
    ++next_step_;
  }
  if (next_step_ == 4 && time_ns >= kCutoff_ns) {
    for (const Booster& booster : boosters_) commands.set(booster.cutoff, 1);
    ++next_step_;
  }

  // Each booster on its own: its nozzle opens after its contact has fired, and pushes the nose away.
  for (Booster& booster : boosters_) {
    if (booster.contact_ns == kNever && vehicle.get_sensor(booster.contact) > kClosed) booster.contact_ns = time_ns;
    if (booster.contact_ns != kNever && !booster.nozzle_open && time_ns >= booster.contact_ns + kNozzleDelay_ns) {
      commands.set(booster.nozzle, 1);
      booster.nozzle_open = true;
    }
  }
}

}  // namespace unlatch::fsw
