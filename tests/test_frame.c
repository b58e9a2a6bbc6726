/* test_frame.c - COBS, frames and the receiver that a bad line cannot hurt. */
#include "../firmware/link/crc32c.h"
#include "../firmware/link/frame.h"
#include "check.h"
#include "fixture.h"

#define LARGEST (KELLY_FRAME_MAX - KELLY_FRAME_MIN)

static uint32_t noise_state;

static uint8_t noise(void)
{
    noise_state ^= noise_state << 13;
    noise_state ^= noise_state >> 17;
    noise_state ^= noise_state << 5;
    return (uint8_t)(noise_state >> 24);
}

/* The largest answer that these bytes bring, and how many frames they complete and lose. */
typedef struct {
    int last;
    unsigned frames, lost;
} outcome;

static outcome feed(kelly_receiver *receiver, const uint8_t *bytes, size_t n)
{
    outcome seen = { 0, 0, 0 };

    for (size_t i = 0; i < n; i++) {
        const int got = kelly_receive(receiver, bytes[i]);

        seen.last = got;
        seen.frames += got > 0;
        seen.lost += got < 0;
    }
    return seen;
}

/* The same bytes, without a claim for each. */
static int same(const uint8_t *a, const uint8_t *b, size_t n)
{
    for (size_t i = 0; i < n; i++) {
        if (a[i] != b[i]) {
            return 0;
        }
    }
    return 1;
}

/* A good frame, after whatever came before, is received. */
static int hears(kelly_receiver *receiver)
{
    static const uint8_t body[3] = { 1, 0, 255 };
    uint8_t wire[KELLY_WIRE_MAX];
    const size_t n = kelly_frame(wire, 77, 0x01020304u, body, 3);
    size_t size = 0;

    return feed(receiver, wire, n).last == 4 && kelly_received_type(receiver) == 77 && kelly_received_seq(receiver) == 0x01020304u &&
           same(kelly_received_body(receiver, &size), body, 3) && size == 3;
}

/* n plain bytes -> packed, and the receiver unpacks them. */
static void packs(const uint8_t *plain, size_t n, const uint8_t *packed, size_t count)
{
    uint8_t to[270];
    kelly_receiver receiver = { 0 };

    EQUAL(kelly_cobs(to, plain, n), count);
    CHECK(same(to, packed, count));
    (void)kelly_receive(&receiver, 0);
    EQUAL(feed(&receiver, to, count).lost, 0);
    EQUAL(receiver.size, n);
    EQUAL(receiver.left, 0);
    CHECK(same(receiver.payload, plain, n));
}

static void cobs_has_its_known_answers(void)
{
    static const uint8_t zero[] = { 0 }, mixed[] = { 0x11, 0x22, 0, 0x33 }, zeros[] = { 0x11, 0, 0, 0 };
    uint8_t plain[255], packed[258];

    packs(zero, 0, (const uint8_t[]){ 1 }, 1);
    packs(zero, 1, (const uint8_t[]){ 1, 1 }, 2);
    packs(mixed, 4, (const uint8_t[]){ 3, 0x11, 0x22, 2, 0x33 }, 5);
    packs(zeros, 4, (const uint8_t[]){ 2, 0x11, 1, 1, 1 }, 5);

    packed[0] = 255;                                        /* 01..FE, 01..FF */
    for (unsigned k = 0; k < 255; k++) {
        plain[k] = packed[k + 1] = (uint8_t)(k + 1);
    }
    packs(plain, 254, packed, 255);
    packed[255] = 2;
    packed[256] = 255;
    packs(plain, 255, packed, 257);

    for (unsigned k = 0; k < 254; k++) {                    /* 02..FF 00 */
        plain[k] = packed[k + 1] = (uint8_t)(k + 2);
    }
    plain[254] = 0;
    packed[255] = packed[256] = 1;
    packs(plain, 255, packed, 257);
}

static int comes_back(const uint8_t *plain, size_t n)
{
    uint8_t packed[KELLY_WIRE_MAX];
    const size_t count = kelly_cobs(packed, plain, n);
    kelly_receiver receiver = { 0 };

    (void)kelly_receive(&receiver, 0);
    for (size_t i = 0; i < count; i++) {
        if (packed[i] == 0 || kelly_receive(&receiver, packed[i]) != 0) {
            return 0;
        }
    }
    return count <= n + n / 254 + 1 && receiver.size == n && receiver.left == 0 && same(receiver.payload, plain, n);
}

/* COBS sees of a byte only whether it is 0, and copies it otherwise: the round trip holds for all bytes if it does for every pattern of
 * zeros. All of them up to 15 bytes; around the group of 254 bytes, which no 0 ends, all with at most two zeros. */
