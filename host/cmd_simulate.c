/* cmd_simulate.c - one realisation in time. */
#include <math.h>
#include <string.h>

#include "host.h"

#define STEP_LEAST 1e-6          /* [s] that --step takes */

/* %.9g and %.17g bring a float and a double back unchanged. */
#define DIGITS (sizeof(real) > sizeof(float) ? 17 : 9)

void sight_line(FILE *to, double time, const kelly_sight *s)
{
    fprintf(to, "%.12g,%.*g,%.*g,%.*g,%.*g,%.*g,%.*g\n", time, DIGITS, (double)s->bit_speed / RPM, DIGITS, -(double)s->bit_torque / 1000.0,
            DIGITS, -(double)s->f_bit / 1000.0, DIGITS, (double)s->axial_speed, DIGITS, (double)s->surface_torque / 1000.0,
            DIGITS, (double)s->top_speed / RPM);
}

_Noreturn void plant_refuse(const kelly_plant *plant, const options *opts, const kelly_draw *draw, kelly_status status)
{
    const double step = case_seconds(&opts->run, 1);
    char safe[STEP_TEXT];
    double largest;

    if (status == KELLY_RANGE) {
        die(EXIT_USAGE, "--wob %.6g kN: outside the fitted range of the table; give %.6g..%.6g kN", (double)draw->fc / 1000.0,
            (double)kelly_string.fc_min / 1000.0, (double)kelly_string.fc_max / 1000.0);
    }
    if (step < (double)kelly_smallest_step(&plant->modes)) {
        die(EXIT_USAGE, "--step %.12g: too short for %s, whose rounding would drown the slowest mode; give at least %s s%s", step,
            sizeof(real) > 4 ? "double" : "float", step_text((double)kelly_smallest_step(&plant->modes), 1, safe), sizeof(real) > 4 ? "" : ", or build with REAL=double");
    }
    largest = fmin((double)kelly_largest_step(&kelly_string, &opts->run, draw, &plant->modes),
                   (double)kelly_axial_largest_step(&kelly_string, &opts->run, draw));
    die(EXIT_USAGE, "--step %.12g: too long for this case; the largest safe step is %s s%s", step, step_text(largest, 0, safe),
        largest < STEP_LEAST ? ", and none below 1e-06 s can be given: another case is needed" : "");
}

/* Lowest, highest and mean bit speed over the window [rad/s]. */
typedef struct {
    real lowest, highest, mean;
} window_speeds;

/* A window opens: the mean is the difference of the bit's twist over it, see kelly_plant_twist. */
static void open_window(kelly_plant *plant, window_speeds *w)
{
    kelly_plant_watch(plant);
    w->mean = kelly_plant_twist(plant);
}

static void close_window(const kelly_plant *plant, const kelly_case *run, window_speeds *w)
{
    const double seconds = case_seconds(run, run->window_last - run->window_first);

    kelly_plant_extremes(plant, &w->lowest, &w->highest);
    w->mean = plant->draw.w0 + (kelly_plant_twist(plant) - w->mean) / (real)seconds;
}

/* The whole run, a line at tick 0 and after every out-step; fills what the summary needs. */
static void run_to(FILE *to, field_file *field, kelly_plant *plant, const options *opts, window_speeds *window)
{
    const kelly_case *const run = &opts->run;
    uint32_t tick = 0;
    kelly_sight sight;

    if (run->window_first == 0) {
        open_window(plant, window);
    }
    kelly_plant_look(plant, &sight);
    sight_line(to, 0.0, &sight);
    field_write(field, plant, 0.0);
    while (tick < run->ticks) {
        const uint32_t to_line = opts->out_ticks - tick % opts->out_ticks;
        uint32_t next = to_line < run->ticks - tick ? tick + to_line : run->ticks;

        if (tick < run->window_first && next > run->window_first) {
            next = run->window_first;
        } else if (tick < run->window_last && next > run->window_last) {
            next = run->window_last;
        }
        kelly_plant_advance(plant, next - tick);
        tick = next;
        if (tick == run->window_first) {
            open_window(plant, window);
        }
        if (tick == run->window_last) {
            close_window(plant, run, window);
        }
        if (tick % opts->out_ticks == 0) {
            kelly_plant_look(plant, &sight);
            sight_line(to, case_seconds(run, tick), &sight);
            field_write(field, plant, case_seconds(run, tick));
        }
    }
}

