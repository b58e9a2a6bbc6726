/* caught.h - parts of the host program for a fuzzer: die() comes back instead of ending the program, and what it leaves is freed.
 *
 * Include it first, then the source file that is tried: memory and files that this takes are kept in a list. CATCH(status, work) carries
 * out `work`; status is 0, or what die was called with.
 */
#ifndef CAUGHT_H
#define CAUGHT_H

#include <fcntl.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "../../host/host.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

#define CAUGHT_MOST 256
static void *caught_blocks[CAUGHT_MOST];
static FILE *caught_files[CAUGHT_MOST];
static unsigned caught_count, caught_open;
static jmp_buf caught;

static void must(int holds)
{
    if (!holds) {
        abort();
    }
}

void die(int status, const char *format, ...)
{
    char text[4096];
    va_list args;
    int n;

    va_start(args, format);
    n = vsnprintf(text, sizeof(text), format, args);
    va_end(args);
    must(n > 0 && (status == EXIT_FAILED || status == EXIT_USAGE));
    longjmp(caught, status);
}

/* As in host/files.c, but for the lock: nobody else writes here. */
int open_locked(const char *path)
{
    return open(path, O_RDWR | O_CREAT, 0666);
}

void journals_open(int by)
{
    (void)by;
}

void outfile_open(outfile *file, const char *path)      /* of what is not run */
{
    (void)file, (void)path;
    abort();
}

void outfile_close(outfile *file)
{
    (void)file;
    abort();
}

void outfile_drop(outfile *file)
{
    (void)file;
    abort();
}

static inline void *caught_keep(void *block)
{
    must(caught_count < CAUGHT_MOST);
    caught_blocks[caught_count++] = block;
    return block;
}

static inline void caught_free(void *block)
{
    for (unsigned i = 0; i < caught_count; i++) {
        if (caught_blocks[i] == block) {
            caught_blocks[i] = caught_blocks[--caught_count];
            break;
        }
    }
    (free)(block);
}

static inline FILE *caught_fopen(FILE *file)
{
    if (file) {
        must(caught_open < CAUGHT_MOST);
        caught_files[caught_open++] = file;
    }
    return file;
}

static inline int caught_fclose(FILE *file)
{
    for (unsigned i = 0; i < caught_open; i++) {
        if (caught_files[i] == file) {
            caught_files[i] = caught_files[--caught_open];
            break;
        }
    }
    return (fclose)(file);
}

static inline void caught_clear(void)
{
    while (caught_count > 0) {
        (free)(caught_blocks[--caught_count]);
    }
    while (caught_open > 0) {
        (void)(fclose)(caught_files[--caught_open]);
    }
}

#define CATCH(status, work) \
    do { \
        (status) = setjmp(caught); \
        if ((status) == 0) { \
            work; \
        } \
    } while (0)

/* What the source file calls from here on. */
#define malloc(size) caught_keep((malloc)(size))
#define calloc(count, size) caught_keep((calloc)(count, size))
#define free(block) caught_free(block)
#undef strdup
#define strdup(text) caught_keep((strdup)(text))
#define fopen(path, mode) caught_fopen((fopen)(path, mode))
#define fdopen(fd, mode) caught_fopen((fdopen)(fd, mode))
#define fclose(file) caught_fclose(file)

/* A path that reads these bytes. The same one each time. */
static inline const char *caught_file(const char *end, const uint8_t *data, size_t size)
{
    static char directory[64], path[128];
    FILE *to;

    if (!directory[0]) {
        strcpy(directory, "/dev/shm/fuzz-XXXXXX");
        if (!mkdtemp(directory)) {
            strcpy(directory, "/tmp/fuzz-XXXXXX");
            must(mkdtemp(directory) != 0);
        }
    }
    snprintf(path, sizeof(path), "%s/in%s", directory, end);
    to = (fopen)(path, "wb");
    must(to != 0 && (fwrite)(data, 1, size, to) == size && (fclose)(to) == 0);
    return path;
}

#endif
