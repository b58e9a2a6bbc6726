/* link.c - boards on their lines. */
#include <poll.h>
#include <string.h>
#include <unistd.h>

#include "elf.h"
#include "host.h"
#include "link.h"

#define ANSWER_TIME 3.0          /* [s] before a request is repeated; an emulator may stall for one */
#define FAULTY_TIME 0.5          /* the same on a line that has been seen to lose frames */
#define ALIVE_TIME 0.3           /* the same where the board has sent a sign of life since */
#define DROPPED_TIME 0.02        /* and where that says that it has dropped a frame */
#define REQUEST_TIME 20.0        /* [s] of repeating a request, after which the board is greeted anew */
#define HELLO_SOON 0.25          /* [s] between the first hellos: one may come before the UART of the board is up */
#define HELLO_TIME 1.0           /* and between later ones */
#define HELLOS_SOON 4u
#define HELLOS_MOST 12u          /* before the line is closed and opened again */
#define SILENCE_TOLD 2.0         /* [s] without any board after which people are told what is waited for */
#define LINES_MOST 64u
#define TRIED 1024

void board_parse(board *b, const char *text, const char *image, const char *icount)
{
    *b = (board){ 0 };
    port_parse(&b->port, text, image, icount);
    if (b->port.image[0]) {
        elf_image(b->port.image, &b->image_crc, &b->image_size);
        b->image_known = 1;
    }
}

/* ---- sending ------------------------------------------------------------------------------------------------- */

uint32_t board_send(board *b, uint8_t type, const uint8_t *body, size_t size)
{
    uint8_t wire[KELLY_WIRE_MAX];

    port_write(&b->port, wire, kelly_frame(wire, type, ++b->seq, body, size));
    return b->seq;
}

static void send_request(board *b)
{
    const int faulty = b->bad + b->receiver.bad + b->bad_there > 0;

    b->request_sent = port_now();
    b->request_due = b->request_sent + (faulty ? FAULTY_TIME : ANSWER_TIME);
    port_write(&b->port, b->request, b->request_size);
}

uint32_t board_ask(board *b, uint8_t type, const uint8_t *body, size_t size)
{
    b->request_seq = ++b->seq;
    b->request_size = kelly_frame(b->request, type, b->request_seq, body, size);
    b->request_begun = port_now();
    send_request(b);
    return b->request_seq;
}

/* There is reason to repeat the request this long after it was sent last. */
static void hurry(board *b, double after)
{
    const double due = b->request_sent + after;

    b->request_due = due < b->request_due ? due : b->request_due;
}

static void greet(board *b)
{
    uint8_t body[KELLY_HELLO_MAX];

    if (b->hellos == 0) {
        b->nonce += 0x9e3779b9u ^ (uint32_t)getpid();   /* another one each time: an old answer is not taken for a new one */
    }
    b->hellos++;
    b->hello_sent = port_now();
    b->state = BOARD_GREETED;
    (void)board_send(b, KELLY_MSG_HELLO, body, kelly_put_hello(body, &(kelly_msg_hello){ KELLY_LINK_SCHEMA, b->nonce }));
}

/* ---- coming and going ---------------------------------------------------------------------------------------- */

static void leave(link_set *set, board *b, const char *why)
{
    const int was_ready = b->state == BOARD_READY;

    b->state = BOARD_AWAY;
    b->request_size = 0;
    b->hellos = 0;
    if (was_ready) {
        set->on.down(set->on.context, b, why);
    }
}

static void lose(link_set *set, board *b, const char *why)
{
    if (b->port.fd >= 0) {
        port_close(&b->port, why);
    }
    leave(set, b, why);
}

void link_greet(link_set *set, board *b, const char *why)
{
    leave(set, b, why);
    greet(b);
}

/* Fresh bytes on a fresh line. */
static void begin(board *b)
{
    b->good += b->receiver.good;
    b->bad += b->receiver.bad;
    b->receiver = (kelly_receiver){ 0 };
    b->hellos = 0;
    greet(b);
}

