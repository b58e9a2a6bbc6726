/* scpi.h - one line of a console in the style of SCPI (IEEE 488.2): `SYSTem:ERRor?`, `RPM 100`. */
#ifndef KELLY_SCPI_H
#define KELLY_SCPI_H

#include "../real.h"

/* Error numbers of SCPI-1999. */
enum {
    SCPI_NO_ERROR = 0,
    SCPI_NOT_ALLOWED = -108,     /* a parameter too many */
    SCPI_MISSING = -109,
    SCPI_UNDEFINED = -113,
    SCPI_BAD_NUMBER = -121,
    SCPI_CONFLICT = -221,
    SCPI_RANGE = -222,
    SCPI_QUEUE = -350
};

/* What SCPI calls it. */
const char *scpi_error_text(int error);

/* Whether the line's header, up to a space, is `pattern`: any case, each node in its short form, which the pattern writes in
 * capitals, or in full. *rest: what follows, spaces left out. */
int scpi_is(const char *line, const char *pattern, const char **rest);

/* One decimal number, `100`, `-2.5`, `.004`, at most nine digits, and nothing behind it. SCPI_NO_ERROR, or what is wrong. */
int scpi_number(const char *text, real *value);

#endif
