/* test_messages.c - bodies of messages: layout, what is refused, reals that keep their bits. */
#include "../firmware/link/frame.h"
#include "../firmware/link/keys.h"
#include "../firmware/link/messages.h"
#include "check.h"
#include "fixture.h"

static int same(const uint8_t *a, const uint8_t *b, size_t n)
{
    for (size_t i = 0; i < n; i++) {
        if (a[i] != b[i]) {
            return 0;
        }
    }
    return 1;
}

static void hello_has_its_layout(void)
{
    static const uint8_t want[] = { 0x44, 0x33, 0x22, 0x11, 8, 7, 6, 5 };
    const kelly_msg_hello hello = { .schema = 0x11223344u, .nonce = 0x05060708u };
    kelly_msg_hello got;
    uint8_t body[KELLY_HELLO_MAX];

    EQUAL(kelly_put_hello(body, &hello), 8);                /* frozen for ever: see gen/protocol.py */
    CHECK(same(body, want, 8));
    EQUAL(KELLY_MSG_HELLO, 1);
    EQUAL(KELLY_MSG_HELLO_REPLY, 2);
    CHECK(kelly_get_hello(body, 8, &got));
    EQUAL(got.schema, hello.schema);
    EQUAL(got.nonce, hello.nonce);
}

/* One of each kind, every byte written down. */
static void kinds_have_their_layout(void)
{
    static const uint8_t want_run[] = { 4, 3, 2, 1, 0x18, 0x17, 0x16, 0x15, 0x14, 0x13, 0x12, 0x11, 5, 0, 0, 0, 0xff, 0xff, 0xff, 0x7f };
    static const uint8_t want_error[] = { 3, 20, 2, 0, 'h', 'i' };
    static const uint8_t want_sample[] = { 0, 0, 0, 0, 0xf8, 0xbf, 0xff, 0xfe };
    const kelly_msg_run run = { .case_crc = 0x01020304u, .seed = 0x1112131415161718u, .first = 5, .count = 0x7fffffffu };
    const kelly_msg_error error = { .code = KELLY_ERR_BODY, .of_type = KELLY_MSG_WITS, .text = "hi" };
    const kelly_msg_rt_sample sample = { .top_speed = R(-1.5), .load_permille = 0xfeffu };
    const kelly_msg_case_set set = { .cov0 = 0.5f };
    uint8_t body[KELLY_BODY_MAX];

    EQUAL(kelly_put_run(body, &run), sizeof(want_run));
    CHECK(same(body, want_run, sizeof(want_run)));
    EQUAL(kelly_put_error(body, &error), sizeof(want_error));
    CHECK(same(body, want_error, sizeof(want_error)));
    EQUAL(kelly_put_rt_sample(body, &sample), KELLY_RT_SAMPLE_MAX);
    CHECK(same(body + 52, want_sample + 2, 4));             /* 4 + 4 + 5 reals before the top's speed, its last bytes */
    CHECK(same(body + 64, want_sample + 6, 2));             /* u16 between two u32 and a u8 */
    EQUAL(kelly_put_case_set(body, &set), KELLY_CASE_SET_MAX);
    CHECK(same(body + 48, (const uint8_t[]){ 0, 0, 0, 0x3f }, 4));
}

/* Every u8 is 1, every number some number, every text full: what is put is what was got, and no other size will do. */
#define FILL(memory) \
    for (size_t fill = 0; fill < sizeof(memory); fill++) { \
        ((unsigned char *)&(memory))[fill] = 1; \
    }
