// Space packets: their headers, what has none, layouts that hostile messages cannot break, bounded queues.
#include <gtest/gtest.h>

#include <random>

#include "bridge/telemetry/send_queue.h"
#include "bridge/telemetry/sequence_gaps.h"
#include "bridge/telemetry/session_layout.h"
#include "bridge/telemetry/space_packets.h"
#include "bridge/telemetry/xtce.h"

namespace unlatch::test {
namespace {

using bridge::SessionLayout;
using bridge::SpacePacket;
using bridge::SpacePacketWriter;

constexpr std::int64_t kSession = 42;

hil::HelloMessage build_hello(std::int32_t bodies, std::int32_t joints, std::int32_t sensors) {
  hil::HelloMessage hello;
  hello.session = kSession;
  hello.body_count = bodies;
  hello.joint_count = joints;
  hello.sensor_count = sensors;
  hil::set_name(hello.scenario, "test");
  return hello;
}

hil::CatalogMessage build_item(hil::CatalogKind kind, std::int32_t index, const std::string& name) {
  hil::CatalogMessage item;
  item.session = kSession;
  item.kind = static_cast<std::int32_t>(kind);
  item.index = index;
  hil::set_name(item.name, name);
  return item;
}

SessionLayout build_layout(std::int32_t bodies, std::int32_t joints, std::int32_t sensors) {
  SessionLayout layout;
  layout.hear(build_hello(bodies, joints, sensors));
  for (std::int32_t i = 0; i < bodies; ++i)
    layout.hear(build_item(hil::CatalogKind::kBody, i, "body" + std::to_string(i)));
  for (std::int32_t i = 0; i < joints; ++i)
    layout.hear(build_item(hil::CatalogKind::kJoint, i, "joint" + std::to_string(i)));
  for (std::int32_t i = 0; i < sensors; ++i)
    layout.hear(build_item(hil::CatalogKind::kSensor, i, "gyro." + std::to_string(i)));
  return layout;
}

// CCSDS 133.0-B-2, section 4.1.3: version, type, flag of the secondary header, identifier; flags and count; length.
TEST(SpacePackets, HeadersAreThoseOfTheStandard) {
  const SessionLayout layout = build_layout(1, 0, 0);
  SpacePacketWriter writer;
  SpacePacket packet;
  hil::EventMessage event;
  event.session = kSession;
  event.time_ns = 3'500'000'000;
  const hil::Message message(event);
  ASSERT_TRUE(writer.write(message, layout, packet));
  ASSERT_EQ(packet.size(), 6 + 7 + sizeof(hil::EventMessage));
  EXPECT_EQ(packet[0] >> 5, 0);      // version
  EXPECT_EQ(packet[0] >> 4 & 1, 0);  // telemetry
  EXPECT_EQ(packet[0] >> 3 & 1, 1);  // secondary header
  EXPECT_EQ((packet[0] & 7) << 8 | packet[1], 106);
  EXPECT_EQ(packet[2] >> 6, 3);  // unsegmented
  EXPECT_EQ((packet[2] & 0x3F) << 8 | packet[3], 0);
  EXPECT_EQ(static_cast<std::size_t>(packet[4] << 8 | packet[5]), packet.size() - 7);
  EXPECT_EQ(packet[9], 3);      // seconds
  EXPECT_EQ(packet[10], 0x80);  // and a half
  ASSERT_TRUE(writer.write(message, layout, packet));
  EXPECT_EQ(packet[3], 1);
}

TEST(SpacePackets, TheCountGoesRoundAfterFourteenBits) {
  const SessionLayout layout = build_layout(1, 0, 0);
  SpacePacketWriter writer;
  SpacePacket packet;
  hil::EventMessage event;
  event.session = kSession;
  for (int i = 0; i <= 1 << 14; ++i) ASSERT_TRUE(writer.write(hil::Message(event), layout, packet));
  EXPECT_EQ((packet[2] & 0x3F) << 8 | packet[3], 0);
}

TEST(SpacePackets, PartsOfAStateHoldTheirValidEntriesAlone) {
  const SessionLayout layout = build_layout(20, 3, 70);
  EXPECT_EQ(layout.count_state_parts(), 2);
  SpacePacketWriter writer;
  SpacePacket packet;
  hil::StateMessage state;
  state.session = kSession;
  state.parts = 2;
  state.body_count = 16;
  state.sensor_count = 64;
  state.joint_count = 3;
  ASSERT_TRUE(writer.write(hil::Message(state), layout, packet));
  EXPECT_EQ(packet.size(), 13u + 5 * 8 + 64 * 8 + 16 * 13 * 8 + 6 * 4 + 3);
  state.part = 1;
  EXPECT_FALSE(writer.write(hil::Message(state), layout, packet));  // counts of another part
  state.body_count = 4;
  state.sensor_count = 6;
  state.joint_count = 0;
  ASSERT_TRUE(writer.write(hil::Message(state), layout, packet));
  EXPECT_EQ((packet[0] & 7) << 8 | packet[1], bridge::kStateApid + 1);
  EXPECT_EQ(packet.size(), 13u + 5 * 8 + 6 * 8 + 4 * 13 * 8 + 6 * 4);
  state.part = 2;
  EXPECT_FALSE(writer.write(hil::Message(state), layout, packet));
}

TEST(SpacePackets, OtherSessionsAndUnknownLayoutsHaveNone) {
  SessionLayout layout;
  SpacePacketWriter writer;
  SpacePacket packet;
  hil::StateMessage state;
  state.session = kSession;
  EXPECT_FALSE(writer.write(hil::Message(state), layout, packet));
  layout.hear(build_hello(1, 0, 0));
  state.body_count = 1;
  EXPECT_FALSE(writer.write(hil::Message(state), layout, packet));  // no catalog yet
  layout.hear(build_item(hil::CatalogKind::kBody, 0, "core"));
  EXPECT_TRUE(writer.write(hil::Message(state), layout, packet));
  state.session = kSession + 1;
  EXPECT_FALSE(writer.write(hil::Message(state), layout, packet));
}

TEST(SessionLayout, ItemsBeyondTheirCountAndNamesThatAreNoTextDoNoHarm) {
  SessionLayout layout;
  layout.hear(build_hello(2, 0, 0));
  layout.hear(build_item(hil::CatalogKind::kBody, 2, "beyond"));
  layout.hear(build_item(hil::CatalogKind::kSensor, 0, "none"));
  layout.hear(build_item(hil::CatalogKind::kBody, 0, "\xff<&\x01"));
  EXPECT_FALSE(layout.is_complete());
  layout.hear(build_item(hil::CatalogKind::kBody, 0, "\xff<&\x01"));  // again: it counts once
  EXPECT_FALSE(layout.is_complete());
  layout.hear(build_item(hil::CatalogKind::kBody, 1, "fine"));
  EXPECT_TRUE(layout.is_complete());
  EXPECT_EQ(layout.list(hil::CatalogKind::kBody)[0].name, "?<&?");
  const std::string text = write_xtce(layout);
  EXPECT_NE(text.find("alias=\"?&lt;&amp;?.x\""), std::string::npos);
  EXPECT_EQ(text, write_xtce(layout));
}

// Any messages that are well formed: nothing but packets of a right length.
TEST(SpacePackets, RandomMessagesMakeWholePackets) {
  constexpr unsigned kSeed = 7;
  SCOPED_TRACE("seed " + std::to_string(kSeed));
  std::mt19937 random(kSeed);
  SessionLayout layout;
  SpacePacketWriter writer;
  SpacePacket packet;
  int written = 0;
  for (int i = 0; i < 20000; ++i) {
    hil::Message message;
    const auto kind = static_cast<hil::MessageKind>(random() % hil::kMessageKinds);
    std::array<std::uint8_t, hil::kMaxWireBytes> bytes{};
    hil::Message empty;
    empty.kind = kind;
    std::memset(reinterpret_cast<char*>(&empty) + offsetof(hil::Message, hello), 0, hil::get_size(kind));
    const std::size_t length = encode(empty, bytes);
    for (std::size_t k = 16; k < length; ++k)
      if (random() % 4 == 0) bytes[k] = static_cast<std::uint8_t>(random() % 3 == 0 ? random() : random() % 8);
    if (!decode(kind, {bytes.data(), length}, message) || !is_well_formed(message)) continue;
    layout.hear(message);
    if (!writer.write(message, layout, packet)) continue;
    ++written;
    ASSERT_EQ(static_cast<std::size_t>(packet[4] << 8 | packet[5]), packet.size() - 7);
  }
  EXPECT_GT(written, 100);
}

TEST(SendQueue, HoldsWhatItMayAndCountsWhatItDrops) {
  bridge::SendQueue queue;
  const auto block = std::make_shared<const std::string>(bridge::SendQueue::kMostBytes / 4, 'x');
  for (int i = 0; i < 4; ++i) EXPECT_TRUE(queue.push({block}));
  EXPECT_FALSE(queue.push({block}));
  EXPECT_FALSE(queue.push({std::make_shared<const std::string>("x")}));
  EXPECT_EQ(queue.get_dropped(), 2);
  queue.pop();
  EXPECT_TRUE(queue.push({block}));
  for (int i = 0; i < 4; ++i) queue.pop();
  EXPECT_TRUE(queue.is_empty());
}

std::int64_t count_lost(std::initializer_list<std::int64_t> numbers) {
  bridge::SequenceGaps gaps;
  for (const std::int64_t number : numbers) gaps.hear(number);
  return gaps.get_lost();
}

TEST(SequenceGaps, NumbersThatNeverComeAreLost) {
  EXPECT_EQ(count_lost({}), 0);
  EXPECT_EQ(count_lost({7, 8, 9}), 0);    // what came before the first one heard is no loss
  EXPECT_EQ(count_lost({7, 10, 12}), 3);  // 8, 9, 11
  EXPECT_EQ(count_lost({7, 1345, 1346}), 1337);
}

TEST(SequenceGaps, NumbersThatComeLateOrTwiceAreNone) {
  EXPECT_EQ(count_lost({7, 9, 8, 10}), 0);
  EXPECT_EQ(count_lost({7, 7, 8, 8, 9, 8}), 0);
  EXPECT_EQ(count_lost({7, 10, 9, 9}), 1);  // 8
  EXPECT_EQ(count_lost({7, 8, 6, 3}), 0);   // before the first
  EXPECT_EQ(count_lost({0, 200, 199, 199, 198}), 197);
  EXPECT_EQ(count_lost({0, 200, 100}), 199);  // later than anybody waits: it stays lost
  EXPECT_EQ(count_lost({5, -1, 6}), 0);       // a message without a number
}

}  // namespace
}  // namespace unlatch::test
