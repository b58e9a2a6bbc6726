/* levels.h - for WP: a level of rare.h of any size, and what each function of rare.c and rare_look.c, and kelly_rare_aim, asks of it and leaves
 * of it: of memory, of indices, and of what is summed or divided over samples. Floats are taken as reals. Bounds leave room for what rounding
 * adds: 1000000 floats summed lose less than 7 %. All other values are Eva's to say (tests/eva/rare.c, look.c, walk.c). Large numbers are
 * written out, as WP reads 4e6 as 4.6. */
#ifndef KELLY_EVA_LEVELS_H
#define KELLY_EVA_LEVELS_H

#include "rare.h"

#ifdef QUOTIENTS   /* of means; they hinder the other proofs */
/*@ lemma below: \forall real s, n; 0 < n && s <= 2000000 * n ==> s / n <= 2000000;
    lemma above: \forall real s, n; 0 < n && -2000000 * n <= s ==> -2000000 <= s / n;
    lemma share: \forall real s, n; 1 <= n && 0 <= s <= 2000000000000 * n ==> 0 <= s / n <= 2000000000000;
*/
#endif
/*@ predicate sized(kelly_rare *r) = KELLY_RARE_MIN <= r->n <= KELLY_RARE_MAX && r->n % 40 == 0 && 10 * r->chains == r->n && r->chains % 4 == 0 &&
      r->level < KELLY_RARE_LEVELS;
    predicate hinted(kelly_rare *r) = r->leads != 0 ==> \valid_read(r->hint);
    predicate held(kelly_rare *r) = \valid(r) && \valid(r->samples + (0 .. r->n - 1)) && \valid(r->keys + (0 .. r->n - 1)) &&
      \separated(r, r->samples + (0 .. r->n - 1), r->keys + (0 .. r->n - 1)) && hinted(r);
    predicate span(kelly_rare *r) = r->first + r->count <= r->n && (r->level > 0 ==> r->first >= r->chains);
    predicate turn(kelly_rare *r) = r->quarter < 4 && 1 <= r->at < KELLY_RARE_STATES;
    predicate ready(kelly_rare *r) = span(r) && (r->level > 0 ==> turn(r));
    predicate paced(kelly_rare *r) = r->straight_accepted <= r->straight <= (r->level > 0 ? 100000 * r->at : 0) && 0.01 <= r->step <= 1;
    predicate going(kelly_rare *r) = ready(r) && paced(r) && (r->level > 0 ==> r->count == r->chains / 4);
    predicate kept{K, L}(kelly_rare *r) = \at(r->n, K) == \at(r->n, L) && \at(r->chains, K) == \at(r->chains, L) &&
      \at(r->samples, K) == \at(r->samples, L) && \at(r->keys, K) == \at(r->keys, L) && \at(r->hint, K) == \at(r->hint, L);
    predicate stood{K, L}(kelly_rare *r) = \at(r->level, K) == \at(r->level, L) && \at(r->at, K) == \at(r->at, L) &&
      \at(r->quarter, K) == \at(r->quarter, L) && \at(r->leads, K) == \at(r->leads, L);
    predicate as_fast{K, L}(kelly_rare *r) = \at(r->straight, K) == \at(r->straight, L) &&
      \at(r->straight_accepted, K) == \at(r->straight_accepted, L) && \at(r->step, K) == \at(r->step, L);
    lemma apart: \forall real a, b; -100 <= a <= 100 && -1000000 <= b <= 1000000 ==> 0 <= (a - b) * (a - b) <= 1000200010000;
    lemma few: \forall real x; 0 <= x <= 1000000 ==> 0 <= x * x <= 1000000 * x;
*/
/*@ requires sized(rare) && held(rare) && 1 <= k <= rare->n;
    assigns rare->keys[0 .. rare->n - 1]; */
static float kth_guide(kelly_rare *rare, uint32_t k);
/*@ requires \valid_read(sample);
    assigns \nothing;
    ensures \result != 0 <==> sample->guide >= KELLY_RARE_FAILED; */
int kelly_rare_failed(const kelly_rare_sample *sample);
/*@ requires sized(rare) && held(rare) && \valid(in_effect);
    assigns rare->keys[0 .. rare->n - 1], *in_effect;
    ensures 0 <= *in_effect <= 1100000000000; */
static uint32_t count_different(kelly_rare *rare, int finds, float *in_effect);
/*@ requires i < rare->n && held(rare);
    assigns \nothing;
    ensures \result == 0 || \result == 1; */
static int inside(const kelly_rare *rare, uint32_t i, float guide);
/*@ requires sized(rare) && held(rare) && lag < KELLY_RARE_STATES;
    assigns \nothing;
    ensures \result <= rare->n - lag * rare->chains; */
static uint32_t count_pairs(const kelly_rare *rare, uint32_t lag, float guide);
/*@ requires sized(rare) && held(rare);
    assigns \nothing;
    ensures \result == &rare->levels[rare->level]; */
static kelly_rare_level *now(kelly_rare *rare);
/*@ requires \valid_read(rare);
    assigns \nothing;
    ensures hinted: \result != 0 ==> rare->leads != 0 && rare->at % 3 != 0; */