static void summary(FILE *to, const options *opts, const window_speeds *w)
{
    const real ss = kelly_severity(w->lowest, w->highest), ssi = kelly_ssi(w->lowest, w->highest, w->mean);

    fprintf(to, "bit speed %.2f .. %.2f rpm over %.12g:%.12g s, severity ss = %.4f (paper: (max - min)/(max + min)): %s\n",
            (double)w->lowest / RPM, (double)w->highest / RPM, case_seconds(&opts->run, opts->run.window_first),
            case_seconds(&opts->run, opts->run.window_last), (double)ss, ss > opts->run.limit ? "stick-slip" : "no stick-slip");
    if (w->mean > KELLY_NO_SPEED) {
        fprintf(to, "mean %.2f rpm, SSI = %.4f (field: (max - min)/(2 mean))\n", (double)w->mean / RPM, (double)ssi);
    } else {
        fprintf(to, "mean %.2f rpm, not above 0: no SSI (field: (max - min)/(2 mean))\n", (double)w->mean / RPM);
    }
}

const command_help simulate_help = {
    .brief = "one run in time: the nominal case, or realisation J of seed S",
    .synopsis = "[case] [--out F.csv] [--field F.npy|F.csv] [--sample J --seed S [--cov D]]",
    .takes = TAKES_CASE | TAKES_SIMULATE,
    .notes = "CSV: time_s,bit_speed_rpm,bit_torque_kNm,wob_kN,bit_axial_speed_m_s,surface_torque_kNm,top_speed_rpm; weight and torque\n"
             "are positive while drilling.\n"
             "Field: time_s,x_m,displacement_m,twist_rad at every node (x from the top down) and output time; displacement relative to\n"
             "the prestressed string, twist relative to the top. NPY: a structured array [time, node], a = numpy.load(F), a['twist_rad'].",
    .example = "kelly simulate --mu 0.004 --out run.csv --field field.npy --out-step 0.05",
};

int command_simulate(int argc, char **argv)
{
    static kelly_plant plant;
    options opts;
    outfile file;
    kelly_draw draw;
    kelly_status status;
    window_speeds window = { 0 };
    field_file field;

    options_parse(&opts, argc, argv, TAKES_CASE | TAKES_SIMULATE, "simulate", 0, 0);
    check_outputs((const char *const[]){ opts.out, opts.field }, 2);
    check_nominal(&opts);
    if (opts.sample_given) {
        kelly_draw_sample(&opts.run, opts.seed, opts.sample, &draw);
    } else {
        kelly_draw_nominal(&opts.run, &draw);
    }
    status = kelly_plant_start(&plant, &kelly_string, &opts.run, &draw);
    if (status != KELLY_OK) {
        plant_refuse(&plant, &opts, &draw, status);
    }
    outfile_open(&file, opts.out ? opts.out : "-");
    fputs(SIGHT_HEADER, file.stream);
    field_open(&field, opts.field, &opts, &draw);
    run_to(file.stream, &field, &plant, &opts, &window);
    if (!kelly_plant_sane(&plant)) {
        die(EXIT_FAILED, "simulate: the state left all bounds; no result");
    }
    outfile_close(&file);
    field_close(&field);
    if (!opts.quiet && opts.out && strcmp(opts.out, "-") != 0) {
        summary(stdout, &opts, &window);
        if (kelly_lifts_off(&opts.run, &draw)) {
            puts("warning: the weight changes its sign (|fc| < 1.01 f0) and is held at 0: the bit would lift off, which this model leaves out");
        }
    }
    return EXIT_DONE;
}
