/* The smallest stand-in for the interface of cFE that unlatch_io.c uses, written from NASA's published interface (cFE
 * 7, Apache-2.0): names, types and meanings, no code of it. The bus is a queue; cfs_host.c has the functions. */
#ifndef CFE_H_
#define CFE_H_

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef int32_t int32;
typedef uint32_t uint32;
typedef uint16_t uint16;
typedef int64_t int64;
typedef int32 CFE_Status_t;
typedef uint32 CFE_SB_PipeId_t;
typedef uint32 CFE_SB_MsgId_t;
typedef size_t CFE_MSG_Size_t;

#define CFE_SUCCESS ((CFE_Status_t)0)
#define CFE_SB_TIME_OUT ((CFE_Status_t)-1)
#define CFE_STATUS_EXTERNAL_RESOURCE_FAIL ((CFE_Status_t)-2)

enum { CFE_ES_RunStatus_APP_RUN = 1, CFE_ES_RunStatus_APP_EXIT = 2, CFE_ES_RunStatus_APP_ERROR = 3 };
enum { CFE_EVS_EventFilter_BINARY = 0 };
enum { CFE_EVS_EventType_INFORMATION = 2, CFE_EVS_EventType_ERROR = 3 };

typedef struct {
  CFE_SB_MsgId_t id;
  uint32 size;
} CFE_MSG_Message_t;
typedef struct {
  CFE_MSG_Message_t Msg;
  uint32 time[2];
} CFE_MSG_TelemetryHeader_t;
typedef struct {
  CFE_MSG_Message_t Msg;
  uint32 function;
} CFE_MSG_CommandHeader_t;
typedef struct {
  CFE_MSG_Message_t Msg;
} CFE_SB_Buffer_t;

#define CFE_MSG_PTR(header) (&(header).Msg)
#define CFE_SB_ValueToMsgId(value) ((CFE_SB_MsgId_t)(value))

CFE_Status_t CFE_EVS_Register(const void* filters, uint16 count, uint16 scheme);
CFE_Status_t CFE_EVS_SendEvent(uint16 id, uint16 type, const char* format, ...) __attribute__((format(printf, 3, 4)));
CFE_Status_t CFE_SB_CreatePipe(CFE_SB_PipeId_t* pipe, uint16 depth, const char* name);
CFE_Status_t CFE_SB_Subscribe(CFE_SB_MsgId_t id, CFE_SB_PipeId_t pipe);
CFE_Status_t CFE_SB_TransmitMsg(const CFE_MSG_Message_t* message, bool is_origination);
CFE_Status_t CFE_SB_ReceiveBuffer(CFE_SB_Buffer_t** buffer, CFE_SB_PipeId_t pipe, int32 timeout);
void CFE_SB_TimeStampMsg(CFE_MSG_Message_t* message);
CFE_Status_t CFE_MSG_Init(CFE_MSG_Message_t* message, CFE_SB_MsgId_t id, CFE_MSG_Size_t size);
CFE_Status_t CFE_MSG_GetSize(const CFE_MSG_Message_t* message, CFE_MSG_Size_t* size);
bool CFE_ES_RunLoop(uint32* status);
void CFE_ES_ExitApp(uint32 status);

#endif
