/* kelly_exp of every finite number, in slices: the remainder is small because x and its power belong together. */
#include "detmath.h"

int main(void)
{
    const double log2 = 0.6931471805599453;
    double y = kelly_exp(Frama_C_double_interval(-ANY_DOUBLE, -708));

    //@ assert -1.2e308 <= y <= 1.2e308;
    //@ loop unroll 130;
    for (int k = -1024; k < 992; k += 16) {
        y = kelly_exp(Frama_C_double_interval(k * log2, (k + 16) * log2));
        //@ assert -1.2e308 <= y <= 1.2e308;
    }
    //@ loop unroll 130;
    for (int k = 3968; k < 4088; k++) {
        y = kelly_exp(Frama_C_double_interval(k * (log2 / 4), (k + 1) * (log2 / 4)));
        //@ assert -1.2e308 <= y <= 1.2e308;
    }
    y = kelly_exp(Frama_C_double_interval(708, ANY_DOUBLE));
    //@ assert -1.2e308 <= y <= 1.2e308;
    return 0;
}
