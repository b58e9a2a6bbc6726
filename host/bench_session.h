/* bench_session.h - one board, one string: what lockstep and real time have in common. */
#ifndef KELLY_BENCH_SESSION_H
#define KELLY_BENCH_SESSION_H

#include "bench.h"

typedef struct {
    const bench_request *ask;
    board *b;
    link_set set;
    kelly_case run;               /* as the board has it: the drive left out, for the top is commanded */
    kelly_draw draw;
    uint32_t case_key;
    uint32_t id;                  /* of the session, once the string is started */
    int ready;
    uint32_t awaited;             /* seq of the request that is waited for, 0: none */
    uint8_t reply_type;
    size_t reply_size;
    uint8_t reply[KELLY_BODY_MAX];
    void (*unasked)(void *context, uint8_t type, const uint8_t *body, size_t size);   /* or 0 */
    void *context;
} bench_session;

/* Wait for the board, give it the case and draw of the request. Dies where it does not answer or does not fit. */
void session_open(bench_session *s, const bench_request *ask, board *b);

/* Start its string: fills case, source and draw of `start`, the rest is the caller's. Dies with one line where it is refused. */
void session_start(bench_session *s, kelly_msg_plant_start *start);

/* Ask, and wait for an answer of type `want` into s->reply: 1; or 0 and the error where the board refuses. */
int session_ask(bench_session *s, uint8_t type, const uint8_t *body, size_t size, uint8_t want, kelly_msg_error *error);

/* The same where a refusal ends the program. */
void session_call(bench_session *s, uint8_t type, const uint8_t *body, size_t size, uint8_t want);

/* Stop the board: it is idle afterwards. */
void session_close(bench_session *s);

/* Speed [rpm] and weight [kN] over time: straight lines between points, a step where two have one time. */
typedef struct {
    unsigned count;
    struct {
        double time, rpm, wob;
    } *points;
    double period;                /* [s] after which it begins again; 0: the last point holds */
} bench_profile;

/* --profile, or without one: the exercise (speed and weight up and down in ramps and steps), or what the case says. Dies with exit 2,
 * file and line. */
void profile_open(bench_profile *p, const bench_request *ask, int exercise);
void profile_at(const bench_profile *p, double time, double *rpm, double *wob);

#endif
