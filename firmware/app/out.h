/* out.h - what goes out over the UART: frames and text in one order.
 *
 * At once as a rule: each byte waits for the line. A program on the tick has no time to wait: after out_defer(1) bytes are kept in a
 * ring and leave as the line takes them, whenever out_pump is called.
 */
#ifndef KELLY_OUT_H
#define KELLY_OUT_H

#include "../link/frame.h"

#define OUT_RING 512u   /* bytes that can be kept; the largest frame and more */

/* Keep (1) or send at once (0, after what was kept). */
void out_defer(int on);

/* Send what the line takes without waiting. Returns 1 while something is kept. */
int out_pump(void);

/* Whether so many bytes can be given without waiting for the line. */
int out_room(size_t bytes);

void out_byte(uint8_t byte);

/* Pack the body, `size` bytes at wire + KELLY_WIRE_BODY, and send it as a frame. */
void out_frame(uint8_t wire[KELLY_WIRE_MAX], uint8_t type, uint32_t seq, size_t size);

#endif
