/* fuzz_journal.c - the journal of an earlier run (host/journal.c), behind its CRCs.
 *
 * The first byte: 1 put the right CRC into the header, 2 into every whole record, 4 begin with the right header, 8 indices must come in
 * order. What is resumed hands out records of this run alone, leaves a journal that ends with the last of them, and gives the same ones
 * when it is opened again.
 */
#include "caught.h"

#include <unistd.h>

#define fdatasync(fd) (0)        /* no disk is tried here */
#include "../../host/journal.c"

#define PAYLOAD 12u
#define RECORD (PAYLOAD + 8u)
#define RECORDS 1000u
#define MOST 4096u

static journal_run run = { .kind = "map", .model = "paper-4c51472e", .seed = 1, .parameters = 0x1234u, .records = RECORDS, .payload = PAYLOAD };
static uint32_t seen, sum;

static void open_and_read(journal *j, const char *output, int resume)
{
    uint8_t payload[PAYLOAD];
    uint32_t index;

    journal_open(j, output, &run, resume);
    while (journal_next(j, &index, payload)) {
        must(index < RECORDS && (!run.in_order || index == seen));
        seen++;
        must(j->next == seen);
        sum = kelly_crc32c(sum ^ index, payload, PAYLOAD);
    }
}

/* -> how it ended. */
static int open_again(const char *output, journal *j, int resume)
{
    int status;

    seen = sum = 0;
    *j = (journal){ .fd = -1 };
    CATCH(status, open_and_read(j, output, resume));
    return status;
}

static void close_it(journal *j)
{
    if (j->earlier) {
        fclose(j->earlier);
        j->earlier = 0;
    }
    if (j->fd > 2) {
        close(j->fd);
    }
    caught_clear();
}

static size_t prepare(uint8_t file[MOST], unsigned what, const uint8_t *data, size_t size)
{
    memcpy(file, data, size);
    if (what & 4 && size + HEADER <= MOST) {
        memmove(file + HEADER, file, size);
        make_header(file, &run);
        size += HEADER;
    }
    if (what & 1 && size >= HEADER) {
        put_u32(file + AT_CRC, kelly_crc32c(0, file, AT_CRC));
    }
    for (size_t at = HEADER; what & 2 && at + RECORD <= size; at += RECORD) {
        put_u32(file + at + RECORD - 4, kelly_crc32c(0, file + at, RECORD - 4));
    }
    return size;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static uint8_t file[MOST];
    char output[128];
    journal j;
    uint32_t before, digest;
    size_t length;

    if (size == 0 || size > MOST) {
        return 0;
    }
    run.in_order = data[0] >> 3 & 1;
    length = prepare(file, data[0], data + 1, size - 1);
    strcpy(output, caught_file(".journal", file, length));
    *strrchr(output, '.') = '\0';
    if (open_again(output, &j, 1) == 0) {
        must(file_size(&j) == (off_t)(HEADER + seen * RECORD));
        before = seen;
        digest = sum;
        close_it(&j);
        must(open_again(output, &j, 1) == 0 && seen == before && sum == digest);
        close_it(&j);
        must(open_again(output, &j, 0) == 0 && seen == 0 && file_size(&j) == HEADER);   /* afresh */
    }
    close_it(&j);
    return 0;
}
