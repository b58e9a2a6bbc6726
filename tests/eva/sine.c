/* kelly_sin_turn of every phase, in slices by the distance from the nearest quarter turn. */
#include "detmath.h"

int main(void)
{
    real s;

    //@ loop unroll 4;
    for (unsigned quarter = 0; quarter < 4; quarter++) {
        const uint64_t from = (uint64_t)quarter << 62;

        s = kelly_sin_turn(from);
        //@ assert -1.01 <= s <= 1.01;
        //@ assert quarter == 1 ==> s >= 0.09;
        s = kelly_sin_turn(from + ((uint64_t)1 << 61));
        //@ assert -1.01 <= s <= 1.01;
        //@ assert quarter == 1 ==> s >= 0.09;
        //@ loop unroll 62;
        for (unsigned k = 0; k < 61; k++) {
            const uint64_t low = (uint64_t)1 << k;

            s = kelly_sin_turn(from + Frama_C_unsigned_long_long_interval(low, 2 * low - 1));
            //@ assert -1.01 <= s <= 1.01;
            //@ assert quarter == 1 ==> s >= 0.09;
            s = kelly_sin_turn(from - Frama_C_unsigned_long_long_interval(low, 2 * low - 1));
            //@ assert -1.01 <= s <= 1.01;
            //@ assert quarter == 2 && k >= 58 ==> s >= 0.09;
        }
    }
    return 0;
}
