#include "unlatch_io.h"

#include <string.h>

#include "participant.h"

static struct {
  unlatch_participant sim;
  UNLATCH_IO_State_t state;
  CFE_SB_PipeId_t pipe;
  uint32 status;
  bool open;
} UNLATCH_IO;

static CFE_Status_t UNLATCH_IO_Init(void) {
  CFE_Status_t status = CFE_EVS_Register(NULL, 0, CFE_EVS_EventFilter_BINARY);
  if (status == CFE_SUCCESS) status = CFE_SB_CreatePipe(&UNLATCH_IO.pipe, 16, "UNLATCH_IO");
  if (status == CFE_SUCCESS) status = CFE_SB_Subscribe(CFE_SB_ValueToMsgId(UNLATCH_IO_COMMAND_MID), UNLATCH_IO.pipe);
  if (status == CFE_SUCCESS)
    status = CFE_MSG_Init(CFE_MSG_PTR(UNLATCH_IO.state.TelemetryHeader), CFE_SB_ValueToMsgId(UNLATCH_IO_STATE_MID),
                          sizeof UNLATCH_IO.state);
  if (status != CFE_SUCCESS) return status;
  if (unlatch_participant_open(&UNLATCH_IO.sim, UNLATCH_IO_PARTICIPANT, UNLATCH_IO_ADDRESS, UNLATCH_IO_PORT) != 0) {
    CFE_EVS_SendEvent(UNLATCH_IO_OPEN_EID, CFE_EVS_EventType_ERROR, "no socket for the simulator at %s:%d",
                      UNLATCH_IO_ADDRESS, UNLATCH_IO_PORT);
    return CFE_STATUS_EXTERNAL_RESOURCE_FAIL;
  }
  UNLATCH_IO.open = true;
  return CFE_SUCCESS;
}

/* Puts the State on the software bus. */
static void UNLATCH_IO_SendState(void) {
  const unlatch_wire_state* from = &UNLATCH_IO.sim.state;
  UNLATCH_IO_State_t* to = &UNLATCH_IO.state;
  to->Tick = from->tick;
  to->Time_ns = from->time_ns;
  to->SensorCount = (uint32)from->sensor_count;
  to->BodyCount = (uint32)from->body_count;
  memcpy(to->Sensors, from->sensors, sizeof to->Sensors);
  memcpy(to->Bodies, from->bodies, sizeof to->Bodies);
  CFE_SB_TimeStampMsg(CFE_MSG_PTR(to->TelemetryHeader));
  CFE_SB_TransmitMsg(CFE_MSG_PTR(to->TelemetryHeader), true);
}

/* Takes the commands of this tick, until the last one of it or the end of the time, whatever else comes. */
static void UNLATCH_IO_TakeCommands(void) {
  CFE_SB_Buffer_t* buffer = NULL;
  const int64 end_ms = unlatch_participant_clock_ms() + UNLATCH_IO_TIMEOUT_MS;
  int64 left_ms = UNLATCH_IO_TIMEOUT_MS;
  for (; left_ms > 0; left_ms = end_ms - unlatch_participant_clock_ms()) {
    UNLATCH_IO_Command_t command; /* a packet on the bus need not be aligned for doubles */
    CFE_MSG_Size_t size = 0;
    if (CFE_SB_ReceiveBuffer(&buffer, UNLATCH_IO.pipe, (int32)left_ms) != CFE_SUCCESS) continue;
    if (CFE_MSG_GetSize(&buffer->Msg, &size) != CFE_SUCCESS || size != sizeof command) continue;
    memcpy(&command, buffer, sizeof command);
    if (command.Tick != UNLATCH_IO.sim.state.tick) continue; /* of an earlier tick */
    command.Channel[sizeof command.Channel - 1] = '\0';
    if (command.Channel[0] != '\0') {
      const int channel = unlatch_participant_find(&UNLATCH_IO.sim, UNLATCH_CATALOG_KIND_CHANNEL, command.Channel);
      if (channel < 0 || unlatch_participant_command(&UNLATCH_IO.sim, channel, command.Value) != 0)
        CFE_EVS_SendEvent(UNLATCH_IO_CHANNEL_EID, CFE_EVS_EventType_ERROR,
                          "no channel '%s' in this session, or too many commands", command.Channel);
    }
    if (command.Last != 0) return;
  }
  CFE_EVS_SendEvent(UNLATCH_IO_LATE_EID, CFE_EVS_EventType_ERROR, "tick %ld: no last command within %d ms",
                    (long)UNLATCH_IO.sim.state.tick, UNLATCH_IO_TIMEOUT_MS);
}

int64 UNLATCH_IO_GetTime_ns(void) { return UNLATCH_IO.sim.state.time_ns; }

void UNLATCH_IO_AppMain(void) {
  UNLATCH_IO.status = CFE_ES_RunStatus_APP_RUN;
  if (UNLATCH_IO_Init() != CFE_SUCCESS) UNLATCH_IO.status = CFE_ES_RunStatus_APP_ERROR;
  while (CFE_ES_RunLoop(&UNLATCH_IO.status)) {
    switch (unlatch_participant_poll(&UNLATCH_IO.sim, 1000)) {
      case UNLATCH_PARTICIPANT_STATE:
        UNLATCH_IO_SendState();
        UNLATCH_IO_TakeCommands();
        unlatch_participant_answer(&UNLATCH_IO.sim);
        break;
      case UNLATCH_PARTICIPANT_REFUSED:
        CFE_EVS_SendEvent(UNLATCH_IO_REFUSED_EID, CFE_EVS_EventType_ERROR, "refused by the simulator, reason %d",
                          (int)UNLATCH_IO.sim.verdict.reason);
        break;
      case UNLATCH_PARTICIPANT_END:
        CFE_EVS_SendEvent(UNLATCH_IO_SESSION_EID, CFE_EVS_EventType_INFORMATION, "the session ended at tick %ld",
                          (long)UNLATCH_IO.sim.state.tick);
        UNLATCH_IO.status = CFE_ES_RunStatus_APP_EXIT;
        break;
      default:
        break;
    }
  }
  if (UNLATCH_IO.open) unlatch_participant_close(&UNLATCH_IO.sim);
  UNLATCH_IO.open = false;
  CFE_ES_ExitApp(UNLATCH_IO.status);
}
