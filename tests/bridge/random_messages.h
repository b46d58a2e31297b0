// Messages with random bit patterns in every field: NaNs with payloads, denormals and -0.0 among the numbers.
#pragma once

#include <array>
#include <bit>
#include <cstring>
#include <limits>
#include <random>

#include "hil/session/messages/messages.h"

namespace unlatch::test {

using Random = std::mt19937_64;

inline constexpr std::array<std::uint64_t, 8> kSpecialBits{
    0x8000000000000000U,  // -0.0
    0x0000000000000001U,  // smallest denormal
    0x800fffffffffffffU,  // largest negative denormal
    0x7ff0000000000000U,  // infinity
    0xfff0000000000000U,  // -infinity
    0x7ff8000000000000U,  // quiet NaN
    0x7ff4dead0000beefU,  // signalling NaN with a payload
    0xffffffffffffffffU,  // quiet negative NaN, all ones
};

// Fills a struct whose 8-byte fields come first with random bits, every fourth word a special number.
template <class T>
void fill_with_bits(T& message, Random& random) {
  std::array<std::uint64_t, sizeof(T) / 8> words{};
  for (std::uint64_t& word : words) word = random() % 4 == 0 ? kSpecialBits[random() % kSpecialBits.size()] : random();
  message = std::bit_cast<T>(words);
}

inline std::int32_t pick(Random& random, std::size_t last) { return static_cast<std::int32_t>(random() % (last + 1)); }

// Makes a random message with counts and enums in their ranges, so that a port accepts it.
inline hil::Message make_random_message(hil::MessageKind kind, Random& random) {
  hil::StateMessage bits;
  fill_with_bits(bits, random);
  hil::Message message(bits);
  message.kind = kind;
  switch (kind) {
    case hil::MessageKind::kHello:
      message.hello.pace = pick(random, 2);
      message.hello.status = pick(random, 7);
      message.hello.policy = pick(random, 5);
      for (auto* count : {&message.hello.body_count, &message.hello.joint_count, &message.hello.channel_count,
                          &message.hello.sensor_count, &message.hello.signal_count, &message.hello.participant_count}) {
        *count = pick(random, hil::kMaxItems);
      }
      break;
    case hil::MessageKind::kCatalog:
      message.catalog.kind = pick(random, 5);
      message.catalog.index = pick(random, hil::kMaxItems);
      break;
    case hil::MessageKind::kHelloAck:
      message.hello_ack.status = pick(random, 2);
      break;
    case hil::MessageKind::kState:
      message.state.status = pick(random, 7);
      message.state.part = pick(random, 3);
      message.state.parts = 4;
      message.state.body_count = pick(random, hil::kBodiesPerPart);
      message.state.sensor_count = pick(random, hil::kSensorsPerPart);
      message.state.joint_count = pick(random, hil::kJointsPerPart);
      break;
    case hil::MessageKind::kReactions:
      message.reactions.part = pick(random, 3);
      message.reactions.parts = 4;
      message.reactions.count = pick(random, hil::kReactionsPerPart);
      break;
    case hil::MessageKind::kSource:
      message.source.part = pick(random, 3);
      message.source.parts = 4;
      message.source.count = pick(random, hil::kSourcePerPart);
      break;
    case hil::MessageKind::kVerdict:
      message.verdict.reason = pick(random, 11);
      break;
    default:
      break;
  }
  return message;
}

// Compares kind and bits (== is not enough: NaN is not equal to itself).
inline bool is_same(const hil::Message& a, const hil::Message& b) {
  return a.kind == b.kind && std::memcmp(&a.hello, &b.hello, hil::get_size(a.kind)) == 0;
}

// All kinds, in the order of the enumeration.
inline std::array<hil::MessageKind, hil::kMessageKinds> list_kinds() {
  std::array<hil::MessageKind, hil::kMessageKinds> kinds{};
  for (std::size_t i = 0; i < kinds.size(); ++i) kinds[i] = static_cast<hil::MessageKind>(i);
  return kinds;
}

}  // namespace unlatch::test
