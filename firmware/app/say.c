#include "say.h"
#include "out.h"

void say_text(const char *text)
{
    while (*text != '\0') {
        out_byte((uint8_t)*text++);
    }
}

void say_decimal(uint32_t value)
{
    char digits[11] = { 0 };   /* 2^32 has ten digits */
    int at = 10;

    do {
        digits[--at] = (char)('0' + value % 10u);
        value /= 10u;
    } while (value != 0);
    say_text(digits + at);
}

void say_hex(uint32_t value)
{
    for (int shift = 28; shift >= 0; shift -= 4) {
        out_byte((uint8_t)"0123456789abcdef"[(value >> shift) & 15u]);
    }
}

void say_fixed(wide value, unsigned digits)
{
    uint32_t scale = 1, scaled;

    for (unsigned k = 0; k < digits; k++) {
        scale *= 10u;
    }
    if (value < 0) {
        say_text("-");
        value = -value;
    }
    value = value * (wide)scale + W(0.5);
    scaled = value < W(2147483520.0) ? (uint32_t)(int32_t)value : 2147483520u;   /* the largest float below 2^31 */
    say_decimal(scaled / scale);
    if (digits > 0) {
        say_text(".");
    }
    for (uint32_t digit = scale / 10u; digit > 0; digit /= 10u) {
        say_decimal(scaled / digit % 10u);
    }
}

void say_number(const char *name, uint32_t value)
{
    say_text(name);
    say_decimal(value);
}

void say_value(const char *name, wide value, unsigned digits)
{
    say_text(name);
    say_fixed(value, digits);
}
