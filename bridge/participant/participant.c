/* The datagrams are those of bridge/UDP.md. UNLATCH_PARTICIPANT_WITHOUT_SOCKETS leaves out what needs an operating
 * system: unlatch_participant_open(), _poll(), _close() and _clock_ms(). */
#ifndef UNLATCH_PARTICIPANT_WITHOUT_SOCKETS
#define _POSIX_C_SOURCE 200112L
#include <arpa/inet.h>
#include <errno.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>
#endif

#include "participant.h"

/* A message of `payload` bytes stands behind the header. */
static void send_datagram(unlatch_participant* p, uint8_t* datagram, int kind, size_t payload) {
  p->send(p, datagram, unlatch_frame_seal(datagram, p->run, p->sequence++, kind, payload));
}

void unlatch_participant_join(unlatch_participant* p) {
  uint8_t datagram[UNLATCH_FRAME_HEADER_BYTES + UNLATCH_FRAME_JOIN_BYTES];
  p->send(p, datagram, unlatch_frame_build_join(datagram, p->run, p->sequence++));
}

static void introduce(unlatch_participant* p) {
  uint8_t datagram[UNLATCH_FRAME_HEADER_BYTES + UNLATCH_WIRE_HELLO_ACK_BYTES];
  const size_t payload = unlatch_wire_encode_hello_ack(&p->introduction, datagram + UNLATCH_FRAME_HEADER_BYTES,
                                                       sizeof datagram - UNLATCH_FRAME_HEADER_BYTES);
  send_datagram(p, datagram, UNLATCH_WIRE_HELLO_ACK_KIND, payload);
  ++p->introduction.sequence;
}

/* Answered once the catalog is complete; Hello comes again and again. */
static void hear_hello(unlatch_participant* p, const unlatch_wire_hello* hello) {
  int expected;
  if (hello->status >= UNLATCH_RUN_STATUS_DONE) return;
  if (hello->session != p->hello.session) {
    p->item_count = p->command_count = 0;
    p->answered_tick = -1;
    p->last_command = 0;
    p->introduction.session = hello->session;
    p->introduction.sequence = 0;
    p->introduction.schema_hash = UNLATCH_WIRE_SCHEMA_HASH;
    p->introduction.protocol = UNLATCH_WIRE_PROTOCOL;
    p->introduction.model_hash = hello->model_hash;
    p->introduction.dt_ns = hello->dt_ns;
    p->introduction.status = UNLATCH_ACK_STATUS_READY;
  }
  p->hello = *hello;
  expected = hello->channel_count + hello->sensor_count + hello->signal_count +
             (hello->body_count < UNLATCH_WIRE_BODIES_PER_PART ? hello->body_count : UNLATCH_WIRE_BODIES_PER_PART);
  if (p->item_count >= (expected < UNLATCH_PARTICIPANT_ITEMS ? expected : UNLATCH_PARTICIPANT_ITEMS)) introduce(p);
}

static void hear_catalog(unlatch_participant* p, const unlatch_wire_catalog* item) {
  int i;
  if (item->session != p->hello.session || p->item_count == UNLATCH_PARTICIPANT_ITEMS) return;
  if (item->kind != UNLATCH_CATALOG_KIND_CHANNEL && item->kind != UNLATCH_CATALOG_KIND_SENSOR &&
      item->kind != UNLATCH_CATALOG_KIND_SIGNAL &&
      (item->kind != UNLATCH_CATALOG_KIND_BODY || item->index >= UNLATCH_WIRE_BODIES_PER_PART)) {
    return;
  }
  for (i = 0; i < p->item_count; ++i) {
    if (p->items[i].kind == item->kind && p->items[i].index == item->index) return;
  }
  p->items[p->item_count] = *item;
  p->items[p->item_count++].name[UNLATCH_WIRE_NAME_LENGTH - 1] = 0;
}

