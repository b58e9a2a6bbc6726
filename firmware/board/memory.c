/* memory.c - the three functions that a compiler calls behind our back (struct copies, cleared arrays).
 *
 * Built with -fno-tree-loop-distribute-patterns: otherwise the loops below become calls of themselves.
 */
#include <stddef.h>

void *memcpy(void *restrict to, const void *restrict from, size_t size);
void *memmove(void *to, const void *from, size_t size);
void *memset(void *to, int value, size_t size);

void *memcpy(void *restrict to, const void *restrict from, size_t size)
{
    unsigned char *t = to;
    const unsigned char *f = from;

    while (size-- > 0) {
        *t++ = *f++;
    }
    return to;
}

void *memmove(void *to, const void *from, size_t size)
{
    unsigned char *t = to;
    const unsigned char *f = from;

    if (t < f) {
        return memcpy(to, from, size);   /* upwards, byte by byte: right for overlap in this direction */
    }
    while (size-- > 0) {
        t[size] = f[size];
    }
    return to;
}

void *memset(void *to, int value, size_t size)
{
    unsigned char *t = to;

    while (size-- > 0) {
        *t++ = (unsigned char)value;
    }
    return to;
}
