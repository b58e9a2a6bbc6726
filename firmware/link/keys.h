/* keys.h - short names of a case, a job and a draw, by which a host and a board know that they speak of the same.
 *
 * Each is a CRC-32C of wire bytes, so a host in any language and a board of either precision come to the same.
 */
#ifndef KELLY_KEYS_H
#define KELLY_KEYS_H

#include "../realisation.h"
#include "messages.h"

/* Of the body of case_set: names the case. */
uint32_t kelly_case_key(const kelly_msg_case_set *set);

/* Of a case and a seed: what a result belongs to. */
uint32_t kelly_job_key(uint32_t case_crc, uint64_t seed);

/* Of fc, mu, a1, a2, w0 as reals of the wire. */
uint32_t kelly_draw_key(const kelly_draw *draw);

#endif
