/* Frames of UDP and of serial lines for C99 and C++ without any library: a header with sequence and CRC-32, then a
 * message of unlatch_wire.h. bridge/UDP.md describes the header, bridge/UART.md a stream of frames.
 *
 *   unlatch_frame_seal()    writes the header of a message that stands behind it
 *   unlatch_frame_read()    reads one whole frame: a datagram
 *   unlatch_frame_push(), unlatch_frame_next()
 *                           find the frames in a stream of bytes; no frame is lost behind noise
 *   unlatch_frame_is_new()  refuses frames that are late or come twice
 *
 * Nothing allocates. */
#ifndef UNLATCH_FRAME_H_
#define UNLATCH_FRAME_H_

#include "unlatch_wire.h"

enum {
  UNLATCH_FRAME_HEADER_BYTES = 20,
  UNLATCH_FRAME_JOIN_BYTES = 4,
  UNLATCH_FRAME_LONGEST_MESSAGE = UNLATCH_WIRE_STATE_BYTES,
  UNLATCH_FRAME_LONGEST = UNLATCH_FRAME_HEADER_BYTES + UNLATCH_FRAME_LONGEST_MESSAGE
};
enum { UNLATCH_FRAME_JOIN_KIND = 0, UNLATCH_FRAME_LAST_KIND = UNLATCH_WIRE_SOURCE_KIND };
enum { UNLATCH_FRAME_AS_PARTICIPANT = 1 };
#define UNLATCH_FRAME_MAGIC UINT64_C(0x554e4c31) /* "UNL1" */

typedef struct unlatch_frame {
  uint32_t run, sequence;
  int kind; /* UNLATCH_WIRE_…_KIND, or UNLATCH_FRAME_JOIN_KIND */
  const uint8_t* payload;
  size_t length; /* of the payload */
} unlatch_frame;

/* CRC-32 of IEEE 802.3, to be continued from a previous result. */
static inline uint32_t unlatch_frame_crc32(const uint8_t* bytes, size_t count, uint32_t crc) {
  size_t i;
  int bit;
  crc = ~crc;
  for (i = 0; i < count; ++i) {
    crc ^= bytes[i];
    for (bit = 0; bit < 8; ++bit) crc = (crc & 1U) != 0 ? crc >> 1 ^ 0xedb88320U : crc >> 1;
  }
  return ~crc;
}

/* Checksum of a frame, computed as if its field for the checksum were zero. */
static inline uint32_t unlatch_frame_checksum(const uint8_t* frame, size_t length) {
  static const uint8_t kZero[4] = {0, 0, 0, 0};
  const uint32_t crc = unlatch_frame_crc32(kZero, 4, unlatch_frame_crc32(frame, 16, 0));
  return unlatch_frame_crc32(frame + UNLATCH_FRAME_HEADER_BYTES, length - UNLATCH_FRAME_HEADER_BYTES, crc);
}

/* `payload` bytes stand behind the header's place. Returns the frame's length. */
static inline size_t unlatch_frame_seal(uint8_t* frame, uint32_t run, uint32_t sequence, int kind, size_t payload) {
  const size_t length = UNLATCH_FRAME_HEADER_BYTES + payload;
  uint8_t* to = unlatch_wire_put(frame, UNLATCH_FRAME_MAGIC, 4);
  to = unlatch_wire_put(to, run, 4);
  to = unlatch_wire_put(to, sequence, 4);
  to = unlatch_wire_put(to, (uint64_t)kind, 2);
  to = unlatch_wire_put(to, payload, 2);
  unlatch_wire_put(to, unlatch_frame_checksum(frame, length), 4);
  return length;
}

/* A participant's join. `frame`: UNLATCH_FRAME_HEADER_BYTES + UNLATCH_FRAME_JOIN_BYTES. */
static inline size_t unlatch_frame_build_join(uint8_t* frame, uint32_t run, uint32_t sequence) {
  unlatch_wire_put(frame + UNLATCH_FRAME_HEADER_BYTES, UNLATCH_FRAME_AS_PARTICIPANT, UNLATCH_FRAME_JOIN_BYTES);
  return unlatch_frame_seal(frame, run, sequence, UNLATCH_FRAME_JOIN_KIND, UNLATCH_FRAME_JOIN_BYTES);
}