static void every_pattern_comes_back(void)
{
    uint8_t plain[257];
    unsigned lost = 0;

    for (unsigned n = 1; n <= BY_LENGTH(6u, 15u); n++) {
        for (unsigned zeros = 0; zeros < 1u << n; zeros++) {
            for (unsigned i = 0; i < n; i++) {
                plain[i] = (uint8_t)(zeros >> i & 1u ? 0u : i + 1u);
            }
            lost += !comes_back(plain, n);
        }
    }
    for (unsigned k = 0; k < 257; k++) {
        plain[k] = (uint8_t)(k % 255u + 1u);
    }
    for (unsigned n = 253; n <= 257; n++) {
        for (unsigned a = 0; a < n; a += BY_LENGTH(64u, 1u)) {
            for (unsigned b = a; b < n; b += BY_LENGTH(64u, 1u)) {
                plain[a] = plain[b] = 0;
                lost += !comes_back(plain, n);
                plain[a] = (uint8_t)(a % 255u + 1u);
                plain[b] = (uint8_t)(b % 255u + 1u);
            }
        }
        lost += !comes_back(plain, n);
    }
    EQUAL(lost, 0);
}

/* Type 1, seq 2, body 03: written down byte by byte. */
static void frame_has_its_layout(void)
{
    const uint8_t payload[] = { 1, 2, 0, 0, 0, 3 };
    const uint32_t crc = kelly_crc32c(0, payload, 6);
    const uint8_t want[] = { 0, 3, 1, 2, 1, 1, 6, 3, (uint8_t)crc, (uint8_t)(crc >> 8), (uint8_t)(crc >> 16), (uint8_t)(crc >> 24), 0 };
    uint8_t wire[KELLY_WIRE_MAX];

    EQUAL(crc, 0xdb683b3fu);                                /* none of its bytes is 00, so COBS leaves them alone */
    EQUAL(kelly_frame(wire, 1, 2, payload + 5, 1), sizeof(want));
    CHECK(same(wire, want, sizeof(want)));
}

/* Bodies of every size; zeros, no zeros and noise, which is what COBS tells apart. */
static void every_size_comes_back(void)
{
    uint8_t wire[KELLY_WIRE_MAX], body[LARGEST + 1];
    kelly_receiver receiver = { 0 };
    unsigned wrong = 0;

    for (unsigned kind = 0; kind < 3; kind++) {
        for (size_t n = 0; n <= LARGEST; n++) {
            size_t size = 0, length;

            for (size_t i = 0; i < n; i++) {
                body[i] = kind == 2 ? noise() : (uint8_t)kind;
            }
            length = kelly_frame(wire, (uint8_t)n, (uint32_t)n << 20, body, n);
            wrong += length > KELLY_WIRE_MAX || feed(&receiver, wire, length).last != (int)n + 1;
            wrong += kelly_received_type(&receiver) != (uint8_t)n || kelly_received_seq(&receiver) != (uint32_t)n << 20;
            wrong += !same(kelly_received_body(&receiver, &size), body, n) || size != n;
        }
    }
    EQUAL(wrong, 0);
    EQUAL(receiver.good, 3 * (LARGEST + 1));
    EQUAL(receiver.bad, 0);
    EQUAL(kelly_frame(wire, 1, 1, body, LARGEST + 1), 0);   /* larger than a frame */
}

static void body_may_lie_in_the_wire(void)
{
    uint8_t wire[KELLY_WIRE_MAX], there[KELLY_WIRE_MAX], body[LARGEST];

    for (size_t i = 0; i < LARGEST; i++) {
        there[KELLY_WIRE_BODY + i] = body[i] = (uint8_t)(i % 7 + (i > 100));
    }
    EQUAL(kelly_frame(wire, 5, 6, body, LARGEST), kelly_frame(there, 5, 6, there + KELLY_WIRE_BODY, LARGEST));
    CHECK(same(wire, there, KELLY_FRAME_MAX + 2));
}

static void silence_and_text_are_no_errors(void)
{
    static const uint8_t text[] = "kelly 1.0.0 on a board\n?\n";
    const uint8_t zeros[5] = { 0 };
    kelly_receiver receiver = { 0 };

    EQUAL(feed(&receiver, text, sizeof(text) - 1).lost, 0); /* before the first 00 */
    EQUAL(feed(&receiver, zeros, 5).lost, 0);
    EQUAL(receiver.bad, 0);
    CHECK(hears(&receiver));
    EQUAL(feed(&receiver, zeros, 5).frames, 0);             /* the same frame does not come again */
    EQUAL(receiver.good, 1);
    EQUAL(feed(&receiver, text, sizeof(text) - 1).lost + feed(&receiver, zeros, 1).lost, 1);   /* between frames: a dropped one */
    CHECK(hears(&receiver));
}

