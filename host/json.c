#include "json.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include "host.h"

#define DEPTH 16                 /* objects in objects */
#define MOST (16u << 20)         /* bytes of a file: ours have some thousand */

static const char *blank(const char *at)
{
    return at + strspn(at, " \t\r\n");
}

/* Behind a string, or 0. */
static const char *skip_string(const char *at)
{
    for (at++; *at && *at != '"'; at++) {
        at += *at == '\\' && at[1];
    }
    return *at ? at + 1 : 0;
}

static const char *skip_value(const char *at, int depth);

/* Behind the object or array that begins here, or 0. */
static const char *skip_nested(const char *at, int depth)
{
    const int object = *at == '{';
    const char close = object ? '}' : ']';

    at = blank(at + 1);
    if (*at == close) {
        return at + 1;
    }
    for (;;) {
        if (object) {
            at = *at == '"' ? skip_string(at) : 0;
            at = at ? blank(at) : 0;
            if (!at || *at != ':') {
                return 0;
            }
            at = blank(at + 1);
        }
        at = skip_value(at, depth);
        at = at ? blank(at) : 0;
        if (!at || *at == close) {
            return at ? at + 1 : 0;
        }
        if (*at != ',') {
            return 0;
        }
        at = blank(at + 1);
    }
}

static const char *skip_value(const char *at, int depth)
{
    const size_t plain = strspn(at, "+-.0123456789eEtrufalsn");

    if (*at == '"') {
        return skip_string(at);
    }
    if (*at == '{' || *at == '[') {
        return depth < DEPTH ? skip_nested(at, depth + 1) : 0;
    }
    return plain > 0 ? at + plain : 0;
}

char *json_load(const char *path)
{
    FILE *const in = fopen(path, "rb");
    char *const text = malloc(MOST + 1);
    const char *end;
    size_t length;

    if (!in || !text) {
        die(EXIT_FAILED, "%s: cannot be read: %s", path, in ? "out of memory" : strerror(errno));
    }
    length = fread(text, 1, MOST, in);
    if (ferror(in)) {
        die(EXIT_FAILED, "%s: cannot be read: %s", path, strerror(errno));
    }
    fclose(in);
    text[length] = '\0';
    end = *blank(text) == '{' ? skip_value(blank(text), 0) : 0;
    if (!end || *blank(end) != '\0' || strlen(text) != length) {
        die(EXIT_USAGE, "%s: not a JSON object; give what --json of kelly wrote", path);
    }
    return text;
}

const char *json_find(const char *object, const char *names)
{
    const size_t length = strcspn(names, ".");
    const char *at = blank(object);

    if (*at != '{') {
        return 0;
    }
    for (at = blank(at + 1); *at == '"'; at = blank(at + 1)) {
        const char *const name = at + 1, *const value = blank(blank(skip_string(at)) + 1);

        if (strncmp(name, names, length) == 0 && name[length] == '"') {
            return names[length] ? json_find(value, names + length + 1) : value;
        }
        at = blank(skip_value(value, 0));
        if (*at != ',') {
            break;
        }
    }
    return 0;
}

unsigned json_length(const char *value)
{
    return (unsigned)(skip_value(value, 0) - value);
}

static const char *wanted(const char *path, const char *object, const char *names)
{
    const char *const value = json_find(object, names);

    if (!value) {
        die(EXIT_USAGE, "%s: says nothing of \"%s\"; give what --json of this kelly wrote", path, names);
    }
    return value;
}

double json_number(const char *path, const char *object, const char *names)
{
    const char *const value = wanted(path, object, names);
    char *end;
    const double x = strtod(value, &end);

    if (end == value) {
        die(EXIT_USAGE, "%s: \"%s\" is no number", path, names);
    }
    return x;
}

uint64_t json_whole(const char *path, const char *object, const char *names, uint64_t most)
{
    const char *const value = wanted(path, object, names);
    char *end;
    unsigned long long x;

    errno = 0;
    x = strtoull(value, &end, 10);
    if (*value < '0' || *value > '9' || strspn(end, ".eE") > 0 || errno == ERANGE || x > most) {
        die(EXIT_USAGE, "%s: \"%s\" is no whole number up to %llu", path, names, (unsigned long long)most);
    }
    return x;
}

void json_text(const char *path, const char *object, const char *names, char *to, unsigned size)
{
    const char *const value = wanted(path, object, names);
    const char *const end = *value == '"' ? skip_string(value) : 0;

    if (!end) {
        die(EXIT_USAGE, "%s: \"%s\" is no text", path, names);
    }
    snprintf(to, size, "%.*s", (int)(end - value) - 2, value + 1);
}

const char *json_first(const char *value)
{
    const char *const at = value && *value == '[' ? blank(value + 1) : 0;

    return at && *at != ']' ? at : 0;
}

const char *json_next(const char *element)
{
    const char *const at = blank(skip_value(element, 0));

    return *at == ',' ? blank(at + 1) : 0;
}