/* What the first bytes of a stream say: length of the frame that begins here; 0: too few bytes to say; -1: none. */
static inline int unlatch_frame_measure(const uint8_t* bytes, size_t count) {
  uint64_t kind, payload;
  size_t i;
  for (i = 0; i < count && i < 4; ++i) {
    if (bytes[i] != (uint8_t)(UNLATCH_FRAME_MAGIC >> (24 - 8 * i))) return -1;
  }
  if (count < UNLATCH_FRAME_HEADER_BYTES) return 0;
  unlatch_wire_get(bytes + 12, &kind, 2);
  unlatch_wire_get(bytes + 14, &payload, 2);
  if (payload > UNLATCH_FRAME_LONGEST_MESSAGE || kind > UNLATCH_FRAME_LAST_KIND) return -1;
  return (int)(UNLATCH_FRAME_HEADER_BYTES + payload);
}

/* 0 unless these bytes are exactly one frame with the right checksum. The message is unlatch_wire_decode_X()'s to
 * judge. */
static inline int unlatch_frame_read(unlatch_frame* frame, const uint8_t* bytes, size_t length) {
  uint64_t run, sequence, kind, checksum;
  const int measured = unlatch_frame_measure(bytes, length);
  if (measured <= 0 || (size_t)measured != length) return 0;
  unlatch_wire_get(bytes + 4, &run, 4);
  unlatch_wire_get(bytes + 8, &sequence, 4);
  unlatch_wire_get(bytes + 12, &kind, 2);
  unlatch_wire_get(bytes + 16, &checksum, 4);
  if (checksum != unlatch_frame_checksum(bytes, length)) return 0;
  frame->run = (uint32_t)run;
  frame->sequence = (uint32_t)sequence;
  frame->kind = (int)kind;
  frame->payload = bytes + UNLATCH_FRAME_HEADER_BYTES;
  frame->length = length - UNLATCH_FRAME_HEADER_BYTES;
  return 1;
}

/* Frames in a stream of bytes; begins with all zero. */
typedef struct unlatch_frame_stream {
  uint8_t bytes[2 * UNLATCH_FRAME_LONGEST];
  size_t begin, end; /* of what has not been read */
  int in_gap;
  int64_t gaps; /* runs of bytes that belong to no frame */
} unlatch_frame_stream;

static inline void unlatch_frame_skip(unlatch_frame_stream* stream) {
  stream->gaps += stream->in_gap ? 0 : 1;
  stream->in_gap = 1;
  ++stream->begin;
}

/* One byte more. Call unlatch_frame_next() until it has none before the next byte. */
static inline void unlatch_frame_push(unlatch_frame_stream* stream, uint8_t byte) {
  if (stream->end == sizeof stream->bytes) { /* less than a frame is left: the other half is free */
    memmove(stream->bytes, stream->bytes + stream->begin, stream->end - stream->begin);
    stream->end -= stream->begin;
    stream->begin = 0;
  }
  stream->bytes[stream->end++] = byte;
}

/* The next frame that is complete; 0: there is none. It lies in the stream's memory until the next byte. */
static inline int unlatch_frame_next(unlatch_frame_stream* stream, unlatch_frame* frame) {
  while (stream->begin < stream->end) {
    const uint8_t* const from = stream->bytes + stream->begin;
    const size_t left = stream->end - stream->begin;
    const int length = unlatch_frame_measure(from, left);
    if (length == 0 || (length > 0 && (size_t)length > left)) return 0;
    if (length < 0 || !unlatch_frame_read(frame, from, (size_t)length)) {
      unlatch_frame_skip(stream);
      continue;
    }
    stream->in_gap = 0;
    stream->begin += (size_t)length;
    return 1;
  }
  return 0;
}

/* The line is silent: a frame that has begun is not continued. Frames that it hid come from unlatch_frame_next(), until
 * it has none; then again, until nothing is left. Returns 0 once nothing was left. */
static inline int unlatch_frame_give_up(unlatch_frame_stream* stream) {
  if (stream->begin == stream->end) return 0;
  unlatch_frame_skip(stream);
  return 1;
}

/* Order of one sender's frames; begins with all zero. */
typedef struct unlatch_frame_order {
  int begun;
  uint32_t run, next;
} unlatch_frame_order;

/* 0: late, or a repetition. */
static inline int unlatch_frame_is_new(unlatch_frame_order* order, const unlatch_frame* frame) {
  if (!order->begun || order->run != frame->run) {
    order->begun = 1;
    order->run = frame->run;
    order->next = frame->sequence;
  }
  if (frame->sequence - order->next >= 0x80000000U) return 0;
  order->next = frame->sequence + 1;
  return 1;
}

#endif /* UNLATCH_FRAME_H_ */
