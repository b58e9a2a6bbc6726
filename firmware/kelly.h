/* kelly.h - how likely is this drill string to stick and slip?
 *
 * The kernel in the order in which data flows. Include this; every header below says shapes, units, ranges, errors, cost.
 *
 *   string_model.h   what the generator left: the string, its modes as functions of the weight on bit
 *   random.h         streams keyed by (seed, index, parameter)
 *   realisation.h    one draw of the random parameters, and whether the step can be trusted with it
 *   bitrock.h        torque of the rock on the bit                                        (B)
 *   integrator.h     RK4 of torsion over lanes of realisations                            (T), (W), (F)
 *   drive.h          the same under a soft drive, or a commanded top                      (S), (D)
 *   axial.h          axial response                                                       (A)
 *   severity.h       what counts as stick-slip
 *   ensemble.h       draw, integrate, classify a range of indices
 *   tally.h          counts, digest, interval
 *   sequence.h       an interval that holds at every n, and when to stop
 *   rare.h           small probabilities by subset simulation
 *   envelope.h       mean, spread and quantiles of a stream of values, in fixed memory
 *   sobol.h          which parameter the answer depends on
 *   reweight.h       the probability under other laws, from realisations that have been run
 *   plant.h          one string, everything that a bench reads                            (S)
 *
 * Units    SI, angles in rad. Angular speed of the bit and the top positive while drilling; f_bit and T_bit negative.
 * Memory   none is allocated. Every struct is the caller's; fields are not to be written except those of kelly_case.
 * Threads  no mutable global: any number of callers, each with its own structs.
 * Time     one step of one realisation costs about 300 operations and 4 divisions with ten modes (double: 470), 850 with a top of variable speed.
 * Bits     realisation j of seed s is the same on every machine, at every lane count, cut in any way.
 * Errors   checks are done once, by kelly_table_error and kelly_case_error; what comes after cannot fail, and a
 *          realisation that cannot be trusted carries a status and is never counted.
 */
#ifndef KELLY_H
#define KELLY_H

#include "axial.h"
#include "bitrock.h"
#include "drive.h"
#include "ensemble.h"
#include "envelope.h"
#include "integrator.h"
#include "plant.h"
#include "random.h"
#include "rare.h"
#include "realisation.h"
#include "reweight.h"
#include "sequence.h"
#include "severity.h"
#include "sobol.h"
#include "string_model.h"
#include "tally.h"

#define KELLY_VERSION "1.0.0"

#endif
