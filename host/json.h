/* json.h - reads the JSON that kelly writes (any JSON: members in any order, white space anywhere), to take numbers out of it. */
#ifndef KELLY_JSON_H
#define KELLY_JSON_H

#include <stdint.h>

/* The text of a whole file; dies with exit 1 if it cannot be read, with exit 2 unless it holds one sound object. */
char *json_load(const char *path);

/* Value of a member, by names from the outermost object inwards ("case.cov.fc"), or 0. */
const char *json_find(const char *object, const char *names);

/* Characters of a value's text. */
unsigned json_length(const char *value);

/* The same of a kind, or exit 2 with the path of the file: a number, a whole number, a text (at most size - 1 bytes are copied). */
double json_number(const char *path, const char *object, const char *names);
uint64_t json_whole(const char *path, const char *object, const char *names, uint64_t most);
void json_text(const char *path, const char *object, const char *names, char *to, unsigned size);

/* First element of an array (`value`: from json_find) or the one behind `element`; 0 at the end, or where there is no array. */
const char *json_first(const char *value);
const char *json_next(const char *element);

#endif
