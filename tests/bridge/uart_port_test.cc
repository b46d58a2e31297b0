// The simulator's end of a serial line; the test is at the other one.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <pty.h>
#include <termios.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <memory>
#include <string>
#include <vector>

#include "bridge/core/port.h"
#include "bridge/uart/frame_reader.h"

namespace unlatch::test {
namespace {

using bridge::MessageKind;
using std::chrono::steady_clock;

constexpr std::chrono::seconds kHang(60);
constexpr int kItems = 50;

class Line {
 public:
  Line() {
    char name[128] = {};
    termios raw{};
    cfmakeraw(&raw);
    EXPECT_EQ(openpty(&end_, &other_, name, &raw, nullptr), 0);
    simulator_ = bridge::open_uart_port(bridge::Role::kSimulator, {.device = name, .baud = 115200});
  }
  ~Line() {
    simulator_.reset();
    close(end_);
    close(other_);
  }
  bridge::Port& simulator() { return *simulator_; }

  void join() {
    std::array<std::uint8_t, bridge::kUdpHeaderBytes + 4> frame{};
    const std::size_t bytes =
        bridge::build_udp_join({.run = 1, .sequence = joins_++}, bridge::Role::kParticipant, frame);
    EXPECT_EQ(write(end_, frame.data(), bytes), static_cast<ssize_t>(bytes));
  }
  // What has come since the last call, after at most `wait`.
  std::vector<hil::Message> read_all(std::chrono::milliseconds wait) {
    pollfd event{end_, POLLIN, 0};
    std::array<std::uint8_t, 4096> bytes{};
    if (poll(&event, 1, static_cast<int>(wait.count())) == 1) {
      const ssize_t count = read(end_, bytes.data(), bytes.size());
      if (count > 0) reader_.push(std::span(bytes).first(static_cast<std::size_t>(count)));
    }
    return std::exchange(came_, {});
  }

 private:
  void accept(const bridge::UdpPacket& packet) {
    hil::Message& message = came_.emplace_back();
    EXPECT_TRUE(packet.kind && hil::decode(*packet.kind, packet.payload, message));
  }

  int end_ = -1, other_ = -1;
  std::uint32_t joins_ = 0;
  std::vector<hil::Message> came_;
  bridge::FrameReader reader_{[this](const bridge::UdpPacket& packet) { accept(packet); }};
  std::unique_ptr<bridge::Port> simulator_;
};

TEST(UartPort, AStateStaysBehindOneDescriptionAndOfEachTheLatestComes) {
  Line line;
  const auto end = steady_clock::now() + kHang;
  for (bool joined = false; !joined && steady_clock::now() < end;) {
    line.join();
    line.simulator().publish(hil::HelloMessage{});
    joined = !line.read_all(std::chrono::milliseconds(20)).empty();
  }
  for (int round = 0; round < 3; ++round) {
    for (int i = 0; i < kItems; ++i) {
      hil::CatalogMessage item;
      item.index = i;
      item.sequence = round * kItems + i;
      EXPECT_TRUE(line.simulator().publish(item));
    }
  }
  EXPECT_TRUE(line.simulator().publish(hil::StateMessage{}));
  std::vector<int> came;  // of each item
  came.resize(kItems);
  std::size_t before_state = 0, items = 0;
  bool state = false;
  while ((!state || std::ranges::count(came, 0) > 0) && steady_clock::now() < end) {
    line.join();
    for (const hil::Message& message : line.read_all(std::chrono::milliseconds(20))) {
      if (message.kind == MessageKind::kState) {
        state = true;
        before_state = items;
      }
      if (message.kind != MessageKind::kCatalog) continue;
      ++items;
      ++came[static_cast<std::size_t>(message.catalog.index)];
      if (state) {
        EXPECT_EQ(message.catalog.sequence, 2 * kItems + message.catalog.index);
      }
    }
  }
  EXPECT_TRUE(state);
  EXPECT_LT(before_state, 10u);  // some leave while the others are published
  EXPECT_EQ(std::ranges::count(came, 0), 0);
  EXPECT_LT(items, std::size_t{kItems} + 10);
}

}  // namespace
}  // namespace unlatch::test
