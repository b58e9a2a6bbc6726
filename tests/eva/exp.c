/* kelly_exp of every finite number, in slices: the remainder is small because x and its power belong together. */
#include "detmath.h"

int main(void)
{
    const double log2 = 0.6931471805599453;
    double y = kelly_exp(any_wide(-ANY_WIDE, -708));

    //@ assert 0 <= y <= 4;
    //@ loop unroll 2100;
    for (int k = -2043; k < 0; k++) {
        y = kelly_exp(any_wide(k * (log2 / 2), (k + 1) * (log2 / 2)));
        //@ assert 0 <= y <= 4;
    }
    //@ loop unroll 230;
    for (int k = 0; k < 223; k++) {
        y = kelly_exp(any_wide(k * (log2 / 2), (k + 1) * (log2 / 2)));
        //@ assert 0.0625 <= y <= 1e45;
    }
    //@ loop unroll 2000;
    for (int k = 223; k < 2000; k++) {
        y = kelly_exp(any_wide(k * (log2 / 2), (k + 1) * (log2 / 2)));
        //@ assert 0.0625 <= y <= MOST_EXP;
    }
    //@ loop unroll 130;
    for (int k = 4000; k < 4088; k++) {
        y = kelly_exp(any_wide(k * (log2 / 4), (k + 1) * (log2 / 4)));
        //@ assert 0.0625 <= y <= MOST_EXP;
    }
    y = kelly_exp(any_wide(708, ANY_WIDE));
    //@ assert 0.0625 <= y <= MOST_EXP;
    return 0;
}
