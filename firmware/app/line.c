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

/* The text after `key=` where a word of the line starts so, 0 where none does. */
static const char *value_of(const char *line, const char *key)
{
    for (const char *word = line; *word != '\0'; word++) {
        int i = 0;

        if (word != line && word[-1] != ' ') {
            continue;
        }
        while (key[i] != '\0' && word[i] == key[i]) {
            i++;
        }
        if (key[i] == '\0' && word[i] == '=') {
            return word + i + 1;
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

/* The length of a word that is `key=digits`, 0 where it is not. */
static int known_word(const char *word, const char *key)
{
    uint64_t value = 0;
    int i = 0, digits = 0;

    while (key[i] != '\0' && word[i] == key[i]) {
        i++;
    }
    if (key[i] != '\0' || word[i] != '=') {
        return 0;
    }
    for (i++; word[i] >= '0' && word[i] <= '9'; i++, digits++) {
        const uint64_t digit = (uint64_t)(word[i] - '0');

        if (value > (UINT64_MAX - digit) / 10u) {   /* 2^64 or more */
            return 0;
        }
        value = 10u * value + digit;
    }
    return digits > 0 && (word[i] == ' ' || word[i] == '\0') ? i : 0;
}

const char *line_stranger(const char line[LINE_MAX], const char *const keys[], int count)
{
    const char *word = line;

    while (*word != '\0') {
        int length = *word == ' ';

        for (int k = 0; k < count && length == 0; k++) {
            length = known_word(word, keys[k]);
        }
        if (length == 0) {
            return word;
        }
        word += length;
    }
    return 0;
}
