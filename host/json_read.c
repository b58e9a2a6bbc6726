/* json_read.c - a JSON text from its first character to its last, one path at a time; RFC 8259, but escapes in strings stay as they are. */
#include <ctype.h>
#include <string.h>

#include "stored.h"

#define DEPTH 16
#define PATH_MAX_LENGTH 256
#define VALUE_MAX_LENGTH 4096     /* an emulator's command line is one */

typedef struct {
    const char *text, *at;
    json_visit visit;
    void *context;
    char path[PATH_MAX_LENGTH], value[VALUE_MAX_LENGTH];
    struct {
        char kind;                /* '{' or '[' */
        size_t path;              /* length of the path outside */
    } stack[DEPTH];
    unsigned depth;
} reader;

static void skip_space(reader *r)
{
    while (*r->at == ' ' || *r->at == '\n' || *r->at == '\r' || *r->at == '\t') {
        r->at++;
    }
}

static int expect(reader *r, char c)
{
    skip_space(r);
    if (*r->at != c) {
        return 0;
    }
    r->at++;
    return 1;
}

/* A string into value; 0 where it is none, or longer than any that matters here. */
static int string(reader *r)
{
    size_t n = 0;

    if (!expect(r, '"')) {
        return 0;
    }
    while (*r->at != '"') {
        if ((unsigned char)*r->at < ' ' || n + 2 >= sizeof(r->value)) {
            return 0;
        }
        if (*r->at == '\\' && (unsigned char)r->at[1] >= ' ') {
            r->value[n++] = *r->at++;
        }
        r->value[n++] = *r->at++;
    }
    r->value[n] = '\0';
    r->at++;
    return 1;
}

static size_t digits(const char *at)
{
    return strspn(at, "0123456789");
}

/* Length of the number that begins here, 0 where none does. */
static size_t number(const char *text)
{
    const char *at = text + (*text == '-');
    const size_t whole = digits(at);

    if (whole == 0 || (whole > 1 && *at == '0')) {
        return 0;
    }
    at += whole;
    if (*at == '.') {
        if (digits(at + 1) == 0) {
            return 0;
        }
        at += 1 + digits(at + 1);
    }
    if (*at == 'e' || *at == 'E') {
        const size_t sign = at[1] == '+' || at[1] == '-';

        if (digits(at + 1 + sign) == 0) {
            return 0;
        }
        at += 1 + sign + digits(at + 1 + sign);
    }
    return (size_t)(at - text);
}

/* Number, true, false or null as it stands; what it means is for who asks. */
static int word(reader *r)
{
    static const char *const words[] = { "true", "false", "null" };
    size_t n = number(r->at);

    for (unsigned k = 0; k < 3 && n == 0; k++) {
        n = strncmp(r->at, words[k], strlen(words[k])) == 0 ? strlen(words[k]) : 0;
    }
    if (n == 0 || n >= sizeof(r->value)) {
        return 0;
    }
    memcpy(r->value, r->at, n);
    r->value[n] = '\0';
    r->at += n;
    return 1;
}

/* "key": before a value of an object, onto the path. */
static int key(reader *r)
{
    size_t length = r->depth > 0 ? r->stack[r->depth - 1].path : 0;

    if (r->depth == 0 || r->stack[r->depth - 1].kind != '{') {
        return 1;
    }
    if (!string(r) || length + strlen(r->value) + 2 > sizeof(r->path) || !expect(r, ':')) {
        return 0;
    }
    if (length > 0) {
        r->path[length++] = '.';
    }
    memcpy(r->path + length, r->value, strlen(r->value) + 1);
    return 1;
}

/* A value: a scalar is shown; an object or array is begun. `open`: whether it has been begun and is not empty. */
static int value(reader *r, int *open)
{
    *open = 0;
    skip_space(r);
    if (*r->at == '{' || *r->at == '[') {
        if (r->depth == DEPTH) {
            return 0;
        }
        r->stack[r->depth].kind = *r->at++;
        r->stack[r->depth++].path = strlen(r->path);
        skip_space(r);
        *open = *r->at != '}' && *r->at != ']';
        return 1;
    }
    if (!(*r->at == '"' ? string(r) : word(r))) {
        return 0;
    }
    r->visit(r->context, r->path, r->value);
    return 1;
}

/* Close what ends here; 1 where another element follows, 0 at the end of the text or a mistake (depth > 0). */
static int next(reader *r)
{
    while (r->depth > 0) {
        const char kind = r->stack[r->depth - 1].kind;

        skip_space(r);
        if (*r->at == ',') {
            r->at++;
            return 1;
        }
        if (*r->at != (kind == '{' ? '}' : ']')) {
            return 0;
        }
        r->at++;
        r->path[r->stack[--r->depth].path] = '\0';
    }
    return 0;
}

long json_walk(const char *text, json_visit visit, void *context)
{
    reader r = { .text = text, .at = text, .visit = visit, .context = context };
    int open;

    do {
        do {
            if (!key(&r) || !value(&r, &open)) {
                return r.at - r.text;
            }
        } while (open);
    } while (next(&r));
    skip_space(&r);
    return r.depth == 0 && *r.at == '\0' ? -1 : r.at - r.text;
}
