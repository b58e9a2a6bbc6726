#include "journal.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#include "../firmware/link/crc32c.h"
#include "host.h"

#define MAGIC "KELLYJNL"
#define VERSION 1u
#define SYNC_EVERY 5.0           /* [s] */
#define TOGETHER 4096u           /* bytes in one write */
#define TWICE 0x74776963u        /* what sets the parameters of a run that runs twice apart */

/* The header: where each field lies. Names are cut to their length; the CRC of the whole model id is in `parameters`. */
enum { AT_VERSION = 8, AT_REAL = 12, AT_PAYLOAD = 16, AT_RECORDS = 20, AT_PARAMETERS = 24, AT_SEED = 28, AT_KIND = 36, AT_MODEL = 52,
       AT_CRC = 92, HEADER = 96 };

void put_u32(uint8_t *to, uint32_t x)
{
    for (unsigned k = 0; k < 4; k++) {
        to[k] = (uint8_t)(x >> (8 * k));
    }
}

uint32_t get_u32(const uint8_t *from)
{
    return (uint32_t)from[0] | (uint32_t)from[1] << 8 | (uint32_t)from[2] << 16 | (uint32_t)from[3] << 24;
}

static double now(void)
{
    struct timespec t;

    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* Numbers as hexadecimal floats, exact. The axial modes are none of it: they do not reach the bit's torsion. */
uint32_t case_identity(const kelly_case *r)
{
    char text[640];

    snprintf(text, sizeof(text), "%s rpm %a wob %a f0 %a mu %a %a %a cov %a %a %a %a %a limit %a time %u %u %u %u modes %u drive %a %a %a %s",
             KELLY_VERSION, (double)r->w0, (double)r->fc, (double)r->f0, (double)r->mu, (double)r->a1, (double)r->a2, (double)r->cov[0],
             (double)r->cov[1], (double)r->cov[2], (double)r->cov[3], (double)r->cov[4], (double)r->limit, r->step_ns, r->ticks,
             r->window_first, r->window_last, r->torsional, (double)r->drive.inertia, (double)r->drive.impedance, (double)r->drive.hz,
             r->rotating ? "rotating" : "rest");
    return kelly_crc32c(0, (const uint8_t *)text, strlen(text));
}

static void make_header(uint8_t header[HEADER], const journal_run *run)
{
    memset(header, 0, HEADER);
    memcpy(header, MAGIC, 8);
    put_u32(header + AT_VERSION, VERSION);
    put_u32(header + AT_REAL, (uint32_t)sizeof(real));
    put_u32(header + AT_PAYLOAD, run->payload);
    put_u32(header + AT_RECORDS, run->records);
    put_u32(header + AT_PARAMETERS, kelly_crc32c(run->parameters ^ (run->twice ? TWICE : 0), (const uint8_t *)run->model, strlen(run->model)));
    put_u32(header + AT_SEED, (uint32_t)run->seed);
    put_u32(header + AT_SEED + 4, (uint32_t)(run->seed >> 32));
    strncpy((char *)header + AT_KIND, run->kind, AT_MODEL - AT_KIND - 1);
    strncpy((char *)header + AT_MODEL, run->model, AT_CRC - AT_MODEL - 1);
    put_u32(header + AT_CRC, kelly_crc32c(0, header, AT_CRC));
}

/* Write all of it. A file that is full or broken ends the run; the records before this one stay good. */
static void write_all(const journal *j, const uint8_t *bytes, size_t count)
{
    while (count > 0) {
        const ssize_t n = write(j->fd, bytes, count);

        if (n < 0 && errno == EINTR) {
            continue;
        }
        if (n <= 0) {
            die(EXIT_FAILED, "%s: could not be written: %s; what it holds is sound, go on with --resume", j->path, strerror(errno));
        }
        bytes += n;
        count -= (size_t)n;
    }
}

static void sync_now(journal *j)
{
    if (fdatasync(j->fd) != 0) {
        die(EXIT_FAILED, "%s: could not be written: %s; what it holds is sound, go on with --resume", j->path, strerror(errno));
    }
    j->synced = now();
}

/* The first bytes of the file, as many as there are of a header. */
static size_t read_header(const journal *j, uint8_t header[HEADER])
{
    size_t have = 0;

    while (have < HEADER) {
        const ssize_t n = pread(j->fd, header + have, HEADER - have, (off_t)have);

        if (n < 0 && errno != EINTR) {
            die(EXIT_FAILED, "%s: cannot be read: %s", j->path, strerror(errno));
        }
        if (n == 0) {
            break;
        }
        have += n > 0 ? (size_t)n : 0;
    }
    return have;
}

static _Noreturn void refuse(const journal *j, const char *what)
{
    die(EXIT_USAGE, "%s: of another run (%s); give that run's options, or leave --resume away to start afresh", j->path, what);
}

/* Dies unless this is the header of this very run, and says in what it differs. */
static void compare(const journal *j, const uint8_t have[HEADER], const uint8_t want[HEADER])
{
    char what[160];

    if (memcmp(have, MAGIC, 8) != 0 || get_u32(have + AT_CRC) != kelly_crc32c(0, have, AT_CRC)) {
        die(EXIT_USAGE, "%s: not a journal of kelly; move it away", j->path);
    }
    if (get_u32(have + AT_VERSION) != VERSION) {
        refuse(j, "written by another version of kelly");
    }
    if (memcmp(have + AT_KIND, want + AT_KIND, AT_MODEL - AT_KIND) != 0) {
        snprintf(what, sizeof(what), "kelly %.16s, this is kelly %.16s", (const char *)have + AT_KIND, (const char *)want + AT_KIND);
        refuse(j, what);
    }
    if (memcmp(have + AT_MODEL, want + AT_MODEL, AT_CRC - AT_MODEL) != 0) {
        snprintf(what, sizeof(what), "string %.40s, this is %.40s", (const char *)have + AT_MODEL, (const char *)want + AT_MODEL);
        refuse(j, what);
    }
    if (memcmp(have + AT_REAL, want + AT_REAL, 4) != 0) {
        refuse(j, sizeof(real) > 4 ? "in float, this is in double" : "in double, this is in float");
    }
    if (memcmp(have + AT_SEED, want + AT_SEED, 8) != 0) {
        snprintf(what, sizeof(what), "seed %llu, this is %llu",
                 (unsigned long long)get_u32(have + AT_SEED) | (unsigned long long)get_u32(have + AT_SEED + 4) << 32,
                 (unsigned long long)get_u32(want + AT_SEED) | (unsigned long long)get_u32(want + AT_SEED + 4) << 32);
        refuse(j, what);
    }
    if (memcmp(have, want, HEADER) != 0) {
        refuse(j, "another case, grid or number of samples, or with --twice and without");
    }
}

static void cut_to(const journal *j, off_t length)
{
    if (ftruncate(j->fd, length) != 0) {
        die(EXIT_FAILED, "%s: could not be written: %s", j->path, strerror(errno));
    }
}

static off_t file_size(const journal *j)
{
    struct stat here;

    if (fstat(j->fd, &here) != 0) {
        die(EXIT_FAILED, "%s: cannot be read: %s", j->path, strerror(errno));
    }
    return here.st_size;
}

/* Go over to what an earlier run has written. */
static void resume_from(journal *j, const uint8_t have[HEADER], const uint8_t want[HEADER])
{
    int copy;

    compare(j, have, want);
    copy = dup(j->fd);
    j->earlier = copy < 0 ? 0 : fdopen(copy, "rb");
    if (!j->earlier || fseeko(j->earlier, HEADER, SEEK_SET) != 0) {
        die(EXIT_FAILED, "%s: cannot be read: %s", j->path, strerror(errno));
    }
}

/* Another name for a journal with records, in place of an older one of that name, and an empty file where it was. */
static void set_aside(journal *j, const uint8_t have[HEADER])
{
    const int sound = get_u32(have + AT_CRC) == kelly_crc32c(0, have, AT_CRC), earlier = j->fd;
    const long long count = (long long)(file_size(j) - HEADER) / ((long long)get_u32(have + AT_PAYLOAD) + 8);
    char *const old = malloc(strlen(j->path) + sizeof(".old"));

    if (!old) {
        die(EXIT_FAILED, "%s: out of memory", j->path);
    }
    sprintf(old, "%s.old", j->path);
    if (rename(j->path, old) != 0) {
        die(EXIT_FAILED, "%s: could not be renamed to %s: %s", j->path, old, strerror(errno));
    }
    j->fd = open_locked(j->path);
    close(earlier);
    fprintf(stderr, "kelly: %s: %lld records of an earlier kelly %.16s, now in %s; this run begins anew, with --resume it would have gone on from them\n",
            j->path, count, sound ? (const char *)have + AT_KIND : "run", old);
    free(old);
}

/* Begin a file that is empty, holds the beginning of a header (torn in its first write), or a journal to be set aside. */
static void begin(journal *j, const uint8_t *have, size_t length, const uint8_t want[HEADER], int resume)
{
    const size_t magic = length < 8 ? length : 8;

    if (memcmp(have, MAGIC, magic) != 0) {
        die(EXIT_USAGE, "%s: not a journal of kelly; move it away", j->path);
    }
    if (length == HEADER && file_size(j) > HEADER) {
        set_aside(j, have);
    } else if (resume && length > 0) {
        fprintf(stderr, "kelly: %s: dropped a torn header of %zu bytes\n", j->path, length);
    } else if (resume) {
        fprintf(stderr, "kelly: %s: not there, or empty; this run starts from its beginning\n", j->path);
    }
    cut_to(j, 0);
    write_all(j, want, HEADER);
}

void journal_open(journal *j, const char *output, const journal_run *run, int resume)
{
    uint8_t have[HEADER], want[HEADER];
    size_t length;

    *j = (journal){ .payload = run->payload, .records = run->records, .in_order = run->in_order, .sound = run->sound, .path = malloc(strlen(output) + sizeof(".journal")) };
    if (!j->path) {
        die(EXIT_FAILED, "%s: out of memory", output);
    }
    sprintf(j->path, "%s.journal", output);
    j->fd = open_locked(j->path);
    make_header(want, run);
    length = read_header(j, have);
    if (resume && length == HEADER) {
        resume_from(j, have, want);
    } else {
        begin(j, have, length, want, resume);
    }
    sync_now(j);
    journals_open(1);
}

static uint32_t record_crc(const uint8_t number[4], const uint8_t *payload, size_t size)
{
    return kelly_crc32c(kelly_crc32c(0, number, 4), payload, size);
}

/* Nothing sound is left: cut off what is there. A read error is no end of what is sound. */
static void end_of_earlier(journal *j)
{
    const off_t size = file_size(j), end = HEADER + (off_t)j->next * (j->payload + 8);

    if (ferror(j->earlier)) {
        die(EXIT_FAILED, "%s: cannot be read: %s", j->path, strerror(errno));
    }
    (void)fclose(j->earlier);
    j->earlier = 0;
    if (end < size) {
        fprintf(stderr, "kelly: %s: dropped %lld bytes, from a record on that is torn or cannot be\n", j->path, (long long)(size - end));
        cut_to(j, end);
    }
    fprintf(stderr, "kelly: %s: goes on from %lu record%s\n", j->path, (unsigned long)j->next, j->next == 1 ? "" : "s");
}

int journal_next(journal *j, uint32_t *index, void *payload)
{
    uint8_t number[4], crc[4];

    if (!j->earlier) {
        return 0;
    }
    if (fread(number, 4, 1, j->earlier) != 1 || fread(payload, j->payload, 1, j->earlier) != 1 || fread(crc, 4, 1, j->earlier) != 1 ||
        get_u32(crc) != record_crc(number, payload, j->payload) || get_u32(number) >= j->records ||
        (j->in_order && get_u32(number) != j->next) || (j->sound && !j->sound(payload, j->payload))) {
        end_of_earlier(j);
        return 0;
    }
    *index = get_u32(number);
    j->next++;
    return 1;
}

/* Bytes on their way to the file. */
typedef struct {
    uint8_t bytes[TOGETHER];
    size_t used;
} chunk;

static void flush(const journal *j, chunk *c)
{
    write_all(j, c->bytes, c->used);
    c->used = 0;
}

static void add(const journal *j, chunk *c, const uint8_t *bytes, size_t count)
{
    while (count > 0) {
        const size_t room = TOGETHER - c->used, part = count < room ? count : room;

        memcpy(c->bytes + c->used, bytes, part);
        c->used += part;
        bytes += part;
        count -= part;
        if (c->used == TOGETHER) {
            flush(j, c);
        }
    }
}

void journal_append(journal *j, uint32_t first, uint32_t count, const void *payloads)
{
    const uint8_t *payload = payloads;
    chunk c;

    c.used = 0;
    for (uint32_t i = 0; i < count; i++, payload += j->payload) {
        uint8_t number[4], crc[4];

        put_u32(number, first + i);
        put_u32(crc, record_crc(number, payload, j->payload));
        add(j, &c, number, sizeof(number));
        add(j, &c, payload, j->payload);
        add(j, &c, crc, sizeof(crc));
    }
    flush(j, &c);
    j->next += count;
    if (now() - j->synced > SYNC_EVERY) {
        sync_now(j);
    }
}

void journal_remove(journal *j)
{
    if (!j->path) {
        return;
    }
    if (j->earlier) {      /* nothing was missing */
        end_of_earlier(j);
    }
    if (unlink(j->path) != 0) {
        die(EXIT_FAILED, "%s: could not be removed: %s", j->path, strerror(errno));
    }
    close(j->fd);
    journals_open(-1);
    free(j->path);
    *j = (journal){ .fd = -1 };
}
