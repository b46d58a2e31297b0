// Flight software in C++ over another DDS, eProsima's Fast DDS, against nothing but the IDL: takes part in a lockstep
// session of probe.yaml as 'pilot', opens the throttle at tick 100 and shuts it at tick 300.
#include <fastdds/rtps/transport/UDPv4TransportDescriptor.h>

#include <chrono>
#include <condition_variable>
#include <cstdio>
#include <cstring>
#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/DataReaderListener.hpp>
#include <fastdds/dds/subscriber/SampleInfo.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <fastdds/dds/topic/Topic.hpp>
#include <mutex>
#include <string>

#include "unlatchPubSubTypes.h"

namespace {

using namespace eprosima::fastdds::dds;
using Clock = std::chrono::steady_clock;

constexpr int kParticipant = 1003;
constexpr std::int64_t kOpenAt = 100, kShutAt = 300;
constexpr auto kPatience = std::chrono::seconds(30);
constexpr auto kGone = std::chrono::seconds(2);  // a simulator that has been silent for so long is gone

// Loopback alone, as our simulator's default: its participants listen on ports 7410, 7412, …, and there is no
// multicast.
DomainParticipantQos make_participant_qos() {
  DomainParticipantQos qos = PARTICIPANT_QOS_DEFAULT;
  qos.transport().use_builtin_transports = false;
  auto udp = std::make_shared<eprosima::fastdds::rtps::UDPv4TransportDescriptor>();
  udp->interfaceWhiteList.emplace_back("127.0.0.1");
  qos.transport().user_transports.push_back(udp);
  for (std::uint32_t i = 0; i < 10; ++i) {
    eprosima::fastrtps::rtps::Locator_t peer;
    peer.kind = LOCATOR_KIND_UDPv4;
    peer.port = 7410 + 2 * i;
    eprosima::fastrtps::rtps::IPLocator::setIPv4(peer, 127, 0, 0, 1);
    qos.wire_protocol().builtin.initialPeersList.push_back(peer);
  }
  return qos;
}

// Everything is reliable. What must outlive the moments in which both sides discover each other is transient-local.
template <class Qos>
Qos set(Qos qos, bool transient, int depth) {
  qos.reliability().kind = RELIABLE_RELIABILITY_QOS;
  qos.history().kind = KEEP_LAST_HISTORY_QOS;
  qos.history().depth = depth;
  qos.durability().kind = transient ? TRANSIENT_LOCAL_DURABILITY_QOS : VOLATILE_DURABILITY_QOS;
  return qos;
}

class Pilot : public DataReaderListener {
 public:
  Pilot() : participant_(DomainParticipantFactory::get_instance()->create_participant(0, make_participant_qos())) {
    if (participant_ == nullptr) throw std::runtime_error("no participant");
    publisher_ = participant_->create_publisher(PUBLISHER_QOS_DEFAULT);
    subscriber_ = participant_->create_subscriber(SUBSCRIBER_QOS_DEFAULT);
    hello_acks_ = open_writer<unlatch::HelloAckPubSubType>("HelloAck", true);
    commands_ = open_writer<unlatch::CommandPubSubType>("Command", true);
    step_acks_ = open_writer<unlatch::StepAckPubSubType>("StepAck", false);
    hellos_ = open_reader<unlatch::HelloPubSubType>("Hello", true);
    catalog_ = open_reader<unlatch::CatalogPubSubType>("Catalog", true);
    states_ = open_reader<unlatch::StatePubSubType>("State", false);
  }
  ~Pilot() override {
    participant_->delete_contained_entities();
    DomainParticipantFactory::get_instance()->delete_participant(participant_);
  }

  // 0 when the session has come to its planned end.
  int wait() {
    std::unique_lock lock(mutex_);
    for (std::int64_t heard = -1; !ended_; heard = heard_) {
      if (!news_.wait_for(lock, kPatience, [&] { return ended_ || heard_ != heard; })) {
        std::fprintf(stderr, "pilot: the simulator is silent\n");
        return 1;
      }
    }
    std::printf("pilot: the session ended at tick %lld, x = %.6f m\n", static_cast<long long>(end_.tick()),
                end_.bodies()[0].x());
    return end_.status() == unlatch::RunStatus_kDone ? 0 : 1;
  }

 private:
  template <class Type>
  Topic* open_topic(const std::string& name) {
    TypeSupport type(new Type());
    type.register_type(participant_);
    return participant_->create_topic("unlatch_" + name, type.get_type_name(), TOPIC_QOS_DEFAULT);
  }
  template <class Type>
  DataWriter* open_writer(const std::string& name, bool transient) {
    return publisher_->create_datawriter(open_topic<Type>(name), set(DATAWRITER_QOS_DEFAULT, transient, 64));
  }
  template <class Type>
  DataReader* open_reader(const std::string& name, bool transient) {
    return subscriber_->create_datareader(open_topic<Type>(name), set(DATAREADER_QOS_DEFAULT, transient, 256), this);
  }