/* What must be true of a board before it is asked anything; dies with one line. */
static void check_fit(const board *b)
{
    const kelly_msg_hello_reply *const is = &b->is;
    const char *const own = sizeof(real) > sizeof(float) ? "double" : "float";

    if (is->real_bytes != sizeof(real)) {
        die(EXIT_FAILED, "%s: the board computes in %s and this program in %s; use the program of make%s, or flash make TARGET=%s%s",
            b->port.text, is->real_bytes > sizeof(float) ? "double" : "float", own, is->real_bytes > sizeof(float) ? " REAL=double" : "",
            is->board, sizeof(real) > sizeof(float) ? " REAL=double" : "");
    }
    if (strcmp(is->model, kelly_string.id) != 0) {
        die(EXIT_FAILED, "%s: the board holds the string %s and this program %s; build both from one well file (make WELL=...)",
            b->port.text, is->model, kelly_string.id);
    }
    if (b->image_known && (is->image_crc != b->image_crc || is->image_size != b->image_size)) {
        die(EXIT_FAILED, "%s: the image in flash has CRC-32C %08x (%u bytes) and %s has %08x (%u bytes); flash that one, or give the --image that is on the board",
            b->port.text, is->image_crc, is->image_size, b->port.image, b->image_crc, b->image_size);
    }
}

static uint32_t number(const uint8_t *bytes)
{
    return bytes[0] | (uint32_t)bytes[1] << 8 | (uint32_t)bytes[2] << 16 | (uint32_t)bytes[3] << 24;
}

/* The first two fields of a hello_reply are the same in every schema. */
static void take_greeting(link_set *set, board *b, const uint8_t *body, size_t size)
{
    if (size < 8 || number(body + 4) != b->nonce) {
        return;
    }
    if (number(body) != KELLY_LINK_SCHEMA) {
        die(EXIT_FAILED, "%s: the board speaks schema %08x and this program %08x; flash an image of this tree, or use the program that belongs to the board's",
            b->port.text, number(body), KELLY_LINK_SCHEMA);
    }
    if (b->state == BOARD_READY || !kelly_get_hello_reply(body, size, &b->is)) {
        return;
    }
    check_fit(b);
    b->state = BOARD_READY;
    b->hellos = 0;
    b->ups++;
    b->port.tries = 0;
    set->on.up(set->on.context, b);
}

/* ---- frames -------------------------------------------------------------------------------------------------- */

static void sign_of_life(board *b, const uint8_t *body, size_t size)
{
    kelly_msg_status status;

    if (kelly_get_status(body, size, &status)) {
        hurry(b, status.bad != b->bad_there ? DROPPED_TIME : ALIVE_TIME);
        b->bad_there = status.bad;
    }
}

static void take_frame(link_set *set, board *b)
{
    const uint8_t type = kelly_received_type(&b->receiver);
    const uint32_t seq = kelly_received_seq(&b->receiver);
    size_t size;
    const uint8_t *const body = kelly_received_body(&b->receiver, &size);

    b->heard = port_now();
    if (type == KELLY_MSG_HELLO_REPLY) {
        take_greeting(set, b, body, size);
    } else if (b->state == BOARD_READY) {
        if (b->request_size > 0 && seq == b->request_seq) {
            b->request_size = 0;
        } else if (type == KELLY_MSG_STATUS) {
            sign_of_life(b, body, size);
        }
        set->on.heard(set->on.context, b, type, seq, body, size);
    }
}

static void take_bytes(link_set *set, board *b)
{
    uint8_t bytes[4096];
    const long n = port_read(&b->port, bytes, sizeof(bytes));

    if (n < 0) {
        lose(set, b, b->port.why);
    }
    for (long i = 0; i < n && b->port.fd >= 0; i++) {
        const int got = kelly_receive(&b->receiver, bytes[i]);

        if (got > 0) {
            take_frame(set, b);
        } else if (got < 0 && b->state == BOARD_READY) {   /* it may have been the answer */
            hurry(b, DROPPED_TIME);
        }
    }
}

/* ---- time ---------------------------------------------------------------------------------------------------- */

