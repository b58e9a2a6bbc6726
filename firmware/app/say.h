/* say.h - text for people, through out.h. */
#ifndef KELLY_SAY_H
#define KELLY_SAY_H

#include "../real.h"

void say_text(const char *text);
void say_decimal(uint32_t value);
void say_hex(uint32_t value);

/* Fixed point with `digits` decimals, rounded to nearest; up to 7, and numbers up to 1e31: beyond 2^31 / 10^digits it stays there. */
void say_fixed(wide value, unsigned digits);

/* A name and a number behind it. */
void say_number(const char *name, uint32_t value);
void say_value(const char *name, wide value, unsigned digits);

#endif
