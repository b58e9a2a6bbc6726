/* test_integrator.c - form M: it is the textbook's RK4, of fourth order, and the same however it is cut. */
#include "../firmware/detmath.h"
#include "../firmware/stages.h"
#include "check.h"
#include "fixture.h"

static kelly_case run;
static kelly_draw draw;
static kelly_modes modes;

/* The nominal draw of `run` in lane 0 of a block. */
static void load(kelly_block *block, const kelly_table *table)
{
    kelly_draw_nominal(&run, &draw);
    EQUAL(kelly_realise(table, &run, &draw, &modes), KELLY_OK);
    kelly_block_clear(block, table, &run, 1);
    kelly_block_load(block, 0, &run, &draw, &modes);
}

/* Largest distance of the bit speed from the textbook's over `ticks` steps [rad/s]; both are left at the last tick. */
static wide distance(const kelly_table *table, uint32_t ticks)
{
    kelly_block *const block = &fixture.against.block;
    textbook *const book = &fixture.against.book;
    wide worst = 0;

    load(block, table);
    textbook_start(book, table, &run, &draw, &modes);
    for (uint32_t k = 0; k < ticks; k++) {
        wide away;

        kelly_block_advance(block, 1);
        textbook_step(book);
        away = fixture_abs((wide)kelly_block_speed(block, 0) - textbook_speed(book));
        worst = away <= worst ? worst : away;              /* a NaN stays */
    }
    return worst;
}

/* In float the textbook is in double on the host and in float on a board. */
static void follows_the_textbook(void)
{
    fixture_case(&run, 100000);
    CLOSE(distance(&kelly_string, BY_LENGTH(1500, 100000)), 0, BY_LENGTH(BY_REAL(2e-4, 1e-11), BY_REAL(2e-3, 1e-9)));
    run.mu = R(0.004);
    run.rotating = 1;
    CLOSE(distance(&kelly_string, BY_LENGTH(800, 20000)), 0, BY_LENGTH(BY_REAL(1e-4, 1e-11), BY_REAL(2e-4, 1e-10)));
    run.mu = R(0.03);
    run.rotating = 0;
    run.fc = R(45000.0);                                   /* lifts off: the weight is held at 0 */
    run.torsional = 3;
    CLOSE(distance(&kelly_string, BY_LENGTH(800, 20000)), 0, BY_LENGTH(BY_REAL(2e-4, 1e-11), BY_REAL(3e-4, 1e-10)));
}

/* The terms in w^2 that float leaves out for slow modes are there for fast ones. */
static void keeps_fast_terms(void)
{
    fixture_case(&run, 1000);
    run.torsional = KELLY_MODES_MAX;
    run.mu = R(0.01);
    run.step_ns = 2000000;
    CLOSE(distance(&fixture_fast, BY_LENGTH(300, 1000)), 0, BY_REAL(1e-4, 1e-11));
    CHECK(fixture.against.block.full);
    fixture_case(&run, 1000);
    run.torsional = 20;
    CLOSE(distance(&kelly_string, BY_LENGTH(300, 1000)), 0, BY_REAL(1e-4, 3e-11));
}

static void shows_modal_states(void)
{
    real q[KELLY_MODES_MAX], v[KELLY_MODES_MAX];
    const textbook *const book = &fixture.against.book;
    wide q_away = 0, v_away = 0;

    fixture_case(&run, 1000);
    (void)distance(&kelly_string, BY_LENGTH(300, 1000));
    kelly_block_modal(&fixture.against.block, 0, &modes, &kelly_string, q, v);
    for (unsigned i = 0; i < modes.count; i++) {
        const wide dq = fixture_abs((wide)q[i] - book->now.q[i]), dv = fixture_abs((wide)v[i] - book->now.v[i]);

        q_away = dq > q_away ? dq : q_away;
        v_away = dv > v_away ? dv : v_away;
    }
    CHECK(fixture_abs(book->now.q[0]) > W(1.0));           /* there is something to compare */
    CLOSE(q_away, 0, BY_REAL(5e-4, 5e-11));
    CLOSE(v_away, 0, BY_REAL(1e-3, 1e-10));
}