/* What is due on this line. */
static void attend(link_set *set, board *b)
{
    const double now = port_now();

    if (b->port.fd < 0) {
        if (port_open(&b->port) && !b->port.connecting) {
            begin(b);
        }
        return;
    }
    if (b->state == BOARD_GREETED && now - b->hello_sent > (b->hellos <= HELLOS_SOON ? HELLO_SOON : HELLO_TIME)) {
        if (b->hellos >= HELLOS_MOST) {
            lose(set, b, "no answer to hello");
        } else {
            greet(b);
        }
    } else if (b->state == BOARD_READY && b->patience > 0 && now - b->heard > b->patience) {
        link_greet(set, b, "the board fell silent");
    } else if (b->state == BOARD_READY && b->request_size > 0 && now - b->request_begun > REQUEST_TIME) {
        link_greet(set, b, "the board does not answer");
    } else if (b->state == BOARD_READY && b->request_size > 0 && now >= b->request_due) {
        b->retries++;
        send_request(b);
    }
}

/* Each board, what was tried and what came of it. Returns `text`. */
static const char *tried(const link_set *set, char text[TRIED])
{
    text[0] = '\0';
    for (unsigned i = 0; i < set->count; i++) {
        const board *const b = &set->boards[i];
        const size_t used = strlen(text);

        snprintf(text + used, TRIED - used, "%s%s: opened %u times, last: %s", i ? "; " : "", b->port.text, b->port.opened,
                 b->port.why[0] ? b->port.why : b->state == BOARD_GREETED ? "no answer to hello" : "no line");
    }
    return text;
}

/* No board for so long: told once, and at last given up. */
static void lack(link_set *set, double seconds, int hope)
{
    char text[TRIED];

    if (!hope || seconds > set->give_up) {
        die(EXIT_FAILED, "no board for %.0f s: %s", seconds, tried(set, text));
    }
    if (seconds > SILENCE_TOLD && !set->told) {
        set->told = 1;
        fprintf(stderr, "kelly: no board for %.0f s, waiting for one at most %.6g s (--give-up): %s\n", seconds, set->give_up, tried(set, text));
    }
}

void link_begin(link_set *set)
{
    set->ready = port_now();
}

void link_wait(link_set *set, double seconds)
{
    struct pollfd lines[LINES_MOST];
    const double now = port_now();
    int any = 0, hope = 0;

    for (unsigned i = 0; i < set->count; i++) {
        board *const b = &set->boards[i];

        attend(set, b);
        any |= b->state == BOARD_READY;
        hope |= !b->port.hopeless;
        if (b->request_size > 0 && b->request_due - now < seconds) {
            seconds = b->request_due > now ? b->request_due - now : 0;
        }
        lines[i] = (struct pollfd){ .fd = b->port.fd, .events = (short)(POLLIN | (b->port.connecting || b->port.waiting > 0 ? POLLOUT : 0)) };
    }
    if (any) {
        set->ready = port_now();
        set->told = 0;
    } else {
        lack(set, now - set->ready, hope);
    }
    if (poll(lines, set->count, (int)(1000.0 * seconds + 0.999)) <= 0) {
        return;
    }
    for (unsigned i = 0; i < set->count; i++) {
        board *const b = &set->boards[i];

        if (lines[i].revents == 0 || lines[i].fd != b->port.fd) {
            continue;
        }
        if (b->port.connecting) {
            if (port_ready(&b->port) > 0) {
                begin(b);
            }
            continue;
        }
        if (lines[i].revents & POLLOUT) {
            port_write(&b->port, 0, 0);
        }
        if (lines[i].revents & ~POLLOUT) {
            take_bytes(set, b);
        }
    }
}

_Noreturn void board_refused(const board *b, const kelly_msg_error *error)
{
    static const char *const codes[] = { "", "schema", "unknown request", "bad body", "bad value", "case refused", "no such case", "out of order", "wrong mode" };

    die(EXIT_FAILED, "%s: the board refused request %u: %s (%s)", b->port.text, error->of_type,
        error->code < sizeof(codes) / sizeof(codes[0]) ? codes[error->code] : "unknown error", error->text);
}
