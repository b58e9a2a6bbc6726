/* test_severity.c - ss of a window and the field index. */
#include "../firmware/severity.h"
#include "check.h"

void test_severity(void);
void test_severity(void)
{
    CHECK(kelly_severity(R(1.0), R(3.0)) == R(0.5));
    CHECK(kelly_severity(R(2.0), R(2.0)) == 0);              /* smooth drilling */
    CHECK(kelly_severity(R(0.0), R(7.0)) == R(1.0));         /* sticks just so */
    CHECK(kelly_severity(R(-1.0), R(3.0)) == R(2.0));        /* turns backwards: above 1 */
    CHECK(kelly_severity(R(-3.0), R(3.0)) == R(10.0));       /* max + min = 0 counts as stuck */
    CHECK(kelly_severity(R(-5.0), R(3.0)) == R(10.0));
    CHECK(kelly_severity(R(0.0), R(0.0)) == R(10.0));        /* stands still */
    CHECK(kelly_ssi(R(1.0), R(3.0), R(2.0)) == R(0.5));
    CHECK(kelly_ssi(R(-1.0), R(7.0), R(2.0)) == R(2.0));
    CHECK(kelly_ssi(R(-1.0), R(7.0), R(0.0)) == 0);
    CHECK(kelly_ssi(R(-9.0), R(7.0), R(-1.0)) == 0);
    CHECK(kelly_ssi(R(-1e3), R(1e3), R(1e-38)) == 0);        /* no infinity */
}
