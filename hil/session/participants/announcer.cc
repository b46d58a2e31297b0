#include "hil/session/participants/announcer.h"

#include <cmath>
#include <utility>

#include "hil/run/simulation/model_messages.h"

namespace unlatch::hil {
namespace {

constexpr std::int64_t kRetry_ns = 1'000'000;
constexpr int kMaxAttempts = 100;
constexpr std::int64_t kHelloInterval_ns = 100'000'000;

std::int64_t calc_dt_ns(const Simulation& simulation) { return std::llround(simulation.plan().get_options().dt * 1e9); }

}  // namespace

std::vector<CatalogMessage> build_session_catalog(const Simulation& simulation, const SessionOptions& options) {
  std::vector<CatalogMessage> catalog = build_catalog(simulation.model());
  std::int32_t index = 0;
  for (const std::string& name : options.flight_software.required) {
    CatalogMessage& item = catalog.emplace_back();
    item.kind = static_cast<std::int32_t>(CatalogKind::kParticipant);
    item.index = index++;
    set_name(item.name, name);
  }
  for (CatalogMessage& item : catalog) item.session = options.session;
  return catalog;
}

HelloMessage build_hello(const Simulation& simulation, const std::string& scenario, const SessionOptions& options,
                         const std::vector<CatalogMessage>& catalog) {
  const FlightSoftware& flight_software = options.flight_software;
  HelloMessage hello;
  hello.session = options.session;
  hello.schema_hash = kSchemaHash;
  hello.model_hash = static_cast<std::int64_t>(simulation.plan().get_hash());
  hello.dt_ns = calc_dt_ns(simulation);
  hello.last_tick = options.last_tick;
  hello.protocol = kProtocolVersion;
  hello.pace = static_cast<std::int32_t>(options.pace);
  hello.timeout_ns = std::llround(flight_software.timeout * 1e9);
  if (options.pace == Pace::kRealtime) {
    hello.cutoff_ns = std::llround(flight_software.cutoff * static_cast<double>(hello.dt_ns));
  }
  hello.delay_ticks = flight_software.delay;
  hello.policy = static_cast<std::int32_t>(flight_software.policy);
  for (const CatalogMessage& item : catalog) {
    switch (static_cast<CatalogKind>(item.kind)) {
      case CatalogKind::kBody:
        ++hello.body_count;
        break;
      case CatalogKind::kJoint:
        ++hello.joint_count;
        break;
      case CatalogKind::kChannel:
        ++hello.channel_count;
        break;
      case CatalogKind::kSensor:
        ++hello.sensor_count;
        break;
      case CatalogKind::kSignal:
        ++hello.signal_count;
        break;
      case CatalogKind::kParticipant:
        ++hello.participant_count;
        break;
    }
  }
  set_name(hello.scenario, scenario);
  return hello;
}

Announcer::Announcer(const HelloMessage& hello, std::vector<CatalogMessage> catalog, std::vector<SourceMessage> source,
                     Connection& connection, const Clock& clock, std::int64_t interval_ns)
    : hello_(hello),
      catalog_(std::move(catalog)),
      source_(std::move(source)),
      connection_(connection),
      clock_(clock),
      interval_ns_(interval_ns) {}

void Announcer::send_all() {
  (void)send_when_possible(hello_);
  ++hello_.sequence;
  for (CatalogMessage& item : catalog_) {
    item.sequence = catalog_sequence_++;
    (void)send_when_possible(item);
  }
}

// A large catalog does not fit the ring at once; if nothing is taken from its other end, the wait is bounded.
bool Announcer::send_when_possible(const Message& message) {
  for (int attempt = 0; attempt < kMaxAttempts; ++attempt) {
    if (connection_.send(message)) return true;
    clock_.sleep_until_ns(clock_.get_ns() + kRetry_ns);
  }
  return false;
}

void Announcer::announce(std::int64_t now_ns) noexcept {
  if (announced_ns_ && now_ns - *announced_ns_ < interval_ns_) return;
  announced_ns_ = now_ns;
  const bool is_turn = next_ == 0;
  if (is_turn || !hello_ns_ || now_ns - *hello_ns_ >= kHelloInterval_ns) {
    connection_.send(hello_);
    ++hello_.sequence;
    hello_ns_ = now_ns;
  } else {
    CatalogMessage& item = catalog_[next_ - 1];
    item.sequence = catalog_sequence_++;
    connection_.send(item);
  }
  if (is_turn || hello_ns_ != now_ns) next_ = (next_ + 1) % (catalog_.size() + 1);
  if (source_.empty()) return;
  SourceMessage& part = source_[next_source_];
  part.sequence = source_sequence_++;
  connection_.send(part);
  next_source_ = (next_source_ + 1) % source_.size();
}

bool Announcer::send_unsent_source_part() {
  if (source_sequence_ >= static_cast<std::int64_t>(source_.size())) return false;
  SourceMessage& part = source_[static_cast<std::size_t>(source_sequence_)];
  part.sequence = source_sequence_;
  if (!send_when_possible(part)) return false;
  ++source_sequence_;
  return true;
}

}  // namespace unlatch::hil
