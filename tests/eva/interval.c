/* tally.h: intervals of any counts, even such as cannot be, with any tails; what Stirling's formula leaves of any size. */
#include "contracts.h"
#include "../../firmware/interval.c"

static kelly_tally tally;

uint32_t kelly_refused(const kelly_tally *of)
{
    (void)of;
    return any_u32();
}

int main(void)
{
    const wide tail = any_wide(0, 0.5);
    wide lo, hi, rest;

    rest = kelly_stirling(any_wide(WIDER(1e-300, 1e-30f), WIDER(1e300, 1e30f)));
    //@ assert -1e6 <= rest <= 1e6;
    lo = kelly_binomial_lo(any_u32(), Frama_C_unsigned_int_interval(1, UINT32_MAX), tail);
    //@ assert 0 <= lo <= 1;
    hi = kelly_binomial_hi(any_u32(), Frama_C_unsigned_int_interval(1, UINT32_MAX), tail);
    //@ assert 0 <= hi <= 1;
    (void)kelly_binomial_lo(0, 0, tail);
    (void)kelly_binomial_hi(0, 0, tail);
    tally.stuck = any_u32();
    tally.samples = Frama_C_unsigned_int_interval(1, UINT32_MAX);
    kelly_interval(&tally, &lo, &hi);
    return 0;
}
