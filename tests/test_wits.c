/* test_wits.c - the frame that a rig display reads. tests/wits.py reads it back by rules of its own. */
#include "../firmware/link/wits.h"
#include "check.h"
#include "fixture.h"

#define RPM R(0.10471975511965977)       /* one turn a minute [rad/s] */

static const kelly_wits all = {
    .known = KELLY_WITS_CLOCK | KELLY_WITS_DEPTH | KELLY_WITS_SURFACE | KELLY_WITS_BIT | KELLY_WITS_STUDY,
    .activity = 2, .date = 60103, .time = 5, .depth = R(1600.0),
    .wob_mean = R(100000.0), .wob_max = R(125000.0), .torque_mean = R(4250.0), .torque_max = R(9031.25), .top_speed = R(100.0) * RPM,
    .bit_wob_mean = R(99500.0), .bit_wob_max = R(150000.0), .bit_torque_mean = R(-12.5), .bit_torque_max = R(4000.0),
    .bit_lowest = R(-0.25) * RPM, .bit_highest = R(250.5) * RPM, .bit_mean = R(98.5) * RPM, .ss = R(1.002),
    .probability = R(0.984375), .samples = 4000000000u,
};

/* Equal texts; where they part is printed. */
static void reads(const kelly_wits *values, const char *want)
{
    char text[KELLY_WITS_TEXT + 1];
    const size_t n = kelly_wits_frame(text, sizeof(text), values);
    size_t at = 0;

    while (text[at] != '\0' && text[at] == want[at]) {
        at++;
    }
    EQUAL(text[at], want[at]);
    EQUAL(at, n);
}

static void frame_is_as_published(void)
{
    reads(&all, "&&\r\n0105060103\r\n0106000005\r\n01072\r\n01081600.00\r\n0113-9999\r\n011610.000\r\n011712.500\r\n01184.250\r\n"
                "01199.031\r\n0120100\r\n09159.950\r\n091615.000\r\n0917-0.013\r\n09184.000\r\n0921-0.25\r\n0922250.50\r\n"
                "092398.50\r\n09241.002\r\n0925127.3\r\n09260.9844\r\n09274000000000\r\n!!\r\n");
}

static void unknown_is_null(void)
{
    kelly_wits none = all;

    none.known = 0;
    none.activity = 0;
    reads(&none, "&&\r\n0105-9999\r\n0106-9999\r\n01070\r\n0108-9999\r\n0113-9999\r\n0116-9999\r\n0117-9999\r\n0118-9999\r\n0119-9999\r\n"
                 "0120-9999\r\n0915-9999\r\n0916-9999\r\n0917-9999\r\n0918-9999\r\n0921-9999\r\n0922-9999\r\n0923-9999\r\n0924-9999\r\n"
                 "0925-9999\r\n0926-9999\r\n0927-9999\r\n!!\r\n");
}

/* The value of an item, as text: where it stands in the frame. */
static const char *item(char text[KELLY_WITS_TEXT + 1], const kelly_wits *values, const char *code)
{
    const size_t n = kelly_wits_frame(text, KELLY_WITS_TEXT + 1, values);

    for (size_t i = 0; i + 6 < n; i++) {
        if (text[i] == '\n' && text[i + 1] == code[0] && text[i + 2] == code[1] && text[i + 3] == code[2] && text[i + 4] == code[3]) {
            return text + i + 5;
        }
    }
    return "";
}

static int starts(const char *text, const char *with)
{
    while (*with != '\0' && *text == *with) {
        text++;
        with++;
    }
    return *with == '\0';
}

static void depth_reads(real depth, const char *want)
{
    char text[KELLY_WITS_TEXT + 1];
    kelly_wits values = all;

    values.depth = depth;
    CHECK(starts(item(text, &values, "0108"), want));
}

static void numbers_are_rounded_and_bounded(void)
{
    char text[KELLY_WITS_TEXT + 1];
    kelly_wits values = all;

    depth_reads(R(0.0), "0.00\r");
    depth_reads(R(-0.0), "0.00\r");
    depth_reads(R(-0.0049), "0.00\r");                      /* no minus before nothing */
    depth_reads(R(0.0051), "0.01\r");
    depth_reads(R(-0.0051), "-0.01\r");
    depth_reads(R(99.996), "100.00\r");
    depth_reads(R(123.0625), "123.06\r");
    depth_reads(R(-524288.0), "-524288.00\r");
    depth_reads(R(1000000.0), "-9999\r");
    depth_reads(R(1e30), "-9999\r");
    values.bit_mean = R(0.0);                               /* no stick-slip index of a bit that does not turn */
    CHECK(starts(item(text, &values, "0925"), "-9999\r"));
    CHECK(starts(item(text, &values, "0923"), "0.00\r"));
    values.date = 991232;
    values.time = 240000;
    CHECK(starts(item(text, &values, "0105"), "-9999\r"));
    CHECK(starts(item(text, &values, "0106"), "-9999\r"));
}

/* The longest frame: every value as long as it can be. */
static void room_is_enough_or_nothing_is_written(void)
{
    const real wide_one = R(-99999.0);
    kelly_wits values = {
        .known = 31, .activity = 99, .date = 991231, .time = 235959, .depth = R(-999999.0),
        .wob_mean = wide_one * R(1e4), .wob_max = wide_one * R(1e4), .torque_mean = wide_one * R(1e3), .torque_max = wide_one * R(1e3),
        .top_speed = wide_one, .bit_wob_mean = wide_one * R(1e4), .bit_wob_max = wide_one * R(1e4),
        .bit_torque_mean = wide_one * R(1e3), .bit_torque_max = wide_one * R(1e3), .bit_lowest = wide_one, .bit_highest = R(99999.0),
        .bit_mean = R(10000.0), .ss = wide_one, .probability = R(-9999.0), .samples = UINT32_MAX,
    };
    char text[KELLY_WITS_TEXT + 3];
    const size_t longest = kelly_wits_frame(text, sizeof(text), &values);

    CHECK(longest > 300 && longest <= KELLY_WITS_TEXT);
    for (size_t room = 0; room < sizeof(text); room++) {
        text[room] = 'x';
        EQUAL(kelly_wits_frame(text, room, &values), room > longest ? longest : 0);
        EQUAL(text[room], 'x');
        EQUAL(text[room > longest ? longest : 0], room > 0 ? 0 : 'x');
    }
}

void test_wits(void);
void test_wits(void)
{
    frame_is_as_published();
    unknown_is_null();
    numbers_are_rounded_and_bounded();
    room_is_enough_or_nothing_is_written();
}
