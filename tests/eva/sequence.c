/* sequence.h: any counts, even such as cannot be, any alpha in 0 .. 1, any rule. */
#define EVA_LOG32
#include "sequence.h"
#include "contracts.h"

static kelly_tally tally;

uint32_t kelly_refused(const kelly_tally *of)
{
    (void)of;
    return any_u32();
}

int main(void)
{
    kelly_stop_rule rule;
    const float alpha = Frama_C_float_interval(0x1p-126f, 1 - 0x1p-24f);
    float lo, hi;

    lo = kelly_sequence_lo(any_u32(), Frama_C_unsigned_int_interval(1, UINT32_MAX), alpha);
    //@ assert 0 <= lo < 1;
    hi = kelly_sequence_hi(any_u32(), Frama_C_unsigned_int_interval(1, UINT32_MAX), alpha);
    //@ assert 0 < hi <= 1;
    (void)kelly_sequence_lo(0, 0, alpha);
    (void)kelly_sequence_hi(0, 0, alpha);
    rule.alpha = alpha;
    rule.width = Frama_C_float_interval(-ANY_FLOAT, ANY_FLOAT);
    rule.level = Frama_C_float_interval(-ANY_FLOAT, ANY_FLOAT);
    tally.stuck = any_u32();
    tally.samples = Frama_C_unsigned_int_interval(1, UINT32_MAX);
    (void)kelly_sequence_look(&rule, &tally, &lo, &hi);
    return 0;
}
