// The UDP transport: its datagrams, and its hub's treatment of unknown senders, repetitions and gaps.
#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <array>
#include <chrono>
#include <cmath>
#include <string>
#include <vector>

#include "bridge/core/datagram_receiver.h"
#include "bridge/udp/udp_packet.h"

namespace unlatch::test {
namespace {

using namespace std::chrono_literals;
using bridge::Port;
using bridge::Role;
using bridge::UdpHeader;
using hil::Message;
using hil::MessageKind;

constexpr auto kPatience = 10s;  // wait for an expected message
constexpr auto kQuiet = 100ms;   // wait for an unexpected message

std::vector<std::uint8_t> build_datagram(const UdpHeader& header, const Message& message) {
  std::vector<std::uint8_t> datagram(bridge::kMaxUdpBytes);
  const std::size_t length = hil::encode(message, std::span(datagram).subspan(bridge::kUdpHeaderBytes));
  datagram.resize(bridge::seal_udp_message(header, message.kind, datagram, length));
  return datagram;
}

std::vector<std::uint8_t> build_join(const UdpHeader& header, Role role) {
  std::vector<std::uint8_t> datagram(bridge::kMaxUdpBytes);
  datagram.resize(bridge::build_udp_join(header, role, datagram));
  return datagram;
}

TEST(UdpPacket, ChecksumIsThatOfZlib) {
  const std::string text = "123456789";  // the check value of CRC-32/ISO-HDLC
  EXPECT_EQ(bridge::calc_crc32({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()}), 0xcbf43926U);
}

TEST(UdpPacket, IsReadAsItWasWritten) {
  hil::CommandMessage command;
  command.value = -0.0;
  const auto datagram = build_datagram({.run = 0xfedcba98, .sequence = 7}, command);
  const auto packet = bridge::read_udp_packet(datagram);
  ASSERT_TRUE(packet);
  EXPECT_EQ(packet->header.run, 0xfedcba98U);
  EXPECT_EQ(packet->header.sequence, 7U);
  EXPECT_EQ(packet->kind, MessageKind::kCommand);
  Message read;
  ASSERT_TRUE(hil::decode(*packet->kind, packet->payload, read));
  EXPECT_TRUE(std::signbit(read.command.value));
  const auto join = build_join({.run = 1, .sequence = 0}, Role::kParticipant);
  const auto joined = bridge::read_udp_packet(join);
  ASSERT_TRUE(joined);
  EXPECT_FALSE(joined->kind);
  EXPECT_EQ(joined->role, Role::kParticipant);
}

TEST(UdpPacket, AChangeOfAnyBitOrLengthIsNoticed) {
  const auto datagram = build_datagram({.run = 1, .sequence = 2}, hil::StepAckMessage{});
  for (std::size_t bit = 0; bit < 8 * datagram.size(); ++bit) {
    auto changed = datagram;
    changed[bit / 8] ^= static_cast<std::uint8_t>(1U << bit % 8);
    EXPECT_FALSE(bridge::read_udp_packet(changed)) << "bit " << bit;
  }
  for (std::size_t length = 0; length < datagram.size(); ++length) {
    EXPECT_FALSE(bridge::read_udp_packet(std::span(datagram).first(length))) << length;
  }
  auto longer = datagram;
  longer.push_back(0);
  EXPECT_FALSE(bridge::read_udp_packet(longer));
}

TEST(UdpSequence, RefusesWhatIsLateOrRepeatedAndCountsGaps) {
  bridge::UdpSequence sequence;
  EXPECT_TRUE(sequence.accept({.run = 1, .sequence = 100}));  // received from there on
  EXPECT_FALSE(sequence.accept({.run = 1, .sequence = 100}));
  EXPECT_TRUE(sequence.accept({.run = 1, .sequence = 103}));
  EXPECT_FALSE(sequence.accept({.run = 1, .sequence = 101}));
  EXPECT_EQ(sequence.get_lost(), 2);
  EXPECT_TRUE(sequence.accept({.run = 2, .sequence = 0})) << "a sender that has started again";
  EXPECT_TRUE(sequence.accept({.run = 3, .sequence = 0xffffffff}));
  EXPECT_TRUE(sequence.accept({.run = 3, .sequence = 0})) << "past its largest number";
  EXPECT_EQ(sequence.get_lost(), 2);
}

// A socket that sends and receives datagrams only.
class Stranger {
 public:
  explicit Stranger(std::uint16_t port) : socket_(bridge::open_datagram_socket("test")) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(port);
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    EXPECT_EQ(connect(socket_.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
  }
  void send(std::span<const std::uint8_t> datagram) const {
    EXPECT_EQ(::send(socket_.get(), datagram.data(), datagram.size(), 0), static_cast<ssize_t>(datagram.size()));
  }
  [[nodiscard]] bool hears() const {
    std::array<std::uint8_t, 65536> bytes{};
    return recv(socket_.get(), bytes.data(), bytes.size(), 0) > 0;
  }

 private:
  const bridge::Descriptor socket_;
};

// Returns a free port of the loopback interface.
std::uint16_t find_free_port() {
  const bridge::Descriptor socket(bridge::open_datagram_socket("test"));
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof address;
  EXPECT_EQ(bind(socket.get(), reinterpret_cast<const sockaddr*>(&address), size), 0);
  EXPECT_EQ(getsockname(socket.get(), reinterpret_cast<sockaddr*>(&address), &size), 0);
  return ntohs(address.sin_port);
}

class UdpHub : public testing::Test {
 protected:
  [[nodiscard]] std::unique_ptr<Port> open(Role role) const { return bridge::open_udp_port(role, {address_}); }

