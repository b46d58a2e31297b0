// The Cyclone DDS transport: one topic per message, unlatch_State and so on, types from schema/unlatch.idl.
#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "bridge/core/port.h"
#include "bridge/dds/dds_domain.h"
#include "bridge/dds/dds_log.h"
#include "bridge/dds/dds_security.h"
#include "bridge/schema/dds_layout.h"
#include "unlatch.h"

namespace unlatch::bridge {
namespace {

using hil::kMessageKinds;

// Quality of service of a topic. Everything is reliable and keep-last: a reader that does not keep up loses old
// messages and never blocks the writer. Depths are in messages, for keyed topics per key.
struct TopicTraits {
  MessageKind kind;
  const dds_topic_descriptor_t* type;
  std::int32_t writer_depth;  // unacknowledged messages kept for resending
  std::int32_t reader_depth;  // messages waiting for poll
  std::int32_t late_depth;    // messages that a late joiner gets (transient-local); 0: none
  dds_duration_t lifespan;    // after which no reader gets it any more
};

// Messages that participants send once reach the simulator even if sent while the two were still discovering each
// other, which takes each topic up to a tenth of a second; they expire soon, so that the next simulator does not
// receive old commands. An acknowledgement is sent again whenever the State is.
constexpr dds_duration_t kRecent = DDS_SECS(2);
constexpr dds_duration_t kForever = DDS_INFINITY;

// Topics in the order in which waiting messages are delivered: what was sent before is delivered before. The writer of
// states keeps less than the half megabyte of unacknowledged data from which on Cyclone would block it.
constexpr std::array<TopicTraits, kMessageKinds> kTopics{{
    {MessageKind::kHello, &unlatch_Hello_desc, 16, 64, 1, kForever},
    {MessageKind::kCatalog, &unlatch_Catalog_desc, 1, 1, 1, kForever},
    {MessageKind::kHelloAck, &unlatch_HelloAck_desc, 64, 256, 1, kRecent},
    {MessageKind::kEvent, &unlatch_Event_desc, 1024, 4096, 1024, kForever},
    {MessageKind::kCommand, &unlatch_Command_desc, 32768, 65536, 64, kRecent},
    {MessageKind::kState, &unlatch_State_desc, 192, 4096, 0, kForever},
    {MessageKind::kStepAck, &unlatch_StepAck_desc, 1024, 4096, 0, kForever},
    {MessageKind::kHealth, &unlatch_Health_desc, 64, 256, 0, kForever},
    {MessageKind::kVerdict, &unlatch_Verdict_desc, 256, 4096, 0, kForever},
    {MessageKind::kReactions, &unlatch_Reactions_desc, 64, 256, 0, kForever},
    {MessageKind::kSource, &unlatch_Source_desc, 1, 1, 1, kForever},
}};

constexpr std::int64_t kMaxBlocking = DDS_MSECS(10);

// Timeout of a port that closes, for all its writers together, until every reader has all messages. A reader may miss
// the first message that a writer sends after discovery, and gets none of those behind it before that one was sent
// again: some tenths of a second later, when a heartbeat has made the reader ask for it, fragment by fragment.
constexpr auto kFarewell = std::chrono::seconds(1);

constexpr std::size_t kBatch = 128;  // messages taken from a reader at a time

// Names of the DDS standard (DDS 1.4, 2.2.3) of the policies by which a reader and a writer can fail to match.
const char* get_policy_name(std::uint32_t id) {
  switch (id) {
    case DDS_DURABILITY_QOS_POLICY_ID:
      return "DURABILITY";
    case DDS_PRESENTATION_QOS_POLICY_ID:
      return "PRESENTATION";
    case DDS_DEADLINE_QOS_POLICY_ID:
      return "DEADLINE";
    case DDS_LATENCYBUDGET_QOS_POLICY_ID:
      return "LATENCY_BUDGET";
    case DDS_OWNERSHIP_QOS_POLICY_ID:
      return "OWNERSHIP";
    case DDS_LIVELINESS_QOS_POLICY_ID:
      return "LIVELINESS";
    case DDS_PARTITION_QOS_POLICY_ID:
      return "PARTITION";
    case DDS_RELIABILITY_QOS_POLICY_ID:
      return "RELIABILITY";
    case DDS_DESTINATIONORDER_QOS_POLICY_ID:
      return "DESTINATION_ORDER";
    case DDS_DATA_REPRESENTATION_QOS_POLICY_ID:
      return "DATA_REPRESENTATION";
    case DDS_TYPE_CONSISTENCY_ENFORCEMENT_QOS_POLICY_ID:
      return "TYPE_CONSISTENCY_ENFORCEMENT";
    default:
      return "unknown";
  }
}

struct DeleteQos {
  void operator()(dds_qos_t* qos) const { dds_delete_qos(qos); }
};
using Qos = std::unique_ptr<dds_qos_t, DeleteQos>;

Qos make_qos(const TopicTraits& topic, std::int32_t depth) {
  Qos qos(dds_create_qos());
  dds_qset_reliability(qos.get(), DDS_RELIABILITY_RELIABLE, kMaxBlocking);
  dds_qset_history(qos.get(), DDS_HISTORY_KEEP_LAST, depth);
  dds_qset_lifespan(qos.get(), topic.lifespan);
  if (topic.late_depth > 0) {
    dds_qset_durability(qos.get(), DDS_DURABILITY_TRANSIENT_LOCAL);
    dds_qset_durability_service(qos.get(), 0, DDS_HISTORY_KEEP_LAST, topic.late_depth, DDS_LENGTH_UNLIMITED,
                                DDS_LENGTH_UNLIMITED, DDS_LENGTH_UNLIMITED);
  }
  return qos;
}

class DdsPort final : public Port {
 public:
  DdsPort(Role role, const DdsOptions& options)
      : Port(role),
        options_(options),
        domain_(open_dds_domain(options)),
        participant_(create_participant()),
        waitset_(check("creating a waitset", dds_create_waitset(participant_.get()))) {
    for (std::size_t i = 0; i < kMessageKinds; ++i) open_topic(role, i);
  }
  ~DdsPort() override { wait_for_readers(); }

