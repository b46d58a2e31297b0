// The executive's connection in real time: rings, and two threads that carry messages between them and a port, one each
// way. The cyclic thread uses the rings alone.
#pragma once

#include <thread>

#include "bridge/core/port.h"
#include "hil/session/participants/ring_connection.h"

namespace unlatch::bridge {

// Its threads run from construction until stop() or destruction. The port has the simulator's role and must outlive the
// connection, which alone may use it meanwhile.
class ThreadedConnection final : public hil::RingConnection {
 public:
  explicit ThreadedConnection(Port& port, std::size_t out_capacity = 1024, std::size_t in_capacity = 1024,
                              const hil::Clock& clock = hil::kMonotonicClock);
  ~ThreadedConnection() override;

  // Publishes the rest of the out ring, then ends both threads: within some 20 ms. A second call does nothing.
  void stop();

 private:
  void run_out(const std::stop_token& stopping);
  void run_in(const std::stop_token& stopping);

  Port& port_;
  std::jthread out_thread_;
  std::jthread in_thread_;
};

}  // namespace unlatch::bridge
