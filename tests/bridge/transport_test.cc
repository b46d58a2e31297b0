// The transports; DDS, LCM and UDP over real sockets. Run through tests/support/netns.sh, because LCM needs a
// multicast route.
#include <dds/dds.h>
#include <fcntl.h>
#include <gtest/gtest.h>
#include <lcm/lcm.h>
#include <poll.h>
#include <sys/wait.h>
#include <unistd.h>

#include <iostream>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "bridge/core/port.h"
#include "bridge/lcm/lcm_packets.h"
#include "tests/bridge/random_messages.h"
#include "unlatch.h"

namespace unlatch::test {
namespace {

using namespace std::chrono_literals;
using bridge::Port;
using bridge::Role;
using hil::Message;
using hil::MessageKind;

constexpr std::uint64_t kSeed = 777;
constexpr auto kPatience = 10s;  // wait for an expected message
constexpr auto kRepeatAfter = 20ms;

// Opens ports of one transport that receive each other's messages.
class Transport {
 public:
  explicit Transport(std::string name) : name_(std::move(name)) {}

  std::unique_ptr<Port> open(Role role) {
    if (name_ == "dds") return bridge::open_dds_port(role);
    if (name_ == "lcm") return bridge::open_lcm_port(role);
    if (name_ == "udp") return bridge::open_udp_port(role);
    return hub_.open(role);
  }

 private:
  std::string name_;
  bridge::InprocHub hub_;
};

// Sends `greeting` until the other port receives it.
void greet(Port& from, Port& to, const Message& greeting) {
  Message heard;
  for (auto waited = 0ms; waited < kPatience; waited += kRepeatAfter) {
    ASSERT_TRUE(from.publish(greeting));
    while (to.poll(heard, kRepeatAfter)) {
      if (heard.kind == greeting.kind) return;
    }
  }
  FAIL() << "never heard " << hil::get_kind_name(greeting.kind);
}

// Discards messages that are still on the way.
void drain(Port& port) {
  Message message;
  while (port.poll(message, 5 * kRepeatAfter)) {
  }
}

class Transports : public testing::TestWithParam<std::string> {
 protected:
  void SetUp() override {
    std::cout << "seed " << kSeed << '\n';
    simulator_ = transport_.open(Role::kSimulator);
    participant_ = transport_.open(Role::kParticipant);
    observer_ = transport_.open(Role::kObserver);
    greet(*simulator_, *participant_, hil::HelloMessage{});
    greet(*simulator_, *observer_, hil::HelloMessage{});
    greet(*participant_, *simulator_, hil::HelloAckMessage{});
    greet(*participant_, *observer_, hil::HelloAckMessage{});
    for (Port* port : {simulator_.get(), participant_.get(), observer_.get()}) drain(*port);
  }

