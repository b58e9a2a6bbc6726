/* drive.c - the drive at the top as the command line and the results name it: "stiff" or "soft:Z=289,f=0.2,J=2900". */
#include <stdlib.h>
#include <string.h>

#include "host.h"

#define RIGHT "stiff, or soft with some of Z=..,f=..,J=.. behind a colon: soft:Z=289,f=0.2,J=2900"
#define PIPE_IMPEDANCE 289.0     /* of the paper's pipe [N m s/rad], where the table does not say */
#define RETURN_HZ 0.2
#define ROTOR_INERTIA 2900.0     /* [kg m2] */

static double value_of(const char *text, const char *part, double lo, double hi, const char *right)
{
    char option[96];

    if (*part == '\0') {
        die(EXIT_USAGE, "--drive %s: %c= has no number; give %s", text, part[-2], right);
    }
    snprintf(option, sizeof(option), "--drive %.60s:", text);
    return option_number(option, part, lo, hi, right);
}

/* One of Z=, f=, J=; its bit in `seen`. */
static unsigned take_part(kelly_drive *drive, const char *text, const char *part)
{
    if (strncmp(part, "Z=", 2) == 0) {
        drive->impedance = (real)value_of(text, part + 2, 1e-3, 1e9, "an impedance in N m s/rad, 0.001..1e9, e.g. Z=289");
        return 1;
    }
    if (strncmp(part, "f=", 2) == 0) {
        drive->hz = (real)value_of(text, part + 2, 1e-4, 100.0, "a frequency in Hz, 0.0001..100, e.g. f=0.2");
        return 2;
    }
    if (strncmp(part, "J=", 2) == 0) {
        drive->inertia = (real)value_of(text, part + 2, 1.0, 1e9, "an inertia in kg m2, 1..1e9, e.g. J=2900");
        return 4;
    }
    die(EXIT_USAGE, "--drive %s: '%s' is not known; give " RIGHT, text, part);
}

static kelly_drive soft_drive(void)
{
    const double impedance = (double)kelly_string.impedance;

    return (kelly_drive){ .inertia = (real)ROTOR_INERTIA, .impedance = (real)(impedance > 0 ? impedance : PIPE_IMPEDANCE), .hz = (real)RETURN_HZ };
}

void option_drive(kelly_drive *drive, const char *text)
{
    char copy[128], *rest = copy;
    unsigned seen = 0;

    if (strcmp(text, "stiff") == 0) {
        *drive = (kelly_drive){ .inertia = 0 };
        return;
    }
    if (strncmp(text, "soft", 4) != 0 || (text[4] != '\0' && text[4] != ':') || strlen(text) >= sizeof(copy)) {
        die(EXIT_USAGE, "--drive %s: not a drive; give " RIGHT, text);
    }
    *drive = soft_drive();
    if (text[4] == '\0') {
        return;
    }
    strcpy(copy, text + 5);
    while (rest) {
        const unsigned part = take_part(drive, text, strsep(&rest, ","));

        if (seen & part) {
            die(EXIT_USAGE, "--drive %s: the same value stands twice; give each once", text);
        }
        seen |= part;
    }
}

/* A short decimal that comes back as the same real. */
static void shortest(real x, char text[32])
{
    for (int digits = 6; digits <= 17; digits++) {
        snprintf(text, 32, "%.*g", digits, (double)x);
        if ((real)strtod(text, 0) == x) {
            return;
        }
    }
}

const char *drive_text(const kelly_drive *drive, char text[DRIVE_TEXT])
{
    char impedance[32], hz[32], inertia[32];

    if (drive->inertia > 0) {
        shortest(drive->impedance, impedance);
        shortest(drive->hz, hz);
        shortest(drive->inertia, inertia);
        snprintf(text, DRIVE_TEXT, "soft:Z=%.28s,f=%.28s,J=%.28s", impedance, hz, inertia);
    } else {
        snprintf(text, DRIVE_TEXT, "stiff");
    }
    return text;
}

const char *drive_remark(const kelly_drive *drive, char text[DRIVE_TEXT])
{
    text[0] = '\0';
    if (drive->inertia > 0) {
        snprintf(text, DRIVE_TEXT, ", drive soft:Z=%.6g,f=%.6g,J=%.6g", (double)drive->impedance, (double)drive->hz, (double)drive->inertia);
    }
    return text;
}