 private:
  // Messages taken from one reader, delivered one by one. Cyclone writes them into our memory: the types have no
  // pointers, so that nothing is allocated, and a loan would be cleared as a whole each time it is given back.
  struct Batch {
    dds_entity_t reader = 0;
    std::size_t next = 0;
    std::size_t count = 0;
    std::vector<std::byte> storage;
    std::array<void*, kBatch> samples{};
    std::array<dds_sample_info_t, kBatch> infos{};
  };

  dds_entity_t check(const char* what, dds_entity_t result) const {
    if (result < 0) throw make_dds_error(options_, what, result);
    return result;
  }

  dds_entity_t create_participant() const {
    const Qos qos(dds_create_qos());
    if (!options_.security.empty()) set_dds_security(qos.get(), options_.security);
    return check("creating a participant",
                 dds_create_participant(static_cast<dds_domainid_t>(options_.domain), qos.get(), nullptr));
  }

  void open_topic(Role role, std::size_t index) {
    const TopicTraits& traits = kTopics[index];
    if (!publishes(role, traits.kind) && !receives(role, traits.kind)) return;
    const std::string name = "unlatch_" + std::string(hil::get_kind_name(traits.kind));
    const dds_entity_t topic =
        check("creating a topic", dds_create_topic(participant_.get(), traits.type, name.c_str(), nullptr, nullptr));
    if (publishes(role, traits.kind)) {
      const Qos qos = make_qos(traits, traits.writer_depth);
      writers_[static_cast<std::size_t>(traits.kind)] =
          check("creating a writer", dds_create_writer(participant_.get(), topic, qos.get(), nullptr));
    }
    if (!receives(role, traits.kind)) return;
    try {
      open_reader(traits, topic, batches_[index]);
    } catch (const PortError&) {
      // Identities made for an earlier version of the protocol.
      if (!publishes(role, traits.kind) || options_.security.empty()) throw;
      batches_[index].reader = 0;
      std::fputs(
          "DDS Security: this identity may not receive Hello, so that another simulator would not be noticed; "
          "bridge/security/make-keys makes new ones\n",
          stderr);
    }
  }

  void open_reader(const TopicTraits& traits, dds_entity_t topic, Batch& batch) {
    const std::size_t size = hil::get_size(traits.kind);
    batch.storage.resize(kBatch * size);
    for (std::size_t i = 0; i < kBatch; ++i) batch.samples[i] = batch.storage.data() + i * size;
    const Qos qos = make_qos(traits, traits.reader_depth);
    dds_qset_ignorelocal(qos.get(), DDS_IGNORELOCAL_PARTICIPANT);  // a simulator receives the Hello of others
    batch.reader = check("creating a reader", dds_create_reader(participant_.get(), topic, qos.get(), nullptr));
    const dds_entity_t any = check("creating a condition", dds_create_readcondition(batch.reader, DDS_ANY_STATE));
    check("attaching a condition", dds_waitset_attach(waitset_.get(), any, 0));
  }

  void wait_for_readers() const {
    using Clock = std::chrono::steady_clock;
    const auto deadline = Clock::now() + kFarewell;
    for (const dds_entity_t writer : writers_) {
      if (writer == 0) continue;
      const std::chrono::nanoseconds left = deadline - Clock::now();
      (void)dds_wait_for_acks(writer, std::max(left, std::chrono::nanoseconds::zero()).count());
    }
  }

