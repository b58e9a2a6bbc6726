/* rare.c - see rare.h. Au and Beck, Probabilistic Engineering Mechanics 16 (2001) 263-277; conditional sampling: Papaioannou, Betz,
 * Zwirglmaier and Straub, ibid. 41 (2015) 89-103. */
#include "rare.h"

#include "detmath.h"
#include "random.h"

#define QUARTERS 4u
#define FIRST_STEP 0.6f
#define LEAST_STEP 0.02f
#define MOST_STEP 1.0f
/* Acceptance of straight moves aimed at. 0.44 is the literature's for one level; over many, a long step does more harm than a short one. */
#define TARGET 0.35f
#define STRAIGHT 3u              /* where a hint leads, every third move is straight, for what the hint does not see */
#define MISLED 5u                /* a hint by which fewer than one in so many moves is accepted leads no more */
#define STILL 10u                /* a level must accept one move in so many */
#define STREAM UINT64_C(0x7261726500000000)    /* "rare": keeps the walk's streams off those of the first level */

/* ---- order --------------------------------------------------------------------------------------------------------- */

/*@ predicate heap_from(uint32_t *keys, integer top, integer n) = \forall integer c; 2 * top + 1 <= c < n ==> keys[(c - 1) / 2] >= keys[c]; */

/* Let keys[i] sink within the heap keys[0..n-1], the largest on top. */
/*@ requires n <= KELLY_RARE_MAX && i <= KELLY_RARE_MAX && \valid(keys + (0 .. n - 1)) && \valid(keys + i);
    assigns keys[0 .. n - 1], keys[i] \from keys[0 .. n - 1], keys[i], n, i;
    behavior given:
      assumes heap_from(keys, i + 1, n);
      ensures heap_from(keys, i, n); */
static void sink(uint32_t *keys, uint32_t n, uint32_t i)
{
    const uint32_t key = keys[i];

    /*@ loop invariant \at(i, Pre) <= i && (i < n || i == \at(i, Pre)) && child == 2 * i + 1;
        for given: loop invariant \forall integer c; 2 * \at(i, Pre) + 1 <= c < n && (c - 1) / 2 != i ==> keys[(c - 1) / 2] >= keys[c];
        for given: loop invariant i > \at(i, Pre) ==> (i - 1) / 2 >= \at(i, Pre) && keys[(i - 1) / 2] > key;
        for given: loop invariant i > \at(i, Pre) ==> \forall integer c; 2 * i + 1 <= c <= 2 * i + 2 && c < n ==> keys[(i - 1) / 2] >= keys[c];
        loop assigns i, child, keys[0 .. n - 1];
        loop variant n - i; */
    for (uint32_t child = 2 * i + 1; child < n; child = 2 * i + 1) {
        const uint32_t larger = child + 1 < n && keys[child + 1] > keys[child] ? child + 1 : child;

        if (keys[larger] <= key) {
            break;
        }
        keys[i] = keys[larger];
        i = larger;
    }
    keys[i] = key;
}

/*@ requires n <= KELLY_RARE_MAX && \valid(keys + (0 .. n - 1));
    assigns keys[0 .. n - 1] \from keys[0 .. n - 1], n;
    ensures heap_from(keys, 0, n); */
static void heap(uint32_t *keys, uint32_t n)
{
    /*@ loop invariant 0 <= i <= n / 2 && heap_from(keys, i, n);
        loop assigns i, keys[0 .. n - 1];
        loop variant i; */
    for (uint32_t i = n / 2; i > 0; i--) {
        sink(keys, n, i - 1);
    }
}

/* Take the largest of n > 0 away. */
/*@ requires 0 < n <= KELLY_RARE_MAX && \valid(keys + (0 .. n - 1));
    assigns keys[0 .. n - 1], \result \from keys[0 .. n - 1], n;
    behavior given:
      assumes heap_from(keys, 0, n);
      ensures heap_from(keys, 0, n - 1);
      ensures \forall integer j; 0 <= j < n ==> \result >= \old(keys[j]); */
static uint32_t pop(uint32_t *keys, uint32_t n)
{
    const uint32_t top = keys[0];

    /*@ ghost
        /@ loop invariant 1 <= c <= n;
           for given: loop invariant \forall integer j; 0 <= j < c ==> top >= keys[j];
           loop assigns c;
           loop variant n - c; @/
        for (uint32_t c = 1; c < n; c++) {} */
    keys[0] = keys[n - 1];
    sink(keys, n - 1, 0);
    return top;
}

