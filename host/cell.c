/* cell.c - one cell: its case, its P, its record in a journal. */
#include <math.h>

#include "map.h"

kelly_case cell_case(const study *s, const cell *c)
{
    kelly_case run = s->opts->run;

    run.w0 = (real)(c->rpm * RPM);
    run.fc = (real)(c->wob_kN * 1000.0);
    run.f0 = (real)(c->f0_kN * 1000.0);
    run.rotating = c->rotating;
    for (unsigned k = 0; k < KELLY_PARAMETERS; k++) {
        run.cov[k] = c->nominal ? 0.0f : run.cov[k];
    }
    return run;
}

int cell_trusted(const cell *c)
{
    return c->tally.samples > kelly_refused(&c->tally);
}

double cell_probability(const cell *c)
{
    return cell_trusted(c) ? (double)kelly_probability(&c->tally) : (double)NAN;
}

/* The tally in its own order: samples, stuck, lift-off, the statuses but corrupt, of which there is none here, digest. */
void cell_pack(const cell *c, uint8_t payload[CELL_PAYLOAD])
{
    const kelly_tally *const t = &c->tally;
    const uint32_t words[CELL_PAYLOAD / 4] = { t->samples, t->stuck, t->liftoff, t->status[0], t->status[1], t->status[2], t->status[3], t->digest };

    for (unsigned k = 0; k < CELL_PAYLOAD / 4; k++) {
        put_u32(&payload[(size_t)4 * k], words[k]);
    }
}

static void unpack(kelly_tally *t, const uint8_t payload[CELL_PAYLOAD])
{
    uint32_t *const words[CELL_PAYLOAD / 4] = { &t->samples, &t->stuck, &t->liftoff, &t->status[0], &t->status[1], &t->status[2], &t->status[3],
                                                &t->digest };

    for (unsigned k = 0; k < CELL_PAYLOAD / 4; k++) {
        *words[k] = get_u32(&payload[(size_t)4 * k]);
    }
}

void cell_unpack(cell *c, const uint8_t payload[CELL_PAYLOAD])
{
    unpack(&c->tally, payload);
    kelly_interval(&c->tally, &c->lo, &c->hi);
}

int cell_sound(const void *payload, size_t size)
{
    kelly_tally t = { 0 };
    uint64_t sum = 0;

    (void)size;
    unpack(&t, payload);
    for (unsigned k = 0; k < KELLY_STATUSES; k++) {
        sum += t.status[k];
    }
    return t.samples > 0 && sum == t.samples && t.stuck <= t.status[KELLY_OK] && t.liftoff <= t.samples;
}

void cells_recall(journal *log, cell *cells)
{
    uint8_t payload[CELL_PAYLOAD];
    uint32_t index;

    while (journal_next(log, &index, payload)) {
        cell_unpack(&cells[index], payload);
    }
}
