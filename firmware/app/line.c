#include "line.h"
#include "../board/board.h"

int line_ask(char line[LINE_MAX])
{
    uint32_t start = board_ticks();
    int length = 0;

    board_text("?\n");
    while (board_ticks() - start < LINE_WAIT_MS) {
        int byte = board_read();

        if (byte == '\n' || byte == '\r') {
            line[length] = '\0';
            return length;
        }
        if (byte < 0) {
            board_idle();
        } else if (length < LINE_MAX - 1) {
            line[length++] = (char)byte;
        }
    }
    line[0] = '\0';
    return -1;
}

/* Whether a word of the line begins here. */
static int begins(const char *line, const char *here)
{
    return *here != ' ' && (here == line || here[-1] == ' ');
}

/* The text after `key=` where the word starts so, 0 where it does not. */
static const char *after(const char *word, const char *key)
{
    for (; *key != '\0'; key++, word++) {
        if (*word != *key) {
            return 0;
        }
    }
    return *word == '=' ? word + 1 : 0;
}

/* Whether a word is `key=digits`, a number that the key takes, and nothing more. */
static int read_word(const char *word, const line_key *key, uint64_t *value)
{
    const char *const first = after(word, key->name), *at = first;

    if (first == 0) {
        return 0;
    }
    for (*value = 0; *at >= '0' && *at <= '9'; at++) {
        const uint64_t digit = (uint64_t)(*at - '0');

        if (*value > (UINT64_MAX - digit) / 10u) {
            return 0;
        }
        *value = 10u * *value + digit;
    }
    return at != first && (*at == ' ' || *at == '\0') && (key->most == 0 || *value <= key->most);
}

const char *line_read(const char line[LINE_MAX], const line_key keys[], uint64_t values[], unsigned count)
{
    uint32_t seen = 0;           /* a key that comes again is none */

    for (unsigned k = 0; k < count; k++) {
        values[k] = keys[k].otherwise;
    }
    for (const char *word = line; *word != '\0'; word++) {
        if (begins(line, word)) {
            unsigned k = 0;

            while (k < count && ((seen >> k & 1u) != 0 || !read_word(word, &keys[k], &values[k]))) {
                k++;
            }
            if (k == count) {
                return word;
            }
            seen |= 1u << k;
        }
    }
    return 0;
}
