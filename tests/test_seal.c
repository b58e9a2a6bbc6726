/* test_seal.c - the sum over what must not change: its value, its continuation, and that no bit can change unseen. */
#include "../firmware/seal.h"
#include "check.h"

typedef struct {
    uint32_t before, first, middle, last, after;
} members;

static void is_a_polynomial_of_the_words(void)
{
    static const uint8_t bytes[12] = { 0x01, 0x02, 0x03, 0x84, 0xff, 0xff, 0xff, 0xff, 0x05, 0x00, 0x00, 0x00 };
    uint32_t want = 0x84030201u;

    EQUAL(kelly_seal(0, bytes, 0), 0);
    EQUAL(kelly_seal(77, bytes, 0), 77);
    EQUAL(kelly_seal(0, bytes, 4), want);
    want = want * 16777619u + 0xffffffffu;
    EQUAL(kelly_seal(0, bytes, 8), want);
    EQUAL(kelly_seal(0, bytes, 12), want * 16777619u + 5u);
    EQUAL(kelly_seal(kelly_seal(0, bytes, 4), bytes + 4, 8), kelly_seal(0, bytes, 12));
}

static void sees_every_bit(void)
{
    uint8_t bytes[64] = { 3, 1, 4, 1, 5, 9, 2, 6 };
    const uint32_t good = kelly_seal(0, bytes, sizeof(bytes));
    unsigned seen = 0;

    for (unsigned bit = 0; bit < 8 * sizeof(bytes); bit++) {
        bytes[bit / 8] ^= (uint8_t)(1u << bit % 8);
        seen += kelly_seal(0, bytes, sizeof(bytes)) != good;
        bytes[bit / 8] ^= (uint8_t)(1u << bit % 8);
    }
    EQUAL(seen, 8 * sizeof(bytes));
}

static void covers_the_members_named(void)
{
    members of = { 1, 2, 3, 4, 5 };
    const uint32_t good = KELLY_SEAL_MEMBERS(9, &of, members, first, last);

    EQUAL(good, kelly_seal(9, &of.first, 12));
    of.before = of.after = 0;
    EQUAL(KELLY_SEAL_MEMBERS(9, &of, members, first, last), good);
    of.last = 5;
    CHECK(KELLY_SEAL_MEMBERS(9, &of, members, first, last) != good);
}

void test_seal(void);
void test_seal(void)
{
    is_a_polynomial_of_the_words();
    sees_every_bit();
    covers_the_members_named();
}
