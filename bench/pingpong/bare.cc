// Ping-pong with nothing but the middleware: buffers of the size of the protocol's messages out, one back.
#include "bare.h"

#include <dds/dds.h>
#include <lcm/lcm.h>
#include <poll.h>

#include <array>
#include <condition_variable>
#include <mutex>
#include <thread>

#include "bench/pingpong/pingpong.h"
#include "bridge/dds_domain.h"

namespace unlatch::bench {
namespace {

using namespace std::chrono_literals;
using bridge::DdsEntity;

// --- DDS: one topic for each size, reliable, keep last --------------------------------------------------------------

// Two pairs that are open at once must not hear each other.
bridge::DdsOptions get_dds(bool as_one) { return {.domain = as_one ? 79 : 78, .interface = "lo"}; }

class DdsSide {
 public:
  explicit DdsSide(bool as_one)
      : domain_(bridge::open_dds_domain(get_dds(as_one))),
        participant_(dds_create_participant(static_cast<dds_domainid_t>(get_dds(as_one).domain), nullptr, nullptr)),
        waitset_(dds_create_waitset(participant_.get())) {}

  dds_entity_t open_writer(const dds_topic_descriptor_t& type) { return open(type, dds_create_writer); }
  dds_entity_t open_reader(const dds_topic_descriptor_t& type) {
    const dds_entity_t reader = open(type, dds_create_reader);
    dds_waitset_attach(waitset_.get(), dds_create_readcondition(reader, DDS_ANY_STATE), 0);
    return reader;
  }
  bool wait(std::chrono::nanoseconds limit) const {
    return dds_waitset_wait(waitset_.get(), nullptr, 0, limit.count()) > 0;
  }
  static void write(dds_entity_t writer, const void* bytes) {
    dds_write(writer, bytes);
    dds_write_flush(writer);
  }
  static bool take(dds_entity_t reader, void* into) {
    dds_sample_info_t info;
    return dds_take(reader, &into, &info, 1, 1) == 1 && info.valid_data;
  }

 private:
  template <class Create>
  dds_entity_t open(const dds_topic_descriptor_t& type, Create create) {
    const std::string name = std::string(type.m_typename).substr(sizeof "bare::" - 1);
    const dds_entity_t topic = dds_create_topic(participant_.get(), &type, name.c_str(), nullptr, nullptr);
    dds_qos_t* qos = dds_create_qos();
    dds_qset_reliability(qos, DDS_RELIABILITY_RELIABLE, DDS_MSECS(10));
    dds_qset_history(qos, DDS_HISTORY_KEEP_LAST, 16);
    const dds_entity_t entity = create(participant_.get(), topic, qos, nullptr);
    dds_delete_qos(qos);
    if (entity < 0) throw std::runtime_error("ping-pong: no DDS");
    return entity;
  }

  const std::shared_ptr<const DdsEntity> domain_;
  const DdsEntity participant_, waitset_;
};

class DdsPingPong final : public PingPong {
 public:
  explicit DdsPingPong(bool as_one) : as_one_(as_one), side_(as_one) {}

 private:
  void send(int bodies) override {
    if (as_one_) return DdsSide::write(long_pings_, &long_ping_);
    for (int left = calc_parts(bodies); left-- > 0;) {
      ping_.bytes[0] = static_cast<std::uint8_t>(left);
      DdsSide::write(pings_, &ping_);
    }
  }
  bool receive(std::chrono::nanoseconds wait) override { return side_.wait(wait) && DdsSide::take(pongs_, &pong_); }

  const bool as_one_;
  DdsSide side_;
  const dds_entity_t pings_ = side_.open_writer(bare_Ping_desc), long_pings_ = side_.open_writer(bare_LongPing_desc);
  const dds_entity_t pongs_ = side_.open_reader(bare_Pong_desc);
  bare_Ping ping_{};
  bare_LongPing long_ping_{};
  bare_Pong pong_{};
};

void echo_dds(bool as_one) {
  DdsSide side(as_one);
  const dds_entity_t pings = side.open_reader(bare_Ping_desc), long_pings = side.open_reader(bare_LongPing_desc);
  const dds_entity_t pongs = side.open_writer(bare_Pong_desc);
  static bare_LongPing ping;
  const bare_Pong pong{};
  while (true) {
    if (!side.wait(1s)) continue;
    while (DdsSide::take(pings, &ping) || DdsSide::take(long_pings, &ping)) {
      if (ping.bytes[0] == 0) DdsSide::write(pongs, &pong);
    }
  }
}

// --- LCM ------------------------------------------------------------------------------------------------------------

const char* get_url(bool as_one) {
  return as_one ? "udpm://239.255.76.67:7703?ttl=0" : "udpm://239.255.76.67:7702?ttl=0";
}

class LcmSide {
 public:
  LcmSide(bool as_one, const char* hears) : lcm_(lcm_create(get_url(as_one))) {
    if (lcm_ == nullptr) throw std::runtime_error("ping-pong: no LCM; is there a multicast route?");
    const auto hear = [](const lcm_recv_buf_t* buffer, const char*, void* left) {
      *static_cast<int*>(left) = *static_cast<const std::uint8_t*>(buffer->data);
    };
    lcm_subscribe(lcm_, hears, hear, &left_);
  }
  ~LcmSide() { lcm_destroy(lcm_); }
  LcmSide(const LcmSide&) = delete;
  LcmSide& operator=(const LcmSide&) = delete;

