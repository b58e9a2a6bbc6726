#include "wits.h"
#include "../severity.h"

#define TO_RPM R(9.54929658551372)
#define TO_KDAN R(1e-4)
#define TO_KNM R(1e-3)

#define REACH R(1e8)                     /* of what is written, its point left out: ten characters with sign and point */
#define ITEM_MAX 16                      /* RRII, ten characters, CR LF */
#define ITEMS 21

_Static_assert(ITEMS * ITEM_MAX + 8 <= KELLY_WITS_TEXT, "every frame fits");

typedef struct {
    char *text;
    size_t room, at;                     /* at: what would have been written; beyond room nothing is */
} writer;

static void put(writer *to, char c)
{
    if (to->at < to->room) {
        to->text[to->at] = c;
    }
    to->at++;
}

static void put_text(writer *to, const char *text)
{
    while (*text != '\0') {
        put(to, *text++);
    }
}

/* At least `least` digits. */
static void put_digits(writer *to, uint32_t value, unsigned least)
{
    char digits[10];
    unsigned n = 0;

    for (; value > 0 || n < least; value /= 10u) {
        digits[n++] = (char)('0' + value % 10u);
    }
    while (n > 0) {
        put(to, digits[--n]);
    }
}

static void begin(writer *to, unsigned item)
{
    put_digits(to, item, 4);
}

static void end(writer *to, int known)
{
    put_text(to, known ? "\r\n" : "-9999\r\n");
}

static void whole(writer *to, unsigned item, int known, uint32_t value, unsigned least)
{
    begin(to, item);
    if (known) {
        put_digits(to, value, least);
    }
    end(to, known);
}

/* Rounded to nearest; a value that rounds to 0 has no sign. */
static void fixed(writer *to, unsigned item, int known, real value, unsigned decimals)
{
    static const uint16_t scales[] = { 1, 10, 100, 1000, 10000 };
    const real scaled = KELLY_ABS(value) * (real)scales[decimals] + R(0.5);
    const int fits = known && scaled < REACH;    /* no NaN does */
    const uint32_t digits = fits ? (uint32_t)(int32_t)scaled : 0u;

    begin(to, item);
    if (fits) {
        put_text(to, value < R(0.0) && digits > 0 ? "-" : "");
        put_digits(to, digits / scales[decimals], 1);
        if (decimals > 0) {
            put(to, '.');
            put_digits(to, digits % scales[decimals], decimals);
        }
    }
    end(to, fits);
}

static void surface(writer *to, const kelly_wits *v)
{
    const int known = (v->known & KELLY_WITS_SURFACE) != 0;

    fixed(to, 116, known, v->wob_mean * TO_KDAN, 3);
    fixed(to, 117, known, v->wob_max * TO_KDAN, 3);
    fixed(to, 118, known, v->torque_mean * TO_KNM, 3);
    fixed(to, 119, known, v->torque_max * TO_KNM, 3);
    fixed(to, 120, known, v->top_speed * TO_RPM, 0);
}

static void downhole(writer *to, const kelly_wits *v)
{
    const int known = (v->known & KELLY_WITS_BIT) != 0, turns = known && v->bit_mean > R(0.0);

    fixed(to, 915, known, v->bit_wob_mean * TO_KDAN, 3);
    fixed(to, 916, known, v->bit_wob_max * TO_KDAN, 3);
    fixed(to, 917, known, v->bit_torque_mean * TO_KNM, 3);
    fixed(to, 918, known, v->bit_torque_max * TO_KNM, 3);
    fixed(to, 921, known, v->bit_lowest * TO_RPM, 2);
    fixed(to, 922, known, v->bit_highest * TO_RPM, 2);
    fixed(to, 923, known, v->bit_mean * TO_RPM, 2);
    fixed(to, 924, known, v->ss, 3);
    fixed(to, 925, turns, R(100.0) * kelly_ssi(v->bit_lowest, v->bit_highest, v->bit_mean), 1);
}

size_t kelly_wits_frame(char *text, size_t room, const kelly_wits *values)
{
    const int clock = (values->known & KELLY_WITS_CLOCK) != 0, study = (values->known & KELLY_WITS_STUDY) != 0;
    writer to = { text, room, 0 };

    put_text(&to, "&&\r\n");
    whole(&to, 105, clock && values->date <= 991231u, values->date, 6);
    whole(&to, 106, clock && values->time <= 235959u, values->time, 6);
    whole(&to, 107, values->activity <= 99u, values->activity, 1);
    fixed(&to, 108, (values->known & KELLY_WITS_DEPTH) != 0, values->depth, 2);
    whole(&to, 113, 0, 0, 1);
    surface(&to, values);
    downhole(&to, values);
    fixed(&to, 926, study, values->probability, 4);
    whole(&to, 927, study, values->samples, 1);
    put_text(&to, "!!\r\n");
    put(&to, '\0');
    if (to.at > room) {
        if (room > 0) {
            text[0] = '\0';
        }
        return 0;
    }
    return to.at - 1;
}
