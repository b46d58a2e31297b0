#include "UnlatchSim.hpp"

namespace Unlatch {

UnlatchSim::~UnlatchSim() {
  if (m_open) unlatch_participant_close(&m_sim);
}

bool UnlatchSim::configure(const char* participant, const char* address, U16 port) {
  m_open = m_active = unlatch_participant_open(&m_sim, participant, address, port) == 0;
  return m_open;
}

// The State goes out, control runs within that call and comes back to commandIn, then the answer leaves: in lockstep
// the simulator waits for it.
void UnlatchSim::schedIn_handler(FwIndexType, U32) {
  if (!m_active) return;
  switch (unlatch_participant_poll(&m_sim, WAIT_MS)) {
    case UNLATCH_PARTICIPANT_STATE: {
      SensorValues values;
      for (U32 i = 0; i < SensorValues::SIZE; ++i) values[i] = m_sim.state.sensors[i];
      m_inState = true;
      if (isConnected_stateOut_OutputPort(0))
        stateOut_out(0, m_sim.state.tick, m_sim.state.time_ns, static_cast<U32>(m_sim.state.sensor_count), values);
      m_inState = false;
      unlatch_participant_answer(&m_sim);
      break;
    }
    case UNLATCH_PARTICIPANT_REFUSED:
      log_WARNING_HI_Refused(m_sim.verdict.reason);
      break;
    case UNLATCH_PARTICIPANT_END:
      m_active = false;
      log_ACTIVITY_HI_SessionEnded(m_sim.state.tick);
      break;
    case UNLATCH_PARTICIPANT_NOTHING:
      break;
  }
}

void UnlatchSim::commandIn_handler(FwIndexType, const Fw::StringBase& channel, F64 value) {
  const int number = unlatch_participant_find(&m_sim, UNLATCH_CATALOG_KIND_CHANNEL, channel.toChar());
  // A command outside of a State would be for a tick that has been answered.
  if (!m_inState || number < 0 || unlatch_participant_command(&m_sim, number, value) != 0)
    log_WARNING_HI_UnknownChannel(channel);
}

}  // namespace Unlatch
