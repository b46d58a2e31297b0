// Messages of a session in lockstep, both ways.
#include <cstring>

#include "bridge/target/lockstep.h"
#include "kernel/targets/serial.h"
#include "kernel/targets/text_line.h"

namespace unlatch::target {
namespace {

constexpr std::uint64_t kForgetAfter_us = 3'000'000;  // without a frame of the other end nothing is sent
constexpr std::uint64_t kHelloEvery_us = 100'000, kItemEvery_us = 2'000;

std::int32_t calc_parts(std::size_t total, std::size_t capacity) {
  return static_cast<std::int32_t>((total + capacity - 1) / capacity);
}
std::int32_t calc_share(std::size_t total, std::int32_t part, std::size_t capacity) {
  const std::size_t first = static_cast<std::size_t>(part) * capacity, left = total <= first ? 0 : total - first;
  return static_cast<std::int32_t>(left < capacity ? left : capacity);
}

unlatch_wire_body_state to_message(const BodyState& body) {
  return {body.p.x, body.p.y, body.p.z, body.q.w, body.q.x, body.q.y, body.q.z,
          body.v.x, body.v.y, body.v.z, body.w.x, body.w.y, body.w.z};
}

// A number that no other start has: the board's, and what has come over the line until now.
std::int64_t draw_session(const unlatch_frame& first, std::uint64_t plan_hash) {
  std::uint64_t number = plan_hash;
  for (const std::uint32_t part : {draw_start_number(), first.run, first.sequence}) {
    number = (number ^ part) * 0x9E3779B97F4A7C15U;
    number ^= number >> 32;
  }
  return static_cast<std::int64_t>(number >> 2) + 1;
}

}  // namespace

// --- What comes -----------------------------------------------------------------------------------------------------

// The line has one other end. One with another run is a new start of it, which has not introduced itself yet.
void Lockstep::hear(const unlatch_frame& frame) {
  heard_us_ = read_clock_us();
  if (session_ == 0) {
    session_ = draw_session(frame, parts_.plan.get_hash());
    run_ = static_cast<std::uint32_t>(session_ >> 8);
  }
  if (frame.run != its_run_) {
    its_run_ = frame.run;
    is_present_ = false;
  }
  unlatch_wire_hello_ack answer;
  unlatch_wire_command command;
  unlatch_wire_step_ack ack;
  switch (frame.kind) {
    case UNLATCH_WIRE_HELLO_ACK_KIND:
      if (unlatch_wire_decode_hello_ack(&answer, frame.payload, frame.length) != 0) hear(answer);
      break;
    case UNLATCH_WIRE_COMMAND_KIND:
      if (unlatch_wire_decode_command(&command, frame.payload, frame.length) != 0) hear(command);
      break;
    case UNLATCH_WIRE_STEP_ACK_KIND:
      if (unlatch_wire_decode_step_ack(&ack, frame.payload, frame.length) != 0) hear(ack);
      break;
    default:
      break;
  }
}

void Lockstep::hear(const unlatch_wire_hello_ack& answer) {
  if (answer.session != session_) return;
  const unlatch_wire_hello& hello = parts_.image.get_hello();
  const unlatch_wire_catalog required = parts_.image.get_item(parts_.image.get_count() - 1);
  const bool fits = answer.protocol == hello.protocol && answer.schema_hash == hello.schema_hash &&
                    answer.model_hash == hello.model_hash && answer.dt_ns == hello.dt_ns;
  if (answer.status == UNLATCH_ACK_STATUS_LEAVING) {
    if (answer.participant == its_number_) is_present_ = false;
  } else if (!fits || answer.status == UNLATCH_ACK_STATUS_REFUSED) {
    refuse(UNLATCH_REJECT_MISMATCH, answer.sequence, answer.participant, -1);
  } else if (std::memcmp(answer.name, required.name, sizeof answer.name) != 0) {
    refuse(UNLATCH_REJECT_UNKNOWN_PARTICIPANT, answer.sequence, answer.participant, -1);
  } else if (!is_present_) {
    admit(answer);
  }
}

void Lockstep::admit(const unlatch_wire_hello_ack& answer) {
  is_present_ = true;
  if (its_number_ == answer.participant) return;  // it is back
  its_number_ = answer.participant;
  commands_.restart();
  ack_ = unlatch_wire_step_ack{};
  ack_.tick = -1;
  TextLine() << "# '" << reinterpret_cast<const char*>(answer.name) << "' takes part from tick "
             << static_cast<std::uint64_t>(get_tick()) << "\n";
}

void Lockstep::hear(const unlatch_wire_command& command) {
  const auto refuse_it = [&](std::int32_t reason) {
    refuse(reason, command.sequence, command.participant, command.channel);
  };
  if (command.session != session_) return refuse_it(UNLATCH_REJECT_WRONG_SESSION);
  if (!is_present_ || command.participant != its_number_) return refuse_it(UNLATCH_REJECT_UNKNOWN_PARTICIPANT);
  const PendingCommands::Outcome outcome = commands_.add(command, get_tick());
  if (outcome.repeated) return;
  if (outcome.reason) refuse_it(*outcome.reason);
  news_us_ = heard_us_;
}

void Lockstep::hear(const unlatch_wire_step_ack& ack) {
  const bool is_sane = ack.tick >= ack_.tick && ack.tick <= get_tick() && ack.last_command >= 0 &&
                       ack.command_count >= 0 && ack.command_count <= hil::SeenCommands::kWindow;
  if (ack.session == session_ && is_present_ && ack.participant == its_number_ && is_sane) ack_ = ack;
}

bool Lockstep::is_answered() const {
  return is_present_ && ack_.tick == get_tick() && commands_.get_seen().has_all(ack_.last_command, ack_.command_count);
}

// --- What goes ------------------------------------------------------------------------------------------------------

std::span<std::uint8_t> Lockstep::get_message() { return std::span(frame_).subspan(UNLATCH_FRAME_HEADER_BYTES); }

// Of a message that get_message() holds.
void Lockstep::send(int kind, std::size_t bytes) {
  if (session_ == 0 || read_clock_us() - heard_us_ > kForgetAfter_us) return;
  parts_.line.send(std::span(frame_).first(unlatch_frame_seal(frame_, run_, sent_++, kind, bytes)));
}

// Hello every 100 ms, else the catalog, item by item.
void Lockstep::announce() {
  const std::uint64_t now_us = read_clock_us();
  if (session_ == 0 || now_us - announced_us_ < kItemEvery_us) return;
  const std::span<std::uint8_t> to = get_message();
  if (now_us - hello_us_ >= kHelloEvery_us) {
    hello_us_ = now_us;
    unlatch_wire_hello hello = parts_.image.get_hello();
    hello.session = session_;
    hello.sequence = hellos_++;
    hello.status = status_;
    send(UNLATCH_WIRE_HELLO_KIND, unlatch_wire_encode_hello(&hello, to.data(), to.size()));
  } else {
    unlatch_wire_catalog item = parts_.image.get_item(next_item_);
    item.session = session_;
    item.sequence = items_++;
    send(UNLATCH_WIRE_CATALOG_KIND, unlatch_wire_encode_catalog(&item, to.data(), to.size()));
    next_item_ = (next_item_ + 1) % parts_.image.get_count();
  }
  announced_us_ = read_clock_us();
}

std::int32_t Lockstep::count_parts() const {
  std::int32_t parts = 1;
  for (const std::int32_t needed : {calc_parts(parts_.state.bodies.size(), UNLATCH_WIRE_BODIES_PER_PART),
                                    calc_parts(parts_.workspace.sensors.size(), UNLATCH_WIRE_SENSORS_PER_PART),
                                    calc_parts(parts_.state.joints.size(), UNLATCH_WIRE_JOINTS_PER_PART)})
    if (needed > parts) parts = needed;
  return parts;
}

// As fill_state() of hil/run/simulation/model_messages.h.
void Lockstep::fill_state(std::int32_t part, int status) {
  const State& state = parts_.state;
  message_.session = session_;
  message_.tick = get_tick();
  message_.time_ns = get_tick() * parts_.image.get_hello().dt_ns;
  message_.status = status;
  message_.part = part;
  message_.parts = count_parts();
  message_.body_count = calc_share(state.bodies.size(), part, UNLATCH_WIRE_BODIES_PER_PART);
  message_.sensor_count = calc_share(parts_.workspace.sensors.size(), part, UNLATCH_WIRE_SENSORS_PER_PART);
  message_.joint_count = calc_share(state.joints.size(), part, UNLATCH_WIRE_JOINTS_PER_PART);
  const auto first = static_cast<std::size_t>(part);
  for (std::size_t i = 0; i < static_cast<std::size_t>(message_.body_count); ++i)
    message_.bodies[i] = to_message(state.bodies[first * UNLATCH_WIRE_BODIES_PER_PART + i]);
  for (std::size_t i = 0; i < static_cast<std::size_t>(message_.sensor_count); ++i)
    message_.sensors[i] = parts_.workspace.sensors[first * UNLATCH_WIRE_SENSORS_PER_PART + i];
  for (std::size_t i = 0; i < static_cast<std::size_t>(message_.joint_count); ++i)
    message_.modes[i] = static_cast<std::uint8_t>(state.joints[first * UNLATCH_WIRE_JOINTS_PER_PART + i].mode);
}

void Lockstep::publish_state(int status) {
  message_.sequence = states_++;
  message_.hash = static_cast<std::int64_t>(calc_hash(parts_.state));
  for (std::int32_t part = count_parts() - 1; part >= 0; --part) {  // part 0, the token, comes last
    fill_state(part, status);
    const std::span<std::uint8_t> to = get_message();
    send(UNLATCH_WIRE_STATE_KIND, unlatch_wire_encode_state(&message_, to.data(), to.size()));
  }
}

void Lockstep::repeat_state(int status) {
  ask_for_missing();
  --states_;  // a State that is repeated keeps its number
  publish_state(status);
  ++resent_;
}

void Lockstep::ask_for_missing() {
  if (!is_present_ || ack_.tick != get_tick()) return;
  const hil::SeenCommands& seen = commands_.get_seen();
  auto gap = seen.find_gap(ack_.last_command, ack_.command_count);
  for (int asked = 0; gap && asked < kVerdictsPerTick; ++asked) {
    unlatch_wire_verdict verdict{};
    verdict.refers_to = gap->first;
    verdict.count = static_cast<std::int32_t>(gap->count);
    verdict.applied_tick = -1;
    verdict.participant = its_number_;
    verdict.reason = UNLATCH_REJECT_MISSING;
    verdict.channel = -1;
    send_verdict(verdict);
    gap = seen.find_gap(ack_.last_command, ack_.command_count, gap->first + gap->count);
  }
}

void Lockstep::refuse(std::int32_t reason, std::int64_t sequence, std::int32_t participant, std::int32_t channel) {
  ++refused_;
  if (verdicts_left_ == 0) return;
  --verdicts_left_;
  unlatch_wire_verdict verdict{};
  verdict.refers_to = sequence;
  verdict.applied_tick = -1;
  verdict.participant = participant;
  verdict.reason = reason;
  verdict.channel = channel;
  verdict.count = 1;
  send_verdict(verdict);
}

void Lockstep::send_verdict(unlatch_wire_verdict verdict) {
  verdict.session = session_;
  verdict.sequence = verdicts_++;
  verdict.tick = get_tick();
  const std::span<std::uint8_t> to = get_message();
  send(UNLATCH_WIRE_VERDICT_KIND, unlatch_wire_encode_verdict(&verdict, to.data(), to.size()));
}

}  // namespace unlatch::target