/* The k-th largest guide, 1 <= k <= n: guides are >= 0 here, so that their bits have their order, but for those of -0. */
static float kth_guide(kelly_rare *rare, uint32_t k)
{
    union { uint32_t bits; float guide; } u = { .bits = 0 };

    /*@ loop invariant i <= rare->n;
        loop assigns i, u, rare->keys[0 .. \at(rare->n, Pre) - 1]; */
    for (uint32_t i = 0; i < rare->n; i++) {
        u.guide = rare->samples[i].guide;
        rare->keys[i] = u.guide > 0.0f ? u.bits : 0;
    }
    heap(rare->keys, rare->n);
    /*@ loop invariant taken <= k;
        loop assigns taken, u, rare->keys[0 .. \at(rare->n, Pre) - 1]; */
    for (uint32_t taken = 0; taken < k; taken++) {
        u.bits = pop(rare->keys, rare->n - taken);
    }
    return u.guide;
}

int kelly_rare_failed(const kelly_rare_sample *sample)
{
    return sample->guide >= KELLY_RARE_FAILED;
}

/* Different ones among the ids of the failures, or of their finds; and how many they are in effect: F^2 / sum m_i^2. */
static uint32_t count_different(kelly_rare *rare, int finds, float *in_effect)
{
    uint32_t n = 0, different = 0, last = 0;
    float all, same = 0.0f, squares = 0.0f;

    /*@ loop invariant n <= i <= rare->n;
        loop assigns i, n, rare->keys[0 .. \at(rare->n, Pre) - 1]; */
    for (uint32_t i = 0; i < rare->n; i++) {
        if (kelly_rare_failed(&rare->samples[i])) {
            rare->keys[n++] = finds ? rare->samples[i].find : rare->samples[i].id;
        }
    }
    all = (float)(int32_t)n;
    heap(rare->keys, n);
    /*@ loop invariant n <= rare->n;
        loop invariant 0 <= same <= \at(n, LoopEntry) - n;
        loop invariant 0 <= squares <= 2000000 * (\at(n, LoopEntry) - n - same);
        loop assigns n, different, last, squares, same, rare->keys[0 .. \at(rare->n, Pre) - 1]; */
    for (; n > 0; n--) {
        const uint32_t id = pop(rare->keys, n);

        if (different == 0 || id != last) {
            different++;
            //@ assert few: 0 <= same <= 1000000;
            //@ assert square: 0 <= same * same <= 1000000 * same;
            squares += same * same;
            same = 0.0f;
        }
        same += 1.0f;
        last = id;
    }
    squares += same * same;
    //@ assert few: 0 <= all <= 1000000;
    //@ assert all: 0 <= all * all <= 1000000 * all;
    //@ assert effect: squares >= 1 ==> 0 <= all * all / squares <= all * all;
    *in_effect = squares >= 1.0f ? all * all / squares : 0.0f;
    return different;
}

/* What is known of the failures of the last level. */
static void know_failures(kelly_rare *rare)
{
    float in_effect;

    rare->distinct = count_different(rare, 0, &in_effect);
    (void)count_different(rare, 1, &rare->finds);
}

/* ---- a level and its spread ---------------------------------------------------------------------------------------- */

static kelly_rare_level *now(kelly_rare *rare)
{
    return &rare->levels[rare->level];
}

static int inside(const kelly_rare *rare, uint32_t i, float guide)
{
    return rare->samples[i].guide >= guide;
}

/* Pairs of states of a chain, `lag` apart, both in the event; by the layout they lie lag * chains apart. */
static uint32_t count_pairs(const kelly_rare *rare, uint32_t lag, float guide)
{
    const uint32_t apart = lag * rare->chains;
    uint32_t pairs = 0;

    /*@ loop invariant pairs <= i <= rare->n - apart;
        loop assigns i, pairs; */
    for (uint32_t i = 0; i + apart < rare->n; i++) {
        pairs += inside(rare, i, guide) && inside(rare, i + apart, guide);
    }
    return pairs;
}

/* Samples in the event above `guide`, and the squared coefficient of variation of their share: (1 - p) / (p n) (1 + gamma),
 * gamma = 2 sum (1 - k / states) r(k) from the correlations r along the chains. Where all are inside, or none, there is no spread. */
