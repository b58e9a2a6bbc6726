/* cmd_simulate.c - one realisation in time. */
#include <math.h>

#include "host.h"

/* %.9g and %.17g bring a float and a double back unchanged. */
#define DIGITS (sizeof(real) > sizeof(float) ? 17 : 9)

static void write_line(FILE *to, double time, const kelly_sight *s)
{
    fprintf(to, "%.12g,%.*g,%.*g,%.*g,%.*g,%.*g,%.*g\n", time, DIGITS, (double)s->bit_speed / RPM, DIGITS, -(double)s->bit_torque / 1000.0,
            DIGITS, -(double)s->f_bit / 1000.0, DIGITS, (double)s->axial_speed, DIGITS, (double)s->surface_torque / 1000.0,
            DIGITS, (double)s->top_speed / RPM);
}

static void refuse(const kelly_plant *plant, const options *opts, const kelly_draw *draw, kelly_status status)
{
    if (status == KELLY_RANGE) {
        die(EXIT_USAGE, "--wob %.6g kN: outside the fitted range of the table; give %.6g..%.6g kN", (double)draw->fc / 1000.0,
            (double)kelly_string.fc_min / 1000.0, (double)kelly_string.fc_max / 1000.0);
    }
    die(EXIT_USAGE, "--step %.6g: too long for this case; the largest safe step is %.6f s", case_seconds(&opts->run, 1),
        floor(1e6 * (double)kelly_largest_step(&kelly_string, &opts->run, draw, &plant->modes)) / 1e6);
}

/* The whole run, a line at tick 0 and after every out-step; fills what the summary needs. */
static void run_to(FILE *to, kelly_plant *plant, const options *opts, real *lowest, real *highest)
{
    const kelly_case *const run = &opts->run;
    uint32_t tick = 0;
    kelly_sight sight;

    kelly_plant_look(plant, &sight);
    write_line(to, 0.0, &sight);
    while (tick < run->ticks) {
        const uint32_t line = tick + opts->out_ticks - tick % opts->out_ticks;
        uint32_t next = line < run->ticks ? line : run->ticks;

        if (tick < run->window_first && next > run->window_first) {
            next = run->window_first;
        } else if (tick < run->window_last && next > run->window_last) {
            next = run->window_last;
        }
        kelly_plant_advance(plant, next - tick);
        tick = next;
        if (tick == run->window_first) {
            kelly_block_watch(&plant->block);
        }
        if (tick == run->window_last) {
            kelly_block_extremes(&plant->block, 0, lowest, highest);
        }
        if (tick % opts->out_ticks == 0) {
            kelly_plant_look(plant, &sight);
            write_line(to, case_seconds(run, tick), &sight);
        }
    }
}

static void summary(FILE *to, const options *opts, real lowest, real highest)
{
    const real ss = kelly_severity(lowest, highest);

    fprintf(to, "bit speed %.2f .. %.2f rpm over %.6g:%.6g s, severity ss = %.4f (paper: (max - min)/(max + min)): %s\n",
            (double)lowest / RPM, (double)highest / RPM, case_seconds(&opts->run, opts->run.window_first),
            case_seconds(&opts->run, opts->run.window_last), (double)ss, ss > opts->run.limit ? "stick-slip" : "no stick-slip");
}

int command_simulate(int argc, char **argv)
{
    static kelly_plant plant;
    options opts;
    outfile file;
    kelly_draw draw;
    kelly_status status;
    real lowest = 0, highest = 0;

    options_parse(&opts, argc, argv, TAKES_CASE | TAKES_SIMULATE, "simulate", 0, 0);
    if (opts.sample_given) {
        kelly_draw_sample(&opts.run, opts.seed, opts.sample, &draw);
    } else {
        kelly_draw_nominal(&opts.run, &draw);
    }
    status = kelly_plant_start(&plant, &kelly_string, &opts.run, &draw);
    if (status != KELLY_OK) {
        refuse(&plant, &opts, &draw, status);
    }
    outfile_open(&file, opts.out ? opts.out : "-");
    fputs("time_s,bit_speed_rpm,bit_torque_kNm,wob_kN,bit_axial_speed_m_s,surface_torque_kNm,top_speed_rpm\n", file.stream);
    run_to(file.stream, &plant, &opts, &lowest, &highest);
    if (!kelly_block_sane(&plant.block, 0)) {
        die(EXIT_FAILED, "simulate: the state left all bounds; no result");
    }
    outfile_close(&file);
    if (opts.out && opts.out[0] != '-') {
        summary(stdout, &opts, lowest, highest);
    }
    return EXIT_DONE;
}
