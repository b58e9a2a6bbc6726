/* receiver.h - what kelly_receive does with a byte of a frame, for roundtrip.c: a byte that a group counts is appended, another is the code
 * of the next group, before which a 0 is due, unless the group before was full. WP proves it of firmware/link/frame.c.
 */
#ifndef KELLY_EVA_RECEIVER_H
#define KELLY_EVA_RECEIVER_H

#include "link/frame.h"

/*@ logic integer received(kelly_receiver *r) = r->fresh != 0 ? 0 : r->size;

    logic integer appended(kelly_receiver *r) = r->left > 0 || (r->code != 0 && r->code != COBS_GROUP) ? 1 : 0;
*/

/*@ requires \valid(receiver) && receiver->size < KELLY_FRAME_MAX;
    assigns receiver->size, receiver->payload[receiver->size];
    ensures receiver->size == \old(receiver->size) + 1 && receiver->payload[\old(receiver->size)] == byte;
    ensures \result == 0; */
static int append(kelly_receiver *receiver, uint8_t byte);

/*@ requires \valid(receiver) && receiver->inside && byte != 0 && received(receiver) + appended(receiver) <= KELLY_FRAME_MAX;
    assigns receiver->size, receiver->left, receiver->code, receiver->fresh, receiver->payload[0 .. KELLY_FRAME_MAX - 1];
    ensures \result == 0 && receiver->fresh == 0;
    ensures receiver->size == \old(received(receiver) + appended(receiver));
    ensures receiver->left == (\old(receiver->left) > 0 ? \old(receiver->left) - 1 : byte - 1);
    ensures receiver->code == (\old(receiver->left) > 0 ? \old(receiver->code) : byte);
    ensures \old(appended(receiver)) == 1 ==> receiver->payload[\old(received(receiver))] == (\old(receiver->left) > 0 ? byte : 0);
    ensures \forall integer j; 0 <= j < \old(received(receiver)) ==> receiver->payload[j] == \old(receiver->payload[j]); */
int kelly_receive(kelly_receiver *receiver, uint8_t byte);

#endif
