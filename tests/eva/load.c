/* Setting up, commanding and reading the blocks of both propagators: every checked draw of the committed table, every state within bounds. */
#include "drive.h"
#include "integrator.h"
#include "contracts.h"
#include "kernel.h"

static kelly_block block;
static kelly_driven driven;

static void stiff(void)
{
    real low, high, q[KELLY_MODES_MAX], v[KELLY_MODES_MAX];

    kelly_block_load(&block, 0, &run, &draw, &modes);
    kelly_block_watch(&block);
    (void)kelly_block_speed(&block, 0);
    (void)kelly_block_sine(&block, 0);
    kelly_block_extremes(&block, 0, &low, &high);
    (void)kelly_block_sane(&block, 0);
    for (unsigned i = 0; i < MODES; i++) {
        if (block.full) {
            block.mode[0][i].xi = any_real(R(-1e15), R(1e15));
            block.mode[0][i].zeta = any_real(R(-1e15), R(1e15));
        } else {
            block.slow[0][i].v = any_real(R(-1e15), R(1e15));
            block.slow[0][i].x = any_real(R(-1e15), R(1e15));
        }
    }
    (void)kelly_block_sane(&block, 0);
    kelly_block_modal(&block, 0, &modes, &kelly_string, q, v);
    (void)kelly_block_twist(&block, 0, &modes);
    (void)kelly_block_seal(&block);
    (void)kelly_block_untouched(&block);
}

/* One form of the modes after the other. */
static void both_forms(void)
{
    kelly_block_clear(&block, &kelly_string, &run, 1);
    if (block.full) {
        block.full = 1;
        stiff();
    } else {
        stiff();
    }
}

static void soft(void)
{
    real low, high, q[KELLY_MODES_MAX], v[KELLY_MODES_MAX];
    const real most = R(0.25e9) / (real)run.step_ns, top_speed = any_real(-most, most);

    kelly_driven_clear(&driven, &kelly_string, &run, 1);
    kelly_driven_load(&driven, 0, &kelly_string, &run, &draw, &modes, top_speed);
    kelly_driven_ramp(&driven, 0, any_real(R(-1e9), R(1e9)));
    kelly_driven_adjust(&driven, 0, top_speed);
    kelly_driven_hold(&driven, 0, top_speed);
    kelly_driven_weigh(&driven, 0, &run, &draw, any_real(0, R(1e9)));
    kelly_driven_watch(&driven);
    (void)kelly_driven_speed(&driven, 0);
    kelly_driven_extremes(&driven, 0, &low, &high);
    (void)kelly_driven_sane(&driven, 0);
    driven.lane[0].eta = any_real(R(-1e6), R(1e6));
    driven.lane[0].phi = any_real(R(-1e6), R(1e6));
    driven.lane[0].p.at[0] = any_real(R(-1e15), R(1e15));
    for (unsigned i = 0; i < MODES; i++) {
        driven.mode[0][i].v = any_real(R(-1e12), R(1e12));
        driven.mode[0][i].x = any_real(R(-1e12), R(1e12));
    }
    (void)kelly_driven_sane(&driven, 0);
    kelly_driven_modal(&driven, 0, &modes, q, v);
    (void)kelly_driven_twist(&driven, 0, &modes);
    (void)kelly_driven_seal(&driven);
    (void)kelly_driven_untouched(&driven);
    (void)kelly_driven_top_speed(&driven, 0);
    (void)kelly_driven_top_torque(&driven, 0, any_real(R(-1e14), R(1e14)));
}

int main(void)
{
    uint32_t low = 1000;

    if (!kelly_modes_at(&kelly_string, any_real(R(1e3), R(1e6)), MODES, &modes)) {
        return 1;
    }
    //@ loop unroll 7;
    for (unsigned k = 0; k < 7; k++) {
        any_checked(low, 0);
        both_forms();
        any_checked(low, 1);
        soft();
        low *= 8;
    }
    return 0;
}
