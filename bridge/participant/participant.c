/* The datagrams are those of bridge/UDP.md. */
#define _POSIX_C_SOURCE 200112L
#include "participant.h"

#include <arpa/inet.h>
#include <errno.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

enum { kHeaderBytes = 20, kMaxBytes = kHeaderBytes + UNLATCH_WIRE_STATE_BYTES, kJoinInterval_ms = 100 };
enum { kKindAt = 12, kLengthAt = 14, kChecksumAt = 16 };
static const uint32_t kMagic = 0x554e4c31; /* "UNL1" */
static const uint32_t kAsParticipant = 1;

static int64_t get_ms(void) {
  struct timespec now;
  clock_gettime(CLOCK_MONOTONIC, &now);
  return (int64_t)now.tv_sec * 1000 + now.tv_nsec / 1000000;
}

/* CRC-32 of IEEE 802.3, to be continued from a previous result. */
static uint32_t calc_crc32(const uint8_t* bytes, size_t count, uint32_t crc) {
  size_t i;
  int bit;
  crc = ~crc;
  for (i = 0; i < count; ++i) {
    crc ^= bytes[i];
    for (bit = 0; bit < 8; ++bit) crc = (crc & 1U) != 0 ? crc >> 1 ^ 0xedb88320U : crc >> 1;
  }
  return ~crc;
}

/* Checksum of a datagram, computed as if its field for the checksum were zero. */
static uint32_t calc_checksum(const uint8_t* datagram, size_t length) {
  static const uint8_t kZero[4] = {0, 0, 0, 0};
  const uint32_t crc = calc_crc32(kZero, sizeof kZero, calc_crc32(datagram, kChecksumAt, 0));
  return calc_crc32(datagram + kHeaderBytes, length - kHeaderBytes, crc);
}

/* `payload` bytes stand behind the header. Without a simulator the datagram is lost, which is no error. */
static void send_datagram(unlatch_participant* p, uint8_t* datagram, int kind, size_t payload) {
  const size_t length = kHeaderBytes + payload;
  uint8_t* to = unlatch_wire_put(datagram, kMagic, 4);
  to = unlatch_wire_put(to, p->run, 4);
  to = unlatch_wire_put(to, p->sequence++, 4);
  to = unlatch_wire_put(to, (uint64_t)kind, 2);
  to = unlatch_wire_put(to, payload, 2);
  unlatch_wire_put(to, calc_checksum(datagram, length), 4);
  if (send(p->socket, datagram, length, 0) < 0) errno = 0;
}

static void join(unlatch_participant* p) {
  uint8_t datagram[kHeaderBytes + 4];
  unlatch_wire_put(datagram + kHeaderBytes, kAsParticipant, 4);
  send_datagram(p, datagram, 0, 4);
  p->joined_ms = get_ms();
}

static void introduce(unlatch_participant* p) {
  uint8_t datagram[kHeaderBytes + UNLATCH_WIRE_HELLO_ACK_BYTES];
  const size_t payload =
      unlatch_wire_encode_hello_ack(&p->introduction, datagram + kHeaderBytes, sizeof datagram - kHeaderBytes);
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
  expected = hello->channel_count + hello->sensor_count + hello->signal_count;
  if (p->item_count >= (expected < UNLATCH_PARTICIPANT_ITEMS ? expected : UNLATCH_PARTICIPANT_ITEMS)) introduce(p);
}

static void hear_catalog(unlatch_participant* p, const unlatch_wire_catalog* item) {
  int i;
  if (item->session != p->hello.session || p->item_count == UNLATCH_PARTICIPANT_ITEMS) return;
  if (item->kind != UNLATCH_CATALOG_KIND_CHANNEL && item->kind != UNLATCH_CATALOG_KIND_SENSOR &&
      item->kind != UNLATCH_CATALOG_KIND_SIGNAL) {
    return;
  }
  for (i = 0; i < p->item_count; ++i) {
    if (p->items[i].kind == item->kind && p->items[i].index == item->index) return;
  }
  p->items[p->item_count] = *item;
  p->items[p->item_count++].name[UNLATCH_WIRE_NAME_LENGTH - 1] = 0;
}