static void measure(kelly_rare *rare, float guide)
{
    const uint32_t found = count_pairs(rare, 0, guide);
    kelly_rare_level *const level = now(rare);
    wide p, spread, gamma = 0;

    level->guide = guide;
    level->inside = found;
    level->variance = 0;
    if (found == rare->n || found == 0) {
        return;
    }
    p = (wide)found / (wide)rare->n;
    spread = p * (1 - p);
    //@ assert share: p * rare->n >= 0.9 && (1 - p) * rare->n >= 0.9;
    //@ assert shares: p >= 0 && 1 - p >= 0;
    //@ assert least: p * 1000000 >= 0.9 && (1 - p) * 1000000 >= 0.9;
    //@ assert low: p <= 0.5 ==> spread >= 0.0000004;
    //@ assert high: p >= 0.5 ==> spread >= 0.0000004;
    /*@ loop invariant 1 <= lag <= KELLY_RARE_STATES;
        loop invariant -5000000 * (lag - 1) <= gamma <= 5000000 * (lag - 1);
        loop assigns lag, gamma; */
    for (uint32_t lag = 1; rare->level > 0 && lag < KELLY_RARE_STATES; lag++) {
        const wide both = (wide)count_pairs(rare, lag, guide) / (wide)(rare->n - lag * rare->chains);
        const wide excess = both - p * p;

        //@ assert both: 0 <= both <= 1 && 0 <= p * p <= 1;
        //@ assert excess: -1 <= excess <= 1 && spread >= 0.0000004;
        //@ assert weight: 0 <= 2 * (1 - lag / 10.0) <= 2;
        //@ assert weighed: -2 <= 2 * (1 - lag / 10.0) * excess <= 2;
        //@ assert correlation: -5000000 <= 2 * (1 - lag / 10.0) * excess / spread <= 5000000;
        gamma += 2 * (1 - (wide)lag / (wide)KELLY_RARE_STATES) * excess / spread;
    }
    //@ assert alone: 0 <= (1 - p) / (p * rare->n) <= 1.2;
    level->variance = (1 - p) / (p * (wide)rare->n) * (1 + (gamma > 0 ? gamma : 0));
}

/* The first `chains` samples in the event go to the front, in order: any choice that does not look at the guide is fair. */
static void choose_seeds(kelly_rare *rare, float guide)
{
    /*@ loop invariant kept <= i <= rare->n;
        loop assigns i, kept, rare->samples[0 .. \at(rare->n, Pre) - 1]; */
    for (uint32_t i = 0, kept = 0; i < rare->n && kept < rare->chains; i++) {
        kelly_rare_sample sample;

        sample = rare->samples[i];
        if (inside(rare, i, guide)) {
            rare->samples[kept++] = sample;
        }
    }
}

/* ---- the walk ------------------------------------------------------------------------------------------------------ */

static void key_move(const kelly_rare *rare, uint32_t chain, kelly_rng *rng)
{
    uint64_t key = rare->seed;

    key = kelly_splitmix64(&key) ^ STREAM ^ rare->level;
    kelly_rng_key(rng, kelly_splitmix64(&key), chain, rare->at);
}

/* Whether the hint leads the present move. */
static int is_led(const kelly_rare *rare)
{
    return rare->leads && rare->at % STRAIGHT != 0;
}

/* From state `at` - 1 of each chain of the quarter. */
static void propose(kelly_rare *rare)
{
    const uint32_t from = rare->quarter * (rare->chains / QUARTERS);

    //@ assert from: from <= rare->chains - rare->chains / QUARTERS;
    //@ assert at: rare->chains <= rare->at * rare->chains <= 9 * rare->chains;
    rare->first = rare->at * rare->chains + from;
    rare->count = rare->chains / QUARTERS;
    //@ assert span: rare->chains <= rare->first && rare->first + rare->count <= rare->n;
    /*@ loop invariant \at(rare->first, LoopEntry) <= i <= \at(rare->first, LoopEntry) + \at(rare->count, LoopEntry);
        loop assigns i, rare->realisations, rare->samples[\at(rare->chains, Pre) .. \at(rare->n, Pre) - 1]; */
    for (uint32_t i = rare->first; i < rare->first + rare->count; i++) {
        const kelly_rare_sample *const old = &rare->samples[i - rare->chains];
        kelly_rng rng;

        key_move(rare, i % rare->chains, &rng);
        if (kelly_rare_move(rare, &rng, is_led(rare), old->x, rare->samples[i].x)) {
            rare->samples[i].id = rare->realisations;
        } else {
            rare->samples[i] = *old;                       /* run again, for whole vectors */
        }
        rare->realisations++;
    }
}