/* Speed after `ticks` steps in pieces of `piece`. */
static real in_pieces(uint32_t ticks, uint32_t piece)
{
    kelly_block *const block = &fixture.pair[0];

    load(block, &kelly_string);
    for (uint32_t done = 0; done < ticks; done += piece) {
        kelly_block_advance(block, ticks - done < piece ? ticks - done : piece);
    }
    EQUAL(block->tick, ticks);
    return kelly_block_speed(block, 0);
}

/* Across the ticks at which the sine is taken afresh, too. Two modes, to be quick. */
static void does_not_mind_cuts(void)
{
    const uint32_t ticks = BY_LENGTH(KELLY_RESYNC + 20, 3 * KELLY_RESYNC + 20);
    uint64_t at_once;

    fixture_case(&run, ticks);
    run.torsional = 2;
    at_once = fixture_bits(in_pieces(ticks, ticks));
    EQUAL(fixture_bits(in_pieces(ticks, 1)), at_once);
    EQUAL(fixture_bits(in_pieces(ticks, KELLY_RESYNC - 1)), at_once);
    EQUAL(fixture_bits(in_pieces(ticks, KELLY_RESYNC)), at_once);
#if CHECK_LONG
    EQUAL(fixture_bits(in_pieces(ticks, KELLY_RESYNC + 1)), at_once);
    EQUAL(fixture_bits(in_pieces(ticks, 7)), at_once);
    EQUAL(fixture_bits(in_pieces(ticks, 1000)), at_once);
#endif
}

/* Speed at the same instant with a step of `ns`. */
static wide at_step(uint32_t ns, uint32_t milliseconds)
{
    run.step_ns = ns;
    return (wide)in_pieces(milliseconds * (1000000u / 1000u) / (ns / 1000u), 100000);
}

/* On a smooth case the error of a step falls by 2^4 with each halving. log2 of the ratio of differences, in double;
 * in float the differences of fine steps are rounding, and only coarse ones can be told. */
static void is_of_fourth_order(void)
{
    wide coarse, middle, fine;

    fixture_case(&run, 1);
    run.mu = R(0.004);
    run.rotating = 1;
#ifdef KELLY_DOUBLE
    coarse = at_step(4000000u, 2000);
    middle = at_step(2000000u, 2000);
    fine = at_step(1000000u, 2000);
    CLOSE(kelly_log(fixture_abs(coarse - middle) / fixture_abs(middle - fine)) / W(0.69314718055994531), W(4.0), W(0.05));
#else
    coarse = at_step(20000000u, 400);
    middle = at_step(10000000u, 400);
    fine = at_step(2500000u, 400);
    CLOSE(kelly_log(fixture_abs(coarse - fine) / fixture_abs(middle - fine)) / W(0.69314718), W(4.0), W(0.5));
#endif
}

/* Without rock each mode decays freely about its drag equilibrium e = -alpha d w0 / w^2:
 * q' = exp(-c t / 2) [ v0 cos(wd t) + ((w^2 e - c v0 / 2) / wd) sin(wd t) ],  v0 = -d w0, wd^2 = w^2 - c^2 / 4. */
static wide free_speed(wide t)
{
    const wide w0 = (wide)draw.w0;
    wide speed = w0;

    for (unsigned i = 0; i < modes.count; i++) {
        const wide w2 = (wide)modes.w2[i], d = (wide)modes.d[i], c = (wide)kelly_string.alpha + (wide)kelly_string.beta * w2;
        const wide wd = textbook_sqrt(w2 - c * c / 4), v0 = -d * w0, pull = -(wide)kelly_string.alpha * d * w0;

        speed += (wide)modes.b[i] * kelly_exp(-c * t / 2) *
                 (v0 * textbook_cos(wd * t) + (pull - c * v0 / 2) / wd * textbook_sin(wd * t));
    }
    return speed;
}

static void swings_freely_without_rock(void)
{
    kelly_block *const block = &fixture.pair[0];
    const uint32_t ticks = BY_LENGTH(1000, 5000);
    const uint32_t look = ticks / 5;

    fixture_case(&run, ticks);
    run.mu = R(1e-12);
    run.torsional = 3;
    load(block, &kelly_string);
    for (uint32_t k = 1; k <= 5; k++) {
        kelly_block_advance(block, look);
        CLOSE((wide)kelly_block_speed(block, 0), free_speed((wide)(k * look) / 1000), BY_REAL(1e-4, 2e-8));
    }
}

