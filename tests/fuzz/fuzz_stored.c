/* fuzz_stored.c - the files of an earlier run: the JSON, and the CSV line by line (host/stored.c, stored_rows.c, json_read.c).
 *
 * The first byte says which, and whether it is read as a part that is to be put together with others: with the CRC that it should have at
 * its end ('p'), or as it is ('c'). One that is accepted has rows within their ranges.
 */
#include "caught.h"

const subcommand commands[1];        /* of host/help.c, which is not asked here */
const unsigned command_count = 0;

/* The line buffer belongs to the reader, which frees it at the end only: kept by hand. */
static char *line_buffer;

static ssize_t fuzz_getdelim(char **text, size_t *room, int end, FILE *from)
{
    const ssize_t n = getdelim(text, room, end, from);

    if (n >= 0 || *text) {
        caught_keep(*text);
    }
    return n;
}

static ssize_t fuzz_getline(char **text, size_t *room, FILE *from)
{
    const ssize_t n = getline(text, room, from);

    if (line_buffer) {   /* moved or not: the list holds what is there now */
        for (unsigned i = 0; i < caught_count; i++) {
            if (caught_blocks[i] == (void *)line_buffer) {
                caught_blocks[i] = caught_blocks[--caught_count];
                break;
            }
        }
    }
    line_buffer = *text ? caught_keep(*text) : 0;
    return n;
}

#define getline fuzz_getline
#define getdelim fuzz_getdelim
#include "../../host/stored.c"
#include "../../host/stored_rows.c"

static void read_run(const char *path)
{
    stored_run run;

    stored_open_run(&run, path);
    must(run.samples >= 1 && run.run.limit >= 0 && run.run.limit <= R(10.0) && strlen(run.model) < sizeof(run.model));
    for (unsigned k = 0; k < KELLY_PARAMETERS; k++) {
        must(run.run.cov[k] >= 0 && run.run.cov[k] <= 0.5f);
    }
    must(run.run.fc > 0 && run.run.mu > 0 && run.run.a1 > 0 && run.run.a2 > 0 && run.run.w0 > 0);
}

static void read_part(const char *path)
{
    static stored_part part;

    stored_open_part(&part, path);
    must(part.of.samples >= 1 && kelly_refused(&part.tally) <= part.tally.samples && part.refused_listed <= LISTED);
    must(part.tally.stuck <= part.tally.samples - kelly_refused(&part.tally) && part.tally.liftoff <= part.tally.samples);
    must(part.stuck_ssi <= part.tally.samples - kelly_refused(&part.tally));
    must(memchr(part.case_text, 0, sizeof(part.case_text)) && memchr(part.engine, 0, sizeof(part.engine)));
    for (uint32_t i = 0; i < part.refused_listed; i++) {
        must(part.refused_why[i] > KELLY_OK && part.refused_why[i] < KELLY_STATUSES);
    }
}

/* The report with the right CRC in place of its last brace. */
static const char *sealed(const uint8_t *data, size_t size)
{
    static char text[1 << 16];
    size_t n = size;

    while (n > 0 && data[n - 1] != '}') {
        n--;
    }
    if (n == 0 || n + 64 > sizeof(text)) {
        return caught_file(".json", data, size);
    }
    memcpy(text, data, n);
    strcpy(text + n - 1, ",\n");
    n++;
    n += (size_t)sprintf(text + n, OUTCOME_END, kelly_crc32c(0, (const uint8_t *)text, n));
    return caught_file(".json", (const uint8_t *)text, n);
}

static void read_rows(const char *path)
{
    stored_run run = { .path = (char *)(uintptr_t)"x.json", .run = kelly_string.nominal, .seed = 1, .samples = 100 };
    stored_rows rows;
    stored_row row;
    uint32_t place = 0;

    stored_open_rows(&rows, path);
    while (stored_next(&rows, &row)) {
        must(row.status < KELLY_STATUSES && row.stuck <= 1 && row.liftoff <= 1 && !(row.status != KELLY_OK && row.stuck));
        must(row.ss >= 0 && row.ss <= 1e30);
        for (unsigned k = 0; k < KELLY_PARAMETERS; k++) {
            must(row.y[k] > 0 && row.y[k] < 1e34);
        }
        stored_check(&rows, &run, place++, &row);
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    int status;

    if (size == 0) {
        return 0;
    }
    line_buffer = 0;
    if (data[0] == 'r') {
        CATCH(status, read_rows(caught_file(".csv", data + 1, size - 1)));
    } else if (data[0] == 'p') {
        CATCH(status, read_part(sealed(data + 1, size - 1)));
    } else if (data[0] == 'c') {
        CATCH(status, read_part(caught_file(".json", data + 1, size - 1)));
    } else {
        CATCH(status, read_run(caught_file(".json", data + 1, size - 1)));
    }
    must(status != EXIT_FAILED);   /* the file can be read: what is wrong is the user's */
    caught_clear();
    return 0;
}