/* The first level: independent draws, those of kelly_draw_sample. */
static void draw_all(kelly_rare *rare)
{
    rare->first = 0;
    rare->count = rare->n;
    /*@ loop invariant i <= rare->n;
        loop assigns i, rare->realisations, rare->samples[0 .. \at(rare->n, Pre) - 1]; */
    for (uint32_t i = 0; i < rare->n; i++) {
        rare->samples[i] = (kelly_rare_sample){ .id = rare->realisations };
        rare->realisations++;
        /*@ loop invariant k <= KELLY_PARAMETERS;
            loop assigns k, rare->samples[i].x[0 .. KELLY_PARAMETERS - 1]; */
        for (unsigned k = 0; k < KELLY_PARAMETERS; k++) {
            kelly_rng rng;

            if (rare->cov[k] >= KELLY_RARE_COV) {
                kelly_rng_key(&rng, rare->seed, i, k);
                rare->samples[i].x[k] = kelly_gamma_normal(&rng, rare->cov[k]);
            }
        }
    }
}

/* A failure from none is a find. */
static void descend(kelly_rare *rare, uint32_t i)
{
    const kelly_rare_sample *const old = rare->level > 0 ? &rare->samples[i - rare->chains] : 0;

    rare->samples[i].find = old && kelly_rare_failed(old) ? old->find : rare->samples[i].id;
}

/* A move that leaves the event leaves the chain where it was. */
static void settle(kelly_rare *rare)
{
    kelly_rare_level *const level = now(rare);
    uint32_t accepted = 0;

    /*@ loop invariant \at(rare->first, Pre) <= i <= \at(rare->first, Pre) + \at(rare->count, Pre) && accepted <= i - \at(rare->first, Pre);
        loop assigns i, accepted, level->refused, rare->samples[0 .. \at(rare->n, Pre) - 1]; */
    for (uint32_t i = rare->first; i < rare->first + rare->count; i++) {
        level->refused += rare->samples[i].guide < 0.0f;
        if (rare->level > 0 && inside(rare, i, rare->guide)) {
            accepted += rare->samples[i].id != rare->samples[i - rare->chains].id;
            descend(rare, i);
        } else if (rare->level > 0) {
            rare->samples[i] = rare->samples[i - rare->chains];
        } else {
            descend(rare, i);
        }
    }
    if (rare->level > 0) {
        level->proposed += rare->count;
        level->accepted += accepted;
        if (is_led(rare)) {
            level->led += rare->count;
            level->led_accepted += accepted;
        } else {
            rare->straight += rare->count;
            rare->straight_accepted += accepted;
        }
    }
}

/* After a quarter: a longer step where more than TARGET of the straight moves were accepted, and whether the hint goes on leading.
 * Plain products: the same bits everywhere. */
static void adapt(kelly_rare *rare)
{
    const float factor = 1.0f + ((float)(int32_t)rare->straight_accepted / (float)(int32_t)rare->straight - TARGET);
    const float step = rare->step * (factor * factor);

    rare->straight = 0;
    rare->straight_accepted = 0;
    rare->leads = rare->leads && now(rare)->led_accepted * MISLED >= now(rare)->led;
    rare->step = step < LEAST_STEP ? LEAST_STEP : step > MOST_STEP ? MOST_STEP : step;
    now(rare)->step = rare->step;
}

/* ---- from level to level ------------------------------------------------------------------------------------------- */

/* Whether the chains of this level can be believed. */
static kelly_rare_state judge(const kelly_rare *rare)
{
    const kelly_rare_level *const level = &rare->levels[rare->level];

    if (level->refused > 0 && (rare->level > 0 || level->failed < rare->chains)) {
        return KELLY_RARE_UNKNOWN;
    }
    return rare->level > 0 && level->accepted * STILL < level->proposed ? KELLY_RARE_STILL : KELLY_RARE_RUNNING;
}

/* Whether those of the last of several levels can. */
static kelly_rare_state judge_failures(const kelly_rare *rare)
{
    return kelly_rare_product(rare) < KELLY_RARE_LEAST ? KELLY_RARE_TOO_RARE :
           rare->finds < KELLY_RARE_FINDS(rare->n) ? KELLY_RARE_LUCK :
           rare->distinct < KELLY_RARE_DISTINCT ? KELLY_RARE_FEW : KELLY_RARE_DONE;
}

