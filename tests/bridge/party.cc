// A second process for the transport tests, started by them.
//   bridge_party TRANSPORT record   observes; writes each kind's first message to standard output as it is in
//                                   memory; ends when it has seen all kinds
//   bridge_party TRANSPORT answer   participates; answers everything with a command and an acknowledgement, Hello with
//                                   a HelloAck before; ends at the first Health
//   bridge_party TRANSPORT watch N  N observers; writes a line when all have heard a State; ends at the first Health
//   bridge_party TRANSPORT stunt    sends three commands whose bytes are too few
// TRANSPORT: dds, lcm or udp.
// Exit code 0; 1 if ten seconds pass without a message; 3 with the reason on standard error if the port cannot be
// opened.
#include <arpa/inet.h>
#include <dds/dds.h>
#include <lcm/lcm.h>
#include <sys/socket.h>

#include <array>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string_view>
#include <thread>
#include <vector>

#include "bridge/core/datagram_receiver.h"
#include "bridge/core/port.h"
#include "bridge/udp/udp_packet.h"
#include "unlatch.h"

namespace {

using namespace std::chrono_literals;
using namespace unlatch;
using bridge::Port;

constexpr auto kPatience = 10s;
constexpr int kStunted = 3;

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
  hil::CommandMessage command{};
  hil::StepAckMessage ack{};
  hil::Message message;
  while (port.poll(message, kPatience)) {
    if (message.kind == hil::MessageKind::kHealth) return 0;
    ack.last_command = ++command.sequence;
    if (message.kind == hil::MessageKind::kHello) {
      hil::HelloAckMessage hello_ack{};
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

// Writes samples of a shorter type under the name of unlatch::Command, like a participant with another schema that does
// not announce its types.
int write_stunted_commands() {
  const dds_topic_descriptor_t& other = unlatch_StepAck_desc;
  const dds_topic_descriptor_t stunted{.m_size = other.m_size,
                                       .m_align = other.m_align,
                                       .m_flagset = other.m_flagset & ~std::uint32_t{DDS_TOPIC_XTYPES_METADATA},
                                       .m_nkeys = 0,
                                       .m_typename = unlatch_Command_desc.m_typename,
                                       .m_keys = nullptr,
                                       .m_nops = other.m_nops,
                                       .m_ops = other.m_ops,
                                       .m_meta = "",
                                       .type_information = {},
                                       .type_mapping = {},
                                       .restrict_data_representation = 0};
  const auto port = bridge::open_dds_port(bridge::Role::kObserver);  // opens the domain, on the loopback interface
  const dds_entity_t stranger = dds_create_participant(0, nullptr, nullptr);
  const dds_entity_t topic = dds_create_topic(stranger, &stunted, "unlatch_Command", nullptr, nullptr);
  if (topic < 0) return 1;
  dds_qos_t* qos = dds_create_qos();
  dds_qset_reliability(qos, DDS_RELIABILITY_RELIABLE, DDS_SECS(1));
  dds_qset_history(qos, DDS_HISTORY_KEEP_LAST, 64);
  dds_qset_durability(qos, DDS_DURABILITY_TRANSIENT_LOCAL);
  const dds_entity_t writer = dds_create_writer(stranger, topic, qos, nullptr);
  dds_delete_qos(qos);
  dds_publication_matched_status_t matched{};
  for (int i = 0; i < 1000 && matched.current_count < 2; ++i) {
    dds_get_publication_matched_status(writer, &matched);
    std::this_thread::sleep_for(1ms);
  }
  if (matched.current_count < 2) return 1;  // this program's observer, and the simulator
  const unlatch_StepAck sample{};
  for (int i = 0; i < kStunted; ++i) dds_write(writer, &sample);
  dds_write_flush(writer);  // the domain batches
  dds_wait_for_acks(writer, DDS_SECS(1));
  std::this_thread::sleep_for(100ms);
  dds_delete(stranger);
  return 0;
}

int publish_stunted_commands() {
  std::array<std::uint8_t, hil::kCommandWireBytes> bytes{};
  lcm_t* lcm = lcm_create(bridge::LcmOptions{}.url.c_str());
  if (lcm == nullptr) return 1;
  for (int i = 0; i < kStunted; ++i) {
    lcm_publish(lcm, "UNLATCH_COMMAND", bytes.data(), static_cast<unsigned>(bytes.size()) - 1);
  }
  std::this_thread::sleep_for(100ms);
  lcm_destroy(lcm);
  return 0;
}

// Sends commands of UDP that are too short, in valid datagrams.
int send_stunted_commands() {
  const bridge::Descriptor socket(bridge::open_datagram_socket("UDP"));
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(7670);
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  if (connect(socket.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) return 1;
  std::array<std::uint8_t, bridge::kMaxUdpBytes> datagram{};
  const auto send = [&](std::size_t length) { (void)!::send(socket.get(), datagram.data(), length, 0); };
  send(bridge::build_udp_join({.run = 1, .sequence = 0}, bridge::Role::kParticipant, datagram));
  for (std::uint32_t i = 1; i <= kStunted; ++i) {
    send(bridge::seal_udp_message({.run = 1, .sequence = i}, hil::MessageKind::kCommand, datagram,
                                  hil::kCommandWireBytes - 1));
  }
  std::this_thread::sleep_for(100ms);
  return 0;
}

OpenPort find_transport(std::string_view name) {
  if (name == "dds") return [](bridge::Role role) { return bridge::open_dds_port(role); };
  if (name == "udp") return [](bridge::Role role) { return bridge::open_udp_port(role); };
  return [](bridge::Role role) { return bridge::open_lcm_port(role); };
}

}  // namespace

int main(int count, char** arguments) {
  if (count < 3) return 2;
  const std::string_view what = arguments[2];
  if (what == "stunt") {
    const std::string_view transport = arguments[1];
    if (transport == "udp") return send_stunted_commands();
    return transport == "dds" ? write_stunted_commands() : publish_stunted_commands();
  }
  const OpenPort open = find_transport(arguments[1]);
  try {
    if (what == "watch") return count == 4 ? watch(open, std::atoi(arguments[3])) : 2;
    if (what == "record") return record(*open(bridge::Role::kObserver));
    return answer(*open(bridge::Role::kParticipant));
  } catch (const bridge::PortError& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 3;
  }
}