static void starts_as_told(void)
{
    kelly_block *const block = &fixture.pair[0];

    fixture_case(&run, 100);
    load(block, &kelly_string);
    CLOSE((wide)kelly_block_speed(block, 0), W(0.1442639), BY_REAL(1e-5, 1e-7));   /* model.md; not 0 with ten modes */
    CHECK(kelly_block_sine(block, 0) == 0);
    EQUAL(block->tick, 0);
    run.rotating = 1;
    load(block, &kelly_string);
    CLOSE((wide)kelly_block_speed(block, 0), (wide)draw.w0, BY_REAL(1e-5, 1e-13));
}

/* Both ends of the watched stretch count, and nothing before it. */
static void watches_extremes(void)
{
    kelly_block *const block = &fixture.pair[0];
    real low, high, lowest, highest;

    fixture_case(&run, 400);
    load(block, &kelly_string);
    kelly_block_extremes(block, 0, &lowest, &highest);
    CHECK(lowest == kelly_block_speed(block, 0) && highest == lowest);
    kelly_block_advance(block, 150);
    kelly_block_watch(block);
    low = high = kelly_block_speed(block, 0);
    for (int k = 0; k < 200; k++) {
        const real speed = (kelly_block_advance(block, 1), kelly_block_speed(block, 0));

        low = speed < low ? speed : low;
        high = speed > high ? speed : high;
    }
    kelly_block_extremes(block, 0, &lowest, &highest);
    EQUAL(fixture_bits(lowest), fixture_bits(low));
    EQUAL(fixture_bits(highest), fixture_bits(high));
    CHECK(low < high);
}

/* w0 + difference of the twist over the time is the mean of the bit speed. */
static void twist_gives_the_mean(void)
{
    kelly_block *const block = &fixture.pair[0];
    const uint32_t ticks = BY_LENGTH(500, 4000);
    wide sum = 0, before, mean;

    fixture_case(&run, 2 * ticks);
    load(block, &kelly_string);
    kelly_block_advance(block, 300);
    before = (wide)kelly_block_twist(block, 0, &modes);
    for (uint32_t k = 0; k < ticks; k++) {
        const wide speed = (wide)kelly_block_speed(block, 0);

        kelly_block_advance(block, 1);
        sum += (speed + (wide)kelly_block_speed(block, 0)) / 2;
    }
    mean = (wide)draw.w0 + ((wide)kelly_block_twist(block, 0, &modes) - before) / ((wide)ticks * W(0.001));
    CLOSE(sum / (wide)ticks, mean, BY_REAL(2e-4, 2e-5));   /* the trapezoid's own error is 1e-5 */
}

/* Form S leaves out terms in h alpha, h w and h beta w^2: each alone, where it is not small, asks for form M, which is the textbook's. */
static void takes_the_form_that_fits(void)
{
    kelly_table other = kelly_string;

    fixture_case(&run, 400);
    load(&fixture.pair[0], &other);
    EQUAL(fixture.pair[0].full, sizeof(real) > sizeof(float));
    other.alpha = R(1.0);                                  /* h alpha = 1e-3 */
    CLOSE(distance(&other, 300), 0, BY_REAL(1e-4, 1e-9));
    CHECK(fixture.against.block.full);
    other = kelly_string;
    other.beta = R(1e-9);
    run.step_ns = 3000000;                                 /* h w = 0.16 in the tenth mode */
    run.mu = R(0.01);
    CLOSE(distance(&other, 100), 0, BY_REAL(1e-4, 1e-9));
    CHECK(fixture.against.block.full);
    other.beta = R(1e-3);
    run.step_ns = 50000;                                   /* h w = 3e-3, beta / h = 20 */
    CLOSE(distance(&other, 100), 0, BY_REAL(1e-4, 1e-9));
}

/* The two numbers of state of mode i. */
static real *state_of(kelly_block *block, unsigned i)
{
    return block->full ? &block->mode[0][i].xi : &block->slow[0][i].v;
}

