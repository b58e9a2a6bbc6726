/* npy.c - header of a NPY 1.0 file. */
#include "host.h"

#define HEADER 1024u             /* most characters of a header: longer ones are a mistake of the caller */

#if defined(__BYTE_ORDER__) && __BYTE_ORDER__ == __ORDER_BIG_ENDIAN__
#define ORDER '>'
#else
#define ORDER '<'
#endif

/* 93 NUMPY 01 00, length of the rest as two bytes, little-endian, a Python literal, and blanks: in all a multiple of 64. */
void npy_header(FILE *to, const char *type, unsigned dimensions, const uint64_t *shape)
{
    char text[HEADER];
    const char *const quote = type[0] == '[' ? "" : "'";
    size_t n = (size_t)snprintf(text, sizeof(text), "{'descr': %s%s%s, 'fortran_order': False, 'shape': (", quote, type, quote);
    unsigned length;

    for (char *c = text; *c; c++) {
        if (*c == '<') {
            *c = ORDER;
        }
    }
    for (unsigned d = 0; d < dimensions; d++) {   /* a tuple of one needs its comma */
        n += (size_t)snprintf(text + n, sizeof(text) - n, "%llu%s", (unsigned long long)shape[d], d + 1 < dimensions ? ", " : dimensions == 1 ? "," : "");
    }
    n += (size_t)snprintf(text + n, sizeof(text) - n, "), }");
    length = (unsigned)((10 + n + 1 + 63) / 64 * 64 - 10);
    fwrite("\x93NUMPY\x01", 1, 7, to);
    fputc(0, to);
    fputc((int)(length & 255u), to);
    fputc((int)(length >> 8), to);
    fprintf(to, "%s%*s\n", text, (int)(length - 1 - n), "");
}
