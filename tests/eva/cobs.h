/* cobs.h - how the packer of firmware/link/frame.c puts bytes where, noted by ghost code as it goes: for the proof that they come back
 * (roundtrip.c). A group is a code and the bytes that it counts; before byte j, the last one begins at cobs_lead[j] and ends at
 * cobs_place[j]. A full one, of 255, is followed by another as soon as there is a byte for it.
 */
#ifndef KELLY_EVA_COBS_H
#define KELLY_EVA_COBS_H

#include "link/frame.h"

#define COBS_GROUP 255

/*@ ghost size_t cobs_lead[KELLY_FRAME_MAX + 1u]; */
/*@ ghost size_t cobs_place[KELLY_FRAME_MAX + 1u]; */
/*@ ghost size_t cobs_spot[KELLY_FRAME_MAX]; */     /* where byte j goes; if it is 0, where the next code goes instead */
/*@ ghost int cobs_byte[KELLY_FRAME_MAX]; */        /* byte j */

/*@ logic integer cobs_size{L}(integer j) = cobs_place[j] - cobs_lead[j];

    // where the code of byte j's group is
    logic integer cobs_head{L}(integer j) = cobs_size(j) == COBS_GROUP ? cobs_place[j] : cobs_lead[j];

    predicate cobs_spots(integer i) =
      cobs_place[0] == 1 &&
      \forall integer j; 0 <= j < i ==> cobs_spot[j] == cobs_place[j] + (cobs_size(j) == COBS_GROUP ? 1 : 0);

    predicate cobs_places(integer i) = \forall integer j; 0 <= j < i ==> cobs_place[j + 1] == cobs_spot[j] + 1;

    predicate cobs_begun(integer i) =
      cobs_lead[0] == 0 && \forall integer j; 0 <= j < i && cobs_byte[j] == 0 ==> cobs_lead[j + 1] == cobs_spot[j];

    predicate cobs_kept(integer i) = \forall integer j; 0 <= j < i && cobs_byte[j] != 0 ==> cobs_lead[j + 1] == cobs_head(j);

    predicate cobs_order(integer i) =
      cobs_lead[i] < cobs_place[i] &&
      \forall integer j; 0 <= j < i ==>
        cobs_spot[j] < cobs_place[i] && cobs_head(j) <= cobs_lead[i] &&
        (cobs_size(j) == COBS_GROUP ==> cobs_lead[j] < cobs_lead[i]) &&
        (cobs_byte[j] == 0 ==> cobs_head(j) < cobs_lead[i]) &&
        (cobs_byte[j] != 0 ==> cobs_spot[j] != cobs_lead[i]);

    predicate cobs_fulls(uint8_t *to, integer i) =
      \forall integer j; 0 <= j < i && cobs_size(j) == COBS_GROUP ==> to[cobs_lead[j]] == COBS_GROUP;

    predicate cobs_ends(uint8_t *to, integer i) =
      \forall integer j; 0 <= j < i && cobs_byte[j] == 0 ==> cobs_head(j) + to[cobs_head(j)] == cobs_spot[j];

    predicate cobs_others(uint8_t *to, integer i) =
      \forall integer j; 0 <= j < i && cobs_byte[j] != 0 ==>
        cobs_head(j) == cobs_lead[i] || cobs_head(j) + to[cobs_head(j)] > cobs_spot[j];

    predicate cobs_bytes(uint8_t *to, integer i) =
      \forall integer j; 0 <= j < i && cobs_byte[j] != 0 ==> to[cobs_spot[j]] == cobs_byte[j];

    predicate cobs_no_zero(uint8_t *to, integer i) =
      \forall integer p; 0 <= p < cobs_place[i] && p != cobs_lead[i] ==> to[p] != 0;

    predicate cobs_taken{L, M}(uint8_t *from, integer i) = \forall integer j; 0 <= j < i ==> \at(cobs_byte[j], M) == \at(from[j], L);

    predicate cobs_unread{L, M}(uint8_t *from, integer i, integer n) = \forall integer j; i <= j < n ==> \at(from[j], M) == \at(from[j], L);

    // a packer in step overwrites no byte that it has yet to read: \separated, or n / 254 + 1 bytes before `from`, see roundtrip.c
    predicate cobs_apart(uint8_t *to, uint8_t *from, integer n) =
      \forall integer p, j; 0 <= j < n && 0 <= p <= j + n / 254 ==> to + p != from + j;
*/

#define cobs_packed(to, i) \
    (cobs_spots(i) && cobs_places(i) && cobs_begun(i) && cobs_kept(i) && cobs_order(i) && cobs_fulls(to, i) && cobs_ends(to, i) && \
     cobs_others(to, i) && cobs_bytes(to, i) && cobs_no_zero(to, i))

#endif
