#include "tools/fsw/separation_sequence.h"

#include "tools/fsw/needs.h"

namespace unlatch::fsw {
namespace {

constexpr std::int64_t kMs = 1'000'000;  // ns

// The cyclogram, from the separation command at t = 0.
constexpr std::int64_t kThrottle_ns = 100 * kMs;
constexpr std::int64_t kVerniersOff_ns = 250 * kMs;
constexpr std::int64_t kRuddersNeutral_ns = 300 * kMs;
constexpr std::int64_t kCutTies_ns = 450 * kMs;
constexpr std::int64_t kCutoff_ns = 500 * kMs;
constexpr std::int64_t kNozzleDelay_ns = 12 * kMs;  // from a booster's contact to its nozzles

constexpr double kSeparationThrottle = 0.84;  // of full thrust
constexpr double kClosed = 0.5;               // a contact that reads more has fired

}  // namespace

std::string SeparationSequence::attach(const Vehicle& vehicle) {
  *this = SeparationSequence{};
  Needs needs(vehicle);
  verniers_ = needs.channel("verniers");
  for (int i = 1; i == 1 || vehicle.find_channel("nozzle" + std::to_string(i)) >= 0; ++i) {
    const std::string n = std::to_string(i);
    Booster booster{};
    booster.throttle = needs.channel("throttle" + n);
    booster.rudder = needs.channel("rudder" + n);
    booster.cut_ties = needs.channel("cut_ties" + n);
    booster.cutoff = needs.channel("cutoff" + n);
    booster.nozzle = needs.channel("nozzle" + n);
    booster.fuel_nozzle = vehicle.find_channel("fuel_nozzle" + n);
    booster.contact = needs.sensor("kr" + n);
    boosters_.push_back(booster);
  }
  const std::string of_the_loop = attitude_loop_.attach(vehicle);
  const std::string& missing = needs.get_missing();
  return missing + (missing.empty() || of_the_loop.empty() ? "" : ", ") + of_the_loop;
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

  // Each booster on its own: its nozzles open after its contact has fired, and push it away.
  for (Booster& booster : boosters_) {
    if (booster.contact_ns == kNever && vehicle.get_sensor(booster.contact) > kClosed) booster.contact_ns = time_ns;
    if (booster.contact_ns != kNever && !booster.nozzles_open && time_ns >= booster.contact_ns + kNozzleDelay_ns) {
      commands.set(booster.nozzle, 1);
      if (booster.fuel_nozzle >= 0) commands.set(booster.fuel_nozzle, 1);
      booster.nozzles_open = true;
    }
  }
  attitude_loop_.update(vehicle, commands);
}

}  // namespace unlatch::fsw
