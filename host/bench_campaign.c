/* bench_campaign.c - an ensemble on boards: ranges of indices out, results back, montecarlo's files.
 *
 * A range is at most what a board keeps of its last results: what was lost on the line is asked for at the end of the range and comes
 * from memory, and no work is interrupted for it. When all indices are out, an idle board takes over what another one has not delivered,
 * the last first: a slow or dead board holds up nothing. The first result of an index counts; a second one must have the same bits.
 *
 * The journal takes results as they come, in any order: a campaign that goes on asks the boards for what it does not hold.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "../firmware/link/keys.h"
#include "bench.h"
#include "outcome.h"

#define RANGE_MOST 8u            /* results that a board keeps */
#define RANGE_SECONDS 1.0        /* of work that is handed out at once */
#define RUN_TIME 0.3             /* [s] after which a run that a sign of life knows nothing of is sent again */
#define SAME_TIME 0.03           /* and one that was done with something missing */
#define SILENCE 5.0              /* [s]: longer than the stalls of a line */
#define NO_BOARD 255             /* in place of one: the journal */

typedef struct {
    kelly_result result;
    uint8_t done;
    uint8_t holders;             /* boards that have it in their range */
    uint8_t by;                  /* board whose result counts */
} cell;

/* What one board has to do: indices as offsets from the first one of the campaign. */
typedef struct {
    uint32_t first, end;         /* its range, empty where they are equal */
    uint32_t told;               /* one behind the last one that it was told to run */
    int set;                     /* it has the case */
    double sent;                 /* when it was told the range last */
    double mark;                 /* when it began its present realisation, as far as can be told */
    double pace;                 /* [s] a realisation; 0: not known */
    uint32_t results, doubles, repeats;
} worker;

typedef struct {
    const options *opts;
    link_set set;
    worker work[BENCH_PORTS];
    uint8_t body[KELLY_CASE_SET_MAX];
    size_t body_size;
    uint32_t case_key, job_key;
    cell *cells;
    uint32_t low;                /* all below are done */
    uint32_t fresh;              /* none from here on has been handed out */
    uint32_t delivered;
    uint32_t recalled;           /* of them, from the journal */
    outcome out;
} campaign;

/* ---- ranges -------------------------------------------------------------------------------------------------- */

static unsigned number_of(const campaign *c, const board *b)
{
    return (unsigned)(b - c->set.boards);
}

static void release(campaign *c, worker *w)
{
    for (uint32_t i = w->first; i < w->end; i++) {
        c->cells[i].holders--;
    }
    w->first = w->end = 0;
}

static void hold(campaign *c, worker *w, uint32_t first, uint32_t end)
{
    w->first = first;
    w->end = end;
    for (uint32_t i = first; i < end; i++) {
        c->cells[i].holders++;
    }
    c->fresh = end > c->fresh ? end : c->fresh;
}

/* First and one behind the last index of a range that are not delivered: 0 where all are. */
static int missing(const campaign *c, uint32_t first, uint32_t end, uint32_t *from, uint32_t *to)
{
    while (first < end && c->cells[first].done) {
        first++;
    }
    while (end > first && c->cells[end - 1].done) {
        end--;
    }
    *from = first;
    *to = end;
    return first < end;
}

/* Indices that nobody has: those of boards that went away, then fresh ones. */
static int find_free(const campaign *c, uint32_t most, uint32_t *from, uint32_t *to)
{
    uint32_t i = c->low;

    while (i < c->opts->samples && (c->cells[i].done || c->cells[i].holders > 0)) {
        i++;
    }
    *from = i;
    while (i < c->opts->samples && i - *from < most && !c->cells[i].done && c->cells[i].holders == 0) {
        i++;
    }
    *to = i;
    return *from < *to;
}

/* The last one that the fewest others are at, where there is nothing else to do. */
static int find_held(const campaign *c, uint32_t *from, uint32_t *to)
{
    unsigned fewest = 3;         /* more boards on one index would help nobody */

    for (uint32_t i = c->fresh; i > c->low; i--) {
        if (!c->cells[i - 1].done && c->cells[i - 1].holders < fewest) {
            fewest = c->cells[i - 1].holders;
            *from = i - 1;
        }
    }
    *to = *from + 1;
    return fewest < 3;
}

