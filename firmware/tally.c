#include "tally.h"

#include "link/crc32c.h"

/* Bytes of a real, least significant first, whatever the byte order of the machine. */
static unsigned put_real(uint8_t *to, real x)
{
#ifdef KELLY_DOUBLE
    const union { real x; uint64_t bits; } u = { .x = x };
#else
    const union { real x; uint32_t bits; } u = { .x = x };
#endif
    for (unsigned k = 0; k < sizeof(real); k++) {
        to[k] = (uint8_t)(u.bits >> (8 * k));
    }
    return sizeof(real);
}

static uint32_t digest(uint32_t crc, uint32_t index, const kelly_result *result)
{
    const real values[] = { result->draw.fc, result->draw.mu, result->draw.a1, result->draw.a2, result->draw.w0,
                            result->lowest, result->highest, result->mean, result->ss };
    uint8_t record[4 + sizeof(values) + 1];
    unsigned n = 0;

    for (; n < 4; n++) {
        record[n] = (uint8_t)(index >> (8 * n));
    }
    for (unsigned k = 0; k < sizeof(values) / sizeof(values[0]); k++) {
        n += put_real(&record[n], values[k]);
    }
    record[n++] = result->status;
    return kelly_crc32c(crc, record, n);
}

void kelly_tally_add(kelly_tally *tally, uint32_t index, const kelly_result *result)
{
    tally->samples++;
    tally->stuck += result->stuck;
    tally->liftoff += result->liftoff;
    tally->status[result->status]++;
    tally->digest = digest(tally->digest, index, result);
}

uint32_t kelly_refused(const kelly_tally *tally)
{
    return tally->status[KELLY_STEP] + tally->status[KELLY_RANGE] + tally->status[KELLY_NONFINITE] + tally->status[KELLY_CORRUPT];
}

wide kelly_probability(const kelly_tally *tally)
{
    const uint32_t counted = tally->samples - kelly_refused(tally);

    return counted > 0 ? (wide)tally->stuck / (wide)counted : 0;
}