static void knows_the_insane(void)
{
    kelly_block *const block = &fixture.pair[0];
    const real bad[] = { CHECK_NAN, CHECK_INFINITY, -CHECK_INFINITY, R(1e31), R(-1e31) };
    real *const place[] = { &block->lane[0].y1, &block->lane[0].lowest, &block->lane[0].highest, state_of(block, 0),
                            state_of(block, 0) + 1, state_of(block, 9), state_of(block, 9) + 1 };
    int caught = 1;

    fixture_case(&run, 100);
    load(block, &kelly_string);
    CHECK(kelly_block_sane(block, 0));
    for (unsigned p = 0; p < sizeof(place) / sizeof(place[0]); p++) {
        const real good = *place[p];

        for (unsigned k = 0; k < sizeof(bad) / sizeof(bad[0]); k++) {
            *place[p] = bad[k];
            caught &= !kelly_block_sane(block, 0);
        }
        *place[p] = good;
    }
    CHECK(caught);
    CHECK(kelly_block_sane(block, 0));
}

/* The weight off its phase is seen at once, and still known after the next exact evaluation has put it right. */
static void knows_a_weight_astray(void)
{
    kelly_block *const block = &fixture.pair[0];
    const real endless = fixture_endless();
    real swing, good;

    fixture_case(&run, 4000);
    load(block, &kelly_string);
    swing = block->lane[0].muf_swing;
    CHECK(!kelly_block_strays(block, 0));
    block->lane[0].wave = swing / 2;
    CHECK(kelly_block_strays(block, 0) && !kelly_block_sane(block, 0));
    block->lane[0].wave = endless - endless;
    CHECK(kelly_block_strays(block, 0));
    kelly_block_resync(block, 0);
    CHECK(kelly_block_sane(block, 0));
    good = block->lane[0].dwave;
    block->lane[0].dwave = endless - endless;
    CHECK(!kelly_block_strays(block, 0) && !kelly_block_sane(block, 0));
    block->lane[0].dwave = good;
    kelly_block_advance(block, KELLY_RESYNC);
    CHECK(kelly_block_sane(block, 0));
    block->lane[0].wave += swing / 2;
    kelly_block_advance(block, 1);
    CHECK(!kelly_block_strays(block, 0) && block->strayed[0] && !kelly_block_sane(block, 0));
    fixture_case(&run, 4000);
    run.w0 = R(2000.0);                                    /* 2 rad a step: only its size can be judged */
    load(block, &kelly_string);
    swing = block->lane[0].muf_swing;
    block->lane[0].wave = swing / 2;
    CHECK(!kelly_block_strays(block, 0));
    block->lane[0].wave = swing * R(1.5);
    CHECK(kelly_block_strays(block, 0));
}

/* What is only large is not insane: at a step of 10 us the scaled states reach 1e14. */
static void keeps_short_steps(void)
{
    kelly_block *const block = &fixture.pair[0];

    fixture_case(&run, 100);
    run.step_ns = 10000;
    load(block, &kelly_string);
    kelly_block_advance(block, 100);
    CHECK(KELLY_ABS(state_of(block, 0)[1]) > R(1e12));
    CHECK(kelly_block_sane(block, 0));
}

/* A block nobody was loaded into stands still. */
static void idles_when_empty(void)
{
    kelly_block *const block = &fixture.pair[0];
    real lowest, highest;

    fixture_case(&run, 100);
    kelly_block_clear(block, &kelly_string, &run, 1);
    kelly_block_advance(block, 50);
    kelly_block_extremes(block, 0, &lowest, &highest);
    CHECK(kelly_block_speed(block, 0) == 0 && lowest == 0 && highest == 0);
    CHECK(kelly_block_sane(block, 0));
}

void test_integrator(void);
void test_integrator(void)
{
    starts_as_told();
    follows_the_textbook();
    keeps_fast_terms();
    takes_the_form_that_fits();
    shows_modal_states();
    does_not_mind_cuts();
    is_of_fourth_order();
    swings_freely_without_rock();
    watches_extremes();
    twist_gives_the_mean();
    knows_the_insane();
    knows_a_weight_astray();
    keeps_short_steps();
    idles_when_empty();
}
