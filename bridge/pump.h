// Moves messages between the cyclic thread's Link and a Port: one thread each way.
#pragma once

#include <thread>

#include "bridge/port.h"
#include "hil/messages/link.h"

namespace unlatch::bridge {

// Runs from construction until stop() or destruction. The port belongs to the simulator's side; link and port must
// outlive the pump, and nobody else may use the port meanwhile.
class Pump {
 public:
  Pump(hil::Link& link, Port& port);
  ~Pump();
  Pump(const Pump&) = delete;
  Pump& operator=(const Pump&) = delete;

  // Publishes what is still in the out ring, then ends both threads: within some 20 ms. A second call does nothing.
  void stop();

 private:
  void run_out(const std::stop_token& stopping);
  void run_in(const std::stop_token& stopping);

  hil::Link& link_;
  Port& port_;
  std::jthread out_;
  std::jthread in_;
};

}  // namespace unlatch::bridge
