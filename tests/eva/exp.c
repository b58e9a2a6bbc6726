/* kelly_exp of every finite number, in slices of a quarter power of 2: the remainder is small because x and its power belong together. */
#include "detmath.h"

int main(void)
{
    const double quarter = 0.17328679513998632;
    double y = kelly_exp(Frama_C_double_interval(-ANY_DOUBLE, -708));

    //@ assert 0 <= y <= 3.1e307;
    //@ loop unroll 8200;
    for (int k = -4088; k < 4088; k++) {
        y = kelly_exp(Frama_C_double_interval(k * quarter, (k + 1) * quarter));
        //@ assert 0 <= y <= 3.1e307;
    }
    y = kelly_exp(Frama_C_double_interval(708, ANY_DOUBLE));
    //@ assert 0 <= y <= 3.1e307;
    return 0;
}
