/* console.h - the board from a plain terminal: lines in the style of SCPI, ended by CR or LF, any case, short or long forms.
 *
 *   *IDN?                    who is there
 *   *RST                     idle, the well file's case, WITS off
 *   *CLS                     forget the errors
 *   SYSTem:ERRor?            the oldest error: 0,"No error" where there is none; nothing else is ever printed about errors
 *   RPM n   RPM?             top speed [rpm], 0.01..10000; while the string runs it gets there within a second
 *   WOB n   WOB?             weight on bit [kN]; at once
 *   MU n    MU?              bit-rock factor [m], 0.000001..1000, for the next start
 *   STARt   STOP             the string of this case in real time
 *   READ?                    time_s,bit_rpm,top_rpm,surface_torque_kNm,bit_torque_kNm,wob_kN
 *   STATus?                  late steps, worst lateness [us], load [%]
 *   WITS?   WITS ON|OFF      one frame for a rig display; one a second from now on
 *
 * What a host has started over the link is not changed from here: -221. STOP ends anything.
 */
#ifndef KELLY_CONSOLE_H
#define KELLY_CONSOLE_H

#include "../real.h"

#define CONSOLE_ERRORS 4u

typedef struct kelly_bench kelly_bench;

typedef struct {
    int16_t errors[CONSOLE_ERRORS];
    uint8_t first, count;        /* of the errors that wait */
    uint8_t wits;                /* 1: on */
    uint32_t wits_tick;          /* of the last frame */
} kelly_console;

/* Carry out one line. */
void console_line(kelly_bench *bench, const char *line);

/* Whatever is due. */
void console_tick(kelly_bench *bench);

#endif
