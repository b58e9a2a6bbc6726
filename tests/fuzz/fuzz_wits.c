/* fuzz_wits.c - WITS frames for rig displays (firmware/link/wits.c): whatever the numbers are, the frame is one that a strict reader takes.
 *
 * The input is a kelly_wits as it lies in memory, a word for the room, and the rest. Finite where known, as the header asks; the reader
 * here is written from the format. The reader of tests/wits.py is tried with damaged frames by fuzz_text.py.
 */
#include <stdlib.h>
#include <string.h>

#include "../../firmware/link/wits.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static void must(int holds)
{
    if (!holds) {
        abort();
    }
}

/* A number: digits, one minus before it, one point in it; -> what follows. */
static const char *number(const char *text)
{
    unsigned digits = 0, points = 0;

    text += *text == '-';
    for (; *text != '\r'; text++) {
        points += *text == '.';
        digits += *text != '.';
        must(*text == '.' ? digits > 0 && points == 1 : *text >= '0' && *text <= '9');
    }
    must(digits > 0 && text[-1] != '.');
    return text;
}

static void read_frame(const char *text)
{
    unsigned last = 0;

    must(strncmp(text, "&&\r\n", 4) == 0);
    for (text += 4; *text != '!';) {
        unsigned item = 0;

        for (unsigned k = 0; k < 4; k++, text++) {
            must(*text >= '0' && *text <= '9');
            item = 10 * item + (unsigned)(*text - '0');
        }
        must(item > last);
        last = item;
        text = number(text);
        must(text[0] == '\r' && text[1] == '\n');
        text += 2;
    }
    must(strcmp(text, "!!\r\n") == 0 && last == 927);
}

static void tame(real *x, unsigned count)
{
    for (unsigned k = 0; k < count; k++) {
        x[k] = x[k] - x[k] == 0 ? x[k] : 0;
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    kelly_wits values;
    uint16_t room = KELLY_WITS_TEXT + 1;
    char *text;
    size_t length;

    memset(&values, 0, sizeof(values));
    memcpy(&values, data, size < sizeof(values) ? size : sizeof(values));
    if (size >= sizeof(values) + sizeof(room)) {
        memcpy(&room, data + sizeof(values), sizeof(room));
        room = (uint16_t)(room % (KELLY_WITS_TEXT + 2u));
    }
    tame(&values.depth, (unsigned)((offsetof(kelly_wits, samples) - offsetof(kelly_wits, depth)) / sizeof(real)));
    text = malloc(room > 0 ? room : 1u);
    must(text != 0);
    length = kelly_wits_frame(text, room, &values);
    must(length > 0 || room <= KELLY_WITS_TEXT);
    if (length > 0) {
        must(length < room && strlen(text) == length);
        read_frame(text);
    }
    free(text);
    return 0;
}
