// Messages that describe a session: Hello, the catalog, the scenario's source. Hello and the whole catalog are sent at
// the beginning; during the run one message at a time, for participants and observers that come later.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "hil/run/simulation/simulation.h"
#include "hil/session/messages/messages.h"
#include "hil/session/participants/connection.h"
#include "hil/session/participants/session_options.h"
#include "hil/session/realtime/clock.h"

namespace unlatch::hil {

// Catalog of the model and the required participants; with session, without sequence numbers.
[[nodiscard]] std::vector<CatalogMessage> build_session_catalog(const Simulation& simulation,
                                                                const SessionOptions& options);
// `scenario`: its name.
[[nodiscard]] HelloMessage build_hello(const Simulation& simulation, const std::string& scenario,
                                       const SessionOptions& options, const std::vector<CatalogMessage>& catalog);

class Announcer {
 public:
  // `connection` and `clock` must outlive it.
  Announcer(const HelloMessage& hello, std::vector<CatalogMessage> catalog, std::vector<SourceMessage> source,
            Connection& connection, const Clock& clock, std::int64_t interval_ns);

  [[nodiscard]] const HelloMessage& get_hello() const noexcept { return hello_; }
  void set_status(RunStatus status) noexcept { hello_.status = static_cast<std::int32_t>(status); }

  // Sends Hello and the whole catalog; waits while the connection is full. Not for the cycle.
  void send_all();
  // Sends once in an interval one message of Hello and the catalog in turn, Hello a tenth of a second after the latest
  // for any length of the catalog; and one part of the source.
  void announce(std::int64_t now_ns) noexcept;
  // Sends Hello with the session's last status: a late joiner that finds it kept knows that the session is over.
  void send_farewell() { (void)send_when_possible(hello_); }
  // Sends the next part of the source that has not been sent yet: a run may end before each part has had its turn.
  // False if there is none, or the connection stays full. Not for the cycle.
  bool send_unsent_source_part();

 private:
  bool send_when_possible(const Message& message);

  HelloMessage hello_;
  std::vector<CatalogMessage> catalog_;
  std::vector<SourceMessage> source_;
  Connection& connection_;
  const Clock& clock_;
  const std::int64_t interval_ns_;
  std::optional<std::int64_t> announced_ns_;  // time of the latest message
  std::optional<std::int64_t> hello_ns_;      // time of the latest Hello
  std::size_t next_ = 0;                      // 0: Hello, then the catalog
  std::size_t next_source_ = 0;
  std::int64_t catalog_sequence_ = 0, source_sequence_ = 0;
};

}  // namespace unlatch::hil