  Random random_{kSeed};
  Transport transport_{GetParam()};
  std::unique_ptr<Port> simulator_;
  std::unique_ptr<Port> participant_;
  std::unique_ptr<Port> observer_;
};

TEST_P(Transports, EveryMessageArrivesBitForBit) {
  Message heard;
  for (int round = 0; round < 20; ++round) {
    for (const MessageKind kind : list_kinds()) {
      const bool down = hil::is_from_simulator(kind);
      const Message message = make_random_message(kind, random_);
      ASSERT_TRUE((down ? simulator_ : participant_)->publish(message));
      std::vector<Port*> listeners{observer_.get()};
      if (!down || receives(Role::kParticipant, kind))
        listeners.push_back(down ? participant_.get() : simulator_.get());
      for (Port* port : listeners) {
        ASSERT_TRUE(port->poll(heard, kPatience)) << hil::get_kind_name(kind);
        ASSERT_TRUE(is_same(heard, message)) << hil::get_kind_name(kind) << " in round " << round;
      }
    }
  }
  EXPECT_EQ(observer_->get_counts().malformed, 0);
  EXPECT_EQ(observer_->get_counts().lost, 0);
}

TEST_P(Transports, NobodyHearsHimself) {
  Message heard;
  ASSERT_TRUE(simulator_->publish(make_random_message(MessageKind::kState, random_)));
  ASSERT_TRUE(participant_->publish(make_random_message(MessageKind::kCommand, random_)));
  ASSERT_TRUE(simulator_->poll(heard, kPatience));
  EXPECT_EQ(heard.kind, MessageKind::kCommand);
  ASSERT_TRUE(participant_->poll(heard, kPatience));
  EXPECT_EQ(heard.kind, MessageKind::kState);
  EXPECT_FALSE(simulator_->poll(heard, kRepeatAfter));
  EXPECT_FALSE(participant_->poll(heard, kRepeatAfter));
}

TEST_P(Transports, RolesKeepToTheirMessages) {
  EXPECT_FALSE(participant_->publish(hil::StateMessage{}));
  EXPECT_FALSE(simulator_->publish(hil::CommandMessage{}));
  EXPECT_FALSE(observer_->publish(hil::HelloMessage{}));
  Message nothing;
  nothing.kind = static_cast<MessageKind>(99);
  EXPECT_FALSE(participant_->publish(nothing));
  EXPECT_EQ(participant_->get_counts().publish_failures, 2);
  EXPECT_EQ(simulator_->get_counts().publish_failures, 1);
  EXPECT_EQ(observer_->get_counts().publish_failures, 1);
}

TEST_P(Transports, CommandsComeBeforeTheirAcknowledgement) {
  constexpr std::int64_t kTicks = 100;
  for (std::int64_t tick = 1; tick <= kTicks; ++tick) {
    hil::CommandMessage command{};
    command.sequence = tick;
    hil::StepAckMessage ack{};
    ack.last_command = tick;
    ASSERT_TRUE(participant_->publish(command));
    ASSERT_TRUE(participant_->publish(ack));
  }
  std::int64_t last_command = 0;
  Message heard;
  for (std::int64_t acks = 0; acks < kTicks;) {
    ASSERT_TRUE(simulator_->poll(heard, kPatience));
    if (heard.kind == MessageKind::kCommand) {
      EXPECT_EQ(heard.command.sequence, last_command + 1);
      last_command = heard.command.sequence;
    } else {
      EXPECT_EQ(heard.step_ack.last_command, ++acks);
      EXPECT_GE(last_command, heard.step_ack.last_command);
    }
  }
}

TEST_P(Transports, CountsOutOfRangeAreMalformed) {
  hil::StateMessage state{};
  state.parts = 1;
  state.body_count = static_cast<std::int32_t>(hil::kBodiesPerPart) + 1;
  ASSERT_TRUE(simulator_->publish(state));
  state.body_count = 0;
  ASSERT_TRUE(simulator_->publish(state));
  Message heard;
  ASSERT_TRUE(participant_->poll(heard, kPatience));
  EXPECT_EQ(heard.state.body_count, 0);
  EXPECT_EQ(participant_->get_counts().malformed, 1);
}

// UDP has one simulator to an address.
TEST_P(Transports, ASimulatorHearsAnotherOfItsSessionNumberButNeverItself) {
  if (GetParam() == "udp") return;
  const std::unique_ptr<Port> second = transport_.open(Role::kSimulator);
  Port* const both[] = {simulator_.get(), second.get()};
  Message heard;
  for (std::int32_t round = 0; round < 2; ++round) {
    for (const int sender : {0, 1}) {
      hil::HelloMessage hello;
      hello.session = 4711;
      hello.body_count = sender;
      Port& other = *both[1 - sender];
      greet(*both[sender], other, hello);
      while (both[sender]->poll(heard, 5 * kRepeatAfter)) EXPECT_NE(heard.hello.body_count, sender);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(All, Transports, testing::Values("inproc", "dds", "lcm", "udp"),
                         [](const auto& test) { return test.param; });

// A property: a gateway from DDS to LCM and another one back to DDS keep all bits of every message.
TEST(Gateway, DdsToLcmAndBackIsBitExact) {
  constexpr int kRounds = 100;
  std::cout << "seed " << kSeed << '\n';
  Random random(kSeed);
  for (const Role role : {Role::kSimulator, Role::kParticipant}) {
    std::unique_ptr<Port> senders[] = {bridge::open_dds_port(role), bridge::open_lcm_port(role),
                                       bridge::open_dds_port(role, {.domain = 7})};
    std::unique_ptr<Port> hearers[] = {bridge::open_dds_port(Role::kObserver), bridge::open_lcm_port(Role::kObserver),
                                       bridge::open_dds_port(Role::kObserver, {.domain = 7})};
    for (std::size_t i = 0; i < 3; ++i) {
      for (const MessageKind kind : list_kinds()) {
        if (bridge::publishes(role, kind)) greet(*senders[i], *hearers[i], make_random_message(kind, random));
      }
      drain(*hearers[i]);
    }
    for (int round = 0; round < kRounds; ++round) {
      for (const MessageKind kind : list_kinds()) {
        if (!bridge::publishes(role, kind)) continue;
        const Message original = make_random_message(kind, random);
        Message passed = original;
        for (std::size_t i = 0; i < 3; ++i) {
          ASSERT_TRUE(senders[i]->publish(passed));
          ASSERT_TRUE(hearers[i]->poll(passed, kPatience)) << hil::get_kind_name(kind) << ", leg " << i;
          ASSERT_TRUE(is_same(passed, original)) << hil::get_kind_name(kind) << ", leg " << i << ", round " << round;
        }
      }
    }
  }
}

// Runs bridge_party in another process; gives its output, and its exit code once it has ended.
class Party {
 public:
  explicit Party(const std::string& arguments, const std::string& before = "")
      : pipe_(popen((before + BRIDGE_PARTY " " + arguments).c_str(), "r")) {
    fcntl(fileno(pipe_), F_SETFL, O_NONBLOCK);
  }
  ~Party() { close(); }

  // Reads the available output; false at its end.
  bool read(std::chrono::milliseconds wait) {
    pollfd waiting{.fd = fileno(pipe_), .events = POLLIN, .revents = 0};
    if (::poll(&waiting, 1, static_cast<int>(wait.count())) <= 0) return true;
    std::array<char, 4096> bytes{};
    const ssize_t count = ::read(waiting.fd, bytes.data(), bytes.size());
    if (count > 0) output_.insert(output_.end(), bytes.begin(), bytes.begin() + count);
    return count > 0;
  }

  int close() {
    if (pipe_ != nullptr) status_ = pclose(pipe_);
    pipe_ = nullptr;
    return WIFEXITED(status_) ? WEXITSTATUS(status_) : -1;
  }

  [[nodiscard]] const std::vector<char>& get_output() const { return output_; }

 private:
  FILE* pipe_;
  std::vector<char> output_;
  int status_ = 0;
};

class Processes : public testing::TestWithParam<std::string> {};

TEST_P(Processes, HearEveryMessageBitForBit) {
  std::cout << "seed " << kSeed << '\n';
  Random random(kSeed);
  std::vector<Message> messages;
  for (const MessageKind kind : list_kinds()) messages.push_back(make_random_message(kind, random));
  Transport transport(GetParam());
  const auto simulator = transport.open(Role::kSimulator);
  const auto participant = transport.open(Role::kParticipant);
  Party recorder(GetParam() + " record");
  do {
    for (const Message& message : messages) {
      (hil::is_from_simulator(message.kind) ? simulator : participant)->publish(message);
    }
  } while (recorder.read(kRepeatAfter));
  ASSERT_EQ(recorder.close(), 0);

  const char* at = recorder.get_output().data();
  for (std::size_t i = 0; i < hil::kMessageKinds; ++i) {
    Message heard;
    std::memcpy(&heard.kind, at, sizeof heard.kind);
    ASSERT_GT(hil::get_size(heard.kind), 0U);
    std::memcpy(static_cast<void*>(&heard.hello), at + sizeof heard.kind, hil::get_size(heard.kind));
    at += sizeof heard.kind + hil::get_size(heard.kind);
    EXPECT_TRUE(is_same(heard, messages[static_cast<std::size_t>(heard.kind)])) << hil::get_kind_name(heard.kind);
  }
  EXPECT_EQ(at, recorder.get_output().data() + recorder.get_output().size());
}

INSTANTIATE_TEST_SUITE_P(All, Processes, testing::Values("dds", "lcm", "udp"),
                         [](const auto& test) { return test.param; });

// Writer of the only DDS participant of this process for a topic; 0 if there is none.
dds_entity_t find_writer(const std::string& topic) {
  std::array<dds_entity_t, 64> publishers{};  // and topics, subscribers, and more
  std::array<dds_entity_t, 4> writers{};      // each has a publisher of its own
  dds_entity_t participant = 0;
  if (dds_lookup_participant(0, &participant, 1) != 1) return 0;
  const int count = dds_get_children(participant, publishers.data(), publishers.size());
  for (int i = 0; i < count; ++i) {
    if (dds_get_children(publishers[i], writers.data(), writers.size()) < 1) continue;
    std::array<char, 64> name{};
    dds_publication_matched_status_t matched{};
    if (dds_get_publication_matched_status(writers[0], &matched) != DDS_RETCODE_OK) continue;  // a reader
    if (dds_get_name(dds_get_topic(writers[0]), name.data(), name.size()) > 0 && name.data() == topic)
      return writers[0];
  }
  return 0;
}

// Waits until somebody reads a topic: what is written there before is lost.
void await_reader(const std::string& topic) {
  const dds_entity_t writer = find_writer(topic);
  ASSERT_GT(writer, 0);
  dds_publication_matched_status_t matched{};
  for (auto waited = 0ms; waited < kPatience && matched.current_count == 0; waited += 1ms) {
    std::this_thread::sleep_for(1ms);
    ASSERT_EQ(dds_get_publication_matched_status(writer, &matched), DDS_RETCODE_OK);
  }
  ASSERT_GT(matched.current_count, 0) << "nobody reads " << topic;
}

// Every topic finds its readers separately and at different times. Hello and State are repeated until they are
// answered, as the protocol demands; no message of the participant after its HelloAck is lost.
TEST(Dds, CommandsOfTheFirstMomentArrive) {
  for (int round = 0; round < 5; ++round) {
    SCOPED_TRACE(round);
    const auto simulator = bridge::open_dds_port(Role::kSimulator);
    Party participant("dds answer");
    std::set<std::int64_t> commands;
    Message heard;
    // Sends a message until the answer arrives, noting the commands that arrive before.
    const auto say = [&](const Message& message, const auto& is_answer) {
      for (auto waited = 0ms; waited < kPatience; waited += kRepeatAfter) {
        ASSERT_TRUE(simulator->publish(message));
        while (simulator->poll(heard, kRepeatAfter)) {
          if (is_answer()) return;
          if (heard.kind == MessageKind::kCommand) commands.insert(heard.command.sequence);
        }
      }
      FAIL() << "no answer to " << hil::get_kind_name(message.kind);
    };
    say(hil::HelloMessage{}, [&] { return heard.kind == MessageKind::kHelloAck; });
    const std::int64_t first = heard.hello_ack.participant;  // see party.cc: the number of the command that follows
    hil::StateMessage state{};
    state.parts = 1;
    state.tick = 1;
    say(state, [&] { return heard.kind == MessageKind::kStepAck && heard.step_ack.tick == 1; });
    const std::int64_t last = heard.step_ack.last_command;
    const auto all_came = [&] {
      return std::distance(commands.lower_bound(first), commands.upper_bound(last)) == last - first + 1;
    };
    while (!all_came()) {
      ASSERT_TRUE(simulator->poll(heard, kPatience)) << "lost some of " << first << " to " << last;
      if (heard.kind == MessageKind::kCommand) commands.insert(heard.command.sequence);
    }
    await_reader("unlatch_Health");
    ASSERT_TRUE(simulator->publish(hil::HealthMessage{}));
    EXPECT_EQ(participant.close(), 0);
  }
}

TEST(Dds, AnEmptyConfigurationOfTheUserIsNone) {
  ASSERT_EQ(setenv("CYCLONEDDS_URI", "", 1), 0);
  EXPECT_EQ(bridge::describe(bridge::DdsOptions{}),
            "DDS, domain 0, on the interface 'lo': this machine only; every process there may listen and command");
  ASSERT_EQ(setenv("CYCLONEDDS_URI", "<General/>", 1), 0);
  EXPECT_NE(bridge::describe(bridge::DdsOptions{}).find("as CYCLONEDDS_URI configures it"), std::string::npos);
  ASSERT_EQ(unsetenv("CYCLONEDDS_URI"), 0);
}

// The first packets of the last message are lost; the port repeats it before it closes.
TEST(Dds, WhatIsSaidLastIsHeard) {
  constexpr auto kMute = 200ms;
  auto simulator = bridge::open_dds_port(Role::kSimulator);
  Party watcher("dds watch 1");
  hil::StateMessage state{};
  state.parts = 1;
  for (auto waited = 0ms; waited < kPatience && watcher.get_output().empty(); waited += kRepeatAfter) {
    ASSERT_TRUE(simulator->publish(state));
    ASSERT_TRUE(watcher.read(kRepeatAfter));
  }
  await_reader("unlatch_Health");
  dds_entity_t participant = 0;
  ASSERT_EQ(dds_lookup_participant(0, &participant, 1), 1);
  ASSERT_EQ(dds_domain_set_deafmute(participant, false, true, std::chrono::nanoseconds(kMute).count()), DDS_RETCODE_OK);
  ASSERT_TRUE(simulator->publish(hil::HealthMessage{}));
  simulator.reset();
  EXPECT_EQ(watcher.close(), 0);
}

TEST(Dds, LateJoinersGetHelloCatalogAndEvents) {
  constexpr std::int32_t kItems = 300;
  const auto simulator = bridge::open_dds_port(Role::kSimulator);
  hil::HelloMessage hello{};
  for (int again = 1; again <= 3; ++again) {  // Hello is repeated until answered; a late joiner receives it once
    hello.session = again;
    ASSERT_TRUE(simulator->publish(hello));
    hil::CatalogMessage item{};
    for (item.index = 0; item.index < kItems; ++item.index) {
      item.safe = item.index + 0.5;
      ASSERT_TRUE(simulator->publish(item));
    }
  }
  ASSERT_TRUE(simulator->publish(hil::EventMessage{}));

  const auto late = bridge::open_dds_port(Role::kParticipant);
  std::set<std::int32_t> items;
  int hellos = 0;
  int events = 0;
  Message heard;
  while (hellos < 1 || events < 1 || items.size() < kItems) {
    ASSERT_TRUE(late->poll(heard, kPatience));
    if (heard.kind == MessageKind::kHello) {
      ++hellos;
      EXPECT_EQ(heard.hello.session, 3);
    } else if (heard.kind == MessageKind::kCatalog) {
      EXPECT_TRUE(items.insert(heard.catalog.index).second);
      EXPECT_EQ(heard.catalog.safe, heard.catalog.index + 0.5);
    } else {
      ++events;
    }
  }
  EXPECT_FALSE(late->poll(heard, 5 * kRepeatAfter));  // nothing arrives twice
}

// A foreign writer with the default quality of service, which keeps no history, would lose commands: it does not match,
// and is counted.
TEST(Dds, AWriterThatDoesNotFitIsCounted) {
  const auto simulator = bridge::open_dds_port(Role::kSimulator);
  const dds_entity_t stranger = dds_create_participant(0, nullptr, nullptr);
  ASSERT_GT(stranger, 0);
  const dds_entity_t topic = dds_create_topic(stranger, &unlatch_Command_desc, "unlatch_Command", nullptr, nullptr);
  ASSERT_GT(dds_create_writer(stranger, topic, nullptr, nullptr), 0);
  for (auto waited = 0ms; waited < kPatience && simulator->get_counts().unfit == 0; waited += kRepeatAfter) {
    std::this_thread::sleep_for(kRepeatAfter);
  }
  EXPECT_EQ(simulator->get_counts().unfit, 1);
  const auto unfit = simulator->list_unfit();
  ASSERT_EQ(unfit.size(), 1u);
  EXPECT_EQ(unfit[0].kind, MessageKind::kCommand);
  EXPECT_FALSE(unfit[0].read);
  EXPECT_EQ(unfit[0].policy, "DURABILITY");
  dds_delete(stranger);
}

// It would wait for ever without a word.
TEST(Dds, AReaderThatDoesNotFitIsCountedWithItsPolicy) {
  const auto simulator = bridge::open_dds_port(Role::kSimulator);
  const dds_entity_t stranger = dds_create_participant(0, nullptr, nullptr);
  ASSERT_GT(stranger, 0);
  const dds_entity_t topic = dds_create_topic(stranger, &unlatch_State_desc, "unlatch_State", nullptr, nullptr);
  dds_qos_t* const qos = dds_create_qos();
  dds_qset_deadline(qos, DDS_MSECS(100));
  ASSERT_GT(dds_create_reader(stranger, topic, qos, nullptr), 0);
  dds_delete_qos(qos);
  std::vector<bridge::UnfitPeers> unfit;
  for (auto waited = 0ms; waited < kPatience && unfit.empty(); waited += kRepeatAfter) {
    std::this_thread::sleep_for(kRepeatAfter);
    unfit = simulator->list_unfit();
  }
  ASSERT_EQ(unfit.size(), 1u);
  EXPECT_EQ(bridge::describe(unfit[0]),
            "unlatch_State: 1 reader of another program does not match (policy DEADLINE), and receives nothing; "
            "bridge/README.md lists the quality of service of each topic");
  EXPECT_EQ(simulator->get_counts().unfit, 1);
  dds_delete(stranger);
}

TEST(Lcm, MalformedBytesAreCounted) {
  Transport transport("lcm");
  const auto simulator = transport.open(Role::kSimulator);
  const auto participant = transport.open(Role::kParticipant);
  greet(*simulator, *participant, hil::HelloMessage{});
  drain(*participant);

  std::array<std::uint8_t, hil::kMaxWireBytes> bytes{};
  hil::StateMessage state{};
  state.parts = 1;
  ASSERT_EQ(hil::encode(state, bytes), hil::kStateWireBytes);
  lcm_t* raw = lcm_create(bridge::LcmOptions{}.url.c_str());
  ASSERT_NE(raw, nullptr);
  const auto send = [&](std::size_t length) {
    return lcm_publish(raw, "UNLATCH_STATE", bytes.data(), static_cast<unsigned int>(length));
  };
  EXPECT_EQ(send(0), 0);
  EXPECT_EQ(send(7), 0);
  EXPECT_EQ(send(hil::kStateWireBytes - 1), 0);
  bytes[0] ^= 1U;  // the fingerprint
  EXPECT_EQ(send(hil::kStateWireBytes), 0);
  bytes[0] ^= 1U;
  EXPECT_EQ(send(hil::kStateWireBytes), 0);  // a good one at last
  lcm_destroy(raw);

  Message heard;
  ASSERT_TRUE(participant->poll(heard, kPatience));
  EXPECT_EQ(heard.kind, MessageKind::kState);
  EXPECT_EQ(participant->get_counts().malformed, 4);
}

// A datagram that liblcm 1.3.1 cannot process, and others that are not well-formed: they are counted, and the next
// message arrives.
TEST(Lcm, DatagramsThatAreNotWellFormedAreCounted) {
  bridge::LcmPackets packets;
  using Result = bridge::LcmPackets::Result;
  bridge::LcmPackets::Packet packet;
  const auto number = [](std::uint32_t value, int bytes) {
    std::string text;
    while (bytes-- > 0) text += static_cast<char>(value >> 8 * bytes & 0xFFU);
    return text;
  };
  const auto fragment = [&](std::uint32_t sequence, std::uint32_t size, std::uint32_t offset, std::uint32_t which,
                            std::uint32_t count, const std::string& bytes) {
    const std::string datagram = number(bridge::kLcmFragment, 4) + number(sequence, 4) + number(size, 4) +
                                 number(offset, 4) + number(which, 2) + number(count, 2) + bytes;
    return packets.accept(1, {reinterpret_cast<const std::uint8_t*>(datagram.data()), datagram.size()}, packet);
  };
  const std::string channel("UNLATCH_STEP_ACK\0", 17);
  EXPECT_EQ(fragment(1, 1000, 0xffffffc0, 0, 2, channel + std::string(100, 'x')), Result::kMalformed);
  EXPECT_EQ(fragment(2, 50, 0, 0, 2, channel + std::string(51, 'x')), Result::kMalformed) << "longer than its message";
  EXPECT_EQ(fragment(3, 50, 0, 2, 2, "x"), Result::kMalformed) << "the third of two";
  EXPECT_EQ(fragment(4, 50, 0, 0, 2, std::string(64, 'x')), Result::kMalformed) << "no channel";
  EXPECT_EQ(fragment(5, 4, 0, 0, 2, channel + "ab"), Result::kPart);
  EXPECT_EQ(fragment(5, 5, 2, 1, 2, "cd"), Result::kMalformed) << "another size than announced";
  EXPECT_EQ(fragment(6, 4, 0, 0, 2, channel + "ab"), Result::kPart);
  EXPECT_EQ(fragment(6, 4, 1, 1, 2, "cd"), Result::kMalformed) << "overlaps";
  EXPECT_EQ(fragment(7, 4, 0, 0, 2, std::string("OTHER\0", 6) + "ab"), Result::kPart);
  EXPECT_EQ(fragment(7, 4, 2, 1, 2, "cd"), Result::kForeign);
  EXPECT_EQ(fragment(8, 4, 2, 1, 2, "cd"), Result::kPart) << "in any order";
  EXPECT_EQ(fragment(8, 4, 2, 1, 2, "cd"), Result::kPart) << "and twice";
  ASSERT_EQ(fragment(8, 4, 0, 0, 2, channel + "ab"), Result::kMessage);
  EXPECT_EQ(std::string(packet.data.begin(), packet.data.end()), "abcd");
}

// Returns the text of the PortError that opening throws.
template <class Open>
std::string get_error(Open open) {
  try {
    open();
  } catch (const bridge::PortError& error) {
    return error.what();
  }
  return "no error";
}

TEST(PortError, SaysWhatIsWrongAndHowToMendIt) {
  const auto dds = [](int domain, const char* interface) {
    return get_error([&] { return bridge::open_dds_port(Role::kObserver, {domain, interface}); });
  };
  EXPECT_NE(dds(231, "lo").find("from 0 to 230"), std::string::npos);
  EXPECT_NE(dds(1, "x\"/><y").find("`ip link`"), std::string::npos);
  EXPECT_NE(dds(1, "nosuch0").find("ip link show nosuch0"), std::string::npos);
  const auto port = bridge::open_dds_port(Role::kObserver, {.domain = 2, .interface = "lo"});
  EXPECT_NE(dds(2, "eth0").find("open in this process on the interface 'lo'"), std::string::npos);
  EXPECT_NE(get_error([] { return bridge::open_lcm_port(Role::kObserver, {"tcpq://"}); }).find("udpm://"),
            std::string::npos);
}

// Runs in a namespace in which even the loopback interface is down.
TEST(PortError, AMachineWithoutANetworkIsExitCode3) {
  for (const std::string transport : {"dds", "lcm"}) {
    Party party(transport + " record 2>&1", "unshare -n ");
    while (party.read(kPatience)) {
    }
    EXPECT_EQ(party.close(), 3) << transport;
    const std::string said(party.get_output().begin(), party.get_output().end());
    EXPECT_NE(said.find(transport == "lcm" ? "ip route replace" : "ip link show lo"), std::string::npos) << said;
  }
}

}  // namespace
}  // namespace unlatch::test
