// Ping-pong with nothing but the middleware: buffers of the size of the protocol's messages out, one back.
#include "bare.h"

#include <dds/dds.h>
#include <lcm/lcm.h>
#include <poll.h>

#include <array>
#include <atomic>
#include <condition_variable>
#include <cstring>
#include <mutex>
#include <thread>

#include "bench/pingpong/pingpong.h"
#include "bridge/dds/dds_domain.h"

namespace unlatch::bench {
namespace {

using namespace std::chrono_literals;
using bridge::DdsEntity;

// Writes the first octets: the number of messages of this ping that follow, and the ping's number, which the pong
// repeats.
void mark(std::uint8_t* bytes, int left, std::uint32_t number) {
  bytes[0] = static_cast<std::uint8_t>(left);
  std::memcpy(bytes + 1, &number, sizeof number);
}
bool is_last(const std::uint8_t* bytes) { return bytes[0] == 0; }
std::uint32_t get_number(const std::uint8_t* bytes) {
  std::uint32_t number = 0;
  std::memcpy(&number, bytes + 1, sizeof number);
  return number;
}

// --- DDS: one topic for each size, reliable, keep last --------------------------------------------------------------

// Two pairs that are open at once must not receive each other's messages.
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
    ++number_;
    if (as_one_) {
      mark(long_ping_.bytes, 0, number_);
      return DdsSide::write(long_pings_, &long_ping_);
    }
    for (int left = calc_parts(bodies); left-- > 0;) {
      mark(ping_.bytes, left, number_);
      DdsSide::write(pings_, &ping_);
    }
  }
  bool receive(std::chrono::nanoseconds wait) override {
    while (side_.wait(wait)) {
      if (DdsSide::take(pongs_, &pong_) && get_number(pong_.bytes) == number_) return true;
    }
    return false;
  }

  const bool as_one_;
  std::uint32_t number_ = 0;
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
  bare_Pong pong{};
  while (true) {
    if (!side.wait(1s)) continue;
    while (DdsSide::take(pings, &ping) || DdsSide::take(long_pings, &ping)) {
      if (!is_last(ping.bytes)) continue;
      mark(pong.bytes, 0, get_number(ping.bytes));
      DdsSide::write(pongs, &pong);
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
    const auto hear = [](const lcm_recv_buf_t* buffer, const char*, void* side) {
      const auto* bytes = static_cast<const std::uint8_t*>(buffer->data);
      static_cast<LcmSide*>(side)->heard_last_ = is_last(bytes);
      static_cast<LcmSide*>(side)->heard_ = get_number(bytes);
    };
    lcm_subscribe(lcm_, hears, hear, this);
  }
  ~LcmSide() { lcm_destroy(lcm_); }
  LcmSide(const LcmSide&) = delete;
  LcmSide& operator=(const LcmSide&) = delete;

  void send(const char* channel, const void* bytes, std::size_t size) {
    lcm_publish(lcm_, channel, bytes, static_cast<unsigned int>(size));
  }
  // Returns true with the last message of a ping, or with a pong; then get_heard() is its number.
  bool receive(std::chrono::nanoseconds wait) {
    pollfd waiting{.fd = lcm_get_fileno(lcm_), .events = POLLIN, .revents = 0};
    const auto limit = std::chrono::duration_cast<std::chrono::milliseconds>(wait);
    if (::poll(&waiting, 1, static_cast<int>(limit.count())) <= 0) return false;
    lcm_handle(lcm_);
    return heard_last_;
  }
  [[nodiscard]] std::uint32_t get_heard() const { return heard_; }

 private:
  lcm_t* lcm_;
  bool heard_last_ = false;
  std::uint32_t heard_ = 0;
};

class LcmPingPong final : public PingPong {
 public:
  explicit LcmPingPong(bool as_one) : as_one_(as_one), side_(as_one, "PONG") {}

 private:
  static constexpr std::size_t kFingerprint = 8;

  void send(int bodies) override {
    ++number_;
    mark(bytes_.data(), 0, number_);
    if (as_one_) return side_.send("PING", bytes_.data(), kFingerprint + calc_bytes(bodies));
    for (int left = calc_parts(bodies); left-- > 0;) {
      mark(bytes_.data(), left, number_);
      side_.send("PING", bytes_.data(), kFingerprint + calc_bytes(kFew));
    }
  }
  bool receive(std::chrono::nanoseconds wait) override {
    while (side_.receive(wait)) {
      if (side_.get_heard() == number_) return true;
    }
    return false;
  }

  const bool as_one_;
  std::uint32_t number_ = 0;
  LcmSide side_;
  std::vector<std::uint8_t> bytes_ = std::vector<std::uint8_t>(kFingerprint + calc_bytes(kMany));
};

void echo_lcm(bool as_one) {
  LcmSide side(as_one, "PING");
  std::array<std::uint8_t, 48> pong{};
  while (true) {
    if (!side.receive(1s)) continue;
    mark(pong.data(), 0, side.get_heard());
    side.send("PONG", pong.data(), pong.size());
  }
}

// --- In-process: a buffer under a mutex each way --------------------------------------------------------------------

class Box {
 public:
  void put(const std::vector<std::uint8_t>& bytes) {
    {
      const std::lock_guard lock(mutex_);
      bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
    }
    ready_.notify_one();
  }
  // Takes all stored messages; returns their bytes.
  std::size_t take(std::vector<std::uint8_t>& bytes, std::chrono::nanoseconds wait) {
    std::unique_lock lock(mutex_);
    if (!ready_.wait_for(lock, wait, [this] { return !bytes_.empty(); })) return 0;
    bytes.assign(bytes_.begin(), bytes_.end());
    bytes_.clear();
    return bytes.size();
  }

 private:
  std::mutex mutex_;
  std::condition_variable ready_;
  std::vector<std::uint8_t> bytes_;
};

class InprocPingPong final : public PingPong {
 public:
  explicit InprocPingPong(bool as_one) : as_one_(as_one) {}
  ~InprocPingPong() override { stop_ = true; }

 private:
  void send(int bodies) override {
    ++number_;
    for (int left = as_one_ ? 1 : calc_parts(bodies); left-- > 0;) {
      mark(bytes_.data(), left, number_);
      ping_.put(bytes_);
    }
  }
  bool receive(std::chrono::nanoseconds wait) override {
    while (pong_.take(answer_, wait) > 0) {
      if (get_number(answer_.data() + answer_.size() - kPong) == number_) return true;
    }
    return false;
  }

  static constexpr std::size_t kPong = 40;
  const bool as_one_;
  Box ping_, pong_;
  std::uint32_t number_ = 0;
  std::vector<std::uint8_t> bytes_ = std::vector<std::uint8_t>(calc_bytes(as_one_ ? kMany : kFew)), answer_;
  std::atomic<bool> stop_{false};
  std::jthread echo_{[this] {
    pin(kTheirs);
    std::vector<std::uint8_t> heard, pong(kPong);
    while (!stop_) {
      if (ping_.take(heard, 100ms) == 0) continue;
      const std::uint8_t* const latest = heard.data() + heard.size() - bytes_.size();
      if (!is_last(latest)) continue;
      mark(pong.data(), 0, get_number(latest));
      pong_.put(pong);
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
