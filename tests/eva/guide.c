/* The string as rare.h sees it: any weight, any draw in range (string_model.h) at speeds of 0.01 rad/s and more, any x; as slices of the speed
 * and of a2, as the slope of the rock has a maximum between. Stubs: the laws (random.c). */
#define EVA_LOG32
#include "rare.h"
#include "contracts.h"

#define X 3e3f                           /* as far as a move tries: walk.c */
#define SLOWEST 1e-2f
#ifndef MODES
#define MODES 20                         /* all of the committed table */
#endif
#define SPEEDS 10u                       /* slices, each to 4 times its least */
#define LEAST_A2 1e-4f
#define A2S 10u                          /* to 16 times */

static kelly_case run;
static kelly_rare_hint hint = { .table = &kelly_string, .run = &run };
static kelly_draw low, high;             /* of the draws */

static float between(real least, real most) { return Frama_C_float_interval((float)least, (float)most); }

/* random.c; which parameter it is asked for says the mean */
float kelly_gamma_value(float x, float mean, float cov)
{
    //@ assert -X <= x <= X;
    //@ assert 0 < mean <= 1e30;
    //@ assert 1e-4f <= cov <= 0.5;
    return mean == 1 ? between(low.fc, high.fc) : mean == 2 ? between(low.mu, high.mu) : mean == 3 ? between(low.a1, high.a1)
         : mean == 4 ? between(low.a2, high.a2) : between(low.w0, high.w0);
}

float kelly_gamma_log_weight(float x, float cov)
{
    //@ assert -X <= x <= X;
    //@ assert 1e-4f <= cov <= 0.5;
    return Frama_C_float_interval(KELLY_NO_WEIGHT, 1e16f);
}

static void any_draws(unsigned speed, unsigned a2)
{
    low = (kelly_draw){ .fc = R(1e-30), .mu = R(1e-30), .a1 = R(1e-30), .a2 = LEAST_A2, .w0 = SLOWEST };
    //@ loop unroll 10;
    for (unsigned k = 0; k < speed; k++) {
        low.w0 *= 4;
    }
    //@ loop unroll 10;
    for (unsigned k = 0; k < a2; k++) {
        low.a2 *= 16;
    }
    high = (kelly_draw){ .fc = R(1e9), .mu = R(1800.0), .a1 = R(1000.0), .a2 = 16 * low.a2, .w0 = 4 * low.w0 };
}

/* Nothing random, or everything. */
static void any_case(int random)
{
    run.fc = random ? 1 : any_real(low.fc, high.fc);
    run.mu = random ? 2 : any_real(low.mu, high.mu);
    run.a1 = random ? 3 : any_real(low.a1, high.a1);
    run.a2 = random ? 4 : any_real(low.a2, high.a2);
    run.w0 = random ? 5 : any_real(low.w0, high.w0);
    run.f0 = any_real(0, R(1e9));
    for (unsigned k = 0; k < KELLY_PARAMETERS; k++) {
        run.cov[k] = random ? Frama_C_float_interval(1e-4f, 0.5f) : Frama_C_float_interval(0, 0x1.a36e2cp-14f);
    }
    run.limit = any_real(0, R(10.0));
    run.step_ns = Frama_C_unsigned_int_interval(1000, 1000000000);
    run.window_first = Frama_C_unsigned_int_interval(0, UINT32_MAX - 1);
    run.torsional = MODES;
    run.rotating = Frama_C_unsigned_char_interval(0, 1);
}

static void any_x(float x[KELLY_PARAMETERS])
{
    for (unsigned k = 0; k < KELLY_PARAMETERS; k++) {
        x[k] = Frama_C_float_interval(-X, X);
    }
}

static void hints(void)
{
    float x[KELLY_PARAMETERS], hinted;

    any_x(x);
    hint.plane = 0;
    hinted = kelly_rare_guess(&hint, x);
    //@ assert -1e6 <= hinted <= 1e6;
    //@ loop unroll 20;
    for (unsigned mode = 0; mode < MODES; mode++) {
        hinted = kelly_rare_resonance(&hint, x, mode);
        //@ assert 0 <= hinted <= 1e38;
    }
    hinted = kelly_rare_own(&hint);
    //@ assert 0 <= hinted <= 1e38;
}

static void guides(void)
{
    const kelly_result result = { .status = (kelly_status)Frama_C_unsigned_int_interval(0, KELLY_STATUSES - 1), .ss = any_real(0, R(10.0)),
                                  .draw = { any_real(low.fc, high.fc), any_real(low.mu, high.mu), any_real(low.a1, high.a1),
                                            any_real(low.a2, high.a2), any_real(low.w0, high.w0) } };
    const float guide = kelly_rare_guide(&kelly_string, &run, &result);

    //@ assert guide == KELLY_RARE_REFUSED || 0 <= guide <= KELLY_RARE_FAILED;
}

static void plane(void)
{
    float x[KELLY_PARAMETERS], plane[KELLY_PARAMETERS];

    any_x(x);
    for (unsigned k = 0; k < KELLY_PARAMETERS; k++) {
        plane[k] = Frama_C_float_interval(-60.0f, 60.0f);
    }
    hint.plane = plane;
    (void)kelly_rare_guess(&hint, x);
}

int main(void)
{
    //@ loop unroll 10;
    for (unsigned speed = 0; speed < SPEEDS; speed++) {
        //@ loop unroll 10;
        for (unsigned a2 = 0; a2 < A2S; a2++) {
            any_draws(speed, a2);
            any_case(0);
            hints();
            guides();
            any_case(1);
            hints();
        }
    }
    plane();
    return 0;
}
