/* host_drive.c - a plant under a drive or under commands, as numbers for check_drive.py.
 *
 *     drive stiff|soft|commanded key=value...      mu= fc= f0= w0= rotating= step= (us) ticks= every= J= Z= f= top=  (SI)
 *     standard input, commanded: lines `tick top_speed weight ramp_ticks`, ticks rising
 *
 * Prints `every` ticks: time, bit speed, top speed, surface torque, bit torque, weight, axial speed; then `sane` or `insane`,
 * and the CRC-32C of all that was seen at every tick, as test_drive.c adds it up.
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "../firmware/kelly.h"
#include "../firmware/link/crc32c.h"

typedef struct {
    double top, every;
} extra;

static void set(kelly_case *run, extra *more, const char *text)
{
    const struct {
        const char *name;
        real *value;
    } reals[] = { { "mu", &run->mu }, { "fc", &run->fc }, { "f0", &run->f0 }, { "w0", &run->w0 }, { "J", &run->drive.inertia },
                  { "Z", &run->drive.impedance }, { "f", &run->drive.hz } };
    const char *const equals = strchr(text, '=');
    const double value = equals ? atof(equals + 1) : 0.0;
    const size_t length = equals ? (size_t)(equals - text) : strlen(text);

    for (size_t k = 0; k < sizeof(reals) / sizeof(reals[0]); k++) {
        if (strlen(reals[k].name) == length && strncmp(reals[k].name, text, length) == 0) {
            *reals[k].value = (real)value;
            return;
        }
    }
    if (strncmp(text, "rotating=", 9) == 0) {
        run->rotating = value > 0.0;
    } else if (strncmp(text, "step=", 5) == 0) {
        run->step_ns = (uint32_t)(value * 1000.0 + 0.5);
    } else if (strncmp(text, "ticks=", 6) == 0) {
        run->ticks = (uint32_t)value;
    } else if (strncmp(text, "top=", 4) == 0) {
        more->top = value;
    } else if (strncmp(text, "every=", 6) == 0) {
        more->every = value;
    } else {
        fprintf(stderr, "%s: not understood\n", text);
        exit(2);
    }
}

/* The reals of a sight in the order of its fields, as they lie in this machine's memory (little-endian). */
static uint32_t add(uint32_t crc, const kelly_sight *s)
{
    const real seen[6] = { s->bit_speed, s->bit_torque, s->f_bit, s->axial_speed, s->surface_torque, s->top_speed };
    uint8_t bytes[sizeof(seen)];

    memcpy(bytes, seen, sizeof(seen));
    return kelly_crc32c(crc, bytes, sizeof(bytes));
}

static void say(const kelly_plant *plant, const kelly_sight *s, uint32_t tick)
{
    printf("%.17g %.17g %.17g %.17g %.17g %.17g %.17g\n", (double)tick * (double)plant->run.step_ns / 1e9, (double)s->bit_speed,
           (double)s->top_speed, (double)s->surface_torque, (double)s->bit_torque, (double)s->f_bit, (double)s->axial_speed);
}

static int next_command(double command[4])
{
    return scanf("%lf %lf %lf %lf", &command[0], &command[1], &command[2], &command[3]) == 4;
}

static void run_plant(kelly_plant *plant, const kelly_case *run, uint32_t every, int commanded)
{
    double command[4];
    int more = commanded && next_command(command);
    uint32_t crc = 0;
    kelly_sight s;

    for (uint32_t tick = 0; tick <= run->ticks; tick++) {
        for (; more && (uint32_t)command[0] == tick; more = next_command(command)) {
            kelly_plant_command(plant, (real)command[1], (real)command[2], (uint32_t)command[3]);
        }
        kelly_plant_look(plant, &s);
        crc = add(crc, &s);
        if (tick % every == 0) {
            say(plant, &s, tick);
        }
        kelly_plant_advance(plant, 1);
    }
    puts(kelly_plant_sane(plant) ? "sane" : "insane");
    printf("crc %08x\n", crc);
}

int main(int argc, char **argv)
{
    static kelly_plant plant;
    kelly_case run = kelly_string.nominal;
    extra more = { .top = 0.0, .every = 100.0 };
    kelly_draw draw;
    kelly_status status;
    const int commanded = argc > 1 && strcmp(argv[1], "commanded") == 0;

    if (argc > 1 && strcmp(argv[1], "soft") == 0) {
        run.drive = (kelly_drive){ .inertia = R(2900.0), .impedance = R(289.0), .hz = R(0.2) };
    }
    for (int i = 2; i < argc; i++) {
        set(&run, &more, argv[i]);
    }
    kelly_draw_nominal(&run, &draw);
    status = commanded ? kelly_plant_start_commanded(&plant, &kelly_string, &run, &draw, (real)more.top)
                       : kelly_plant_start(&plant, &kelly_string, &run, &draw);
    if (status != KELLY_OK) {
        printf("status %d\n", (int)status);
        return 1;
    }
    run_plant(&plant, &run, (uint32_t)more.every, commanded);
    return 0;
}
