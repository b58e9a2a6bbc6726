/* wits.h - one WITS level 0 frame, as rig displays read it: `&&`, a line RRIIvalue for each item (record, item, no separator), `!!`,
 * each ended by CR LF; ASCII, no checksum, 1 Hz.
 *
 *   0105 date YYMMDD   0106 time HHMMSS   0107 activity   0108 bit depth [m]   0113 ROP: always null
 *   0116 0117 surface WOB, mean and largest [kdaN, 1 is 10 kN]   0118 0119 surface torque, mean and largest [kN m]
 *   0120 surface speed [rpm, whole]   0915 0916 downhole WOB [kdaN]   0917 0918 downhole torque [kN m], mean and largest
 *   spare items, since none exists for these: 0921 bit speed, lowest [rpm]   0922 highest   0923 mean   0924 severity ss
 *   0925 stick-slip index (highest - lowest) / (2 mean) [%]   0926 P(stick-slip)   0927 realisations behind it
 *
 * Null is -9999: what is not known, and what its column could not hold. ROP is null because the model has none: its axial speed
 * is vibration about a string that is fed as fast as the rock gives way, and a display would take it for progress.
 * The same text on every machine: fixed point by integers.
 */
#ifndef KELLY_WITS_H
#define KELLY_WITS_H

#include "../real.h"

#define KELLY_WITS_TEXT 360              /* longest frame, without the 00 behind it [characters] */

enum {                                   /* what is known */
    KELLY_WITS_CLOCK = 1,                /* date, time */
    KELLY_WITS_DEPTH = 2,                /* depth */
    KELLY_WITS_SURFACE = 4,              /* wob_..., torque_..., top_speed */
    KELLY_WITS_BIT = 8,                  /* bit_...; ss */
    KELLY_WITS_STUDY = 16                /* probability, samples */
};

/* SI; weights and torques positive while drilling. Where known within 1e30, speeds within 1e6. */
typedef struct {
    uint32_t known;                      /* sum of the above; the other fields do not matter */
    uint32_t activity;                   /* WITS code: 2 drilling, 0 none */
    uint32_t date, time;                 /* as written: 260131 is 31 January 2026, 235959 */
    real depth;                          /* of the bit [m] */
    real wob_mean, wob_max;              /* at the surface [N] */
    real torque_mean, torque_max;        /* at the surface [N m] */
    real top_speed;                      /* [rad/s] */
    real bit_wob_mean, bit_wob_max;      /* [N] */
    real bit_torque_mean, bit_torque_max;   /* [N m] */
    real bit_lowest, bit_highest, bit_mean;   /* speed [rad/s] */
    real ss;                             /* severity */
    real probability;                    /* of stick-slip */
    uint32_t samples;
} kelly_wits;

/* -> characters written, a 00 behind them; 0, and an empty text, if room is too small. KELLY_WITS_TEXT + 1 is always enough. */
size_t kelly_wits_frame(char *text, size_t room, const kelly_wits *values);

#endif
