/* What writes text and frames on the board: any number, any bytes into the ring, a line that is ready or not. */
#include "app/out.h"
#include "app/say.h"
#include "board/board.h"
#include "contracts.h"

/* ---- board ---- */

int board_read(void) { return Frama_C_interval(-1, 255); }
int board_ready(void) { return Frama_C_interval(0, 1); }
void board_write(uint8_t byte) { (void)byte; }
uint32_t board_ticks(void) { return any_u32(); }
uint32_t board_micros(void) { return any_u32(); }
uint32_t board_count(void) { return any_u32(); }
int board_counts_cycles(void) { return Frama_C_interval(0, 1); }
void board_idle(void) { }
void board_vectors(int readable) { (void)readable; }
int board_watchdog(void) { return Frama_C_interval(0, 2); }
void watchdog_start(uint32_t ms) { (void)ms; }
void watchdog_kick(void) { }
void watchdog_stop(void) { }
void board_text(const char *text)
{
    while (*text != '\0') {
        board_write((uint8_t)*text++);
    }
}
/* ---- text ---- */

static void numbers(void)
{
    say_decimal(any_u32());
    say_hex(any_u32());
    //@ loop unroll 7;
    for (unsigned digits = 0; digits < 7; digits++) {
        say_fixed(Frama_C_double_interval(-1e30, 1e30), digits);
    }
    say_number("n ", any_u32());
    say_value("v ", Frama_C_double_interval(-1e30, 1e30), 3);
}

static void ring(void)
{
    static uint8_t wire[KELLY_WIRE_MAX];

    ANY(wire);
    while (Frama_C_interval(0, 1)) {
        out_byte(any_byte());
        out_defer(Frama_C_interval(0, 1));
        (void)out_pump();
        (void)out_room(Frama_C_size_t_interval(0, SIZE_MAX));
        out_frame(wire, any_byte(), any_u32(), Frama_C_size_t_interval(0, KELLY_FRAME_MAX));
    }
}

int main(void)
{
    numbers();
    ring();
    return 0;
}