  const std::uint16_t port_ = find_free_port();
  const std::string address_ = "127.0.0.1:" + std::to_string(port_);
  Message heard_;
};

TEST_F(UdpHub, HearsOnlyThoseThatHaveJoined) {
  const auto simulator = open(Role::kSimulator);
  const Stranger stranger(port_);
  hil::CommandMessage command;
  stranger.send(build_datagram({.run = 1, .sequence = 0}, command));
  EXPECT_FALSE(simulator->poll(heard_, kQuiet));
  stranger.send(build_join({.run = 1, .sequence = 1}, Role::kParticipant));
  stranger.send(build_datagram({.run = 1, .sequence = 2}, command));
  EXPECT_TRUE(simulator->poll(heard_, kPatience));
  ASSERT_TRUE(simulator->publish(hil::StateMessage{}));
  EXPECT_TRUE(stranger.hears());
}

TEST_F(UdpHub, TakesNothingFromObserversAndNothingTwice) {
  const auto simulator = open(Role::kSimulator);
  const Stranger observer(port_), participant(port_);
  observer.send(build_join({.run = 1, .sequence = 0}, Role::kObserver));
  participant.send(build_join({.run = 2, .sequence = 0}, Role::kParticipant));
  observer.send(build_datagram({.run = 1, .sequence = 1}, hil::CommandMessage{}));
  participant.send(build_datagram({.run = 2, .sequence = 1}, hil::HelloMessage{}));  // a participant must not send this
  hil::CommandMessage command;
  command.sequence = 5;
  const auto datagram = build_datagram({.run = 2, .sequence = 3}, command);  // 2 is lost
  participant.send(datagram);
  participant.send(datagram);
  ASSERT_TRUE(simulator->poll(heard_, kPatience));
  EXPECT_EQ(heard_.command.sequence, 5);
  EXPECT_FALSE(simulator->poll(heard_, kQuiet));
  EXPECT_EQ(simulator->get_counts().malformed, 2);
  EXPECT_EQ(simulator->get_counts().lost, 1);
}

TEST_F(UdpHub, CountsWhatIsNoDatagramOfOurs) {
  const auto simulator = open(Role::kSimulator);
  const Stranger stranger(port_);
  stranger.send(std::array<std::uint8_t, 3>{1, 2, 3});
  stranger.send(std::vector<std::uint8_t>(60'000, 0x55));
  auto damaged = build_join({.run = 1, .sequence = 0}, Role::kParticipant);
  damaged.back() ^= 2U;
  stranger.send(damaged);
  stranger.send(build_join({.run = 1, .sequence = 0}, Role::kParticipant));
  stranger.send(build_datagram({.run = 1, .sequence = 1}, hil::CommandMessage{}));
  ASSERT_TRUE(simulator->poll(heard_, kPatience));
  EXPECT_EQ(simulator->get_counts().malformed, 3);
}

TEST_F(UdpHub, MayStartAfterItsParticipantsAndAgain) {
  const auto participant = open(Role::kParticipant);
  for (int start = 0; start < 2; ++start) {
    const auto simulator = open(Role::kSimulator);
    bool heard = false;
    for (auto waited = 0ms; waited < kPatience && !heard; waited += 20ms) {
      ASSERT_TRUE(simulator->publish(hil::HelloMessage{}));
      heard = participant->poll(heard_, 20ms);
    }
    EXPECT_TRUE(heard) << "start " << start;
    while (participant->poll(heard_, kQuiet)) {
    }
  }
}

TEST_F(UdpHub, ASecondSimulatorIsToldHowToFindAnotherPort) {
  const auto simulator = open(Role::kSimulator);
  try {
    (void)open(Role::kSimulator);
    FAIL() << "two simulators on one port";
  } catch (const bridge::PortError& error) {
    EXPECT_NE(std::string(error.what()).find("--udp"), std::string::npos) << error.what();
  }
  for (const char* address : {"127.0.0.1", "127.0.0.1:0", "127.0.0.1:70000", "localhost:7670", "127.0.0.1:1x", ":1"}) {
    EXPECT_THROW((void)bridge::open_udp_port(Role::kObserver, {address}), bridge::PortError) << address;
  }
}

}  // namespace
}  // namespace unlatch::test
