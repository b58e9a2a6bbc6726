/* elf.c - little-endian ELF, 32 or 64 bit: its loadable segments as one stretch of flash. */
#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include "../firmware/link/crc32c.h"
#include "elf.h"
#include "host.h"

#ifndef FILE_MOST                 /* a fuzzer asks for less memory each time */
#define FILE_MOST (64u << 20)     /* debug information included */
#endif
#define IMAGE_MOST (16u << 20)    /* more than any of these parts has */

typedef struct {
    const uint8_t *bytes;
    size_t size;
    const char *path;
} elf_file;

/* The n bytes from `at` on are there. Nothing is added that might wrap. */
static void must_hold(const elf_file *f, uint64_t at, uint64_t n)
{
    if (at > f->size || n > f->size - at) {
        die(EXIT_USAGE, "--image %s: ends in the middle; give the .elf that make TARGET=NAME wrote", f->path);
    }
}

/* Little-endian number of n bytes at this offset. */
static uint64_t number(const elf_file *f, uint64_t at, unsigned n)
{
    uint64_t x = 0;

    must_hold(f, at, n);
    while (n-- > 0) {
        x = x << 8 | f->bytes[at + n];
    }
    return x;
}

/* What a program header says of a segment with bytes in the file. */
typedef struct {
    uint64_t offset, address, size;
} segment;

/* Whether header i is of such a segment; its bytes are then in the file, and its end is an address. */
static int segment_at(const elf_file *f, unsigned i, segment *s)
{
    const int wide_file = f->bytes[4] == 2;
    const uint64_t table = wide_file ? number(f, 32, 8) : number(f, 28, 4);
    const uint64_t each = number(f, wide_file ? 54 : 42, 2), at = table + i * each;

    must_hold(f, table, 0);              /* so `at` has not wrapped: i and `each` have 16 bits */
    if (each < (wide_file ? 56u : 32u)) {
        die(EXIT_USAGE, "--image %s: program headers of %u bytes; give the .elf that make TARGET=NAME wrote", f->path, (unsigned)each);
    }
    must_hold(f, at, each);
    *s = wide_file ? (segment){ number(f, at + 8, 8), number(f, at + 24, 8), number(f, at + 32, 8) }
                   : (segment){ number(f, at + 4, 4), number(f, at + 12, 4), number(f, at + 16, 4) };
    if (number(f, at, 4) != 1 || s->size == 0) {
        return 0;
    }
    must_hold(f, s->offset, s->size);
    if (s->address > (wide_file ? UINT64_MAX : UINT32_MAX) - s->size) {
        die(EXIT_USAGE, "--image %s: a segment goes beyond the last address; give the .elf that make TARGET=NAME wrote", f->path);
    }
    return 1;
}

static uint8_t *read_whole(const char *path, size_t *size)
{
    FILE *const file = fopen(path, "rb");
    uint8_t *bytes = malloc(FILE_MOST);

    if (!file || !bytes) {
        die(EXIT_USAGE, "--image %s: cannot be read: %s", path, strerror(errno));
    }
    *size = fread(bytes, 1, FILE_MOST, file);
    (void)fclose(file);
    if (*size < 52 || memcmp(bytes, "\177ELF", 4) != 0 || (bytes[4] != 1 && bytes[4] != 2) || bytes[5] != 1) {
        die(EXIT_USAGE, "--image %s: not an ELF of a board; give the .elf that make TARGET=NAME wrote", path);
    }
    return bytes;
}

unsigned elf_machine(const char *path, int *wide_file)
{
    elf_file f = { .path = path };
    uint8_t *const bytes = read_whole(path, &f.size);
    unsigned machine;

    f.bytes = bytes;
    machine = (unsigned)number(&f, 18, 2);
    *wide_file = bytes[4] == 2;
    free(bytes);
    return machine;
}

void elf_image(const char *path, uint32_t *crc, uint32_t *size)
{
    elf_file f = { .path = path };
    uint8_t *const bytes = read_whole(path, &f.size), *image;
    uint64_t low = UINT64_MAX, high = 0;
    unsigned count;
    segment s;

    f.bytes = bytes;
    count = (unsigned)number(&f, bytes[4] == 2 ? 56 : 44, 2);
    for (unsigned i = 0; i < count; i++) {
        if (segment_at(&f, i, &s)) {
            low = s.address < low ? s.address : low;
            high = s.address + s.size > high ? s.address + s.size : high;
        }
    }
    if (high <= low || high - low > IMAGE_MOST) {
        die(EXIT_USAGE, "--image %s: holds nothing for flash; give the .elf that make TARGET=NAME wrote", path);
    }
    image = calloc(1, high - low);
    if (!image) {
        die(EXIT_FAILED, "--image %s: no memory for its %llu bytes", path, (unsigned long long)(high - low));
    }
    for (unsigned i = 0; i < count; i++) {
        if (segment_at(&f, i, &s)) {
            memcpy(image + (s.address - low), bytes + s.offset, s.size);
        }
    }
    *size = (uint32_t)(high - low);
    *crc = kelly_crc32c(0, image, *size);
    free(image);
    free(bytes);
}
