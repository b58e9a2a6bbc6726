/* The table, a draw, its modes, its rates, axial motion: any finite weight, any case of the documented ranges. */
#include "axial.h"
#include "realisation.h"
#include "contracts.h"

static kelly_case run;
static kelly_draw draw;
static kelly_modes modes;

static void any_case(uint8_t torsional, uint8_t axial)
{
    run.fc = any_real(R(1e-30), R(1e9));
    run.mu = any_real(R(1e-30), R(1800.0));
    run.a1 = any_real(R(1e-30), R(1000.0));
    run.a2 = any_real(R(1e-6), R(1.8e7));
    run.w0 = any_real(R(1e-30), R(1e4));
    run.f0 = any_real(0, R(1e9));
    for (unsigned k = 0; k < KELLY_PARAMETERS; k++) {
        run.cov[k] = Frama_C_nondet(0, 1) ? 0 : Frama_C_float_interval(1e-4f, 0.5f);
    }
    run.limit = any_real(0, R(10.0));
    run.step_ns = Frama_C_unsigned_int_interval(1000, 1000000000);
    run.ticks = Frama_C_unsigned_int_interval(1, UINT32_MAX);
    run.window_first = any_u32();
    run.window_last = any_u32();
    run.torsional = torsional;
    run.axial = axial;
    run.rotating = Frama_C_unsigned_char_interval(0, 1);
    run.drive.inertia = Frama_C_nondet(0, 1) ? 0 : any_real(R(1.0), R(1e12));
    run.drive.impedance = any_real(R(1e-30), R(1e12));
    run.drive.hz = any_real(R(1e-30), R(1e3));
}

/* What any of 32 bits can draw. */
static void any_draw(void)
{
    draw.fc = any_real(0, R(1.8e10));
    draw.mu = any_real(0, R(1800.0));
    draw.a1 = any_real(0, R(1800.0));
    draw.a2 = any_real(0, R(1.8e7));
    draw.w0 = any_real(0, R(1.8e5));
}

/* Shapes of two modes at three nodes, straight in s: the CRC goes over all of any table in the same way. */
static void shapes(void)
{
    static real x[3], twist[12], axial[12], gram[6];
    kelly_table small = kelly_string;
    kelly_shapes of = { .schema = any_u32(), .real_bytes = any_u32(), .crc = any_u32(), .id = kelly_string.id, .x = x, .twist = twist,
                        .axial = axial, .twist_gram = gram, .axial_gram = gram };

    small.torsional = small.axial = 2;
    small.degree = 1;
    small.nodes = 3;
    for (unsigned k = 0; k < 12; k++) {
        twist[k] = axial[k] = any_real(-ANY_REAL, ANY_REAL);
        x[k % 3] = gram[k % 6] = twist[k];
    }
    (void)kelly_shapes_error(&small, &of);
}

static void tables(void)
{
    kelly_table table = kelly_string;
    real w2[KELLY_MODES_MAX], b[KELLY_MODES_MAX];
    int known;

    table.schema = any_u32();
    table.real_bytes = any_u32();
    table.torsional = Frama_C_unsigned_short_interval(0, 65535);
    table.axial = Frama_C_unsigned_short_interval(0, 65535);
    table.degree = Frama_C_unsigned_short_interval(0, 65535);
    table.head_crc = any_u32();
    (void)kelly_table_head_error(&table);
    (void)kelly_table_error(&kelly_string);
    shapes();
    known = kelly_modes_at(&kelly_string, any_real(R(-1e30), R(1e30)), Frama_C_unsigned_int_interval(0, UINT32_MAX), &modes);
    known += kelly_axial_modes_at(&kelly_string, any_real(R(-1e30), R(1e30)), Frama_C_unsigned_int_interval(0, UINT32_MAX), w2, b);
    if (kelly_modes_at(&kelly_string, any_real(R(-1e30), R(1e30)), 20, &modes)) {
        for (unsigned i = 0; i < 20; i++) {
            //@ assert 1e-3 <= modes.w2[i] <= 1e8;
            //@ assert 1e-4 <= modes.b[i] <= 1;
            //@ assert -1e4 <= modes.d[i] <= 1e4;
        }
    }
}

static void cases(void)
{
    any_case(any_byte(), any_byte());
    (void)kelly_case_error(&kelly_string, &run);
    run.fc = any_real(-ANY_REAL, ANY_REAL);
    run.mu = any_real(-ANY_REAL, ANY_REAL);
    run.f0 = any_real(-ANY_REAL, ANY_REAL);
    run.ticks = any_u32();
    run.limit = any_real(-ANY_REAL, ANY_REAL);
    run.cov[0] = Frama_C_float_interval(-ANY_FLOAT, ANY_FLOAT);
    run.drive.inertia = any_real(-ANY_REAL, ANY_REAL);
    run.drive.hz = any_real(-ANY_REAL, ANY_REAL);
    run.step_ns = any_u32();
    run.torsional = any_byte();
    (void)kelly_case_error(&kelly_string, &run);
    any_case(1, 1);
    kelly_draw_nominal(&run, &draw);
    kelly_draw_sample(&run, any_u64(), any_u32(), &draw);
    (void)kelly_lifts_off(&run, &draw);
}

static void rates(uint8_t torsional)
{
    any_case(torsional, 1);
    any_draw();
    (void)kelly_realise(&kelly_string, &run, &draw, &modes);
    (void)kelly_modes_at(&kelly_string, any_real(R(1e3), R(1e6)), torsional, &modes);
    (void)kelly_fastest_rate(&kelly_string, &run, &draw, &modes, draw.fc);
    (void)kelly_smallest_step(&modes);
    (void)kelly_largest_step(&kelly_string, &run, &draw, &modes);
}

static void axial(uint8_t count)
{
    kelly_axial axial;
    const real f[4] = { any_real(R(-2e9), R(2e9)), any_real(R(-2e9), R(2e9)), any_real(R(-2e9), R(2e9)), any_real(R(-2e9), R(2e9)) };

    any_case(1, count);
    any_draw();
    (void)kelly_axial_largest_step(&kelly_string, &run, &draw);
    if (kelly_axial_start(&axial, &kelly_string, &run, &draw) == KELLY_OK) {
        for (unsigned j = 0; j < count; j++) {
            axial.p[j] = any_real(R(-1e9), R(1e9));
            axial.v[j] = any_real(R(-1e9), R(1e9));
        }
        kelly_axial_step(&axial, any_u32());
        kelly_axial_push(&axial, f);
        (void)kelly_axial_speed(&axial);
    }
}

int main(void)
{
    tables();
    cases();
    //@ loop unroll 20;
    for (uint8_t k = 1; k <= 20; k++) {
        rates(k);
    }
    //@ loop unroll 11;
    for (uint8_t k = 1; k <= 11; k++) {
        axial(k);
    }
    return 0;
}