#define COMES_BACK(name, most, prepare) \
    static void name##_comes_back(void) \
    { \
        kelly_msg_##name out, in; \
        uint8_t body[KELLY_BODY_MAX + 1], again[KELLY_BODY_MAX + 1]; \
        size_t size; \
        FILL(out) \
        FILL(in) \
        prepare; \
        size = kelly_put_##name(body, &out); \
        EQUAL(size, most); \
        CHECK(size <= KELLY_BODY_MAX); \
        CHECK(kelly_get_##name(body, size, &in)); \
        EQUAL(kelly_put_##name(again, &in), size); \
        CHECK(same(body, again, size)); \
        body[size] = 0; \
        CHECK(!kelly_get_##name(body, size + 1, &in)); \
        for (size_t cut = 0; cut < size; cut++) { \
            CHECK(!kelly_get_##name(body, cut, &in)); \
        } \
    }

COMES_BACK(hello, KELLY_HELLO_MAX, (void)0)
COMES_BACK(hello_reply, KELLY_HELLO_REPLY_MAX, (void)0)
COMES_BACK(error, KELLY_ERROR_MAX, (void)0)
COMES_BACK(case_set, KELLY_CASE_SET_MAX, (void)0)
COMES_BACK(case_reply, KELLY_CASE_REPLY_MAX, (void)0)
COMES_BACK(run, KELLY_RUN_MAX, (void)0)
COMES_BACK(result, KELLY_RESULT_MAX, (void)0)
COMES_BACK(status, KELLY_STATUS_MAX, (void)0)
COMES_BACK(stop, KELLY_STOP_MAX, (void)0)
COMES_BACK(plant_start, KELLY_PLANT_START_MAX, out.mode = KELLY_MODE_REALTIME)
COMES_BACK(plant_reply, KELLY_PLANT_REPLY_MAX, (void)0)
COMES_BACK(lock_step, KELLY_LOCK_STEP_MAX, (void)0)
COMES_BACK(lock_answer, KELLY_LOCK_ANSWER_MAX, (void)0)
COMES_BACK(rt_command, KELLY_RT_COMMAND_MAX, (void)0)
COMES_BACK(rt_ack, KELLY_RT_ACK_MAX, (void)0)
COMES_BACK(rt_sample, KELLY_RT_SAMPLE_MAX, (void)0)
COMES_BACK(rt_query, KELLY_RT_QUERY_MAX, (void)0)
COMES_BACK(rt_report, KELLY_RT_REPORT_MAX, (void)0)
COMES_BACK(wits_query, KELLY_WITS_QUERY_MAX, (void)0)
COMES_BACK(wits, KELLY_WITS_MAX, (void)0)

static void every_message_comes_back(void)
{
    static void (*const all[])(void) = {
        hello_comes_back, hello_reply_comes_back, error_comes_back, case_set_comes_back, case_reply_comes_back, run_comes_back,
        result_comes_back, status_comes_back, stop_comes_back, plant_start_comes_back, plant_reply_comes_back, lock_step_comes_back,
        lock_answer_comes_back, rt_command_comes_back, rt_ack_comes_back, rt_sample_comes_back, rt_query_comes_back,
        rt_report_comes_back, wits_query_comes_back, wits_comes_back,
    };

    EQUAL(sizeof(all) / sizeof(all[0]), KELLY_MSG_WITS);    /* one for each */
    for (size_t k = 0; k < sizeof(all) / sizeof(all[0]); k++) {
        all[k]();
    }
}

static void values_have_their_ranges(void)
{
    kelly_msg_plant_start start = { .mode = KELLY_MODE_LOCKSTEP };
    kelly_msg_error error;
    uint8_t body[KELLY_PLANT_START_MAX];
    const uint8_t no_code[] = { 0, 1, 0, 0 }, last_code[] = { 8, 1, 0, 0 }, over[] = { 9, 1, 0, 0 };

    for (unsigned mode = 0; mode < 256; mode++) {
        start.mode = (uint8_t)mode;
        (void)kelly_put_plant_start(body, &start);
        EQUAL(kelly_get_plant_start(body, sizeof(body), &start), mode == KELLY_MODE_LOCKSTEP || mode == KELLY_MODE_REALTIME);
    }
    CHECK(!kelly_get_error(no_code, 4, &error));
    CHECK(kelly_get_error(last_code, 4, &error));
    CHECK(!kelly_get_error(over, 4, &error));
}

static void texts_have_their_characters(void)
{
    kelly_msg_error error = { .code = 1 };
    uint8_t body[KELLY_ERROR_MAX + 8] = { 1, 1, 2, 0, 'o', 'k' };
    char text[4];

    CHECK(kelly_get_error(body, 6, &error));
    EQUAL(error.text[2], 0);
    for (unsigned c = 0; c < 256; c++) {
        body[5] = (uint8_t)c;
        EQUAL(kelly_get_error(body, 6, &error), (c >= 32 && c < 127) || c == 10 || c == 13);
    }
    for (unsigned k = 4; k < sizeof(body); k++) {
        body[k] = 'x';
    }
    body[2] = 80;
    CHECK(kelly_get_error(body, 84, &error));
    body[2] = 81;
    CHECK(!kelly_get_error(body, 85, &error));              /* longer than the text may be */
    body[2] = 80;
    body[3] = 1;
    CHECK(!kelly_get_error(body, 84, &error));
    error.text[0] = '\t';
    EQUAL(kelly_put_error(body, &error), 84);
    EQUAL(body[4], '?');
    kelly_set_text(text, sizeof(text), "abcdef");
    CHECK(same((const uint8_t *)text, (const uint8_t *)"abc", 4));
    kelly_set_text(text, sizeof(text), "");
    EQUAL(text[0], 0);
}

/* ---- numbers ---- */

static const kelly_field one_real = { 0, KELLY_FIELD_REAL }, one_float = { 0, KELLY_FIELD_F32 };

/* Whether these bits of a double are taken; if so they must come back. */
static int takes(uint64_t bits)
{
    uint8_t body[8], again[8];
    real value;

    for (unsigned k = 0; k < 8; k++) {
        body[k] = (uint8_t)(bits >> (8 * k));
    }
    if (!kelly_get_fields(body, 8, &value, &one_real, 1)) {
        return 0;
    }
    EQUAL(kelly_put_fields(again, &value, &one_real, 1), 8);
    CHECK(same(body, again, 8));
    return 1;
}

static void reals_keep_their_bits(void)
{
    static const uint64_t floats[] = {                      /* what is exactly a float, and its negative */
        0x0000000000000000u, 0x3ff0000000000000u, 0x3ff0000020000000u, 0x400921fb60000000u, 0x47efffffe0000000u,
        0x3810000000000000u, 0x380fffffc0000000u, 0x3800000000000000u, 0x36a0000000000000u, 0x36b8000000000000u,
    };
    static const uint64_t doubles[] = {                     /* 0.1, 1 + 2^-24, 2^128, 2^-150, 3 2^-150, largest, smallest */
        0x3fb999999999999au, 0x3ff0000010000000u, 0x47f0000000000000u, 0x3690000000000000u, 0x36a8000000000000u,
        0x7fefffffffffffffu, 0x0000000000000001u, 0x3ff0000000000001u, 0x380fffffe0000000u, 0x0010000000000000u,
    };
    static const uint64_t none[] = { 0x7ff0000000000000u, 0x7ff8000000000000u, 0x7ff0000000000001u, 0x7fffffffe0000000u };

    for (unsigned k = 0; k < 10; k++) {
        CHECK(takes(floats[k]));
        CHECK(takes(floats[k] | 1ull << 63));
        EQUAL(takes(doubles[k]), sizeof(real) == 8);
        EQUAL(takes(doubles[k] | 1ull << 63), sizeof(real) == 8);
    }
    for (unsigned k = 0; k < 4; k++) {
        CHECK(!takes(none[k]));
        CHECK(!takes(none[k] | 1ull << 63));
    }
}

/* Every exponent of a float, some fractions each: widened, they are doubles that narrow back. */
static void floats_widen_exactly(void)
{
    unsigned wrong = 0;

    for (uint32_t high = 0; high < 0x10000u; high += BY_LENGTH(37u, 1u)) {
        const union { uint32_t bits; float value; } f = { high << 16 | (high * 2654435761u) >> 16 };
        const real value = (real)f.value;
        uint8_t body[8];
        real got;

        (void)kelly_put_fields(body, &value, &one_real, 1);
        if ((f.bits >> 23 & 255u) == 255u) {
            wrong += kelly_get_fields(body, 8, &got, &one_real, 1) != 0;
            continue;
        }
        wrong += !kelly_get_fields(body, 8, &got, &one_real, 1) || !(got == value);
#if __STDC_HOSTED__
        const union { double value; uint8_t bytes[8]; } d = { (double)f.value };   /* this machine's own widening */

        wrong += !same(d.bytes, body, 8);
#endif
    }
    EQUAL(wrong, 0);
}

static void floats_are_finite(void)
{
    uint8_t body[4] = { 0, 0, 0x80, 0x7f };
    float value;

    CHECK(!kelly_get_fields(body, 4, &value, &one_float, 1));
    body[0] = 1;
    CHECK(!kelly_get_fields(body, 4, &value, &one_float, 1));
    body[2] = 0x7f;
    CHECK(kelly_get_fields(body, 4, &value, &one_float, 1));
    EQUAL(kelly_put_fields(body, &value, &one_float, 1), 4);
    EQUAL(body[0], 1);
}

/* The numbers are those of host/link_codec.py, and the same in float and in double. */
static void keys_have_their_known_answers(void)
{
    const kelly_draw draw = { .fc = R(100000.0), .mu = R(0.0400390625), .a1 = R(2.0), .a2 = R(1.0), .w0 = R(10.5) };
    const kelly_msg_case_set set = { .fc = R(100000.0), .mu = R(0.0400390625), .cov4 = 0.25f, .ticks = 100000, .rotating = 1 };

    EQUAL(kelly_draw_key(&draw), 0x4a66357bu);
    EQUAL(kelly_job_key(0x11223344u, 0x0102030405060708u), 0x76ec82abu);
    EQUAL(kelly_case_key(&set), 0x77c77c45u);
}

void test_messages(void);
void test_messages(void)
{
    hello_has_its_layout();
    kinds_have_their_layout();
    every_message_comes_back();
    values_have_their_ranges();
    texts_have_their_characters();
    reals_keep_their_bits();
    floats_widen_exactly();
    floats_are_finite();
    keys_have_their_known_answers();
}
