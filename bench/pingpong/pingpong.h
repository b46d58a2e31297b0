// A round trip: a state of several bodies out, an acknowledgement back; once by the protocol, once bare, by the
// middleware alone. Over DDS and LCM the other side is a separate process, in-process it is a thread.
#pragma once

#include <chrono>
#include <cstddef>
#include <functional>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

namespace unlatch::bench {

// Numbers of bodies of the two states; the protocol sends them in State parts of 16 bodies each.
inline constexpr int kFew = 5, kMany = 200;
[[nodiscard]] int calc_parts(int bodies);
[[nodiscard]] std::size_t calc_bytes(int bodies);

class PingPong {
 public:
  PingPong() = default;
  virtual ~PingPong() = default;
  PingPong(const PingPong&) = delete;
  PingPong& operator=(const PingPong&) = delete;

  // Makes one round trip, with kFew or kMany bodies. Throws after ten seconds without an answer.
  void run(int bodies);

 protected:
  virtual void send(int bodies) = 0;
  virtual bool receive(std::chrono::nanoseconds wait) = 0;  // the answer to the latest send
};

// Opens a ping-pong. `who`: dds, lcm, inproc: as the executive in lockstep; dds_paced, lcm_paced, inproc_paced: as in
// real time, through the rings and their threads; bare_dds, bare_lcm, bare_inproc: as many messages of the same size;
// bare_one_…: as many bytes in one message (kMany only). Ready when it returns: both sides have found each other.
[[nodiscard]] std::unique_ptr<PingPong> open_pingpong(const std::string& who);

// Measures median round trips, in short alternating turns, so that disturbances by the machine affect all of them.
[[nodiscard]] std::vector<double> measure_in_turns_us(const std::vector<std::string>& who, int bodies, int turns);

// Runs the other side, in its own process: `program --echo WHO` of the program that opened the ping-pong. Returns when
// its parent has ended.
bool is_echo(int count, char** arguments);
int run_echo(char** arguments);

// Cores of the two sides; each side has a core to itself, threads of the middleware included. The scheduler alone would
// put some pairs on one core, which is several times faster or slower, and keep them there for the whole measurement.
enum Core { kOurs = 0, kTheirs = 1 };
void pin(Core core);  // pins the calling thread, and those that it starts

// Parts for pingpong.cc.
[[nodiscard]] std::unique_ptr<PingPong> open_bare(const std::string& transport, bool as_one);
void echo_bare(const std::string& transport, bool as_one);

}  // namespace unlatch::bench
