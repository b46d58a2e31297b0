// Flight software in eighty lines: stops the rotation of satellite.yaml. ../../TUTORIAL.md explains it.
#include <cstdio>
#include <cstring>
#include <lcm/lcm-cpp.hpp>

#include "unlatch/Catalog.hpp"
#include "unlatch/Command.hpp"
#include "unlatch/Hello.hpp"
#include "unlatch/HelloAck.hpp"
#include "unlatch/State.hpp"
#include "unlatch/StepAck.hpp"
using namespace unlatch;
using Buffer = lcm::ReceiveBuffer;

struct FlightSoftware {
  lcm::LCM lcm{"udpm://239.255.76.67:7667?ttl=0"};
  HelloAck me{};              // our name, and the terms we agree to
  Command command{};          // the latest
  int gyro = -1, wheel = -1;  // their numbers in the catalog
  std::int64_t heard_us = 0;  // time at which something of our session came last
  bool warned = false;          // of another simulator
  bool ended = false;

  double control(double rate) { return -40 * rate; }  // N m for rad/s. Your algorithm goes here.

  // Our session is the first that we hear, until nothing of it has come for two seconds.
  bool is_ours(const Hello& hello, std::int64_t now_us) {
    if (hello.status >= Hello::RunStatus_kDone) return false;  // is over
    if (hello.session == me.session) return true;
    if (now_us - heard_us < 2'000'000) {
      if (!warned)
        std::fprintf(stderr, "fsw: another simulator is heard; stays with session %lld\n", (long long)me.session);
      warned = true;
      return false;
    }
    command = {}, gyro = wheel = -1;
    return true;
  }

  void on_hello(const Buffer* buffer, const std::string&, const Hello* hello) {
    if (!is_ours(*hello, buffer->recv_utime)) return;
    heard_us = buffer->recv_utime;
    me = {hello->session,
          me.sequence,
          HelloAck::kSchemaHash,
          hello->model_hash,
          hello->dt_ns,
          HelloAck::kProtocolVersion,
          7,
          HelloAck::AckStatus_kReady,
          0,
          {},
          {}};
    std::memcpy(me.name, "fsw", 4);  // as the scenario requires it
    if (gyro >= 0 && wheel >= 0) lcm.publish("UNLATCH_HELLO_ACK", &me), ++me.sequence;
  }
  void on_catalog(const Buffer*, const std::string&, const Catalog* item) {
    if (item->session != me.session) return;
    const char* const name = reinterpret_cast<const char*>(item->name);
    if (item->kind == Catalog::CatalogKind_kSensor && !std::strcmp(name, "gyro.z")) gyro = item->index;
    if (item->kind == Catalog::CatalogKind_kChannel && !std::strcmp(name, "wheel")) wheel = item->index;
  }
  void on_state(const Buffer* buffer, const std::string&, const State* state) {
    if (state->session != me.session || gyro < 0 || wheel < 0) return;
    heard_us = buffer->recv_utime;
    ended = state->status >= State::RunStatus_kDone;
    if (ended) return;
    if (state->tick >= command.sequence)  // new; a State that is resent gets the same answer again
      command = {me.session, state->tick + 1, state->tick, -1, control(state->sensors[gyro]), me.participant, wheel};
    const StepAck done{me.session, state->sequence, state->tick, command.sequence, me.participant, 1};
    lcm.publish("UNLATCH_COMMAND", &command);
    lcm.publish("UNLATCH_STEP_ACK", &done);
  }
};

int main() {
  FlightSoftware software;
  software.lcm.subscribe("UNLATCH_HELLO", &FlightSoftware::on_hello, &software);
  software.lcm.subscribe("UNLATCH_CATALOG", &FlightSoftware::on_catalog, &software);
  software.lcm.subscribe("UNLATCH_STATE", &FlightSoftware::on_state, &software);
  std::fputs(software.lcm.good() ? "fsw: waits for a simulator\n" : "fsw: no route for multicast\n", stderr);
  while (!software.ended)
    if (software.lcm.handleTimeout(10'000) <= 0) {
      std::fputs("fsw: heard no simulator for 10 s; has it started, and does `ip route get 239.255.76.67` say lo?\n",
                 stderr);
      return 1;
    }
}
