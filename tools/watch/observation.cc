#include "tools/watch/observation.h"

#include <algorithm>
#include <cstdio>
#include <utility>

#include "hil/run/run.h"
#include "hil/session/messages/event_names.h"
#include "tools/common/text.h"

namespace unlatch::tools {
namespace {

using hil::MessageKind;
using hil::RunStatus;

constexpr std::size_t kNotices = 200;          // kept
constexpr std::size_t kMostParticipants = 64;  // distinguished; a stranger may invent any number
constexpr std::size_t kMostEarly = 1024;       // messages kept until Hello comes; more will be said again
constexpr double kRateWindow_s = 1;

double to_seconds(std::chrono::steady_clock::duration duration) {
  return std::chrono::duration<double>(duration).count();
}

std::string name_session(std::int64_t session) { return format("%llx", static_cast<unsigned long long>(session)); }

// Hello says how many there are of what these speak of; but between topics there is no order.
bool depends_on_hello(MessageKind kind) {
  return kind == MessageKind::kCatalog || kind == MessageKind::kReactions || kind == MessageKind::kSource;
}

bool has_ended(RunStatus status) { return status >= RunStatus::kDone; }

// Number of bytes of the first UTF-8 character of `text`; 0 if it is invalid.
std::size_t calc_character_length(std::string_view text) {
  const auto byte = [&text](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const std::size_t length = byte(0) < 0x80                      ? 1
                             : byte(0) >= 0xc2 && byte(0) < 0xe0 ? 2
                             : byte(0) >= 0xe0 && byte(0) < 0xf0 ? 3
                             : byte(0) >= 0xf0 && byte(0) < 0xf5 ? 4
                                                                 : 0;
  if (length == 0 || length > text.size()) return 0;
  for (std::size_t i = 1; i < length; ++i) {
    if ((byte(i) & 0xc0) != 0x80) return 0;
  }
  return length;
}

template <class T>
void put(std::vector<T>& list, std::size_t index, T value) {
  if (index < list.size()) list[index] = std::move(value);
}

}  // namespace

std::string clean_text(std::string_view text) {
  std::string clean;
  while (!text.empty()) {
    const std::size_t length = calc_character_length(text);
    const auto first = static_cast<unsigned char>(text[0]);
    const bool is_control = (length == 1 && (first < 0x20 || first == 0x7f)) ||
                            (length == 2 && first == 0xc2 && static_cast<unsigned char>(text[1]) < 0xa0);
    clean += length == 0 || is_control ? std::string_view("?") : text.substr(0, length);
    text.remove_prefix(std::max<std::size_t>(length, 1));
  }
  return clean;
}

void Observation::hear(const hil::Message& message, Time now) {
  if (!follow(message, now)) return;
  ++view_.counts[static_cast<std::size_t>(message.kind)];
  if (is_from_simulator(message.kind)) heard_ = now;
  if (!view_.has_hello && depends_on_hello(message.kind)) {
    if (early_.size() < kMostEarly) early_.push_back(message);
    return;
  }
  take(message);
}

void Observation::take(const hil::Message& message) {
  switch (message.kind) {
    case MessageKind::kHello:
      return hear_hello(message.hello);
    case MessageKind::kCatalog:
      return hear_catalog(message.catalog);
    case MessageKind::kState:
      return hear_state(message.state);
    case MessageKind::kReactions:
      return hear_reactions(message.reactions);
    case MessageKind::kSource:
      return hear_source(message.source);
    case MessageKind::kEvent:
      return hear_event(message.event);
    case MessageKind::kVerdict:
      return hear_verdict(message.verdict);
    case MessageKind::kHealth:
      count_losses(message.kind, message.health.sequence);
      view_.health = message.health;
      return;
    default:
      return hear_participant(message);
  }
}

// --- Which session --------------------------------------------------------------------------------------------------

// Every message begins with its session. Only a simulator makes one: participants repeat what they heard.
bool Observation::follow(const hil::Message& message, Time now) {
  const std::int64_t session = message.hello.session;
  if (session == view_.session && session != 0) return true;
  if (session == 0 || !is_from_simulator(message.kind)) return false;
  const bool is_free = view_.session == 0 || has_ended(view_.status) || to_seconds(now - heard_) > kSilent_s;
  if (!is_free) {
    if (reported_others_.is_news(session))
      notify("another simulator sends here too, session " + name_session(session), true);
    return false;
  }
  begin(session);
  rated_ = now;
  return true;
}

void Observation::begin(std::int64_t session) {
  std::deque<WatchedNotice> notices = std::move(view_.notices);
  const bool is_second = view_.session != 0;
  const bool had_ended = has_ended(view_.status);
  const std::string before = name_session(view_.session);
  view_ = View{};
  view_.session = session;
  view_.notices = std::move(notices);
  early_.clear();
  source_ = hil::SourceText{};
  scenario_.reset();
  clearances_.reset();
  poses_.clear();
  modes_.clear();
  channels_.clear();
  next_.fill(-1);
  rated_counts_.fill(0);
  looked_tick_ = -1;
  reported_others_.forget();
  reported_silence_ = false;
  if (is_second) {
    notify("session " + before + (had_ended ? " has ended" : " has stopped sending") + "; now follows session " +
               name_session(session),
           !had_ended);
  }
}

// --- What is said once ----------------------------------------------------------------------------------------------

void Observation::hear_hello(const hil::HelloMessage& hello) {
  view_.hello = hello;
  if (!view_.has_state) view_.status = static_cast<RunStatus>(hello.status);
  if (view_.has_hello) return;
  view_.has_hello = true;
  view_.scenario = clean_text(hil::get_name(hello.scenario));
  view_.bodies.resize(static_cast<std::size_t>(hello.body_count));
  view_.joints.resize(static_cast<std::size_t>(hello.joint_count));
  channels_.resize(static_cast<std::size_t>(hello.channel_count));
  poses_.resize(view_.bodies.size());
  modes_.resize(view_.joints.size());
  for (std::size_t i = 0; i < view_.bodies.size(); ++i) view_.bodies[i] = "body " + std::to_string(i);
  for (std::size_t i = 0; i < view_.joints.size(); ++i) view_.joints[i].name = "joint " + std::to_string(i);
  if (hello.schema_hash != hil::kSchemaHash) {
    notify("the simulator was built for another version of the message schema", true);
  }
  for (const hil::Message& message : std::exchange(early_, {})) take(message);
}

void Observation::hear_catalog(const hil::CatalogMessage& item) {
  const auto index = static_cast<std::size_t>(item.index);
  std::string name = clean_text(hil::get_name(item.name));
  switch (static_cast<hil::CatalogKind>(item.kind)) {
    case hil::CatalogKind::kBody:
      return put(view_.bodies, index, std::move(name));
    case hil::CatalogKind::kChannel:
      return put(channels_, index, std::move(name));
    case hil::CatalogKind::kJoint:
      if (index < view_.joints.size()) view_.joints[index].name = std::move(name);
      return;
    case hil::CatalogKind::kParticipant: {
      const auto has_name = [&name](const WatchedParticipant& known) { return known.name == name; };
      auto& list = view_.participants;
      if (std::none_of(list.begin(), list.end(), has_name) && list.size() < kMostParticipants) {
        list.push_back({std::move(name), 0, hil::AckStatus::kLeaving, -1, 0});
      }
      return;
    }
    default:
      return;
  }
}

void Observation::hear_source(const hil::SourceMessage& part) {
  if (scenario_) return;
  const bool was_complete = source_.is_complete();
  source_.add(part);
  if (source_.is_complete()) {
    if (!was_complete) load_source();
    return;
  }
  view_.scenario_note = "the scenario is arriving: " + std::to_string(source_.get_parts() - source_.get_missing()) +
                        " of " + count(source_.get_parts(), "part");
}

// The modes, shapes and pairs of the scenario are shown only if it compiles here to the model that runs there.
void Observation::load_source() {
  const std::vector<std::string> texts = source_.split();
  view_.scenario_note = "the received scenario is invalid";
  if (texts.empty()) return;
  try {
    auto scenario = std::make_unique<hil::Scenario>(hil::load_scenario_text(
        texts[0], "the received scenario", std::vector<std::string>(texts.begin() + 1, texts.end())));
    const auto hash = static_cast<std::int64_t>(hil::build_simulation(*scenario)->plan().get_hash());
    if (hash != view_.hello.model_hash || scenario->model.bodies.size() != view_.bodies.size() ||
        scenario->model.joints.size() != view_.joints.size()) {
      view_.scenario_note = "the received scenario compiles to another model here: no modes and clearances";
      return;
    }
    clearances_.emplace(scenario->clearance, scenario->shapes);
    scenario_ = std::move(scenario);
    view_.knows_scenario = true;
    view_.scenario_note.clear();
    name_modes();
  } catch (const std::exception& error) {
    const std::string what = error.what();
    view_.scenario_note = "the received scenario cannot be read here: " + clean_text(what.substr(0, what.find('\n')));
  }
}

// --- What is said at every tick, or now and then --------------------------------------------------------------------

void Observation::count_losses(MessageKind kind, std::int64_t sequence) {
  std::int64_t& next = next_[static_cast<std::size_t>(kind)];
  const bool is_first = next < 0;
  if (!is_first && sequence > next) view_.lost += sequence - next;
  if (!is_first && sequence < next && kind == MessageKind::kState) ++view_.repeated;
  if (is_first || sequence >= next) next = sequence + 1;
}

void Observation::hear_state(const hil::StateMessage& state) {
  const auto part = static_cast<std::size_t>(state.part);
  for (std::size_t i = 0; i < static_cast<std::size_t>(state.body_count); ++i) {
    const hil::BodyStateMessage& body = state.bodies[i];
    put(poses_, part * hil::kBodiesPerPart + i,
        hil::Pose{{body.x, body.y, body.z}, {body.qw, body.qx, body.qy, body.qz}});
  }
  for (std::size_t i = 0; i < static_cast<std::size_t>(state.joint_count); ++i) {
    put(modes_, part * hil::kJointsPerPart + i, state.modes[i]);
  }
  if (state.part != 0) return;  // part 0 comes last
  count_losses(MessageKind::kState, state.sequence);
  view_.has_state = true;
  view_.status = static_cast<RunStatus>(state.status);
  view_.tick = state.tick;
  view_.time = static_cast<double>(state.time_ns) * 1e-9;
  name_modes();
}

void Observation::name_modes() {
  for (std::size_t i = 0; i < modes_.size(); ++i) {
    const std::size_t mode = modes_[i];
    const bool is_named = scenario_ && mode < scenario_->model.joints[i].modes.size();
    view_.joints[i].mode = is_named ? scenario_->model.joints[i].modes[mode].name : "mode " + std::to_string(mode);
  }
}

void Observation::hear_reactions(const hil::ReactionsMessage& reactions) {
  if (reactions.part == 0) count_losses(MessageKind::kReactions, reactions.sequence);
  const std::size_t begin = static_cast<std::size_t>(reactions.part) * hil::kReactionsPerPart;
  for (std::size_t i = 0; i < static_cast<std::size_t>(reactions.count); ++i) {
    const std::size_t joint = (begin + i) / 6;
    if (joint < view_.joints.size()) view_.joints[joint].reaction[(begin + i) % 6] = reactions.multipliers[i];
  }
  view_.reactions_tick = reactions.tick;
}

void Observation::hear_event(const hil::EventMessage& event) {
  count_losses(MessageKind::kEvent, event.sequence);
  const std::string_view name = hil::get_name(event.name);
  const bool is_bad = name.starts_with(hil::kPolicyPrefix) || name.starts_with(hil::kOverrunPrefix) ||
                      name.starts_with(hil::kFaultPrefix) || name == hil::kLeft || name == hil::kNotAdmitted;
  const std::string text = clean_text(name) + " " + clean_text(hil::get_name(event.subject));
  keep({event.time, text, is_bad, text});
}

void Observation::hear_verdict(const hil::VerdictMessage& verdict) {
  count_losses(MessageKind::kVerdict, verdict.sequence);
  const auto channel = static_cast<std::size_t>(verdict.channel);
  const std::string name = verdict.channel >= 0 && channel < channels_.size() ? " for " + channels_[channel] : "";
  const auto reason = static_cast<hil::Reject>(verdict.reason);
  if (reason == hil::Reject::kMissing) return;  // of the protocol's own
  const std::string what =
      reason == hil::Reject::kLate ? "late: message " : "refused, " + std::string(get_text(reason)) + ": message ";
  const std::string of = name + " of " + find_participant(verdict.participant).name;
  keep({view_.time, what + std::to_string(verdict.refers_to) + of, true, what + of});
}

WatchedParticipant& Observation::find_participant(std::int32_t id) {
  auto& list = view_.participants;
  const auto known = std::find_if(list.begin(), list.end(), [id](const auto& one) { return one.id == id; });
  if (known != list.end()) return *known;
  if (list.size() >= kMostParticipants) return list.back();
  return list.emplace_back(WatchedParticipant{"participant " + std::to_string(id), id, hil::AckStatus::kReady, -1, 0});
}

void Observation::hear_participant(const hil::Message& message) {
  if (message.kind == MessageKind::kHelloAck) {
    const std::string name = clean_text(hil::get_name(message.hello_ack.name));
    const std::int32_t id = message.hello_ack.participant;
    auto& list = view_.participants;
    // Its acknowledgements may have come before its name.
    std::erase_if(list, [&](const auto& one) { return one.id == id && one.name != name; });
    const auto known = std::find_if(list.begin(), list.end(), [&name](const auto& one) { return one.name == name; });
    WatchedParticipant& one = known != list.end() ? *known : find_participant(id);
    one.name = name;
    one.id = id;
    one.status = static_cast<hil::AckStatus>(message.hello_ack.status);
  } else if (message.kind == MessageKind::kCommand) {
    ++find_participant(message.command.participant).commands;
  } else if (message.kind == MessageKind::kStepAck) {
    WatchedParticipant& one = find_participant(message.step_ack.participant);
    one.tick = std::max(one.tick, message.step_ack.tick);
    one.status = hil::AckStatus::kReady;
  }
}

void Observation::notify(std::string text, bool is_bad) { keep({view_.time, std::move(text), is_bad}); }

// One with the key of another takes its place, at the end of the list, and counts it.
void Observation::keep(WatchedNotice notice) {
  const auto same = [&](const WatchedNotice& other) { return !notice.key.empty() && other.key == notice.key; };
  if (const auto known = std::ranges::find_if(view_.notices, same); known != view_.notices.end()) {
    notice.count += known->count;
    view_.notices.erase(known);
  }
  view_.notices.push_back(std::move(notice));
  if (view_.notices.size() > kNotices) view_.notices.pop_front();
}

// --- What depends on time -------------------------------------------------------------------------------------------

const View& Observation::look(Time now, const bridge::PortCounts& port) {
  view_.port = port;
  if (view_.session == 0) return view_;
  view_.silent_s = to_seconds(now - heard_);
  const bool is_silent = view_.silent_s > kSilent_s && !has_ended(view_.status);
  if (is_silent && !reported_silence_) {
    notify("the simulator has stopped sending: it was killed, hangs, or cannot be reached", true);
  }
  if (!is_silent && reported_silence_) notify("the simulator sends again", false);
  reported_silence_ = is_silent;
  update_clearances();
  update_rates(now);
  return view_;
}

void Observation::update_clearances() {
  if (!clearances_ || !view_.has_state || looked_tick_ == view_.tick) return;
  looked_tick_ = view_.tick;
  const auto is_pose = [](const hil::Pose& pose) { return pose.p_WB.allFinite() && pose.q_WB.norm() > 0.5; };
  if (!std::all_of(poses_.begin(), poses_.end(), is_pose)) return;
  clearances_->update(view_.time, poses_);
  view_.clearances = clearances_->get();
}

void Observation::update_rates(Time now) {
  const double since = to_seconds(now - rated_);
  if (since < kRateWindow_s) return;
  for (std::size_t i = 0; i < view_.counts.size(); ++i) {
    view_.rates[i] = static_cast<double>(view_.counts[i] - rated_counts_[i]) / since;
  }
  rated_counts_ = view_.counts;
  rated_ = now;
}

}  // namespace unlatch::tools