  void send(const char* channel, const void* bytes, std::size_t size) {
    lcm_publish(lcm_, channel, bytes, static_cast<unsigned int>(size));
  }
  // True with the last message of a ping.
  bool receive(std::chrono::nanoseconds wait) {
    pollfd waiting{.fd = lcm_get_fileno(lcm_), .events = POLLIN, .revents = 0};
    const auto limit = std::chrono::duration_cast<std::chrono::milliseconds>(wait);
    if (::poll(&waiting, 1, static_cast<int>(limit.count())) <= 0) return false;
    lcm_handle(lcm_);
    return left_ == 0;
  }

 private:
  lcm_t* lcm_;
  int left_ = 0;
};

class LcmPingPong final : public PingPong {
 public:
  explicit LcmPingPong(bool as_one) : as_one_(as_one), side_(as_one, "PONG") {}

 private:
  static constexpr std::size_t kFingerprint = 8;

  void send(int bodies) override {
    if (as_one_) return side_.send("PING", bytes_.data(), kFingerprint + calc_bytes(bodies));
    for (int left = calc_parts(bodies); left-- > 0;) {
      bytes_[0] = static_cast<std::byte>(left);
      side_.send("PING", bytes_.data(), kFingerprint + calc_bytes(kFew));
    }
  }
  bool receive(std::chrono::nanoseconds wait) override { return side_.receive(wait); }

  const bool as_one_;
  LcmSide side_;
  std::vector<std::byte> bytes_ = std::vector<std::byte>(kFingerprint + calc_bytes(kMany));
};

void echo_lcm(bool as_one) {
  LcmSide side(as_one, "PING");
  const std::array<std::byte, 48> pong{};
  while (true) {
    if (side.receive(1s)) side.send("PONG", pong.data(), pong.size());
  }
}

// --- In-process: a buffer under a mutex each way --------------------------------------------------------------------

class Box {
 public:
  void put(const std::vector<std::byte>& bytes) {
    {
      const std::lock_guard lock(mutex_);
      bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
    }
    ready_.notify_one();
  }
  // All that was put: its bytes.
  std::size_t take(std::vector<std::byte>& bytes, std::chrono::nanoseconds wait) {
    std::unique_lock lock(mutex_);
    if (!ready_.wait_for(lock, wait, [this] { return !bytes_.empty(); })) return 0;
    bytes.assign(bytes_.begin(), bytes_.end());
    bytes_.clear();
    return bytes.size();
  }

 private:
  std::mutex mutex_;
  std::condition_variable ready_;
  std::vector<std::byte> bytes_;
};

class InprocPingPong final : public PingPong {
 public:
  explicit InprocPingPong(bool as_one) : as_one_(as_one) {}
  ~InprocPingPong() override { stop_ = true; }

 private:
  void send(int bodies) override {
    expected_ = calc_bytes(bodies);
    if (as_one_) return ping_.put(all_);
    for (int part = 0; part < calc_parts(bodies); ++part) ping_.put(part_);
  }
  bool receive(std::chrono::nanoseconds wait) override { return pong_.take(answer_, wait) > 0; }

  const bool as_one_;
  Box ping_, pong_;
  std::vector<std::byte> part_ = std::vector<std::byte>(calc_bytes(kFew)), answer_;
  std::vector<std::byte> all_ = std::vector<std::byte>(calc_bytes(kMany));
  std::atomic<std::size_t> expected_{0};
  std::atomic<bool> stop_{false};
  std::jthread echo_{[this] {
    pin(kTheirs);
    std::vector<std::byte> heard;
    const std::vector<std::byte> answer(40);
    std::size_t size = 0;
    while (!stop_) {
      size += ping_.take(heard, 100ms);
      if (size == 0 || size < expected_) continue;
      size = 0;
      pong_.put(answer);
    }
  }};
};

}  // namespace

std::unique_ptr<PingPong> open_bare(const std::string& transport, bool as_one) {
  if (transport == "dds") return std::make_unique<DdsPingPong>(as_one);
  if (transport == "lcm") return std::make_unique<LcmPingPong>(as_one);
  return std::make_unique<InprocPingPong>(as_one);
}

void echo_bare(const std::string& transport, bool as_one) { transport == "dds" ? echo_dds(as_one) : echo_lcm(as_one); }

}  // namespace unlatch::bench