static void send_answer(unlatch_participant* p) {
  uint8_t datagram[UNLATCH_FRAME_HEADER_BYTES + UNLATCH_WIRE_COMMAND_BYTES + UNLATCH_WIRE_STEP_ACK_BYTES];
  unlatch_wire_step_ack ack;
  int i;
  for (i = 0; i < p->command_count; ++i) {
    send_datagram(p, datagram, UNLATCH_WIRE_COMMAND_KIND,
                  unlatch_wire_encode_command(&p->commands[i], datagram + UNLATCH_FRAME_HEADER_BYTES,
                                              UNLATCH_WIRE_COMMAND_BYTES));
  }
  ack.session = p->hello.session;
  ack.sequence = p->state.sequence;
  ack.tick = p->state.tick;
  ack.last_command = p->last_command;
  ack.participant = p->introduction.participant;
  ack.command_count = p->command_count;
  send_datagram(p, datagram, UNLATCH_WIRE_STEP_ACK_KIND,
                unlatch_wire_encode_step_ack(&ack, datagram + UNLATCH_FRAME_HEADER_BYTES, UNLATCH_WIRE_STEP_ACK_BYTES));
}

static unlatch_participant_event hear_state(unlatch_participant* p, const unlatch_wire_state* state) {
  if (state->session != p->hello.session || state->part != 0) return UNLATCH_PARTICIPANT_NOTHING;
  if (state->status >= UNLATCH_RUN_STATUS_DONE) {
    p->state = *state;
    return UNLATCH_PARTICIPANT_END;
  }
  if (p->introduction.sequence == 0) return UNLATCH_PARTICIPANT_NOTHING;
  if (state->tick == p->answered_tick) send_answer(p); /* resent */
  if (state->tick <= p->answered_tick) return UNLATCH_PARTICIPANT_NOTHING;
  p->state = *state;
  p->command_count = 0;
  return UNLATCH_PARTICIPANT_STATE;
}

static unlatch_participant_event handle(unlatch_participant* p, int kind, const uint8_t* from, size_t length) {
  unlatch_wire_hello hello;
  unlatch_wire_catalog item;
  unlatch_wire_state state;
  switch (kind) {
    case UNLATCH_WIRE_HELLO_KIND:
      if (unlatch_wire_decode_hello(&hello, from, length)) hear_hello(p, &hello);
      break;
    case UNLATCH_WIRE_CATALOG_KIND:
      if (unlatch_wire_decode_catalog(&item, from, length)) hear_catalog(p, &item);
      break;
    case UNLATCH_WIRE_STATE_KIND:
      if (unlatch_wire_decode_state(&state, from, length)) return hear_state(p, &state);
      break;
    case UNLATCH_WIRE_VERDICT_KIND:
      if (!unlatch_wire_decode_verdict(&p->verdict, from, length)) break;
      if (p->verdict.session == p->hello.session && p->verdict.participant == p->introduction.participant) {
        return UNLATCH_PARTICIPANT_REFUSED;
      }
      break;
    default:
      break;
  }
  return UNLATCH_PARTICIPANT_NOTHING;
}

void unlatch_participant_begin(unlatch_participant* p, const char* name, uint32_t number, unlatch_participant_send send,
                               void* link) {
  size_t i;
  memset(p, 0, sizeof *p);
  p->run = number;
  p->send = send;
  p->link = link;
  p->socket = -1;
  p->introduction.participant = (int32_t)(number & 0x7fffffffU);
  for (i = 0; name[i] != 0 && i + 1 < UNLATCH_WIRE_NAME_LENGTH; ++i) p->introduction.name[i] = (uint8_t)name[i];
  p->answered_tick = -1;
}

unlatch_participant_event unlatch_participant_hear(unlatch_participant* p, const uint8_t* datagram, size_t length) {
  unlatch_frame frame;
  if (!unlatch_frame_read(&frame, datagram, length)) {
    ++p->malformed;
    return UNLATCH_PARTICIPANT_NOTHING;
  }
  return handle(p, frame.kind, frame.payload, frame.length);
}

int unlatch_participant_find(const unlatch_participant* p, int kind, const char* name) {
  int i;
  for (i = 0; i < p->item_count; ++i) {
    if (p->items[i].kind == kind && strcmp((const char*)p->items[i].name, name) == 0) return p->items[i].index;
  }
  return -1;
}

