/* cFS application UNLATCH_IO: the simulator on the software bus. Copy this file, unlatch_io.c, participant.{h,c},
 * unlatch_wire.h and unlatch_frame.h into apps/unlatch_io/fsw/src.
 *
 * Each State leaves as one telemetry packet, UNLATCH_IO_STATE_MID. Control applications answer with command packets,
 * UNLATCH_IO_COMMAND_MID: any number of channels of a tick, and the tick is over with the packet whose `last` is 1. */
#ifndef UNLATCH_IO_H_
#define UNLATCH_IO_H_

#include "cfe.h"
#include "unlatch_wire.h"

/* Message identifiers, name, address: yours. These identifiers are an example, which no application of the public cFS
 * bundle has; the mission assigns its own. */
#ifndef UNLATCH_IO_STATE_MID
#define UNLATCH_IO_STATE_MID 0x08E8
#endif
#ifndef UNLATCH_IO_COMMAND_MID
#define UNLATCH_IO_COMMAND_MID 0x18E8
#endif
#ifndef UNLATCH_IO_PARTICIPANT
#define UNLATCH_IO_PARTICIPANT "fsw" /* as the scenario requires it: flight_software: {required: [fsw]} */
#endif
#define UNLATCH_IO_ADDRESS "127.0.0.1"
#define UNLATCH_IO_PORT 7670
#define UNLATCH_IO_TIMEOUT_MS 1000 /* wall time until the command that ends a tick; then it is answered without it */

/* Event identifiers. */
#define UNLATCH_IO_OPEN_EID 1
#define UNLATCH_IO_SESSION_EID 2
#define UNLATCH_IO_REFUSED_EID 3
#define UNLATCH_IO_LATE_EID 4
#define UNLATCH_IO_CHANNEL_EID 5

typedef struct {
  CFE_MSG_TelemetryHeader_t TelemetryHeader;
  int64 Tick;
  int64 Time_ns;
  uint32 SensorCount;
  uint32 BodyCount;
  double Sensors[UNLATCH_WIRE_SENSORS_PER_PART]; /* in the order of the session's catalog */
  unlatch_wire_body_state Bodies[UNLATCH_WIRE_BODIES_PER_PART];
} UNLATCH_IO_State_t;

typedef struct {
  CFE_MSG_CommandHeader_t CommandHeader;
  int64 Tick;       /* of the State that it answers */
  double Value;     /* in the channel's unit */
  char Channel[48]; /* its name; empty: none */
  uint32 Last;      /* 1: no other follows for this tick */
} UNLATCH_IO_Command_t;

void UNLATCH_IO_AppMain(void);
/* Simulated time of the present State, ns: for cFE TIME. */
int64 UNLATCH_IO_GetTime_ns(void);

#endif