static void send_answer(unlatch_participant* p) {
  uint8_t datagram[kHeaderBytes + UNLATCH_WIRE_COMMAND_BYTES + UNLATCH_WIRE_STEP_ACK_BYTES];
  unlatch_wire_step_ack ack;
  int i;
  for (i = 0; i < p->command_count; ++i) {
    send_datagram(p, datagram, UNLATCH_WIRE_COMMAND_KIND,
                  unlatch_wire_encode_command(&p->commands[i], datagram + kHeaderBytes, UNLATCH_WIRE_COMMAND_BYTES));
  }
  ack.session = p->hello.session;
  ack.sequence = p->state.sequence;
  ack.tick = p->state.tick;
  ack.last_command = p->last_command;
  ack.participant = p->introduction.participant;
  ack.command_count = p->command_count;
  send_datagram(p, datagram, UNLATCH_WIRE_STEP_ACK_KIND,
                unlatch_wire_encode_step_ack(&ack, datagram + kHeaderBytes, UNLATCH_WIRE_STEP_ACK_BYTES));
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

/* The message's number, with its bytes from `payload` on; −1: the datagram is none of ours; 0: a join. */
static int read_datagram(const uint8_t* datagram, size_t length) {
  uint64_t magic, kind, payload, checksum;
  if (length < kHeaderBytes) return -1;
  unlatch_wire_get(datagram, &magic, 4);
  unlatch_wire_get(datagram + kKindAt, &kind, 2);
  unlatch_wire_get(datagram + kLengthAt, &payload, 2);
  unlatch_wire_get(datagram + kChecksumAt, &checksum, 4);
  if (magic != kMagic || payload != length - kHeaderBytes || checksum != calc_checksum(datagram, length)) return -1;
  return (int)kind;
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

int unlatch_participant_open(unlatch_participant* p, const char* name, const char* address, uint16_t port) {
  struct sockaddr_in to;
  struct timespec now;
  const size_t length = strlen(name);
  memset(p, 0, sizeof *p);
  memset(&to, 0, sizeof to);
  to.sin_family = AF_INET;
  to.sin_port = htons(port);
  if (length == 0 || length >= UNLATCH_WIRE_NAME_LENGTH || inet_pton(AF_INET, address, &to.sin_addr) != 1) {
    errno = EINVAL;
    return -1;
  }
  p->socket = socket(AF_INET, SOCK_DGRAM, 0);
  if (p->socket < 0) return -1;
  if (connect(p->socket, (const struct sockaddr*)&to, sizeof to) != 0) { /* what comes from elsewhere is kept away */
    close(p->socket);
    return -1;
  }
  clock_gettime(CLOCK_REALTIME, &now); /* distinguishes this start from others */
  p->run = (uint32_t)now.tv_nsec ^ (uint32_t)now.tv_sec << 8 ^ (uint32_t)getpid() << 16;
  p->introduction.participant = (int32_t)(p->run & 0x7fffffffU);
  memcpy(p->introduction.name, name, length);
  p->answered_tick = -1;
  join(p);
  return 0;
}

unlatch_participant_event unlatch_participant_poll(unlatch_participant* p, int wait_ms) {
  uint8_t datagram[kMaxBytes + 1];
  const int64_t end_ms = get_ms() + wait_ms;
  for (;;) {
    struct pollfd waiting;
    int64_t left_ms, now_ms = get_ms();
    int kind;
    if (now_ms - p->joined_ms >= kJoinInterval_ms) join(p);
    left_ms = end_ms - now_ms;
    if (left_ms < 0) left_ms = 0;
    waiting.fd = p->socket;
    waiting.events = POLLIN;
    waiting.revents = 0;
    if (poll(&waiting, 1, (int)(left_ms < kJoinInterval_ms ? left_ms : kJoinInterval_ms)) > 0) {
      const ssize_t length = recv(p->socket, datagram, sizeof datagram, 0);
      if (length >= 0) {
        kind = read_datagram(datagram, (size_t)length);
        if (kind < 0) {
          ++p->malformed;
        } else {
          const unlatch_participant_event event =
              handle(p, kind, datagram + kHeaderBytes, (size_t)length - kHeaderBytes);
          if (event != UNLATCH_PARTICIPANT_NOTHING) return event;
        }
      }
    }
    if (get_ms() >= end_ms) return UNLATCH_PARTICIPANT_NOTHING;
  }
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
  if (channel < 0 || p->command_count == UNLATCH_PARTICIPANT_COMMANDS) return -1;
  command = &p->commands[p->command_count++];
  command->session = p->hello.session;
  command->sequence = ++p->last_command;
  command->tick = p->state.tick;
  command->valid_until_tick = -1;
  command->value = value;
  command->participant = p->introduction.participant;
  command->channel = channel;
  return 0;
}

void unlatch_participant_answer(unlatch_participant* p) {
  p->answered_tick = p->state.tick;
  send_answer(p);
}

void unlatch_participant_close(unlatch_participant* p) {
  p->introduction.status = UNLATCH_ACK_STATUS_LEAVING;
  if (p->introduction.session != 0) introduce(p);
  close(p->socket);
  p->socket = -1;
}