  // The structs have one layout in C and C++ (schema/dds_layout.h), and all members of the union one address.
  bool send(const Message& message) override {
    const dds_entity_t writer = writers_[static_cast<std::size_t>(message.kind)];
    if (dds_write(writer, &message.hello) != DDS_RETCODE_OK) return false;
    // The domain batches the messages of a writer until it is flushed: the parts of a State are one packet.
    const bool more_follows = message.kind == MessageKind::kState && message.state.part > 0;
    if (!more_follows) dds_write_flush(writer);
    return true;
  }

  Received receive(Message& message, std::chrono::nanoseconds wait) override {
    if (deliver(message)) return Received::kMessage;
    // Not to wait is not to wait for 0 ns: that would sleep for as long as the kernel's timers are coarse.
    const bool waits = wait > std::chrono::nanoseconds::zero();
    if (waits && dds_waitset_wait(waitset_.get(), nullptr, 0, wait.count()) <= 0) return Received::kNothing;
    take_all();
    if (deliver(message)) return Received::kMessage;
    return waits ? Received::kOther : Received::kNothing;  // other: a writer went away
  }

  // From the last sent topic to the first: whatever was sent before an acknowledgement that is taken here has arrived
  // by the time its own topic's turn comes, and is delivered before it.
  void take_all() {
    for (std::size_t i = kMessageKinds; i-- > 0;) {
      Batch& batch = batches_[i];
      if (batch.reader == 0) continue;
      const auto taken = dds_take(batch.reader, batch.samples.data(), batch.infos.data(), kBatch, kBatch);
      batch.next = 0;
      batch.count = taken > 0 ? static_cast<std::size_t>(taken) : 0;
    }
  }

  bool deliver(Message& message) {
    for (std::size_t i = 0; i < kMessageKinds; ++i) {
      Batch& batch = batches_[i];
      while (batch.next < batch.count) {
        const std::size_t sample = batch.next++;
        if (!batch.infos[sample].valid_data) continue;
        copy(kTopics[i].kind, batch.samples[sample], message);
        return true;
      }
    }
    return false;
  }

  static void copy(MessageKind kind, const void* sample, Message& message) {
    message.kind = kind;
    std::copy_n(static_cast<const std::byte*>(sample), hil::get_size(kind),
                reinterpret_cast<std::byte*>(&message.hello));
  }

  [[nodiscard]] std::int64_t get_lost() const override {
    std::int64_t lost = 0;
    for (const Batch& batch : batches_) {
      dds_sample_lost_status_t status{};
      if (batch.reader != 0 && dds_get_sample_lost_status(batch.reader, &status) == DDS_RETCODE_OK)
        lost += status.total_count;
    }
    return lost;
  }

  [[nodiscard]] std::vector<UnfitPeers> list_unfit() const override {
    std::vector<UnfitPeers> list;
    for (std::size_t i = 0; i < kMessageKinds; ++i) {
      const MessageKind kind = kTopics[i].kind;
      const dds_entity_t reader = batches_[i].reader, writer = writers_[static_cast<std::size_t>(kind)];
      dds_requested_incompatible_qos_status_t of_writers{};
      if (reader != 0 && dds_get_requested_incompatible_qos_status(reader, &of_writers) == DDS_RETCODE_OK &&
          of_writers.total_count > 0)
        list.push_back({kind, false, get_policy_name(of_writers.last_policy_id), of_writers.total_count});
      dds_offered_incompatible_qos_status_t of_readers{};
      if (writer != 0 && dds_get_offered_incompatible_qos_status(writer, &of_readers) == DDS_RETCODE_OK &&
          of_readers.total_count > 0)
        list.push_back({kind, true, get_policy_name(of_readers.last_policy_id), of_readers.total_count});
    }
    return list;
  }

  [[nodiscard]] std::int64_t get_unreadable() const noexcept override {
    return get_dds_unreadable() - unreadable_before_;
  }

  const DdsOptions options_;
  const std::shared_ptr<const DdsEntity> domain_;  // outlives the participant
  const std::int64_t unreadable_before_ = get_dds_unreadable();
  const DdsEntity participant_;
  const DdsEntity waitset_;
  std::array<dds_entity_t, kMessageKinds> writers_{};  // by kind; 0: not ours to publish
  std::array<Batch, kMessageKinds> batches_{};         // as kTopics
};

}  // namespace

std::unique_ptr<Port> open_dds_port(Role role, const DdsOptions& options) {
  return std::make_unique<DdsPort>(role, options);
}

}  // namespace unlatch::bridge
