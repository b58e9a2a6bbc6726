/* scpi.h with the console's patterns, line.h with keys of 1 to 7 characters: any text of up to 79 bytes and its final 0, at latest where
 * the array ends. A text that begins further on in the array is a shorter one. */
#include "board.h"
#include "contracts.h"
#include "../../firmware/app/console.c"

static char line[LINE_MAX];

static void any_line(void)
{
    ANY(line);
    line[LINE_MAX - 1] = '\0';
}

static void number(void)
{
    real value;
    int error;

    any_line();
    error = scpi_number(line, &value);
    //@ assert error == SCPI_NO_ERROR || error == SCPI_MISSING || error == SCPI_BAD_NUMBER;
    if (error == SCPI_NO_ERROR) {
        //@ assert -1000000000 <= value <= 1000000000;
    }
}

static void is(const char *pattern)
{
    const char *rest = line;

    any_line();
    (void)scpi_is(line, pattern, &rest);      /* which stays what it was, or becomes a place in the text */
    //@ assert \subset(rest, line + (0 .. LINE_MAX - 1));
}

static void headers(void)
{
    //@ loop unroll 16;
    for (int which = 0; which < COMMANDS; which++) {
        is(patterns[which]);
    }
    is("ON");
    is("OFF");
    is("1");
    is("0");
    (void)scpi_error_text(Frama_C_interval(INT32_MIN, INT32_MAX));
}

#define KEY_MAX 8

/* A key of this length. */
static void any_key(char key[KEY_MAX + 1], unsigned length)
{
    for (unsigned k = 0; k < length; k++) {
        key[k] = Frama_C_char_interval('!', '~');
    }
    key[length] = '\0';
}

static void values(unsigned length)
{
    static char key[KEY_MAX + 1], other[KEY_MAX + 1];
    const line_key keys[2] = { { key, any_u32(), any_u32() }, { other, any_u32(), any_u32() } };
    uint64_t numbers[2];

    any_key(key, length);
    any_key(other, KEY_MAX - length);
    any_line();
    (void)line_read(line, keys, numbers, 2);
}

int main(void)
{
    number();
    headers();
    (void)line_ask(line);
    //@ loop unroll 7;
    for (unsigned length = 1; length < KEY_MAX; length++) {
        values(length);
    }
    return 0;
}
