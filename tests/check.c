/* check.c - see check.h. */
#include "check.h"

unsigned check_passed, check_failed;

void check_text(const char *text)
{
    while (*text) check_put(*text++);
}

void check_hex(uint64_t value, int digits)
{
    while (digits-- > 0) check_put("0123456789abcdef"[(value >> (4 * digits)) & 15]);
}

static void put_unsigned(uint64_t value)
{
    char digits[20];
    int n = 0;
    do {
        digits[n++] = (char)('0' + value % 10);
        value /= 10;
    } while (value);
    while (n) check_put(digits[--n]);
}

void check_decimal(int64_t value)
{
    if (value < 0) check_put('-');
    put_unsigned(value < 0 ? 0 - (uint64_t)value : (uint64_t)value);
}

void check_number(wide value)
{
    if (value != value) {
        check_text("nan");
        return;
    }
    if (value < W(0.0)) check_put('-');
    wide size = value < W(0.0) ? -value : value;
    int exponent = 0;
    for (; size >= W(10.0) && exponent < 400; exponent++) size /= W(10.0);
    for (; size < W(1.0) && size > W(0.0) && exponent > -400; exponent--) size *= W(10.0);
    if (exponent == 400) {
        check_text("inf");
        return;
    }
    for (int i = 0; i < 9; i++) {
        const int digit = (int)size;
        check_put((char)('0' + digit));
        if (i == 0) check_put('.');
        size = (size - (wide)digit) * W(10.0);
    }
    check_put('e');
    check_decimal(exponent);
}

static int count(int holds, const char *file, int line, const char *claim)
{
    if (holds) {
        check_passed++;
        return 1;
    }
    check_failed++;
    check_text("FAIL ");
    check_text(file);
    check_put(':');
    check_decimal(line);
    check_text(": ");
    check_text(claim);
#ifdef CHECK_STOP
    __builtin_trap();             /* for whoever asks only whether anything fails: tests/mutate.py */
#endif
    return 0;
}

void check_claim(int holds, const char *file, int line, const char *claim)
{
    if (!count(holds, file, line, claim)) check_put('\n');
}

void check_close(wide got, wide want, wide within, const char *file, int line, const char *claim)
{
    const wide away = got < want ? want - got : got - want;
    if (count(away <= within, file, line, claim)) return;        /* a NaN is never close */
    check_text(" is ");
    check_number(got);
    check_text(", should be ");
    check_number(want);
    check_text(" within ");
    check_number(within);
    check_put('\n');
}

static void put_both(uint64_t value)
{
    put_unsigned(value);
    check_text(" (0x");
    check_hex(value, value >> 32 ? 16 : 8);
    check_put(')');
}

void check_equal(uint64_t got, uint64_t want, const char *file, int line, const char *claim)
{
    if (count(got == want, file, line, claim)) return;
    check_text(" is ");
    put_both(got);
    check_text(", should be ");
    put_both(want);
    check_put('\n');
}
