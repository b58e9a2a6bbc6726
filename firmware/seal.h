/* seal.h - flipped bits in memory: a seal over what must not change while a realisation is under way, a guard over what changes at each step.
 *
 * Seal: over coefficients, draw and case. Taken when they are in place and again every KELLY_LOOK steps, outside the loop over the steps. A change within one word of 32 bits always
 * gives another sum, since every word goes in times an odd number (a power of KELLY_SEAL_FACTOR) modulo 2^32; other changes do with
 * probability 1 - 2^-32. It never leaves the machine, so bytes go in as they lie. Cost: one multiply-add a word.
 *
 * Guard: over the state, the exclusive or of its bits. What a step writes goes into it; out of it goes, before it is overwritten, what the
 * last read of a number finds, which its last use is of or precedes (lanes.h): between two steps it is that of the state, and a bit that has
 * flipped since a write stays in it for good and is seen at the next look. One that flips after the last read is written over. Registers and
 * stack are not guarded.
 * Cost: 15 % more cycles on a Cortex-M4F, a tenth to a quarter of the speed of a vector unit; -DKELLY_GUARD=0 (lanes.h) builds without.
 */
#ifndef KELLY_SEAL_H
#define KELLY_SEAL_H

#include <stddef.h>
#include <stdint.h>

#define KELLY_SEAL_FACTOR 0x01000193u

/* Steps between two looks. One takes as long as 40 steps of the vectors of a host, 100 of one lane: about a percent of those between. */
#define KELLY_LOOK 8192u

/* The sum over what `seal` covers followed by these bytes, a multiple of four; 0 covers nothing. */
uint32_t kelly_seal(uint32_t seal, const void *from, size_t bytes);

/* The same over the members first .. last of a struct, which lie side by side. */
#define KELLY_SEAL_MEMBERS(seal, of, type, first, last) \
    kelly_seal(seal, (const uint8_t *)(of) + offsetof(type, first), offsetof(type, last) + sizeof((of)->last) - offsetof(type, first))

#endif
