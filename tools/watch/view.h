// An observer's view of a session: received messages, and values computed from them.
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "bridge/core/port.h"
#include "hil/scenario/shapes/clearance.h"
#include "hil/session/messages/messages.h"

namespace unlatch::tools {

struct WatchedJoint {
  std::string name, mode;            // mode: its number until the scenario is known
  std::array<double, 6> reaction{};  // rows x, y, z, rot_x, rot_y, rot_z, on the follower; N, N m
};

struct WatchedParticipant {
  std::string name;
  std::int32_t id = 0;
  hil::AckStatus status = hil::AckStatus::kReady;
  std::int64_t tick = -1;     // of its latest acknowledgement
  std::int64_t commands = 0;  // heard from it
};

struct WatchedNotice {
  double time = 0;  // simulated, s; of the latest of its kind
  std::string text;
  bool is_bad = false;
  std::string key{};       // notices with one key are one, so that a flood pushes out no other; empty: this alone
  std::int64_t count = 1;  // how many
};

struct View {
  std::int64_t session = 0;  // 0: no message yet
  std::string scenario;      // its name
  hil::HelloMessage hello;
  bool has_hello = false, has_state = false;
  hil::RunStatus status = hil::RunStatus::kDiscover;
  std::int64_t tick = 0;
  double time = 0;      // simulated, s
  double silent_s = 0;  // wall time since the simulator was heard, s

  std::vector<WatchedJoint> joints;
  std::int64_t reactions_tick = -1;  // at which they were taken; -1: none was heard yet
  std::vector<std::string> bodies;
  std::vector<hil::Clearance> clearances;  // smallest: of the states that this observer looked at, not of every tick
  std::vector<WatchedParticipant> participants;
  std::optional<hil::HealthMessage> health;
  std::deque<WatchedNotice> notices;  // the latest, oldest first

  std::array<std::int64_t, hil::kMessageKinds> counts{};  // of the session
  std::array<double, hil::kMessageKinds> rates{};         // per second of wall time
  std::int64_t lost = 0;      // of the simulator's numbered messages, between the first heard and the last
  std::int64_t repeated = 0;  // States said again, or out of order
  bridge::PortCounts port;

  bool knows_scenario = false;
  std::string scenario_note;  // why not, until then
};

}  // namespace unlatch::tools
