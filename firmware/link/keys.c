#include "keys.h"
#include "crc32c.h"

#define COUNT(fields) (sizeof(fields) / sizeof((fields)[0]))

uint32_t kelly_case_key(const kelly_msg_case_set *set)
{
    uint8_t body[KELLY_CASE_SET_MAX];

    return kelly_crc32c(0, body, kelly_put_case_set(body, set));
}

uint32_t kelly_job_key(uint32_t case_crc, uint64_t seed)
{
    uint8_t bytes[12];

    for (unsigned k = 0; k < 4; k++) {
        bytes[k] = (uint8_t)(case_crc >> (8 * k));
    }
    for (unsigned k = 0; k < 8; k++) {
        bytes[4 + k] = (uint8_t)(seed >> (8 * k));
    }
    return kelly_crc32c(0, bytes, sizeof(bytes));
}

uint32_t kelly_draw_key(const kelly_draw *draw)
{
    static const kelly_field fields[] = {
        { offsetof(kelly_draw, fc), KELLY_FIELD_REAL }, { offsetof(kelly_draw, mu), KELLY_FIELD_REAL },
        { offsetof(kelly_draw, a1), KELLY_FIELD_REAL }, { offsetof(kelly_draw, a2), KELLY_FIELD_REAL },
        { offsetof(kelly_draw, w0), KELLY_FIELD_REAL },
    };
    uint8_t bytes[8 * COUNT(fields)];

    return kelly_crc32c(0, bytes, kelly_put_fields(bytes, draw, fields, COUNT(fields)));
}
