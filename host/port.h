/* port.h - a line to a board: a serial device, a socket, or an emulator that is started here. Nothing waits: file descriptors are
 * non-blocking, and a line that is gone is opened again after a pause that doubles up to two seconds. An emulator that dies again and again is given up. */
#ifndef KELLY_PORT_H
#define KELLY_PORT_H

#include <stddef.h>
#include <stdint.h>
#include <sys/types.h>

#define PORT_WORDS 40
#define PORT_TEXT 512
#define PORT_WAITING 4096

enum { PORT_SERIAL, PORT_TCP, PORT_UNIX, PORT_EMULATOR };

/* Start from zeros. Nothing is to be touched but by the functions below. */
typedef struct {
    const char *text;             /* as the user gave it */
    int kind;
    char where[PORT_TEXT];        /* path, host, or target */
    char service[32];             /* TCP port */
    unsigned baud;
    char image[PORT_TEXT];        /* ELF that the emulator runs, "" where the port does not say */
    char command[2 * PORT_TEXT];  /* of the emulator, as one would type it */
    const char *words[PORT_WORDS];   /* the same for execvp, ended by 0 */
    char machine[PORT_TEXT];      /* where the first of them lie */

    int fd;                       /* -1: closed */
    int connecting;               /* a socket that is not through yet */
    pid_t child;                  /* emulator, 0: none */
    unsigned opened;              /* times that it was */
    unsigned tries;               /* in vain since a board answered there; whoever hears it sets 0 */
    int hopeless;                 /* an emulator that does not live: not started again */
    double again;                 /* when the next one is due [s of port_now] */
    char why[160];                /* what went wrong last, "" if nothing did */
    uint8_t out[PORT_WAITING];    /* not taken by the line yet */
    size_t waiting;
} port;

/* Seconds of a clock that only goes forward. */
double port_now(void);

/* What a --port says; dies with exit 2 on one that says nothing, on a target that is not there or has no image. `image` and `icount`
 * are --image and --icount, or 0. */
void port_parse(port *p, const char *text, const char *image, const char *icount);

/* Make a serial device raw, 8N1, at this speed; 0 where it cannot be. */
int port_settle(int fd, unsigned baud);

/* Open it if it is closed and a try is due: 1 where it can be used (connecting ends in port_ready). */
int port_open(port *p);

/* Whether a line that is connecting has come through: 1 yes, 0 not yet, -1 it is closed again. Ask when poll says writable. */
int port_ready(port *p);

/* Close it, end its emulator, and try again not before the pause is over. `why` is kept for people. */
void port_close(port *p, const char *why);

/* Bytes that are there: their number, 0 none now, -1 the line is gone and closed. */
long port_read(port *p, uint8_t *bytes, size_t room);

/* Send these bytes, keeping what the line does not take now; with count 0, send what was kept. A line that is closed, or takes nothing
 * for long, loses them: whoever asked asks again. */
void port_write(port *p, const uint8_t *bytes, size_t count);

#endif
