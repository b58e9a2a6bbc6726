#include "scpi.h"

static int is_capital(char c) { return c >= 'A' && c <= 'Z'; }
static int is_small(char c) { return c >= 'a' && c <= 'z'; }
static int is_digit(char c) { return c >= '0' && c <= '9'; }
static char capital(char c) { return (char)(is_small(c) ? c - 'a' + 'A' : c); }

/* Characters of `pattern` and `text` that go together; the pattern's small letters all or not at all. */
static const char *match(const char *text, const char *pattern)
{
    while (*pattern != '\0') {
        if (is_small(*pattern) && capital(*text) != capital(*pattern)) {
            if (!is_capital(pattern[-1])) {
                return 0;
            }
            while (is_small(*pattern)) {
                pattern++;
            }
        } else if (capital(*text) == capital(*pattern)) {
            text++;
            pattern++;
        } else {
            return 0;
        }
    }
    return text;
}

int scpi_is(const char *line, const char *pattern, const char **rest)
{
    const char *text = match(line, pattern);

    if (text == 0 || (*text != '\0' && *text != ' ')) {
        return 0;
    }
    while (*text == ' ') {
        text++;
    }
    *rest = text;
    return 1;
}

int scpi_number(const char *text, real *value)
{
    const int negative = *text == '-';
    uint32_t digits = 0, whole = 0, scale = 1;
    int point = 0;

    if (*text == '\0') {
        return SCPI_MISSING;
    }
    for (text += negative || *text == '+'; is_digit(*text) || (*text == '.' && !point); text++) {
        if (*text == '.') {
            point = 1;
        } else if (++digits > 9u) {
            return SCPI_BAD_NUMBER;
        } else {
            whole = 10u * whole + (uint32_t)(*text - '0');
            scale *= point ? 10u : 1u;
        }
    }
    while (*text == ' ') {
        text++;
    }
    if (digits == 0 || *text != '\0') {
        return SCPI_BAD_NUMBER;
    }
    *value = (real)(int32_t)whole / (real)(int32_t)scale;
    *value = negative ? -*value : *value;
    return SCPI_NO_ERROR;
}

const char *scpi_error_text(int error)
{
    switch (error) {
    case SCPI_NO_ERROR:
        return "No error";
    case SCPI_NOT_ALLOWED:
        return "Parameter not allowed";
    case SCPI_MISSING:
        return "Missing parameter";
    case SCPI_BAD_NUMBER:
        return "Invalid character in number";
    case SCPI_CONFLICT:
        return "Settings conflict";
    case SCPI_RANGE:
        return "Data out of range";
    case SCPI_QUEUE:
        return "Queue overflow";
    default:
        return "Undefined header";
    }
}
