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

/* The first number of this key, 0 where no word has the key. */
static const char *value_of(const char *line, const char *key)
{
    for (const char *word = line; *word != '\0'; word++) {
        const char *const value = begins(line, word) ? after(word, key) : 0;

        if (value != 0) {
            return value;
        }
    }
    return 0;
}

uint64_t line_number(const char line[LINE_MAX], const char *key, uint64_t otherwise)
{
    const char *digit = value_of(line, key);
    uint64_t value = 0;

    if (digit == 0 || *digit < '0' || *digit > '9') {
        return otherwise;
    }
    for (; *digit >= '0' && *digit <= '9'; digit++) {
        value = 10u * value + (uint64_t)(*digit - '0');
    }
    return value;
}

/* Whether a word is `key=digits`, a number below 2^64. */
static int known_word(const char *word, const char *key)
{
    const char *const first = after(word, key), *at = first;
    uint64_t value = 0;

    if (first == 0) {
        return 0;
    }
    for (; *at >= '0' && *at <= '9'; at++) {
        const uint64_t digit = (uint64_t)(*at - '0');

        if (value > (UINT64_MAX - digit) / 10u) {
            return 0;
        }
        value = 10u * value + digit;
    }
    return at != first && (*at == ' ' || *at == '\0');
}

const char *line_stranger(const char line[LINE_MAX], const char *const keys[], int count)
{
    for (const char *word = line; *word != '\0'; word++) {
        int known = !begins(line, word);

        for (int k = 0; k < count && !known; k++) {
            known = known_word(word, keys[k]);
        }
        if (!known) {
            return word;
        }
    }
    return 0;
}