/* Tell a board what of its range is missing. */
static void send_run(campaign *c, board *b)
{
    worker *const w = &c->work[number_of(c, b)];
    uint8_t body[KELLY_RUN_MAX];
    uint32_t from, to;

    if (missing(c, w->first, w->end, &from, &to)) {
        w->sent = w->mark = port_now();
        w->told = to;
        (void)board_send(b, KELLY_MSG_RUN, body, kelly_put_run(body, &(kelly_msg_run){ c->case_key, c->opts->seed, c->opts->first + from, to - from }));
    }
}

static void next_range(campaign *c, board *b)
{
    worker *const w = &c->work[number_of(c, b)];
    const double fit = w->pace > 0 ? RANGE_SECONDS / w->pace : 1;
    const uint32_t most = fit < 1 ? 1 : fit > RANGE_MOST ? RANGE_MOST : (uint32_t)fit;
    uint32_t from = 0, to = 0;

    release(c, w);
    if (c->low < c->opts->samples && (find_free(c, most, &from, &to) || find_held(c, &from, &to))) {
        hold(c, w, from, to);
        send_run(c, b);
    }
}

/* ---- what boards say ------------------------------------------------------------------------------------------ */

static void board_up(void *context, board *b)
{
    campaign *const c = context;

    c->work[number_of(c, b)].set = 0;
    b->patience = SILENCE;
    if (b->ups > 1) {
        fprintf(stderr, "kelly: %s: is back\n", b->port.text);
    }
    (void)board_ask(b, KELLY_MSG_CASE_SET, c->body, c->body_size);
}

static void board_down(void *context, board *b, const char *why)
{
    campaign *const c = context;

    c->work[number_of(c, b)].set = 0;
    release(c, &c->work[number_of(c, b)]);
    fprintf(stderr, "kelly: %s: %s; its range is free again\n", b->port.text, why);
}

static int same_bits(real a, real b)
{
    return memcmp(&a, &b, sizeof(a)) == 0;
}

static int same_result(const kelly_result *a, const kelly_result *b)
{
    return same_bits(a->lowest, b->lowest) && same_bits(a->highest, b->highest) && same_bits(a->mean, b->mean) && same_bits(a->ss, b->ss) &&
           a->status == b->status && a->stuck == b->stuck && a->liftoff == b->liftoff;
}

/* The first result of a board, once more here: an image that was built from other sources shows at once. */
static void check_board(const campaign *c, const board *b, uint32_t index, const kelly_result *theirs)
{
    static kelly_work work;
    kelly_result ours;

    kelly_run(&kelly_string, &c->opts->run, c->opts->seed, index, 1, &ours, &work);
    if (!same_result(&ours, theirs)) {
        die(EXIT_FAILED, "%s: realisation %u: other bits than here; was its image built from other sources? make TARGET=%s again, and this program", b->port.text,
            index, b->is.board);
    }
}

/* The first result of an index. */
static void take_first(campaign *c, uint32_t at, const kelly_result *r, uint8_t by)
{
    c->cells[at].result = *r;
    c->cells[at].done = 1;
    c->cells[at].by = by;
    c->delivered++;
}

/* What is done without a gap is counted and written. */
static void pass_on(campaign *c)
{
    while (c->low < c->opts->samples && c->cells[c->low].done) {
        outcome_take(&c->out, c->opts->first + c->low, 1, &c->cells[c->low].result);
        c->low++;
    }
}