static kelly_rare_state end_level(kelly_rare *rare)
{
    kelly_rare_level *const level = now(rare);
    const kelly_rare_state verdict = judge(rare);

    if (verdict != KELLY_RARE_RUNNING) {
        return verdict;
    }
    if (level->failed >= rare->chains) {
        measure(rare, KELLY_RARE_FAILED);
        know_failures(rare);
        return rare->level > 0 ? judge_failures(rare) : KELLY_RARE_DONE;
    }
    measure(rare, kth_guide(rare, rare->chains));
    if (kelly_rare_product(rare) < W(1.01) * KELLY_RARE_LEAST) {      /* and P lies below it */
        return level->failed > 0 ? KELLY_RARE_TOO_RARE : KELLY_RARE_NO_FAILURE;
    }
    return rare->level + 1 < KELLY_RARE_LEVELS ? KELLY_RARE_RUNNING : KELLY_RARE_DEEP;
}

static void next_level(kelly_rare *rare)
{
    now(rare)->failed = count_pairs(rare, 0, KELLY_RARE_FAILED);
    rare->state = end_level(rare);
    if (rare->state != KELLY_RARE_RUNNING) {
        rare->count = 0;
        return;
    }
    rare->guide = now(rare)->guide;
    choose_seeds(rare, rare->guide);
    if (rare->leads) {
        kelly_rare_aim(rare);
    }
    rare->level++;
    *now(rare) = (kelly_rare_level){ .step = rare->step };
    rare->quarter = 0;
    rare->at = 1;
    propose(rare);
}

void kelly_rare_accept(kelly_rare *rare)
{
    if (rare->count == 0) {
        return;
    }
    settle(rare);
    if (rare->level > 0 && rare->at + 1 < KELLY_RARE_STATES) {
        rare->at++;
        propose(rare);
        return;
    }
    if (rare->level > 0) {
        adapt(rare);
        if (++rare->quarter < QUARTERS) {
            rare->at = 1;
            propose(rare);
            return;
        }
    }
    next_level(rare);
}

uint32_t kelly_rare_count(const kelly_rare *rare)
{
    return rare->count;
}

const char *kelly_rare_start(kelly_rare *rare, const float cov[KELLY_PARAMETERS], uint64_t seed, uint32_t n,
                             kelly_rare_sample *samples, uint32_t *keys)
{
    unsigned laws = 0;

    /*@ loop invariant laws <= k <= KELLY_PARAMETERS;
        loop assigns k, laws; */
    for (unsigned k = 0; k < KELLY_PARAMETERS; k++) {
        laws += cov[k] >= KELLY_RARE_COV;
    }
    if (n < KELLY_RARE_MIN || n > KELLY_RARE_MAX || n % (QUARTERS * KELLY_RARE_STATES) != 0) {
        return "samples a level must be a multiple of 40 in 200..1000000";
    }
    if (laws == 0) {
        return "nothing is random: P is 0 or 1; give a coefficient of variation";
    }
    //@ assert tenths: n / KELLY_RARE_STATES * KELLY_RARE_STATES == n && n / KELLY_RARE_STATES % QUARTERS == 0;
    *rare = (kelly_rare){ .level = 0 };
    rare->seed = seed;
    rare->n = n;
    rare->chains = n / KELLY_RARE_STATES;
    rare->samples = samples;
    rare->keys = keys;
    rare->level = 0;                                       /* WP cannot look into the literal */
    rare->leads = 0;
    rare->straight = 0;
    rare->straight_accepted = 0;
    rare->step = FIRST_STEP;
    //@ assert begun: rare->n == n && rare->chains == n / KELLY_RARE_STATES && rare->samples == samples && rare->keys == keys && rare->level == 0 && rare->leads == 0;
    //@ assert paced: rare->straight == 0 && rare->straight_accepted == 0 && 0.01 <= rare->step <= 1;
    /*@ loop invariant k <= KELLY_PARAMETERS;
        loop assigns k, rare->cov[0 .. KELLY_PARAMETERS - 1]; */
    for (unsigned k = 0; k < KELLY_PARAMETERS; k++) {
        rare->cov[k] = cov[k];
    }
    draw_all(rare);
    return 0;
}

void kelly_rare_lead(kelly_rare *rare, const kelly_rare_hint *hint)
{
    rare->hint = hint;
    rare->leads = 1;
}
