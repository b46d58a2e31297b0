// Connections of the executive: rings, their threads, direct to a port. For ThreadSanitizer as well.
#include <gtest/gtest.h>

#include <array>
#include <thread>

#include "bridge/core/threaded_connection.h"
#include "tests/support/malloc_guard.h"

namespace unlatch::test {
namespace {

using namespace std::chrono_literals;
using hil::Message;

Message make_state(std::int64_t tick) {
  hil::StateMessage state{};
  state.tick = tick;
  state.parts = 1;
  state.bodies.back().wz = static_cast<double>(tick);
  return state;
}

hil::CommandMessage make_command(std::int64_t sequence) {
  hil::CommandMessage command{};
  command.sequence = sequence;
  return command;
}

std::int64_t get_sequence(const hil::Arrival& arrival) {
  return std::get<hil::CommandMessage>(arrival.message).sequence;
}

TEST(RingConnection, AFullRingRefusesAndCounts) {
  hil::RingConnection connection(4, 2);
  for (std::int64_t tick = 0; tick < 4; ++tick) EXPECT_TRUE(connection.send(make_state(tick)));
  EXPECT_FALSE(connection.send(make_state(4)));
  EXPECT_FALSE(connection.send(make_state(5)));
  EXPECT_EQ(connection.get_dropped_out(), 2);
  EXPECT_TRUE(connection.deliver(make_command(0)));
  EXPECT_TRUE(connection.deliver(make_command(1)));
  EXPECT_FALSE(connection.deliver(make_command(2)));
  EXPECT_EQ(connection.get_dropped_in(), 1);

  Message message;
  for (std::int64_t tick = 0; tick < 4; ++tick) {
    ASSERT_TRUE(connection.take(message));
    EXPECT_EQ(message.state.tick, tick);
  }
  EXPECT_FALSE(connection.take(message));
  EXPECT_TRUE(connection.send(make_state(6)));  // there is room again
}

hil::CommandMessage make_command_of(std::int32_t participant) {
  hil::CommandMessage command{};
  command.participant = participant;
  return command;
}

TEST(RingConnection, ASenderThatFloodsLeavesPlacesToTheOthers) {
  constexpr int kPlaces = 1024;
  hil::RingConnection connection(4, kPlaces);
  for (int i = 0; i < 10 * kPlaces; ++i) connection.deliver(make_command_of(1));
  EXPECT_EQ(connection.get_dropped_in(), 9 * kPlaces);
  int taken = 0;
  while (connection.deliver(make_command_of(2))) ++taken;
  EXPECT_EQ(taken, kPlaces / 2);
  EXPECT_TRUE(connection.deliver(make_command_of(3)));
  EXPECT_TRUE(connection.deliver(hil::HelloMessage{}));

  hil::Arrival arrival;
  for (int i = 0; i < kPlaces; ++i) ASSERT_TRUE(connection.receive(arrival));
  while (connection.receive(arrival)) {
  }
  for (int i = 0; i < kPlaces; ++i) EXPECT_TRUE(connection.deliver(make_command_of(1))) << i;
  EXPECT_FALSE(connection.deliver(make_command_of(1)));
}

TEST(RingConnection, FloodsOfManyNumbersLeavePlaces) {
  hil::RingConnection connection(4, 1024);
  for (int i = 0; i < 100'000; ++i) connection.deliver(make_command_of(1 + i % 31));
  for (int i = 0; i < 30; ++i) EXPECT_TRUE(connection.deliver(make_command_of(0))) << i;
}

TEST(RingConnection, NeitherRingsNorCodecAllocate) {
  if (!kCountsAllocations) GTEST_SKIP() << "this build's malloc belongs to a sanitizer";
  hil::RingConnection connection(4, 4);
  Message message = make_state(7);
  hil::Arrival arrival;
  std::array<std::uint8_t, hil::kMaxWireBytes> bytes{};
  const AllocationCount count;
  for (int round = 0; round < 10; ++round) {  // more than full, then empty, past the ring's end
    for (int i = 0; i < 6; ++i) connection.send(message);
    for (int i = 0; i < 6; ++i) connection.deliver(make_command(i));
    while (connection.take(message) && connection.receive(arrival)) {
    }
    const std::size_t length = hil::encode(message, bytes);
    ASSERT_TRUE(hil::decode(hil::MessageKind::kState, std::span(bytes).first(length), message));
  }
  EXPECT_EQ(count.get(), 0);
}

TEST(RingConnection, ThreadsExchangeEverythingInOrder) {
  constexpr std::int64_t kMessages = 20000;
  hil::RingConnection connection(64, 64);
  std::thread bridge([&connection] {
    Message message;
    for (std::int64_t expected = 0; expected < kMessages;) {
      if (!connection.take(message)) {
        std::this_thread::yield();
        continue;
      }
      ASSERT_EQ(message.state.tick, expected);
      ASSERT_EQ(message.state.bodies.back().wz, static_cast<double>(expected));
      while (!connection.deliver(make_command(expected))) std::this_thread::yield();
      ++expected;
    }
  });
  hil::Arrival arrival;
  std::int64_t sent = 0;
  std::int64_t answered = 0;
  while (answered < kMessages) {
    if (sent < kMessages && sent - answered < 32 && connection.send(make_state(sent))) ++sent;
    while (connection.receive(arrival)) ASSERT_EQ(get_sequence(arrival), answered++);
    if (sent - answered >= 32) std::this_thread::yield();
  }
  bridge.join();
}

TEST(ThreadedConnection, ServesALockstepBothWays) {
  constexpr std::int64_t kTicks = 500;
  bridge::InprocHub hub;
  const auto simulator = hub.open(bridge::Role::kSimulator);
  const auto participant = hub.open(bridge::Role::kParticipant);
  bridge::ThreadedConnection connection(*simulator);
  std::thread flight_software([&participant] {
    Message message;
    for (std::int64_t tick = 0; tick < kTicks; ++tick) {
      ASSERT_TRUE(participant->poll(message, 10s));
      ASSERT_EQ(message.state.tick, tick);
      participant->publish(make_command(tick));
    }
  });
  hil::Arrival arrival;
  for (std::int64_t tick = 0; tick < kTicks; ++tick) {
    ASSERT_TRUE(connection.send(make_state(tick)));
    while (!connection.receive(arrival)) std::this_thread::yield();
    ASSERT_EQ(get_sequence(arrival), tick);
  }
  flight_software.join();
}

TEST(ThreadedConnection, PublishesWhatIsLeftBeforeItStops) {
  constexpr std::int64_t kMessages = 700;
  bridge::InprocHub hub;
  const auto simulator = hub.open(bridge::Role::kSimulator);
  const auto observer = hub.open(bridge::Role::kObserver);
  bridge::ThreadedConnection connection(*simulator, 1024, 16);
  for (std::int64_t tick = 0; tick < kMessages; ++tick) ASSERT_TRUE(connection.send(make_state(tick)));
  connection.stop();
  connection.stop();
  EXPECT_EQ(simulator->get_counts().published, kMessages);
  Message message;
  for (std::int64_t tick = 0; tick < kMessages; ++tick) {
    ASSERT_TRUE(observer->poll(message, 0ns));
    ASSERT_EQ(message.state.tick, tick);
  }
}

TEST(InprocPort, KeepsTheNewestAndCountsTheRest) {
  bridge::InprocHub hub(3);
  const auto simulator = hub.open(bridge::Role::kSimulator);
  const auto observer = hub.open(bridge::Role::kObserver);
  for (std::int64_t tick = 0; tick < 5; ++tick) EXPECT_TRUE(simulator->publish(make_state(tick)));
  Message message;
  for (std::int64_t tick = 2; tick < 5; ++tick) {
    ASSERT_TRUE(observer->poll(message, 0ns));
    EXPECT_EQ(message.state.tick, tick);
  }
  EXPECT_FALSE(observer->poll(message, 0ns));
  EXPECT_EQ(observer->get_counts().lost, 2);
  EXPECT_EQ(observer->get_counts().received, 3);
}

}  // namespace
}  // namespace unlatch::test
