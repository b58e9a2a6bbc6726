#include "ledger.h"

#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "../firmware/link/crc32c.h"

#define REALS 9u                 /* of a result: the draw, lowest, highest, mean, ss */
#define PAYLOAD (REALS * (uint32_t)sizeof(real) + 4u)   /* and status, stuck, lift-off, a zero */
#define ROOM 1024u               /* at first */
#define TOGETHER 64u             /* records in one write */

/* ---- a result as bytes ------------------------------------------------------------------------------------------ */

typedef union {
    real x;
    uint8_t bytes[sizeof(real)];
    uint32_t word[sizeof(real) / 4];
} bits;

static void fields(kelly_result *r, real *at[REALS])
{
    real *const list[REALS] = { &r->draw.fc, &r->draw.mu, &r->draw.a1, &r->draw.a2, &r->draw.w0, &r->lowest, &r->highest, &r->mean, &r->ss };

    memcpy(at, list, sizeof(list));
}

/* Words of a real, the lower one first: whatever the byte order of the machine. */
static unsigned word_at(unsigned k)
{
    const bits one = { .word = { 1 } };

    return one.bytes[0] ? k : (unsigned)(sizeof(real) / 4) - 1 - k;
}

static void pack(const kelly_result *result, uint8_t payload[PAYLOAD])
{
    kelly_result copy = *result;
    real *at[REALS];

    fields(&copy, at);
    for (unsigned i = 0; i < REALS; i++) {
        const bits b = { .x = *at[i] };

        for (unsigned k = 0; k < sizeof(real) / 4; k++) {
            put_u32(payload + i * sizeof(real) + 4 * k, b.word[word_at(k)]);
        }
    }
    put_u32(payload + REALS * sizeof(real), (uint32_t)result->status | (uint32_t)result->stuck << 8 | (uint32_t)result->liftoff << 16);
}

static kelly_result unpack(const uint8_t payload[PAYLOAD])
{
    const uint32_t flags = get_u32(payload + REALS * sizeof(real));
    kelly_result r = { .status = (uint8_t)(flags & (KELLY_STATUSES - 1)), .stuck = flags >> 8 & 1, .liftoff = flags >> 16 & 1 };
    real *at[REALS];

    fields(&r, at);
    for (unsigned i = 0; i < REALS; i++) {
        bits b = { .x = 0 };

        for (unsigned k = 0; k < sizeof(real) / 4; k++) {
            b.word[word_at(k)] = get_u32(payload + i * sizeof(real) + 4 * k);
        }
        *at[i] = b.x;
    }
    return r;
}

/* ---- whose run it is ---------------------------------------------------------------------------------------------- */

uint32_t run_identity(const options *opts)
{
    const kelly_case *const r = &opts->run;
    char text[512];

    snprintf(text, sizeof(text), "%s %a %a f0 %a mu %a %a %a cov %a %a %a %a %a limit %a time %u %u %u %u modes %u %s", KELLY_VERSION,
             (double)r->w0, (double)r->fc, (double)r->f0, (double)r->mu, (double)r->a1, (double)r->a2, (double)r->cov[0], (double)r->cov[1],
             (double)r->cov[2], (double)r->cov[3], (double)r->cov[4], (double)r->limit, r->step_ns, r->ticks, r->window_first, r->window_last,
             r->torsional, r->rotating ? "rotating" : "rest");
    return kelly_crc32c(0, (const uint8_t *)text, strlen(text));
}

int is_file(const char *path)
{
    struct stat there;

    return path && strcmp(path, "-") != 0 && (stat(path, &there) != 0 || S_ISREG(there.st_mode));
}

/* ---- in: what the journal holds ----------------------------------------------------------------------------------- */

static void make_room(ledger *l, uint32_t needed)
{
    const uint32_t twice = l->room < UINT32_MAX / 2 ? 2 * l->room : UINT32_MAX;
    const uint32_t room = needed > twice ? needed : twice > ROOM ? twice : ROOM;
    kelly_result *const waiting = calloc(room, sizeof(*waiting));
    uint8_t *const have = calloc(room, 1);

    if (!waiting || !have) {
        die(EXIT_FAILED, "%s: out of memory for %u results that wait for index %u", l->log.path, needed, l->opts->first + l->next);
    }
    for (uint32_t i = 0; i < l->room; i++) {
        const uint32_t from = (l->next + i) % l->room, to = (l->next + i) % room;

        waiting[to] = l->waiting[from];
        have[to] = l->have[from];
    }
    free(l->waiting);
    free(l->have);
    l->waiting = waiting;
    l->have = have;
    l->room = room;
}

/* One sound record: hand on what can be handed on. An index that comes twice came with the same bits. */
static void take_record(void *context, uint32_t index, const uint8_t *payload)
{
    ledger *const l = context;

    if (index < l->next) {
        return;
    }
    if (index - l->next >= l->room) {
        make_room(l, index - l->next + 1);
    }
    l->waiting[index % l->room] = unpack(payload);
    l->have[index % l->room] = 1;
    while (l->have[l->next % l->room]) {
        l->have[l->next % l->room] = 0;
        l->sink(l->context, l->opts->first + l->next, 1, &l->waiting[l->next % l->room]);
        l->next++;
    }
}

/* Results that the journal held behind the first missing index. */
static void recall(void *context, uint32_t first, uint32_t count, void *results, uint8_t *have)
{
    const ledger *const l = context;
    kelly_result *const r = results;

    for (uint32_t i = 0; i < count; i++) {
        const uint32_t at = first - l->opts->first + i;

        if (at - l->next < l->room && l->have[at % l->room]) {
            r[i] = l->waiting[at % l->room];
            have[i] = 1;
        }
    }
}

/* ---- out ------------------------------------------------------------------------------------------------------------ */

static void save(void *context, uint32_t first, uint32_t count, const void *results)
{
    ledger *const l = context;
    const kelly_result *const r = results;
    uint8_t payloads[TOGETHER * PAYLOAD];

    for (uint32_t done = 0; done < count; done += TOGETHER) {
        const uint32_t now = count - done < TOGETHER ? count - done : TOGETHER;

        for (uint32_t i = 0; i < now; i++) {
            pack(&r[done + i], payloads + (size_t)i * PAYLOAD);
        }
        journal_append_run(&l->log, first - l->opts->first + done, now, payloads);
    }
}

void ledger_open(ledger *l, const options *opts, const char *output, batch_sink sink, void *context)
{
    uint8_t first[4];

    *l = (ledger){ .open = 1, .opts = opts, .sink = sink, .context = context };
    l->keep = (keeper){ .context = l, .recall = recall, .save = save };
    make_room(l, ROOM);
    put_u32(first, opts->first);
    journal_open(&l->log, output, &(journal_run){ .kind = "montecarlo", .model = kelly_string.id, .seed = opts->seed,
                 .parameters = kelly_crc32c(run_identity(opts), first, 4), .records = opts->samples, .payload = PAYLOAD },
                 opts->resume, take_record, l);
}

options ledger_rest(const ledger *l, const options *opts)
{
    options rest = *opts;

    rest.samples = opts->samples - l->next;
    rest.first = rest.samples > 0 ? opts->first + l->next : opts->first;
    return rest;
}

void ledger_close(ledger *l)
{
    if (l->open) {
        journal_remove(&l->log);
        free(l->waiting);
        free(l->have);
        *l = (ledger){ 0 };
    }
}
