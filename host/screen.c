/* screen.c - what is for eyes, or for a program that watches: colour, progress. All of it may be lost without loss of a result. */
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "host.h"

/* An escape sequence ("1" bold, "0" plain, "31" red), or nothing where it does not belong: no terminal, NO_COLOR, a dumb one, or mpirun's,
 * which goes on to a file as it is. */
const char *ink(FILE *to, const char *code)
{
    static const char *const sequences[][2] = { { "0", "\033[0m" }, { "1", "\033[1m" }, { "31", "\033[1;31m" }, { "32", "\033[1;32m" },
                                                { "33", "\033[1;33m" } };
    const char *const no = getenv("NO_COLOR"), *const term = getenv("TERM");

    if ((no && *no) || !term || strcmp(term, "dumb") == 0 || getenv("OMPI_COMM_WORLD_RANK") || !isatty(fileno(to))) {
        return "";
    }
    for (size_t i = 0; i < sizeof(sequences) / sizeof(sequences[0]); i++) {
        if (strcmp(sequences[i][0], code) == 0) {
            return sequences[i][1];
        }
    }
    return "";
}

int progress_wanted(const options *opts)
{
    return opts->progress == PROGRESS_JSON || (opts->progress == PROGRESS_AUTO && !opts->quiet && isatty(STDERR_FILENO));
}

/* "12345 of 1000000 (1.2 %), 190000/s, 5 s left" on a terminal; the same as an object where a program reads it. */
void progress_show(const options *opts, uint64_t done, uint64_t total, double seconds)
{
    const double rate = (double)done / (seconds > 1e-3 ? seconds : 1e-3);
    const double left = done > 0 ? (double)(total - done) / rate : 0;

    if (opts->progress == PROGRESS_JSON) {
        fprintf(stderr, "{\"done\": %llu, \"total\": %llu, \"per_s\": %.1f, \"elapsed_s\": %.3f, \"left_s\": %.3f}\n", (unsigned long long)done,
                (unsigned long long)total, rate, seconds, left);
    } else if (done > 0) {
        fprintf(stderr, "\r%llu of %llu (%.1f %%), %.0f/s, %.0f s left   ", (unsigned long long)done, (unsigned long long)total,
                100.0 * (double)done / (double)total, rate, left);
    }
}

/* All done: an object more, or a clean line. */
void progress_end(const options *opts, uint64_t total, double seconds)
{
    if (opts->progress == PROGRESS_JSON) {
        progress_show(opts, total, total, seconds);
    } else {
        fprintf(stderr, "\r%70s\r", "");
    }
}
