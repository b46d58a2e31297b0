// F´ component UnlatchSim: the simulator as a port of States and a port of commands (UnlatchSim.fpp). Copy this folder,
// participant.{h,c}, unlatch_wire.h and unlatch_frame.h into a component folder, and list the sources in its
// CMakeLists.txt.
#ifndef UNLATCH_SIM_HPP_
#define UNLATCH_SIM_HPP_

#include "UnlatchSimComponentAc.hpp"
#include "participant.h"

namespace Unlatch {

class UnlatchSim : public UnlatchSimComponentBase {
 public:
  explicit UnlatchSim(const char* name) : UnlatchSimComponentBase(name) {}
  ~UnlatchSim();

  // Joins the simulator at an IPv4 address, which need not run yet. `participant`: as the scenario requires it. False:
  // there is no socket.
  bool configure(const char* participant, const char* address, U16 port);
  // False once the session is over.
  bool isActive() const { return m_active; }
  // Simulated time of the present State, ns: for the component that answers timeCaller.
  I64 getTimeNs() const { return m_sim.state.time_ns; }

 private:
  void schedIn_handler(FwIndexType portNum, U32 context) override;
  void commandIn_handler(FwIndexType portNum, const Fw::StringBase& channel, F64 value) override;

  static constexpr int WAIT_MS = 1000;
  unlatch_participant m_sim{};
  bool m_open = false, m_active = false, m_inState = false;
};

}  // namespace Unlatch

#endif
