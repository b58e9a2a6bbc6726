/* link.h - boards on their lines: greeted, asked, and greeted again when they have been away.
 *
 * One thread serves any number of boards: link_wait polls, hands each frame to the mode, repeats what was not answered. Every request of
 * the protocol may be repeated (firmware/link/PROTOCOL.md), so nothing here has to know whether the request or its answer was lost.
 */
#ifndef KELLY_LINK_H
#define KELLY_LINK_H

#include "../firmware/link/frame.h"
#include "../firmware/link/messages.h"
#include "port.h"

enum { BOARD_AWAY, BOARD_GREETED, BOARD_READY };   /* no line; hello is out; it has answered and fits this program */

typedef struct {
    port port;
    kelly_receiver receiver;
    int state;
    kelly_msg_hello_reply is;     /* while ready */
    uint32_t nonce, seq;          /* of the last hello, of the last request */
    double hello_sent;
    unsigned hellos;              /* since the line was opened */
    uint8_t request[KELLY_WIRE_MAX];   /* not answered yet */
    size_t request_size;          /* 0: there is none */
    uint32_t request_seq;
    double request_begun, request_sent, request_due;   /* when it was sent first and last, and is to be sent again */
    double heard;                 /* when a good frame came last */
    double patience;              /* [s] of silence after which it is greeted anew; 0: it may be silent */
    uint32_t bad_there;           /* frames that it dropped, as it said last */
    uint32_t good, bad;           /* frames over all times it was open */
    uint32_t retries, ups;        /* requests sent again; times that it became ready */
    uint32_t image_crc, image_size;    /* of the ELF */
    int image_known;
    void *of_mode;                /* the mode's own */
} board;

/* What the mode is told. Any of them may ask and send. */
typedef struct {
    void (*up)(void *context, board *b);                     /* ready, idle, nothing set */
    void (*down)(void *context, board *b, const char *why);  /* not ready any more; whatever it did is lost */
    void (*heard)(void *context, board *b, uint8_t type, uint32_t seq, const uint8_t *body, size_t size);
    void *context;
} board_events;

typedef struct {
    board *boards;
    unsigned count;
    board_events on;
    double give_up;               /* [s] without any board after which the run fails */
    double ready;                 /* when there was one last */
    int told;                     /* that there is none since */
} link_set;

/* A board at this port; see port_parse. */
void board_parse(board *b, const char *text, const char *image, const char *icount);

/* Start the clock of give_up. */
void link_begin(link_set *set);

/* Serve the lines for at most `seconds`. Dies with exit 1 where a board does not fit this program, or where there has been none for
 * give_up seconds. */
void link_wait(link_set *set, double seconds);

/* Say hello anew to a board that is not where it should be: down, then up. */
void link_greet(link_set *set, board *b, const char *why);

/* Send a request and repeat it until something with its seq comes; one at a time. Returns the seq. */
uint32_t board_ask(board *b, uint8_t type, const uint8_t *body, size_t size);

/* Send something that the mode itself repeats, where it must. Returns its seq. */
uint32_t board_send(board *b, uint8_t type, const uint8_t *body, size_t size);

/* Die with exit 1: what this board said to a request. */
_Noreturn void board_refused(const board *b, const kelly_msg_error *error);

#endif
