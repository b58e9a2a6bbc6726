/* bench_session.c - one board, one string: greeted, given its case, started, asked and waited for. */
#include <string.h>

#include "../firmware/link/keys.h"
#include "bench_session.h"

static void board_up(void *context, board *b)
{
    bench_session *const s = context;

    (void)b;
    s->ready = 1;
}

/* A board that was away has another string in it, or none: there is nothing to go on with. */
static void board_down(void *context, board *b, const char *why)
{
    const bench_session *const s = context;

    die(EXIT_FAILED, "%s: %s; the session is lost%s", b->port.text, why, s->id ? ", start it anew" : "");
}

static void board_heard(void *context, board *b, uint8_t type, uint32_t seq, const uint8_t *body, size_t size)
{
    bench_session *const s = context;

    (void)b;
    if (s->awaited != 0 && seq == s->awaited) {
        s->awaited = 0;
        s->reply_type = type;
        s->reply_size = size;
        memcpy(s->reply, body, size < sizeof(s->reply) ? size : sizeof(s->reply));
    } else if (s->unasked) {
        s->unasked(s->context, type, body, size);
    }
}

int session_ask(bench_session *s, uint8_t type, const uint8_t *body, size_t size, uint8_t want, kelly_msg_error *error)
{
    s->awaited = board_ask(s->b, type, body, size);
    while (s->awaited != 0) {
        link_wait(&s->set, 0.1);
    }
    if (s->reply_type == KELLY_MSG_ERROR && kelly_get_error(s->reply, s->reply_size, error)) {
        return 0;
    }
    if (s->reply_type != want) {
        die(EXIT_FAILED, "%s: request %u was answered by message %u instead of %u", s->b->port.text, type, s->reply_type, want);
    }
    return 1;
}

void session_call(bench_session *s, uint8_t type, const uint8_t *body, size_t size, uint8_t want)
{
    kelly_msg_error error;

    if (!session_ask(s, type, body, size, want, &error)) {
        board_refused(s->b, &error);
    }
}

void session_open(bench_session *s, const bench_request *ask, board *b)
{
    uint8_t body[KELLY_CASE_SET_MAX];
    kelly_msg_case_set set;
    kelly_msg_case_reply reply;

    s->ask = ask;
    s->b = b;
    s->set = (link_set){ .boards = b, .count = 1, .give_up = ask->give_up, .on = { board_up, board_down, board_heard, s } };
    s->run = ask->opts.run;
    s->run.drive = (kelly_drive){ 0 };
    if (ask->opts.sample_given) {
        kelly_draw_sample(&s->run, ask->opts.seed, ask->opts.sample, &s->draw);
    } else {
        kelly_draw_nominal(&s->run, &s->draw);
    }
    link_begin(&s->set);
    while (!s->ready) {
        link_wait(&s->set, 0.1);
    }
    bench_case(&s->run, &set);
    s->case_key = kelly_case_key(&set);
    session_call(s, KELLY_MSG_CASE_SET, body, kelly_put_case_set(body, &set), KELLY_MSG_CASE_REPLY);
    if (!kelly_get_case_reply(s->reply, s->reply_size, &reply) || reply.case_crc != s->case_key) {
        die(EXIT_FAILED, "%s: the board has another case than it was given", b->port.text);
    }
}

void session_start(bench_session *s, kelly_msg_plant_start *start)
{
    uint8_t body[KELLY_PLANT_START_MAX];
    kelly_msg_plant_reply reply;

    start->case_crc = s->case_key;
    start->source = s->ask->opts.sample_given ? KELLY_SOURCE_SAMPLE : KELLY_SOURCE_NOMINAL;
    start->seed = s->ask->opts.seed;
    start->index = s->ask->opts.sample;
    session_call(s, KELLY_MSG_PLANT_START, body, kelly_put_plant_start(body, start), KELLY_MSG_PLANT_REPLY);
    if (!kelly_get_plant_reply(s->reply, s->reply_size, &reply) || reply.status != KELLY_OK) {
        die(EXIT_FAILED, "%s: the board cannot run this string (status %u); this program could", s->b->port.text, s->reply[4]);
    }
    s->id = reply.session;
}

void session_close(bench_session *s)
{
    session_call(s, KELLY_MSG_STOP, 0, 0, KELLY_MSG_STATUS);
}
