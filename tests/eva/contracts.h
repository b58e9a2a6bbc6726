/* contracts.h - what a driver may take for granted of a function that another driver has analysed for all its inputs (use-spec in
 * tests/check_eva.py): each `ensures` is proved there, by an assertion of the same words. */
#ifndef KELLY_EVA_CONTRACTS_H
#define KELLY_EVA_CONTRACTS_H

#include "real.h"
#include "app/scpi.h"
#include "detmath.h"
#include "link/crc32c.h"
#include "link/frame.h"
#include "random.h"

/*@ assigns \result \from phase;
    ensures \is_finite(\result) && -1.01 <= \result <= 1.01;
    ensures 0x4000000000000000 <= phase <= 0x7c00000000000000 ==> \result >= 0.09; */
real kelly_sin_turn(uint64_t phase);

#ifdef EVA_LOG32                 /* random.c asks for the logarithm of 1 + t, of which intervals know less: analysed as it stands */
/* math.c */
/*@ requires \is_finite(x) && x >= 0x1p-126;
    assigns \result \from x;
    ensures \is_finite(\result) && -88 <= \result <= 89; */
float kelly_log32(float x);
#endif

/*@ requires \is_finite(x) && x >= LEAST_WIDE;
    assigns \result \from x;
    ensures \is_finite(\result) && -709 <= \result <= 710;
    ensures x >= 1 ==> \result >= 0; */
wide kelly_log(wide x);

/* exp.c */
/*@ requires \is_finite(x);
    assigns \result \from x;
    ensures \is_finite(\result) && 0 <= \result <= MOST_EXP;
    ensures x <= 0 ==> \result <= 4;
    ensures x >= 0 ==> \result >= 0.0625;
    ensures x <= 77 ==> \result <= 1e45; */
wide kelly_exp(wide x);

/*@ requires argument: \is_finite(x) && x >= 0;
    assigns \result \from x;
    ensures \is_finite(\result) && 0 <= \result <= 0x1p64;
    ensures x <= 4000000000000 ==> \result <= 4000000; */
float kelly_sqrt32(float x);

/*@ requires \valid(rng);
    assigns \result, *rng \from *rng;
    ensures \is_finite(\result) && -200 <= \result <= 200; */
float kelly_normal(kelly_rng *rng);

/* link.c */
/*@ requires \valid_read(bytes + (0 .. count - 1));
    assigns \result \from crc, bytes[0 .. count - 1]; */
uint32_t kelly_crc32c(uint32_t crc, const uint8_t *bytes, size_t count);

/* lines.c: of a text that ends in 0, whose array holds no more behind. */
/*@ requires \valid_read(line) && \valid(rest);
    assigns \result, *rest \from *line, *pattern, line, *rest;
    ensures \result == 0 || \result == 1;
    ensures \result == 1 ==> \valid_read(*rest);
    behavior given:
      assumes \valid_read(*rest);
      ensures \valid_read(*rest); */
int scpi_is(const char *line, const char *pattern, const char **rest);

/*@ requires \valid_read(text) && \valid(value);
    assigns \result, *value \from *text;
    ensures \result == SCPI_NO_ERROR || \result == SCPI_MISSING || \result == SCPI_BAD_NUMBER;
    ensures \result == SCPI_NO_ERROR ==> \initialized(value) && \is_finite(*value) && -1000000000 <= *value <= 1000000000; */
int scpi_number(const char *text, real *value);

/* Proved by WP, with the invariants of its loop: bounds, no 00, and where each byte went (cobs.h), the base of roundtrip.c. */
/*@ requires n <= KELLY_FRAME_MAX;
    requires \valid(to + (0 .. n + n / 254)) && \valid_read(from + (0 .. n - 1));
    assigns to[0 .. n + n / 254], cobs_lead[0 .. n], cobs_place[0 .. n], cobs_spot[0 .. n - 1], cobs_byte[0 .. n - 1] \from from[0 .. n - 1];
    assigns \result \from n, from[0 .. n - 1];
    ensures 1 <= \result <= n + n / 254 + 1;
    ensures \result == cobs_place[n];
    ensures packed: cobs_packed(to, n);
    ensures cobs_lead[n] + to[cobs_lead[n]] == \result;
    ensures \forall integer p; 0 <= p < \result ==> to[p] != 0;
    behavior read:
      assumes cobs_apart(to, from, n);
      ensures cobs_taken{Pre, Post}(from, n); */
size_t kelly_cobs(uint8_t *to, const uint8_t *from, size_t n);

/* A board's line is none of the program's memory: what has gone out over it. */
/*@ assigns line_count, line_last;
    ensures line_count == (uint32_t)(\old(line_count) + 1) && line_last == byte; */
void board_write(uint8_t byte);
/*@ assigns \nothing; */
int board_ready(void);

#endif
