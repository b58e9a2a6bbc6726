/* severity.h - what counts as stick-slip.
 *
 * paper  ss = (max - min) / (max + min) of the bit speed over the window; stick-slip where ss > limit (0.8).
 *        A bit that turns backwards as far as forwards (max + min <= 0) has no such ratio: ss is set to 10 and counts.
 * field  SSI = (max - min) / (2 mean), what rig displays call the stick-slip index.
 */
#ifndef KELLY_SEVERITY_H
#define KELLY_SEVERITY_H

#include "real.h"

#define KELLY_SS_NONE R(10.0)   /* ss where max + min <= 0 */
#define KELLY_NO_SPEED R(1e-20) /* nothing beside a speed, in any unit; a quotient by more is finite */

/* Severity of the paper from the extremes of the bit speed, any unit, |speed| <= 1e8. */
static inline real kelly_severity(real lowest, real highest)
{
    const real sum = highest + lowest;

    return sum > KELLY_NO_SPEED ? (highest - lowest) / sum : KELLY_SS_NONE;
}

/* Field index from the extremes and the mean, any unit, |speed| <= 1e6, as a ratio (1 = 100 %). 0 where the mean is not positive. */
static inline real kelly_ssi(real lowest, real highest, real mean)
{
    return mean > KELLY_NO_SPEED ? (highest - lowest) / (2 * mean) : 0;
}

#endif
