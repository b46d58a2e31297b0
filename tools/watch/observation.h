// Hears messages and makes of them what people look at. It follows one session at a time: the first that speaks, and
// another once that one has ended or fallen silent.
#pragma once

#include <chrono>
#include <memory>
#include <string_view>

#include "hil/run/simulation/source_text.h"
#include "hil/scenario/scenario.h"
#include "hil/session/messages/messages.h"
#include "hil/session/participants/other_sessions.h"
#include "tools/watch/view.h"

namespace unlatch::tools {

// Text from outside, safe to show: control characters and bytes that are not UTF-8 become '?'.
std::string clean_text(std::string_view text);

class Observation {
 public:
  using Time = std::chrono::steady_clock::time_point;

  // Silence of the simulator, s of wall time, after which people are notified and another session may take its place.
  static constexpr double kSilent_s = 1.5;

  void hear(const hil::Message& message, Time now);
  // Values that depend on time, clearances included; some ten times a second.
  const View& look(Time now, const bridge::PortCounts& port);

 private:
  bool follow(const hil::Message& message, Time now);
  void begin(std::int64_t session);
  void take(const hil::Message& message);
  void hear_hello(const hil::HelloMessage& hello);
  void hear_catalog(const hil::CatalogMessage& item);
  void hear_state(const hil::StateMessage& state);
  void hear_reactions(const hil::ReactionsMessage& reactions);
  void hear_source(const hil::SourceMessage& part);
  void hear_event(const hil::EventMessage& event);
  void hear_verdict(const hil::VerdictMessage& verdict);
  void hear_participant(const hil::Message& message);
  void count_losses(hil::MessageKind kind, std::int64_t sequence);
  void load_source();
  void name_modes();
  void update_clearances();
  void update_rates(Time now);
  void notify(std::string text, bool is_bad);
  void keep(WatchedNotice notice);
  WatchedParticipant& find_participant(std::int32_t id);

  View view_;
  std::vector<hil::Message> early_;  // came before the Hello on which they depend
  hil::SourceText source_;
  std::unique_ptr<hil::Scenario> scenario_;
  std::optional<hil::ClearanceMonitor> clearances_;
  std::vector<hil::Pose> poses_;
  std::vector<std::uint8_t> modes_;
  std::vector<std::string> channels_;
  std::array<std::int64_t, hil::kMessageKinds> next_{};  // sequence number expected; -1: none was heard
  std::int64_t looked_tick_ = -1;
  hil::OtherSessions reported_others_;  // other sessions that speak meanwhile
  Time heard_{}, rated_{};
  std::array<std::int64_t, hil::kMessageKinds> rated_counts_{};
  bool reported_silence_ = false;
};

}  // namespace unlatch::tools