static int is_led(const kelly_rare *rare);
/*@ requires sized(rare) && held(rare) && \valid_read(hint);
    assigns rare->hint, rare->leads;
    ensures held(rare); */
void kelly_rare_lead(kelly_rare *rare, const kelly_rare_hint *hint);
/*@ requires sized(rare) && held(rare);
    assigns rare->samples[0 .. rare->n - 1];
    ensures kept{Pre, Post}(rare) && stood{Pre, Post}(rare) && as_fast{Pre, Post}(rare); */
static void choose_seeds(kelly_rare *rare, float guide);
/*@ requires \valid_read(rare) && \valid(rng);
    assigns *rng; */
static void key_move(const kelly_rare *rare, uint32_t chain, kelly_rng *rng);
/*@ requires \valid_read(rare) && \valid(rng) && \valid_read(old + (0 .. 4)) && \valid(next + (0 .. 4));
    requires hinted: led != 0 ==> \valid_read(rare->hint);
    assigns *rng, next[0 .. 4]; */
int kelly_rare_move(const kelly_rare *rare, kelly_rng *rng, int led, const float old[KELLY_PARAMETERS], float next[KELLY_PARAMETERS]);
/*@ requires \valid(rng);
    assigns *rng; */
void kelly_rng_key(kelly_rng *rng, uint64_t seed, uint32_t index, uint32_t stream);
/*@ requires \valid(rng);
    assigns *rng; */
float kelly_gamma_normal(kelly_rng *rng, float cov);
/*@ requires \valid(state);
    assigns *state; */
uint64_t kelly_splitmix64(uint64_t *state);
/*@ requires sized(rare) && held(rare) && rare->level > 0;
    requires turn: turn(rare);
    requires paced(rare);
    assigns rare->first, rare->count, rare->realisations, rare->samples[rare->chains .. rare->n - 1];
    ensures going(rare) && kept{Pre, Post}(rare) && stood{Pre, Post}(rare) && as_fast{Pre, Post}(rare); */
static void propose(kelly_rare *rare);
/*@ requires sized(rare) && held(rare);
    assigns rare->first, rare->count, rare->realisations, rare->samples[0 .. rare->n - 1];
    ensures rare->first == 0 && rare->count == rare->n; */
static void draw_all(kelly_rare *rare);
/*@ requires \valid(rare) && \valid_read(cov + (0 .. KELLY_PARAMETERS - 1)) && \separated(rare, cov + (0 .. KELLY_PARAMETERS - 1));
    requires n <= KELLY_RARE_MAX ==> \valid(samples + (0 .. n - 1)) && \valid(keys + (0 .. n - 1)) &&
      \separated(rare, samples + (0 .. n - 1), keys + (0 .. n - 1)) && \separated(cov + (0 .. KELLY_PARAMETERS - 1), samples + (0 .. n - 1));
    assigns *rare, samples[0 .. n - 1];
    ensures \result == \null ==> sized(rare) && held(rare) && going(rare) && rare->n == n; */
const char *kelly_rare_start(kelly_rare *rare, const float cov[KELLY_PARAMETERS], uint64_t seed, uint32_t n,
                             kelly_rare_sample *samples, uint32_t *keys);
/*@ requires sized(rare) && held(rare) && i < rare->n && (rare->level > 0 ==> i >= rare->chains);
    assigns rare->samples[i].find; */
static void descend(kelly_rare *rare, uint32_t i);
/*@ requires sized(rare) && held(rare) && going(rare);
    assigns rare->levels[0 .. KELLY_RARE_LEVELS - 1], rare->straight, rare->straight_accepted, rare->samples[0 .. rare->n - 1];
    ensures rare->straight_accepted <= rare->straight <= (rare->level > 0 ? 100000 * (rare->at + 1) : 0);
    ensures rare->level > 0 && rare->at % 3 == 0 ==> rare->straight > 0;
    ensures kept{Pre, Post}(rare) && stood{Pre, Post}(rare); */
static void settle(kelly_rare *rare);

/*@ requires sized(rare) && held(rare);
    assigns rare->keys[0 .. rare->n - 1], rare->distinct, rare->finds;
    ensures 0 <= rare->finds <= 1100000000000;
    ensures kept{Pre, Post}(rare) && stood{Pre, Post}(rare); */
static void know_failures(kelly_rare *rare);
/*@ requires sized(rare) && held(rare);
    assigns rare->levels[0 .. KELLY_RARE_LEVELS - 1];
    ensures rare->levels[rare->level].inside <= rare->n && 0 <= rare->levels[rare->level].variance <= 1000000000;
    ensures kept{Pre, Post}(rare) && stood{Pre, Post}(rare); */
static void measure(kelly_rare *rare, float guide);
/*@ requires sized(rare) && held(rare) && rare->straight_accepted <= rare->straight && 0 < rare->straight <= 1000000 && 0.01 <= rare->step <= 1;
    assigns rare->levels[0 .. KELLY_RARE_LEVELS - 1], rare->straight, rare->straight_accepted, rare->leads, rare->step;
    ensures held(rare) && rare->straight == 0 && rare->straight_accepted == 0 && 0.01 <= rare->step <= 1;
    ensures kept{Pre, Post}(rare) && rare->level == \old(rare->level) && rare->quarter == \old(rare->quarter); */