/* A result into its cell; dies where two boards, or a board and this program, do not agree. */
static void store(campaign *c, const board *b, uint32_t at, const kelly_msg_result *m)
{
    cell *const to = &c->cells[at];
    worker *const w = &c->work[number_of(c, b)];
    kelly_result r = { .lowest = m->lowest, .highest = m->highest, .mean = m->mean, .ss = m->ss, .status = m->status, .stuck = m->stuck,
                       .liftoff = m->liftoff };

    kelly_draw_sample(&c->opts->run, c->opts->seed, m->index, &r.draw);
    if (kelly_draw_key(&r.draw) != m->draw_crc) {
        die(EXIT_FAILED, "%s: realisation %u: its draw is not this program's (%08x here, %08x there)", b->port.text, m->index,
            kelly_draw_key(&r.draw), m->draw_crc);
    }
    if (w->results + w->doubles == 0) {
        check_board(c, b, m->index, &r);
    }
    if (!to->done) {
        take_first(c, at, &r, (uint8_t)number_of(c, b));
        if (c->out.log.path) {
            journal_append(&c->out.log, at, 1, &r);
        }
        w->results++;
    } else if (same_result(&to->result, &r)) {
        w->doubles++;
    } else {
        die(EXIT_FAILED, "%s: realisation %u: other bits than %s%s; one of the two is wrong", b->port.text, m->index,
            to->by == NO_BOARD ? "the journal holds" : "from ", to->by == NO_BOARD ? "" : c->set.boards[to->by].port.text);
    }
}

/* The next range once this one is all there; what is missing of it once the board is through (`repeat`). */
static void go_on(campaign *c, board *b, int repeat)
{
    worker *const w = &c->work[number_of(c, b)];
    uint32_t from, to;

    if (!missing(c, w->first, w->end, &from, &to)) {
        next_range(c, b);
    } else if (repeat) {
        w->repeats++;
        send_run(c, b);
    }
}

static void take_result(campaign *c, board *b, const kelly_msg_result *m)
{
    worker *const w = &c->work[number_of(c, b)];
    const uint32_t at = m->index - c->opts->first;
    const double now = port_now();

    if (m->job != c->job_key || m->index < c->opts->first || at >= c->opts->samples) {
        return;
    }
    store(c, b, at, m);
    pass_on(c);
    if (at >= w->first && at < w->end) {
        w->pace = w->pace > 0 ? 0.7 * w->pace + 0.3 * (now - w->mark) : now - w->mark;
        w->mark = now;
        go_on(c, b, at + 1 == w->told);
    }
}

/* A sign of life: is it at what it was told? */
static void take_status(campaign *c, board *b, const kelly_msg_status *m)
{
    worker *const w = &c->work[number_of(c, b)];
    const double since = port_now() - w->sent;
    const int idle = m->state == KELLY_STATE_IDLE, knows = m->end == c->opts->first + w->told;

    if (w->set) {
        go_on(c, b, (idle && knows && since > SAME_TIME) || ((idle || !knows) && since > RUN_TIME));
    }
}

static void board_heard(void *context, board *b, uint8_t type, uint32_t seq, const uint8_t *body, size_t size)
{
    campaign *const c = context;
    worker *const w = &c->work[number_of(c, b)];
    union {
        kelly_msg_case_reply reply;
        kelly_msg_result result;
        kelly_msg_status status;
        kelly_msg_error error;
    } m;

    (void)seq;
    if (type == KELLY_MSG_CASE_REPLY && kelly_get_case_reply(body, size, &m.reply) && m.reply.case_crc == c->case_key && !w->set) {
        w->set = 1;
        next_range(c, b);
    } else if (type == KELLY_MSG_RESULT && w->set && kelly_get_result(body, size, &m.result)) {
        take_result(c, b, &m.result);
    } else if (type == KELLY_MSG_STATUS && kelly_get_status(body, size, &m.status)) {
        take_status(c, b, &m.status);
    } else if (type == KELLY_MSG_ERROR && kelly_get_error(body, size, &m.error)) {
        if (m.error.code != KELLY_ERR_SCHEMA && m.error.code != KELLY_ERR_NO_CASE && m.error.code != KELLY_ERR_ORDER) {
            board_refused(b, &m.error);
        }
        link_greet(&c->set, b, "it has been restarted");
    }
}

/* ---- the campaign ---------------------------------------------------------------------------------------------- */

