/* estimate.h - the paper's estimation on the board, as one line of text asks for it:
 *
 *   seed=1 first=0 samples=4     realisations first .. first + samples - 1 of seed, at most a million, up to 4294967295
 *   mu_e6=40000                  bit-rock factor in millionths, up to 10^9
 *   seconds=100 from=50          duration and start of the window, which lasts to the end (without: the well file's); at most 4e9 steps.
 *                                Of the seconds alone the window is the last half
 *   digest=1                     the case of `make digest`: mu 0.04, every law at 0.2
 *   count=1                      instructions a step, exact in an emulator (board.h), and nothing else
 *
 * Each at most once; a number beyond its range and a line that was cut are not understood. An empty line runs the well file's
 * case. Prints each realisation, P with its interval, the stack's high-water mark and
 * the digest, which is that of `kelly montecarlo` of the same case.
 */
#ifndef KELLY_ESTIMATE_H
#define KELLY_ESTIMATE_H

#include "../kelly.h"

/* -> the exit status: 0 done, 1 a case that cannot be run, 2 a line that is not understood. */
int estimate(const char *line, kelly_work *work);

#endif
