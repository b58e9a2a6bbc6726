/* What writes text and frames on the board: any number, any bytes into the ring, a line that is ready or not. */
#include "app/out.h"
#include "app/say.h"
#include "board.h"
#include "contracts.h"

static void numbers(void)
{
    say_decimal(any_u32());
    say_hex(any_u32());
    //@ loop unroll 8;
    for (unsigned digits = 0; digits <= 7; digits++) {
        say_fixed(any_wide(-1e31, 1e31), digits);
    }
    say_number("n ", any_u32());
    say_value("v ", any_wide(-1e31, 1e31), 3);
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