static void write_bench(FILE *to, const void *of)
{
    const campaign *const c = of;

    fprintf(to, "  \"bench\": {\"resumed\": %u, \"boards\": [", c->recalled);
    for (unsigned i = 0; i < c->set.count; i++) {
        const worker *const w = &c->work[i];

        fprintf(to, "%s\n    {", i ? "," : "");
        bench_write_board(to, &c->set.boards[i]);
        fprintf(to, ", \"results\": %u, \"doubles\": %u, \"runs_repeated\": %u, \"seconds_each\": %.6f}", w->results, w->doubles, w->repeats, w->pace);
    }
    fputs("]},\n", to);
}

static void print_bench(const campaign *c)
{
    if (c->recalled > 0) {
        printf("%u from the journal, %u from boards\n", c->recalled, c->delivered - c->recalled);
    }
    for (unsigned i = 0; i < c->set.count; i++) {
        const board *const b = &c->set.boards[i];
        const worker *const w = &c->work[i];

        printf("%s: %s, image %08x, %u results (%u double), %u repeats, bad frames %u here and %u there, connected %u times\n", b->port.text,
               b->ups ? b->is.board : "never answered", b->is.image_crc, w->results, w->doubles, w->repeats + b->retries,
               b->bad + b->receiver.bad, b->bad_there, b->ups);
    }
}

static void recall(campaign *c)
{
    kelly_result r;
    uint32_t at;

    job_log(&c->out.log, c->opts, first_output(c->opts, (const char *const[]){ c->opts->csv, c->opts->json }, 2, "--csv or --json"), &(journal_run){ .kind = "bench", .records = c->opts->samples, .payload = sizeof(r), .sound = results_sound });
    while (journal_next(&c->out.log, &at, &r)) {
        if (!c->cells[at].done) {
            take_first(c, at, &r, NO_BOARD);
        }
    }
    c->recalled = c->delivered;
    pass_on(c);
}

/* Until the last index is there; what a board sends after that does not matter. */
static void collect(campaign *c)
{
    const double start = port_now();
    double shown = start;

    link_begin(&c->set);
    while (c->low < c->opts->samples) {
        link_wait(&c->set, 0.05);
        if (progress_wanted(c->opts) && port_now() - shown > 0.25) {
            shown = port_now();
            progress_show(c->opts, c->delivered, c->opts->samples, shown - start);
        }
    }
    if (progress_wanted(c->opts)) {
        progress_end(c->opts, c->opts->samples, port_now() - start);
    }
    for (unsigned i = 0; i < c->set.count; i++) {
        if (c->set.boards[i].state == BOARD_READY) {
            (void)board_send(&c->set.boards[i], KELLY_MSG_STOP, 0, 0);
        }
    }
}

int bench_campaign(const bench_request *ask, board *boards)
{
    static campaign c;
    kelly_msg_case_set set;
    char engine[48];
    int status;

    if ((uint64_t)ask->opts.first + ask->opts.samples > UINT32_MAX) {
        die(EXIT_USAGE, "--first %u --samples %u: indices end at 4294967294 on a bench", ask->opts.first, ask->opts.samples);
    }
    c = (campaign){ .opts = &ask->opts, .set = { .boards = boards, .count = ask->ports, .give_up = ask->give_up,
                    .on = { board_up, board_down, board_heard, &c } } };
    c.cells = calloc(ask->opts.samples, sizeof(*c.cells));
    if (!c.cells) {
        die(EXIT_FAILED, "out of memory; give fewer --samples, %zu bytes each", sizeof(*c.cells));
    }
    bench_case(&ask->opts.run, &set);
    c.body_size = kelly_put_case_set(c.body, &set);
    c.case_key = kelly_case_key(&set);
    c.job_key = kelly_job_key(c.case_key, ask->opts.seed);
    snprintf(engine, sizeof(engine), "a bench of %u board%s", ask->ports, ask->ports > 1 ? "s" : "");
    c.out.more = write_bench;
    c.out.more_of = &c;
    outcome_open(&c.out, &ask->opts, engine);
    recall(&c);
    if (c.low < ask->opts.samples) {
        collect(&c);
    }
    status = outcome_close(&c.out);
    if (outcome_speaks(&ask->opts)) {
        print_bench(&c);
    }
    free(c.cells);
    return status;
}
