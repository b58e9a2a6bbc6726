/* fuzz_options.c - the command line (host/options.c, drive.c, grid.c, until.c, envelope.c's options): parsed, nothing run.
 *
 * The first byte chooses what the command takes, the rest are its arguments, ended by line feeds. What is accepted can be run: the kernel
 * accepts the case, times are whole steps, and indices do not run over.
 */
#include "caught.h"

#include "../../host/map.h"

#include "../../host/drive.c"
#include "../../host/grid.c"
#include "../../host/options.c"

#define ARGUMENTS 64

static const command_help fuzz_help = { .takes = TAKES_CASE | TAKES_ENSEMBLE | TAKES_JSON, .own = envelope_options, .also = until_options };
const subcommand commands[] = { { "fuzz", 0, &fuzz_help, 0 } };   /* whose options a misspelt one is held against */
const unsigned command_count = 1;

static until_request until;
static envelope_request envelope;

static int own(void *context, const char *name, const char *value)
{
    (void)context;
    return until_option(&until, name, value) || envelope_option(&envelope, name, value);
}

/* decimal() against what its comment says it is. */
static void as_typed(double x)
{
    char text[40];

    snprintf(text, sizeof(text), "%.12g", x);
    must(decimal(x) == strtod(text, 0));
}

static void axes(int argc, char **argv)
{
    const char *const text = take_option(&argc, argv, "--rpm");
    axis a;

    if (text) {
        a = axis_parse("--rpm", text, 1, 10000, "rpm");
        must(a.count >= 1);
        for (uint32_t i = 0; i < a.count; i++) {
            must(a.at[i] >= 1 && a.at[i] <= 10000 && (i == 0 || a.at[i] > a.at[i - 1]));
        }
        as_typed(a.at[a.count / 2] / 3);
        as_typed(a.at[a.count - 1] * 1.0000000000005);
    }
}

static void parse(int argc, char **argv, unsigned takes)
{
    options opts;

    options_parse(&opts, argc, argv, takes, "fuzz", own, 0);
    check_indices(&opts);
    must(kelly_case_error(&kelly_string, &opts.run) == 0);
    must((uint64_t)opts.first + opts.samples <= (uint64_t)UINT32_MAX + 1 && opts.samples >= 1);
    must(opts.out_step > 0 && opts.out_ticks >= 1);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static const unsigned takes[] = { TAKES_CASE | TAKES_ENSEMBLE | TAKES_JSON, TAKES_CASE | TAKES_SIMULATE, TAKES_JSON, TAKES_CASE | TAKES_BENCH };
    char text[1200], *argv[ARGUMENTS + 1];
    int argc = 0, status;

    if (size < 2 || size > 1024) {
        return 0;
    }
    memcpy(text, data + 1, size - 1);
    text[size - 1] = '\0';
    for (char *rest = text, *one; argc < ARGUMENTS && (one = strsep(&rest, "\n")) != 0;) {
        argv[argc++] = one;
    }
    argv[argc] = 0;
    memset(&until, 0, sizeof(until));
    memset(&envelope, 0, sizeof(envelope));
    if (data[0] % 5 == 4) {
        CATCH(status, axes(argc, argv));
    } else {
        CATCH(status, parse(argc, argv, takes[data[0] % 5]));
    }
    must(status != EXIT_FAILED);
    caught_clear();
    return 0;
}
