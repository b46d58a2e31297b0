// A second process for the transport tests, started by them.
//   bridge_party dds|lcm record   observes; writes each kind's first message to standard output as it lies in memory;
//   ends when
//                                 it has seen all kinds
//   bridge_party dds|lcm answer   participates; answers everything with a command and an acknowledgement, Hello with
//                                 a HelloAck before; ends at the first Health
//   bridge_party dds|lcm watch N  N observers; writes a line when all have heard a State; ends at the first Health
// Exit code 0; 1 if ten seconds pass without a message; 3 with the reason on standard error if the port cannot be
// opened.
#include <array>
#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string_view>
#include <thread>
#include <vector>

#include "bridge/port.h"

namespace {

using namespace std::chrono_literals;
using namespace unlatch;
using bridge::Port;

constexpr auto kPatience = 10s;

int record(Port& port) {
  std::array<bool, hil::kMessageKinds> seen{};
  std::size_t count = 0;
  hil::Message message;
  while (count < seen.size()) {
    if (!port.poll(message, kPatience)) return 1;
    bool& known = seen[static_cast<std::size_t>(message.kind)];
    if (known) continue;
    known = true;
    ++count;
    std::fwrite(&message.kind, sizeof message.kind, 1, stdout);
    std::fwrite(&message.hello, hil::get_size(message.kind), 1, stdout);
  }
  return 0;
}

int answer(Port& port) {
  hil::Command command{};
  hil::StepAck ack{};
  hil::Message message;
  while (port.poll(message, kPatience)) {
    if (message.kind == hil::MessageKind::kHealth) return 0;
    ack.last_command = ++command.sequence;
    if (message.kind == hil::MessageKind::kHello) {
      hil::HelloAck hello_ack{};
      hello_ack.participant = static_cast<std::int32_t>(command.sequence);
      port.publish(hello_ack);
    }
    if (message.kind == hil::MessageKind::kState) command.tick = ack.tick = message.state.tick;
    port.publish(command);
    port.publish(ack);
  }
  return 1;
}

using OpenPort = std::unique_ptr<Port> (*)(bridge::Role);

int watch(OpenPort open, int count) {
  std::atomic<int> waiting = count;
  std::atomic<int> silent = 0;
  std::vector<std::jthread> observers;
  for (int i = 0; i < count; ++i) {
    observers.emplace_back([&, port = std::shared_ptr<Port>(open(bridge::Role::kObserver))] {
      hil::Message message;
      bool has_heard = false;
      while (port->poll(message, kPatience)) {
        if (message.kind == hil::MessageKind::kHealth) return;
        if (message.kind != hil::MessageKind::kState || has_heard) continue;
        has_heard = true;
        if (--waiting == 0) std::puts("all have heard"), std::fflush(stdout);
      }
      ++silent;
    });
  }
  observers.clear();  // joins
  return silent > 0;
}

}  // namespace

int main(int count, char** arguments) {
  if (count < 3) return 2;
  const std::string_view what = arguments[2];
  const OpenPort open = arguments[1] == std::string_view("dds")
                            ? [](bridge::Role role) { return bridge::open_dds_port(role); }
                            : [](bridge::Role role) { return bridge::open_lcm_port(role); };
  try {
    if (what == "watch") return count == 4 ? watch(open, std::atoi(arguments[3])) : 2;
    if (what == "record") return record(*open(bridge::Role::kObserver));
    return answer(*open(bridge::Role::kParticipant));
  } catch (const bridge::PortError& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 3;
  }
}
