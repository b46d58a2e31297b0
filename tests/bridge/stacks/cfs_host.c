/* Runs bridge/stacks/cfs/unlatch_io.c on a software bus of our own, with a control application that flies
 * bridge/examples/probe.yaml like the pilot: throttle open at tick 100, shut at tick 300. Exit code 1 if the
 * application reported an error.
 *
 *   cfs_host fail   the application's initialisation fails: exit code 0 if standard input is open afterwards
 *   cfs_host stale  at tick 5 no last command comes, but packets of an earlier tick without end */
#define _POSIX_C_SOURCE 200112L
#include <fcntl.h>
#include <poll.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "unlatch_io.h"

enum { kDepth = 16 };
static UNLATCH_IO_Command_t queue[kDepth]; /* the pipe of UNLATCH_IO */
static UNLATCH_IO_Command_t taken;
static int waiting;
static CFE_SB_MsgId_t subscribed;
static int errors;
static uint32 ended;
static bool fails, is_stale;

/* --- The control application: it runs when a State comes, as one of higher priority does. */

static void send(int64 tick, const char* channel, double value, uint32 last) {
  static UNLATCH_IO_Command_t command;
  CFE_MSG_Init(CFE_MSG_PTR(command.CommandHeader), CFE_SB_ValueToMsgId(UNLATCH_IO_COMMAND_MID), sizeof command);
  command.Tick = tick;
  command.Value = value;
  command.Last = last;
  memset(command.Channel, 0, sizeof command.Channel);
  strncpy(command.Channel, channel, sizeof command.Channel - 1);
  CFE_SB_TransmitMsg(CFE_MSG_PTR(command.CommandHeader), true);
}

static void control(const UNLATCH_IO_State_t* state) {
  if (state->SensorCount != 3 || state->BodyCount != 1) ++errors;
  if (state->Tick == 150) send(state->Tick - 1, "throttle", 0.5, 0); /* of an earlier tick: not taken */
  if (state->Tick == 100 || state->Tick == 300) send(state->Tick, "throttle", state->Tick == 100 ? 1 : 0, 0);
  if (is_stale && state->Tick == 5) return;
  is_stale = is_stale && state->Tick < 5;
  send(state->Tick, "", 0, 1);
}

/* --- The bus. */

CFE_Status_t CFE_SB_TransmitMsg(const CFE_MSG_Message_t* message, bool is_origination) {
  (void)is_origination;
  if (message->id == UNLATCH_IO_STATE_MID) control((const UNLATCH_IO_State_t*)(const void*)message);
  if (message->id != subscribed) return CFE_SUCCESS;
  if (waiting == kDepth || message->size != sizeof queue[0]) return CFE_SB_TIME_OUT;
  memcpy(&queue[waiting++], message, sizeof queue[0]);
  return CFE_SUCCESS;
}
CFE_Status_t CFE_SB_ReceiveBuffer(CFE_SB_Buffer_t** buffer, CFE_SB_PipeId_t pipe, int32 timeout) {
  (void)pipe;
  if (waiting == 0 && is_stale && UNLATCH_IO_GetTime_ns() == 5000000) {
    poll(NULL, 0, 1);
    send(4, "", 0, 1);
  }
  if (waiting == 0) {
    poll(NULL, 0, timeout);
    return CFE_SB_TIME_OUT;
  }
  taken = queue[0];
  memmove(queue, queue + 1, (size_t)--waiting * sizeof queue[0]);
  *buffer = (CFE_SB_Buffer_t*)(void*)&taken;
  return CFE_SUCCESS;
}
CFE_Status_t CFE_SB_CreatePipe(CFE_SB_PipeId_t* pipe, uint16 depth, const char* name) {
  (void)name;
  *pipe = 1;
  return depth <= kDepth ? CFE_SUCCESS : CFE_SB_TIME_OUT;
}
CFE_Status_t CFE_SB_Subscribe(CFE_SB_MsgId_t id, CFE_SB_PipeId_t pipe) {
  subscribed = id;
  return pipe == 1 ? CFE_SUCCESS : CFE_SB_TIME_OUT;
}
void CFE_SB_TimeStampMsg(CFE_MSG_Message_t* message) { (void)message; }
CFE_Status_t CFE_MSG_Init(CFE_MSG_Message_t* message, CFE_SB_MsgId_t id, CFE_MSG_Size_t size) {
  memset(message, 0, size);
  message->id = id;
  message->size = (uint32)size;
  return CFE_SUCCESS;
}
CFE_Status_t CFE_MSG_GetSize(const CFE_MSG_Message_t* message, CFE_MSG_Size_t* size) {
  *size = message->size;
  return CFE_SUCCESS;
}
CFE_Status_t CFE_EVS_Register(const void* filters, uint16 count, uint16 scheme) {
  return !fails && filters == NULL && count == 0 && scheme == CFE_EVS_EventFilter_BINARY ? CFE_SUCCESS
                                                                                         : CFE_SB_TIME_OUT;
}
CFE_Status_t CFE_EVS_SendEvent(uint16 id, uint16 type, const char* format, ...) {
  va_list arguments;
  va_start(arguments, format);
  printf("UNLATCH_IO %d: ", (int)id);
  vprintf(format, arguments);
  printf("\n");
  va_end(arguments);
  errors += type == CFE_EVS_EventType_ERROR ? 1 : 0;
  return CFE_SUCCESS;
}
bool CFE_ES_RunLoop(uint32* status) { return *status == CFE_ES_RunStatus_APP_RUN; }
void CFE_ES_ExitApp(uint32 status) { ended = status; }

int main(int count, char** arguments) {
  fails = count > 1 && strcmp(arguments[1], "fail") == 0;
  is_stale = count > 1 && strcmp(arguments[1], "stale") == 0;
  UNLATCH_IO_AppMain();
  if (fails) return fcntl(0, F_GETFD) != -1 && ended == CFE_ES_RunStatus_APP_ERROR ? 0 : 1;
  return errors == 0 && ended == CFE_ES_RunStatus_APP_EXIT ? 0 : 1;
}
