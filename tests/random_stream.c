/* random_stream.c - what firmware/random.h makes, as raw bytes on stdout, for batteries of tests.
 *
 *     random_stream words|states|gamma [over=index|seed|draw] [streams=N] [each=K] [count=N] [seed=S] [first=J] [cov=D] [keys=plain]
 *
 * Stream k is that of index first + k; or of seed + k; or, over=draw, of parameter k % 5 of index first + k / 5, in the order in
 * which realisations take them. K values come from each of N streams in turn; streams=0: from ever new ones, which is how the
 * realisations use them. count=0 has no end. A value is a word (4 bytes), the four words of a state, or a gamma of mean 1 and
 * coefficient of variation cov as a float; in the byte order of the machine.
 *
 * keys=plain fills the state with the numbers of the key as they are: what the tests must find wanting.
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "../firmware/random.h"

#define STREAMS_MAX 4096u
#define PARAMETERS 5u

typedef struct {
    const char *what, *over;
    uint64_t streams, each, count, seed, first;
    float cov;
    int plain;
} request;

static void refuse(const char *word)
{
    fprintf(stderr, "random_stream: '%s' is not known; see the head of tests/random_stream.c\n", word);
    exit(2);
}

static void take(request *ask, const char *word)
{
    const char *const value = strchr(word, '=');
    const struct { const char *name; uint64_t *to; } numbers[] = {
        { "streams=", &ask->streams }, { "each=", &ask->each }, { "count=", &ask->count }, { "seed=", &ask->seed }, { "first=", &ask->first },
    };

    for (size_t k = 0; k < sizeof(numbers) / sizeof(numbers[0]); k++) {
        if (strncmp(word, numbers[k].name, strlen(numbers[k].name)) == 0) {
            *numbers[k].to = strtoull(value + 1, 0, 10);
            return;
        }
    }
    if (strncmp(word, "over=", 5) == 0) {
        ask->over = value + 1;
    } else if (strncmp(word, "cov=", 4) == 0) {
        ask->cov = strtof(value + 1, 0);
    } else if (strcmp(word, "keys=plain") == 0) {
        ask->plain = 1;
    } else {
        refuse(word);
    }
}

static void key(const request *ask, uint64_t k, kelly_rng *rng)
{
    const int draws = ask->over[0] == 'd', seeds = ask->over[0] == 's';
    const uint64_t seed = ask->seed + (seeds ? k : 0), index = ask->first + (draws ? k / PARAMETERS : seeds ? 0 : k);
    const uint32_t parameter = draws ? (uint32_t)(k % PARAMETERS) : 0;

    if (ask->plain) {
        *rng = (kelly_rng){{ (uint32_t)seed, (uint32_t)index, parameter, 1 }};
    } else {
        kelly_rng_key(rng, seed, (uint32_t)index, parameter);
    }
}

/* A buffer of our own: fwrite takes a lock for each word. */
static unsigned char buffer[1 << 16];
static size_t filled;

static void flush(void)
{
    if (fwrite(buffer, 1, filled, stdout) != filled || fflush(stdout) != 0) {
        exit(1);
    }
    filled = 0;
}

static void add(const void *value, size_t size)
{
    if (filled + size > sizeof(buffer)) {
        flush();
    }
    memcpy(buffer + filled, value, size);
    filled += size;
}

static void put(const request *ask, kelly_rng *rng)
{
    if (ask->what[0] == 's') {
        add(rng->s, sizeof(rng->s));
    } else if (ask->what[0] == 'w') {
        const uint32_t word = kelly_rng_next(rng);

        add(&word, sizeof(word));
    } else {
        const float draw = kelly_gamma(rng, 1.0f, ask->cov);

        add(&draw, sizeof(draw));
    }
}

int main(int argc, char **argv)
{
    static kelly_rng rng[STREAMS_MAX];
    request ask = { .what = argc > 1 ? argv[1] : "", .over = "index", .streams = 1, .each = 1, .seed = 1, .cov = 0.2f };
    uint64_t made = 0;

    if (strcmp(ask.what, "words") != 0 && strcmp(ask.what, "states") != 0 && strcmp(ask.what, "gamma") != 0) {
        refuse(ask.what);
    }
    for (int k = 2; k < argc; k++) {
        take(&ask, argv[k]);
    }
    if (ask.streams > STREAMS_MAX || ask.each == 0 || strchr("isd", ask.over[0]) == 0) {
        refuse("these numbers");
    }
    for (uint64_t k = 0; k < ask.streams; k++) {
        key(&ask, k, &rng[k]);
    }
    for (uint64_t k = 0; ; k++) {
        kelly_rng *const from = &rng[ask.streams ? k % ask.streams : 0];

        if (ask.streams == 0) {
            key(&ask, k, from);
        }
        for (uint64_t n = 0; n < ask.each; n++, made++) {
            if (ask.count > 0 && made == ask.count) {
                flush();
                return 0;
            }
            put(&ask, from);
        }
    }
}