static void every_truncation_is_refused(void)
{
    uint8_t wire[KELLY_WIRE_MAX], body[40] = { 0 };
    size_t n;

    for (size_t i = 0; i < 40; i += 3) {
        body[i] = (uint8_t)i;
    }
    n = kelly_frame(wire, 9, 10, body, 40);
    for (size_t cut = 0; cut < n; cut++) {
        kelly_receiver front = { 0 }, back = { 0 };

        EQUAL(feed(&front, wire, cut).frames, 0);           /* the end is missing */
        CHECK(hears(&front));
        EQUAL(front.good, 1 + (cut == n - 1));
        EQUAL(front.bad, cut > 1 && cut < n - 1);           /* without its last 00 alone, the next frame's first completes it */
        if (cut > 1) {
            EQUAL(feed(&back, wire + cut, n - cut).frames, 0);
            CHECK(hears(&back));
        }
    }
}

static void every_flipped_bit_is_refused(void)
{
    uint8_t wire[KELLY_WIRE_MAX], body[30];
    size_t n;
    unsigned passed = 0, deaf = 0;

    for (size_t i = 0; i < 30; i++) {
        body[i] = (uint8_t)(i % 4 ? i : 0);
    }
    n = kelly_frame(wire, 200, 0x8000ff01u, body, 30);
    for (size_t bit = 0; bit < 8 * n; bit++) {
        kelly_receiver receiver = { 0 };

        (void)kelly_receive(&receiver, 0);
        wire[bit / 8] ^= (uint8_t)(1u << bit % 8);
        passed += feed(&receiver, wire, n).frames;
        deaf += !hears(&receiver) || receiver.good != 1 || receiver.bad == 0;
        wire[bit / 8] ^= (uint8_t)(1u << bit % 8);
    }
    EQUAL(passed, 0);
    EQUAL(deaf, 0);
}

static void lengths_have_limits(void)
{
    uint8_t packed[KELLY_WIRE_MAX + 2], payload[KELLY_FRAME_MAX + 1];

    for (size_t n = 0; n <= KELLY_FRAME_MAX + 1; n++) {     /* the CRC is right at every length that has one */
        const size_t covered = n < 4 ? 0 : n - 4;
        kelly_receiver receiver = { 0 };
        uint32_t crc;
        size_t count;

        for (size_t i = 0; i < covered; i++) {
            payload[i] = (uint8_t)i;
        }
        crc = kelly_crc32c(0, payload, covered);
        for (size_t i = covered; i < n; i++) {
            payload[i] = (uint8_t)(crc >> (8 * (i - covered)));
        }
        count = kelly_cobs(packed, payload, n);
        packed[count] = 0;
        (void)kelly_receive(&receiver, 0);
        EQUAL(feed(&receiver, packed, count + 1).frames, n >= KELLY_FRAME_MIN && n <= KELLY_FRAME_MAX);
        EQUAL(receiver.bad, n < KELLY_FRAME_MIN || n > KELLY_FRAME_MAX);
        CHECK(hears(&receiver));
    }
}

/* Told once, skipped to the next 00. */
static void endless_frame_is_told_once(void)
{
    kelly_receiver receiver = { 0 };
    unsigned lost = 0;

    (void)kelly_receive(&receiver, 0);
    for (unsigned k = 0; k < 5000; k++) {
        lost += kelly_receive(&receiver, 255) < 0;
    }
    EQUAL(lost, 1);
    EQUAL(receiver.bad, 1);
    CHECK(hears(&receiver));
}

/* 1 MB on the host. One byte in 256 is 00, one in three in the second half: short pieces and long ones. */
static void garbage_does_no_harm(void)
{
    struct {
        uint8_t before[8];
        kelly_receiver receiver;
        uint8_t after[8];
    } held = { { 0 }, { 0 }, { 0 } };
    const unsigned bytes = BY_LENGTH(20000, 1u << 20);
    unsigned frames = 0, over = 0, deaf = 0;

    for (unsigned k = 0; k < bytes; k++) {
        const uint8_t byte = noise(), cut = noise();

        frames += kelly_receive(&held.receiver, k > bytes / 2 && cut < 85 ? 0 : byte) > 0;
        over += held.receiver.size > KELLY_FRAME_MAX;
        if (k % 1024 == 0) {
            deaf += !hears(&held.receiver);
        }
    }
    EQUAL(frames, 0);
    EQUAL(over, 0);
    EQUAL(deaf, 0);
    EQUAL(held.receiver.good, (bytes + 1023) / 1024);
    for (unsigned k = 0; k < 8; k++) {
        EQUAL(held.before[k] | held.after[k], 0);
    }
}

void test_frame(void);
void test_frame(void)
{
    noise_state = 2463534242u;
    cobs_has_its_known_answers();
    every_pattern_comes_back();
    frame_has_its_layout();
    every_size_comes_back();
    body_may_lie_in_the_wire();
    silence_and_text_are_no_errors();
    every_truncation_is_refused();
    every_flipped_bit_is_refused();
    lengths_have_limits();
    endless_frame_is_told_once();
    garbage_does_no_harm();
}
