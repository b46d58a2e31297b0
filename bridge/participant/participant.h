/* A participant in C99 over plain UDP, without any library: copy this file, participant.c, schema/unlatch_wire.h and
 * schema/unlatch_frame.h into your flight software (cFS, F´, an RTOS with BSD sockets, a Simulink S-function). It
 * introduces itself, finds numbers of channels and sensors by name, and answers States as hil/PROTOCOL.md demands, also
 * those that are resent.
 *
 *   unlatch_participant p;
 *   if (unlatch_participant_open(&p, "pilot", "127.0.0.1", 7670) != 0) return 1;
 *   for (;;) switch (unlatch_participant_poll(&p, 1000)) {
 *     case UNLATCH_PARTICIPANT_STATE:            // a new tick: p.state
 *       unlatch_participant_command(&p, unlatch_participant_find(&p, UNLATCH_CATALOG_KIND_CHANNEL, "throttle"), 1.0);
 *       unlatch_participant_answer(&p);          // once for each State
 *       break;
 *     case UNLATCH_PARTICIPANT_END: unlatch_participant_close(&p); return 0;
 *   }
 *
 * Without an operating system, over a serial line of your own (bridge/target): unlatch_participant_begin() with a
 * function that sends, unlatch_participant_join() every 100 ms, and unlatch_participant_hear() for each frame.
 *
 * Nothing allocates; one thread. Of systems with more than 64 sensor values or 16 bodies it reads the first part of a
 * State. */
#ifndef UNLATCH_PARTICIPANT_H_
#define UNLATCH_PARTICIPANT_H_

#include "unlatch_frame.h"
#include "unlatch_wire.h"

#ifdef __cplusplus
extern "C" {
#endif

enum { UNLATCH_PARTICIPANT_ITEMS = 1024 };   /* channels, sensor values, signals, and bodies of p->state; at most */
enum { UNLATCH_PARTICIPANT_COMMANDS = 256 }; /* of one tick, at most */

typedef enum unlatch_participant_event {
  UNLATCH_PARTICIPANT_NOTHING, /* the time is over, or what came needs no answer of yours */
  UNLATCH_PARTICIPANT_STATE,   /* a new tick: decide, command, answer */
  UNLATCH_PARTICIPANT_END,     /* the session is over: p->state.status says how */
  UNLATCH_PARTICIPANT_REFUSED  /* p->verdict: one of our messages was refused, and why */
} unlatch_participant_event;

typedef struct unlatch_participant unlatch_participant;
/* Sends a datagram, or a frame of a serial line; one that is lost is sent again. */
typedef void (*unlatch_participant_send)(unlatch_participant* p, const uint8_t* datagram, size_t length);

struct unlatch_participant {
  /* To read. */
  unlatch_wire_hello hello;
  unlatch_wire_state state;
  unlatch_wire_verdict verdict;
  int64_t malformed; /* datagrams that were none */

  /* Its own. */
  unlatch_participant_send send;
  void* link; /* for send() */
  int socket;
  uint32_t run, sequence;
  int64_t answered_tick, last_command, joined_ms;
  unlatch_wire_hello_ack introduction;
  unlatch_wire_catalog items[UNLATCH_PARTICIPANT_ITEMS];
  int item_count;
  unlatch_wire_command commands[UNLATCH_PARTICIPANT_COMMANDS]; /* of answered_tick, for when its State is resent */
  int command_count;
};

/* Joins the simulator at that IPv4 address, which need not run yet. `name`: as the scenario requires it. 0, or −1 with
 * errno. */
int unlatch_participant_open(unlatch_participant* p, const char* name, const char* address, uint16_t port);
/* Waits for a datagram at most `wait_ms` and handles it. */
unlatch_participant_event unlatch_participant_poll(unlatch_participant* p, int wait_ms);
/* The same for a link of your own. `number`: another one for each start. The name is cut where it is too long. */
void unlatch_participant_begin(unlatch_participant* p, const char* name, uint32_t number, unlatch_participant_send send,
                               void* link);
/* Says that it is here; to be repeated every 100 ms. */
void unlatch_participant_join(unlatch_participant* p);
/* Handles one datagram or frame. */
unlatch_participant_event unlatch_participant_hear(unlatch_participant* p, const uint8_t* datagram, size_t length);
/* Says that it leaves. */
void unlatch_participant_leave(unlatch_participant* p);

/* Number of a channel, a sensor's value, a signal or a body of p->state (UNLATCH_CATALOG_KIND_…) in this session; −1:
 * there is none. */
int unlatch_participant_find(const unlatch_participant* p, int kind, const char* name);
/* A command for the tick of p->state, sent with the answer. 0; −1: too many, or no such channel. One for channel −1,
 * which a misspelt name gives, is sent all the same: the simulator refuses it, and the session fails. */
int unlatch_participant_command(unlatch_participant* p, int channel, double value);
/* Answers p->state: its commands, then StepAck. */
void unlatch_participant_answer(unlatch_participant* p);
/* Says that it leaves, and closes the socket. After an open that failed it does nothing. */
void unlatch_participant_close(unlatch_participant* p);
/* Wall time from any beginning, never set back, for limits of waiting. */
int64_t unlatch_participant_clock_ms(void);

#ifdef __cplusplus
}
#endif

#endif /* UNLATCH_PARTICIPANT_H_ */