  void on_data_available(DataReader*) override {
    const std::lock_guard lock(mutex_);
    SampleInfo info;
    unlatch::Hello hello;
    unlatch::Catalog item;
    // States first: they show that our simulator is still there.
    while (states_ != nullptr && states_->take_next_sample(&state_, &info) == ReturnCode_t::RETCODE_OK) {
      if (info.valid_data) hear_state(state_);
    }
    while (hellos_ != nullptr && hellos_->take_next_sample(&hello, &info) == ReturnCode_t::RETCODE_OK) {
      if (info.valid_data) hear_hello(hello);
    }
    while (catalog_ != nullptr && catalog_->take_next_sample(&item, &info) == ReturnCode_t::RETCODE_OK) {
      if (info.valid_data) hear_catalog(item);
    }
    ++heard_;
    news_.notify_one();
  }

  void hear_hello(const unlatch::Hello& hello) {
    if (hello.status() >= unlatch::RunStatus_kDone) return;  // kept from a session that is over
    if (hello.session() != session_) {
      if (session_ != 0 && Clock::now() - heard_at_ < kGone) return warn_of_other(hello);
      session_ = hello.session();
      throttle_ = -1;
      answered_tick_ = -1;
      last_command_ = 0;
      introduction_ = unlatch::HelloAck();
      introduction_.session(session_);
      introduction_.schema_hash(unlatch::kSchemaHash);
      introduction_.protocol(unlatch::kProtocolVersion);
      introduction_.model_hash(hello.model_hash());
      introduction_.dt_ns(hello.dt_ns());
      introduction_.participant(kParticipant);
      introduction_.status(unlatch::AckStatus_kReady);
      std::memcpy(introduction_.name().data(), "pilot", sizeof "pilot");
    }
    heard_at_ = Clock::now();
    introduce();
  }

  // Stays with its session, and says so once.
  void warn_of_other(const unlatch::Hello& hello) {
    if (warned_) return;
    warned_ = true;
    std::fprintf(stderr, "pilot: another simulator is heard, session %lld; stays with session %lld\n",
                 static_cast<long long>(hello.session()), static_cast<long long>(session_));
  }

  void hear_catalog(const unlatch::Catalog& item) {
    if (item.session() != session_ || item.kind() != unlatch::CatalogKind_kChannel) return;
    if (std::strcmp(reinterpret_cast<const char*>(item.name().data()), "throttle") != 0) return;
    const bool news = throttle_ < 0;
    throttle_ = item.index();
    if (news) introduce();
  }

  void introduce() {
    if (session_ == 0 || throttle_ < 0) return;
    hello_acks_->write(&introduction_);
    introduction_.sequence(introduction_.sequence() + 1);
  }

  // A State that is resent is answered again, with the same numbers.
  void hear_state(const unlatch::State& state) {
    if (state.session() != session_ || throttle_ < 0 || state.part() != 0 || ended_) return;
    heard_at_ = Clock::now();
    if (state.status() >= unlatch::RunStatus_kDone) {
      end_ = state;
      ended_ = true;
      return;
    }
    if (state.tick() < answered_tick_) return;
    if (state.tick() > answered_tick_) decide(state);
    if (answer_count_ > 0) commands_->write(&answer_);
    unlatch::StepAck ack;
    ack.session(session_);
    ack.sequence(state.sequence());
    ack.tick(state.tick());
    ack.last_command(last_command_);
    ack.participant(kParticipant);
    ack.command_count(answer_count_);
    step_acks_->write(&ack);
  }

  // The task of flight software: a decision from a state.
  void decide(const unlatch::State& state) {
    answered_tick_ = state.tick();
    answer_count_ = state.tick() == kOpenAt || state.tick() == kShutAt ? 1 : 0;
    answer_.session(session_);
    answer_.sequence(last_command_ += answer_count_);
    answer_.tick(state.tick());
    answer_.valid_until_tick(-1);
    answer_.value(state.tick() == kOpenAt ? 1 : 0);
    answer_.participant(kParticipant);
    answer_.channel(throttle_);
  }

  DomainParticipant* const participant_;
  Publisher* publisher_ = nullptr;
  Subscriber* subscriber_ = nullptr;
  DataReader *hellos_ = nullptr, *catalog_ = nullptr, *states_ = nullptr;
  DataWriter *hello_acks_ = nullptr, *commands_ = nullptr, *step_acks_ = nullptr;

  std::mutex mutex_;
  std::condition_variable news_;
  std::int64_t heard_ = 0;
  std::int64_t session_ = 0;    // 0: none yet
  Clock::time_point heard_at_;  // time at which something of it came last
  bool warned_ = false;           // of another simulator
  int throttle_ = -1;           // the channel's index
  unlatch::HelloAck introduction_;
  std::int64_t answered_tick_ = -1, last_command_ = 0;
  unlatch::Command answer_;  // the command of answered_tick_
  int answer_count_ = 0;
  unlatch::State state_, end_;
  bool ended_ = false;
};

}  // namespace

int main() {
  try {
    Pilot pilot;
    return pilot.wait();
  } catch (const std::exception& error) {
    std::fprintf(stderr, "pilot: Fast DDS: %s\n", error.what());
    return 3;
  }
}
