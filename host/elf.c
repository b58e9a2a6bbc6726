/* elf.c - little-endian ELF, 32 or 64 bit: its loadable segments as one stretch of flash. */
#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include "../firmware/link/crc32c.h"
#include "elf.h"
#include "host.h"

#define FILE_MOST (64u << 20)     /* debug information included */
#define IMAGE_MOST (16u << 20)    /* more than any of these parts has */

typedef struct {
    const uint8_t *bytes;
    size_t size;
    const char *path;
} elf_file;

/* Little-endian number of n bytes at this offset. */
static uint64_t number(const elf_file *f, uint64_t at, unsigned n)
{
    uint64_t x = 0;

    if (at > f->size || n > f->size - at) {
        die(EXIT_USAGE, "%s: ends in the middle; give the .elf that make TARGET=NAME wrote", f->path);
    }
    while (n-- > 0) {
        x = x << 8 | f->bytes[at + n];
    }
    return x;
}

/* What a program header says of a segment with bytes in the file. */
typedef struct {
    uint64_t offset, address, size;
} segment;

static int segment_at(const elf_file *f, unsigned i, segment *s)
{
    const int wide_file = number(f, 4, 1) == 2;
    const uint64_t table = wide_file ? number(f, 32, 8) : number(f, 28, 4);
    const uint64_t at = table + i * number(f, wide_file ? 54 : 42, 2);

    *s = wide_file ? (segment){ number(f, at + 8, 8), number(f, at + 24, 8), number(f, at + 32, 8) }
                   : (segment){ number(f, at + 4, 4), number(f, at + 12, 4), number(f, at + 16, 4) };
    return number(f, at, 4) == 1 && s->size > 0;
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
    if (*size < 52 || memcmp(bytes, "\177ELF", 4) != 0 || bytes[5] != 1) {
        die(EXIT_USAGE, "--image %s: not an ELF of a board; give the .elf that make TARGET=NAME wrote", path);
    }
    return bytes;
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
    for (unsigned i = 0; image && i < count; i++) {
        if (segment_at(&f, i, &s) && s.offset <= f.size && s.size <= f.size - s.offset) {
            memcpy(image + (s.address - low), bytes + s.offset, s.size);
        }
    }
    *size = (uint32_t)(high - low);
    *crc = image ? kelly_crc32c(0, image, *size) : 0;
    free(image);
    free(bytes);
}
