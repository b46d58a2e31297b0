// A round trip: a state of so many bodies out, an acknowledgement back; once as the protocol does it, once bare, with
// nothing but the middleware. Over DDS and LCM the other side is a process of its own, in-process a thread.
#pragma once

#include <chrono>
#include <cstddef>
#include <functional>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

namespace unlatch::bench {

// Bodies of the two states, and the bytes that the protocol sends for them: State parts of 16 bodies each.
inline constexpr int kFew = 5, kMany = 200;
[[nodiscard]] int calc_parts(int bodies);
[[nodiscard]] std::size_t calc_bytes(int bodies);

class PingPong {
 public:
  PingPong() = default;
  virtual ~PingPong() = default;
  PingPong(const PingPong&) = delete;
  PingPong& operator=(const PingPong&) = delete;

  // One round trip, with kFew or kMany bodies. Throws after ten seconds without an answer.
  void run(int bodies);

 protected:
  virtual void send(int bodies) = 0;
  virtual bool receive(std::chrono::nanoseconds wait) = 0;  // the answer to the latest send
};

// who: dds, lcm, inproc: as the executive in lockstep; dds_paced, lcm_paced, inproc_paced: as in real time, through the
// rings and their threads; bare_dds, bare_lcm, bare_inproc: as many messages of the same size; bare_one_…: as many
// bytes in one message (kMany only). Ready when it returns: both sides have found each other.
[[nodiscard]] std::unique_ptr<PingPong> open_pingpong(const std::string& who);

// Median round trips, in turns of a few each, so that whatever else the machine does befalls all alike.
[[nodiscard]] std::vector<double> measure_in_turns_us(const std::vector<std::string>& who, int bodies, int turns);

// The other side, in its own process: `program --echo WHO` of whichever program opened the ping-pong. Returns when its
// parent has gone.
bool is_echo(int count, char** arguments);
int run_echo(char** arguments);

// Each side has a core to itself, threads of the middleware included. Left to the scheduler, some pairs share a core,
// which is several times faster or slower, and stay so for as long as they are watched.
enum Core { kOurs = 0, kTheirs = 1 };
void pin(Core core);  // the calling thread, and those that it starts

// The parts, for pingpong.cc.
[[nodiscard]] std::unique_ptr<PingPong> open_bare(const std::string& transport, bool as_one);
void echo_bare(const std::string& transport, bool as_one);

}  // namespace unlatch::bench