static void adapt(kelly_rare *rare);
/*@ requires sized(rare) && held(rare);
    assigns \nothing; */
static kelly_rare_state judge(const kelly_rare *rare);
/*@ requires sized(rare) && held(rare);
    assigns \nothing;
    ensures \result != KELLY_RARE_RUNNING;
    ensures \result == KELLY_RARE_DONE ==> rare->finds >= 1; */
static kelly_rare_state judge_failures(const kelly_rare *rare);
/*@ requires sized(rare) && held(rare);
    assigns \nothing; */
wide kelly_rare_product(const kelly_rare *rare);
/*@ requires sized(rare) && held(rare);
    assigns rare->keys[0 .. rare->n - 1], rare->distinct, rare->finds, rare->levels[0 .. KELLY_RARE_LEVELS - 1];
    ensures \result == KELLY_RARE_RUNNING ==> rare->level + 1 < KELLY_RARE_LEVELS;
    ensures kept{Pre, Post}(rare) && stood{Pre, Post}(rare) && as_fast{Pre, Post}(rare); */
static kelly_rare_state end_level(kelly_rare *rare);
/*@ requires sized(rare) && held(rare) && rare->leads != 0;
    assigns rare->hint_level;
    ensures -1000000000 <= rare->hint_level <= 1000000000;
    ensures kept{Pre, Post}(rare) && stood{Pre, Post}(rare) && as_fast{Pre, Post}(rare); */
void kelly_rare_aim(kelly_rare *rare);
/*@ requires sized(rare) && held(rare) && rare->straight == 0 && rare->straight_accepted == 0 && 0.01 <= rare->step <= 1;
    assigns *rare, rare->samples[0 .. rare->n - 1], rare->keys[0 .. rare->n - 1];
    ensures sized(rare) && held(rare) && (rare->count > 0 ==> going(rare));
    ensures kept{Pre, Post}(rare); */
static void next_level(kelly_rare *rare);
/*@ requires sized(rare) && held(rare) && (rare->count > 0 ==> going(rare));
    assigns *rare, rare->samples[0 .. rare->n - 1], rare->keys[0 .. rare->n - 1];
    ensures sized(rare) && held(rare) && (rare->count > 0 ==> going(rare));
    ensures kept{Pre, Post}(rare); */
void kelly_rare_accept(kelly_rare *rare);
/*@ requires \valid_read(rare);
    assigns \nothing;
    ensures \result == rare->count; */
uint32_t kelly_rare_count(const kelly_rare *rare);
/*@ requires \valid_read(x + (0 .. 4)) && \valid_read(hint);
    assigns \nothing; */
float kelly_rare_resonance(const kelly_rare_hint *hint, const float x[KELLY_PARAMETERS], unsigned mode);
/*@ requires \valid_read(x + (0 .. 4)) && \valid_read(hint);
    assigns \nothing;
    ensures -1000000 <= \result <= 1000000; */
float kelly_rare_guess(const kelly_rare_hint *hint, const float x[KELLY_PARAMETERS]);
/*@ requires \valid_read(hint) && \valid_read(hint->run);
    assigns \nothing; */
static float enough_of(const kelly_rare_hint *hint);
/*@ requires sized(look) && held(look);
    assigns \nothing; */
static wide reached(const kelly_rare *look);
/*@ requires sized(look) && held(look) && (look->count > 0 ==> going(look)) && most > 0 && \valid_read(hint) && \valid_read(hint->run);
    requires \separated(hint, look, look->samples + (0 .. look->n - 1), look->keys + (0 .. look->n - 1));
    assigns *look, look->samples[0 .. look->n - 1], look->keys[0 .. look->n - 1];
    ensures sized(look) && held(look) && look->first == 0 && look->count <= look->n || look->count == 0; */
void kelly_rare_look(kelly_rare *look, const kelly_rare_hint *hint, unsigned mode, wide least, uint32_t most);
/*@ requires sized(look) && held(look) && look->count <= look->n && \valid(seen) && \separated(seen, look, look->samples + (0 .. look->n - 1));
    assigns *seen; */
void kelly_rare_see(const kelly_rare *look, kelly_rare_seen *seen);
/*@ requires \valid_read(rare) && rare->level < KELLY_RARE_LEVELS && \valid(out);
    assigns *out; */
void kelly_rare_read(const kelly_rare *rare, kelly_rare_estimate *out);
/*@ requires sized(rare) && held(rare) && \valid_read(hint) && \valid_read(hint->run) && \valid(most);
    requires rare->finds >= 1 && \exists integer j; 0 <= j < rare->n && rare->samples[j].guide >= KELLY_RARE_FAILED;
    assigns *most;
    ensures 0 <= \result <= 1; */
static wide share_seen(const kelly_rare *rare, const kelly_rare_hint *hint, unsigned mode, wide *most);
#endif