int unlatch_participant_command(unlatch_participant* p, int channel, double value) {
  unlatch_wire_command* command;
  if (p->command_count == UNLATCH_PARTICIPANT_COMMANDS) return -1;
  command = &p->commands[p->command_count++];
  command->session = p->hello.session;
  command->sequence = ++p->last_command;
  command->tick = p->state.tick;
  command->valid_until_tick = -1;
  command->value = value;
  command->participant = p->introduction.participant;
  command->channel = channel;
  return channel < 0 ? -1 : 0;
}

void unlatch_participant_answer(unlatch_participant* p) {
  p->answered_tick = p->state.tick;
  send_answer(p);
}

void unlatch_participant_leave(unlatch_participant* p) {
  p->introduction.status = UNLATCH_ACK_STATUS_LEAVING;
  if (p->introduction.session != 0) introduce(p);
}

#ifndef UNLATCH_PARTICIPANT_WITHOUT_SOCKETS

enum { kJoinInterval_ms = 100 };

int64_t unlatch_participant_clock_ms(void) {
  struct timespec now;
  clock_gettime(CLOCK_MONOTONIC, &now);
  return (int64_t)now.tv_sec * 1000 + now.tv_nsec / 1000000;
}

/* Without a simulator the datagram is lost, which is no error. */
static void send_to_socket(unlatch_participant* p, const uint8_t* datagram, size_t length) {
  if (send(p->socket, datagram, length, 0) < 0) errno = 0;
}

static void join(unlatch_participant* p) {
  unlatch_participant_join(p);
  p->joined_ms = unlatch_participant_clock_ms();
}

int unlatch_participant_open(unlatch_participant* p, const char* name, const char* address, uint16_t port) {
  struct sockaddr_in to;
  struct timespec now;
  const size_t length = strlen(name);
  memset(&to, 0, sizeof to);
  to.sin_family = AF_INET;
  to.sin_port = htons(port);
  p->send = NULL;
  p->socket = -1;
  if (length == 0 || length >= UNLATCH_WIRE_NAME_LENGTH || inet_pton(AF_INET, address, &to.sin_addr) != 1) {
    errno = EINVAL;
    return -1;
  }
  clock_gettime(CLOCK_REALTIME, &now); /* distinguishes this start from others */
  unlatch_participant_begin(p, name, (uint32_t)now.tv_nsec ^ (uint32_t)now.tv_sec << 8 ^ (uint32_t)getpid() << 16,
                            send_to_socket, NULL);
  p->socket = socket(AF_INET, SOCK_DGRAM, 0);
  if (p->socket < 0) return -1;
  if (connect(p->socket, (const struct sockaddr*)&to, sizeof to) != 0) { /* what comes from elsewhere is kept away */
    close(p->socket);
    p->socket = -1;
    return -1;
  }
  join(p);
  return 0;
}

unlatch_participant_event unlatch_participant_poll(unlatch_participant* p, int wait_ms) {
  uint8_t datagram[UNLATCH_FRAME_LONGEST + 1];
  const int64_t end_ms = unlatch_participant_clock_ms() + wait_ms;
  for (;;) {
    struct pollfd waiting;
    int64_t left_ms, now_ms = unlatch_participant_clock_ms();
    if (now_ms - p->joined_ms >= kJoinInterval_ms) join(p);
    left_ms = end_ms - now_ms;
    if (left_ms < 0) left_ms = 0;
    waiting.fd = p->socket;
    waiting.events = POLLIN;
    waiting.revents = 0;
    if (poll(&waiting, 1, (int)(left_ms < kJoinInterval_ms ? left_ms : kJoinInterval_ms)) > 0) {
      const ssize_t length = recv(p->socket, datagram, sizeof datagram, 0);
      if (length >= 0) {
        const unlatch_participant_event event = unlatch_participant_hear(p, datagram, (size_t)length);
        if (event != UNLATCH_PARTICIPANT_NOTHING) return event;
      }
    }
    if (unlatch_participant_clock_ms() >= end_ms) return UNLATCH_PARTICIPANT_NOTHING;
  }
}

void unlatch_participant_close(unlatch_participant* p) {
  if (p->send == NULL || p->socket < 0) return;
  unlatch_participant_leave(p);
  close(p->socket);
  p->socket = -1;
}

#endif
