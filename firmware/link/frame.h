/* frame.h - frames on a serial line: 00, COBS(payload), 00.
 *
 *   payload = u8 type, u32 seq, body, u32 CRC-32C of all that precedes; little-endian; KELLY_FRAME_MIN .. KELLY_FRAME_MAX bytes
 *
 * COBS leaves no 00 in what it packs, so a 00 is an end whatever was lost before it, and a receiver is in step again at the
 * next one. Each frame begins with a 00 too: text before it (a banner, a console) is not taken for its first bytes.
 * What the CRC lets pass: no error of up to 5 bits, one in 2^32 of the others.
 *
 * Memory   the receiver is the caller's: one payload. Time: a few operations a byte, the CRC at the end of a frame.
 */
#ifndef KELLY_FRAME_H
#define KELLY_FRAME_H

#include <stddef.h>
#include <stdint.h>

#define KELLY_FRAME_MIN 9u                                  /* type, seq, CRC and no body [bytes of payload] */
#define KELLY_FRAME_MAX 400u
#define KELLY_COBS_EXTRA ((KELLY_FRAME_MAX + 253u) / 254u)  /* one byte for every 254 begun */
#define KELLY_WIRE_MAX (KELLY_FRAME_MAX + KELLY_COBS_EXTRA + 2u)

/* Where kelly_frame wants the body, so that nothing has to be copied. */
#define KELLY_WIRE_BODY (1u + KELLY_COBS_EXTRA + 5u)

/* All zero: nothing received, deaf until the first 00. Counters may be read and set; the rest is not to be touched. */
typedef struct {
    uint32_t good, bad;                  /* frames received, frames dropped; both wrap */
    uint16_t size;                       /* bytes of payload so far, or of the frame just completed */
    uint8_t left;                        /* bytes until the next code */
    uint8_t code;                        /* of the group being read, 0 before the first */
    uint8_t inside;                      /* a 00 was seen and no error since */
    uint8_t fresh;                       /* the next byte starts another payload */
    uint8_t payload[KELLY_FRAME_MAX];
} kelly_receiver;

/* Take one byte. > 0: a frame is complete, the value is the size of its body + 1; 0: more is needed; -1: a frame was
 * dropped (bad COBS, bad CRC, too short, too long), said once, and the rest of it is skipped. 00 00 is silence. */
int kelly_receive(kelly_receiver *receiver, uint8_t byte);

/* Of the frame that kelly_receive has just completed; valid until the next byte. */
uint8_t kelly_received_type(const kelly_receiver *receiver);
uint32_t kelly_received_seq(const kelly_receiver *receiver);
const uint8_t *kelly_received_body(const kelly_receiver *receiver, size_t *size);

/* Pack a frame; the bytes to send, both 00 included; 0 if the body is larger than KELLY_FRAME_MAX - KELLY_FRAME_MIN.
 * `body` is either wire + KELLY_WIRE_BODY or somewhere else altogether. */
size_t kelly_frame(uint8_t wire[KELLY_WIRE_MAX], uint8_t type, uint32_t seq, const uint8_t *body, size_t size);

/* COBS alone, without a 00: n bytes -> at most n + n / 254 + 1. `to` may lie n / 254 + 1 bytes or more before `from`. */
size_t kelly_cobs(uint8_t *to, const uint8_t *from, size_t n);

#endif
