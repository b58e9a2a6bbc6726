/* What kelly_cobs packs, kelly_receive gives back: any bytes, as many as a frame may have, packed in place or elsewhere. For WP, not Eva. */
#include "link/frame.h"
#include "receiver.h"

/* The receiver has taken a 00. After k bytes it has i of n: it expects byte i, or the code of the group that a full one makes necessary. */
/*@ predicate in_step(kelly_receiver *r, uint8_t *to, integer k, integer i) =
      k == cobs_place[i] && r->code == to[cobs_lead[i]] && r->left == cobs_lead[i] + r->code - k;

    predicate opened(kelly_receiver *r, uint8_t *to, integer k, integer i, integer n) =
      i < n && cobs_size(i) == COBS_GROUP && k == cobs_place[i] + 1 && r->code == to[cobs_place[i]] && r->left == r->code - 1;

    predicate filled(integer k, integer i) = k > 0 && k == cobs_place[i] && cobs_size(i) == COBS_GROUP;

    // code and byte i are as the packer has them
    predicate before_byte(kelly_receiver *r, uint8_t *to, integer k, integer i) =
      k == cobs_spot[i] && r->code == to[cobs_head(i)] && r->left == cobs_head(i) + r->code - k;

    predicate given{L, M}(kelly_receiver *r, uint8_t *from, integer i) =
      \forall integer j; 0 <= j < i ==> \at(r->payload[j], M) == \at(from[j], L);
*/

/* Of no bytes the size is told only when a code has come: the assertion at the end has it whole. */
/*@ requires n <= KELLY_FRAME_MAX;
    requires \separated(to + (0 .. n + n / 254), from + (0 .. n - 1)) || (\base_addr(to) == \base_addr(from) && from - to >= n / 254 + 1);
    requires \valid(to + (0 .. n + n / 254)) && \valid_read(from + (0 .. n - 1)) && \valid(receiver);
    requires \separated(receiver, to + (0 .. n + n / 254)) && \separated(receiver, from + (0 .. n - 1));
    requires receiver->inside && receiver->code == 0 && receiver->left == 0 && receiver->fresh;
    ensures receiver->size == n || n == 0;
    ensures given{Pre, Post}(receiver, from, n);
    ensures receiver->left == 0 && receiver->code != 0 && receiver->fresh == 0;
    ensures receiver->inside == \old(receiver->inside) && receiver->bad == \old(receiver->bad) && receiver->good == \old(receiver->good); */
void round_trip(kelly_receiver *receiver, uint8_t *to, const uint8_t *from, size_t n)
{
    //@ assert apart: cobs_apart(to, from, n);
    const size_t m = kelly_cobs(to, from, n);

    /*@ loop invariant 0 <= k <= m && received(receiver) <= n;
        loop invariant k == 0 ? receiver->fresh && receiver->code == 0 && receiver->left == 0 : receiver->fresh == 0;
        loop invariant step: k > 0 ==> in_step(receiver, to, k, receiver->size) || opened(receiver, to, k, receiver->size, n);
        loop invariant packed: cobs_packed(to, n) && cobs_lead[n] + to[cobs_lead[n]] == m;
        loop invariant given: given{Pre, Here}(receiver, from, received(receiver));
        loop assigns k, receiver->size, receiver->left, receiver->code, receiver->fresh, receiver->payload[0 .. KELLY_FRAME_MAX - 1];
        loop variant m - k; */
    for (size_t k = 0; k < m; k++) {
        //@ assert not_zero: to[k] != 0;
        //@ ghost const size_t i = receiver->size;
        //@ assert going: k > 0 ==> i < n;
        //@ assert full: filled(k, i) ==> receiver->code == COBS_GROUP && receiver->left == 0;
        //@ assert other: k > 0 && !filled(k, i) ==> before_byte(receiver, to, k, i);
        //@ assert zero: k > 0 && !filled(k, i) && cobs_byte[i] == 0 ==> receiver->left == 0 && appended(receiver) == 1;
        //@ assert byte: k > 0 && !filled(k, i) && cobs_byte[i] != 0 ==> receiver->left > 0 && to[k] == cobs_byte[i];
        //@ assert next: k > 0 && !filled(k, i) ==> cobs_place[i + 1] == k + 1;
        //@ assert begun: k > 0 && !filled(k, i) && cobs_byte[i] == 0 ==> cobs_lead[i + 1] == k;
        //@ assert kept: k > 0 && !filled(k, i) && cobs_byte[i] != 0 ==> cobs_lead[i + 1] == cobs_head(i);
        (void)kelly_receive(receiver, to[k]);
        //@ assert none: k == 0 || filled(k, i) ==> receiver->size == (k == 0 ? 0 : i);
        //@ assert one: k > 0 && !filled(k, i) ==> receiver->size == i + 1 && receiver->payload[i] == cobs_byte[i];
        //@ assert first: k == 0 ==> in_step(receiver, to, k + 1, receiver->size);
        //@ assert opened: filled(k, i) ==> opened(receiver, to, k + 1, receiver->size, n);
        //@ assert ended: k > 0 && !filled(k, i) && cobs_byte[i] == 0 ==> in_step(receiver, to, k + 1, receiver->size);
        //@ assert taken: k > 0 && !filled(k, i) && cobs_byte[i] != 0 ==> in_step(receiver, to, k + 1, receiver->size);
        //@ assert moved: in_step(receiver, to, k + 1, receiver->size) || opened(receiver, to, k + 1, receiver->size, n);
    }
    //@ assert all: receiver->size == n && in_step(receiver, to, m, n);
}
