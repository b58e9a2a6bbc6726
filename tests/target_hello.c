/* target_hello.c - the board alone, without the kernel: is every board function there, is the arithmetic IEEE?
 *
 * Prints lines `name value`, which tests/check_targets.py compares with what they must be. The inputs are volatile or
 * come over the UART, so that the target computes and not the compiler.
 */
#include "../firmware/app/line.h"
#include "../firmware/board/board.h"
#include "../firmware/real.h"

static volatile uint32_t in_data = 0x12345678u, in_bss;   /* .data copied, .bss cleared by start-up */

static void say(const char *name, uint32_t value)
{
    board_text(name);
    board_text(" ");
    board_hex(value);
    board_text("\n");
}

/* Two instructions a round, written out: a compiler may know a loop instruction (Cortex-M55: one a round). */
static __attribute__((noinline)) uint32_t cost_of(uint32_t n)
{
    const uint32_t start = board_measure_start();

    if (n > 0) {
#ifdef __arm__
        __asm volatile(".syntax unified\n1: subs %0, %0, #1\n bne 1b" : "+r"(n) : : "cc");
#else
        __asm volatile("1: addi %0, %0, -1\n bnez %0, 1b" : "+r"(n));
#endif
    }
    return board_measure_end(start);
}

/* Instructions of 1000 rounds less those of 500: a whole number a round, whatever the call costs. */
static void say_cost(void)
{
    static const volatile uint32_t many = 1000, few = 500;   /* volatile: no copy of cost_of() for each */
    const uint32_t thousand = cost_of(many);

    say("cost", thousand - cost_of(few));
    say("cost_again", cost_of(many) - thousand);
}

/* Sums that need the right rounding, a subnormal result, a division. Expected bits are those of the host. */
static void say_float(void)
{
    volatile float third = 1.0f, three = 3.0f, tiny = 1e-38f, big = 16777216.0f;
    union { float f; uint32_t bits; } a, b, c, d;

    third = third / three;
    a.f = third;
    b.f = tiny / three * third;
    c.f = big + third + three;
    d.f = third * third + tiny;
    say("float_third", a.bits);
    say("float_subnormal", b.bits);
    say("float_sum", c.bits);
    say("float_product", d.bits);
}

static void say_real(void)
{
    volatile real x = R(0.1), y = R(0.7);
    union { real value; uint32_t words[2]; } bits = {0};

    for (int i = 0; i < 100; i++)
        x = x * y + R(1.0) / (x + R(3.0));
    bits.value = x;
    say("real_low", bits.words[0]);
    say("real_high", sizeof(real) == 8 ? bits.words[1] : 0);
}

/* Four ticks pass while the core sleeps. */
static void say_ticks(void)
{
    uint32_t start = board_ticks(), wakes = 0;

    while (board_ticks() - start < 4u && wakes < 1000u) {
        board_idle();
        wakes++;
    }
    say("ticks", board_ticks() - start >= 4u && wakes < 1000u);
}

int main(void)
{
    static const line_key keys[] = { { "seed", 0, 1 }, { "first", UINT32_MAX, 0 } };
    char line[LINE_MAX];
    uint64_t asked[2];

    board_text("hello " BOARD_NAME "\n");
    line_ask(line);
    if (line_read(line, keys, asked, 2)) {
        board_text("line not understood\n");
        return 2;
    }
    say("seed_low", (uint32_t)asked[0]);
    say("seed_high", (uint32_t)(asked[0] >> 32));
    say("first", (uint32_t)asked[1]);
    say("data", in_data);
    say("bss", in_bss);
    say_float();
    say_real();
    say_ticks();
    say_cost();
    say("stack_used", stack_used());
    say("stack_size", stack_size());
    return 0;
}
