/* bench_profile.c - what the top and the weight are to do over time. */
#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include "bench_session.h"

#define POINTS_MOST 100000u

/* Parts of the case's speed and weight: ramps up and down, steps, both at once. Begins again after its last time. */
static const double exercise[][3] = {
    { 0, 1, 1 }, { 4, 1, 1 }, { 8, 1.4, 1 }, { 10, 1.4, 1 }, { 10, 1.4, 1.2 }, { 14, 0.6, 1.2 }, { 16, 0.6, 0.7 }, { 18, 0.6, 0.7 },
    { 18, 0.9, 0.7 }, { 22, 0.9, 1.1 }, { 26, 0.3, 0.9 }, { 30, 1, 1 },
};

static void add(bench_profile *p, double time, double rpm, double wob)
{
    if (p->count % 256 == 0) {
        void *const more = realloc(p->points, (p->count + 256) * sizeof(*p->points));

        if (!more) {
            die(EXIT_FAILED, "out of memory");
        }
        p->points = more;
    }
    p->points[p->count].time = time;
    p->points[p->count].rpm = rpm;
    p->points[p->count++].wob = wob;
}

static void read_line(bench_profile *p, const char *path, unsigned number, char *line)
{
    char *rest = line;
    double value[3];

    for (unsigned k = 0; k < 3; k++) {
        char *end;

        value[k] = rest ? strtod(rest, &end) : 0;
        if (!rest || end == rest || *end != (k < 2 ? ',' : '\0')) {
            die(EXIT_USAGE, "%s:%u: '%s' is not three numbers; give time_s,rpm,wob_kN", path, number, line);
        }
        rest = end + 1;
    }
    if (!(value[0] >= (p->count ? p->points[p->count - 1].time : 0) && value[0] <= 1e9)) {
        die(EXIT_USAGE, "%s:%u: time %g s is before that of the line above, or before 0", path, number, value[0]);
    }
    if (!(value[1] >= 0 && value[1] <= 1e4 && value[2] > 0 && value[2] <= 1e6) || p->count == POINTS_MOST) {
        die(EXIT_USAGE, "%s:%u: %g rpm, %g kN: give 0..10000 rpm and a weight above 0, at most %u lines", path, number, value[1], value[2], POINTS_MOST);
    }
    add(p, value[0], value[1], value[2]);
}

static void read_profile(bench_profile *p, const char *path)
{
    FILE *const file = fopen(path, "r");
    char line[256];
    unsigned number = 0;

    if (!file) {
        die(EXIT_USAGE, "--profile %s: cannot be read: %s", path, strerror(errno));
    }
    while (fgets(line, sizeof(line), file)) {
        line[strcspn(line, "\r\n")] = '\0';
        if (++number == 1 && strcmp(line, "time_s,rpm,wob_kN") != 0) {
            die(EXIT_USAGE, "%s:1: the first line must be time_s,rpm,wob_kN", path);
        }
        if (number > 1) {
            read_line(p, path, number, line);
        }
    }
    (void)fclose(file);
    if (p->count == 0) {
        die(EXIT_USAGE, "%s: holds no points; give lines of time_s,rpm,wob_kN", path);
    }
}

void profile_open(bench_profile *p, const bench_request *ask, int exercised)
{
    const double rpm = (double)ask->opts.run.w0 / RPM, wob = (double)ask->opts.run.fc / 1000.0;

    *p = (bench_profile){ 0 };
    if (ask->profile) {
        read_profile(p, ask->profile);
        return;
    }
    for (unsigned i = 0; i < (exercised ? sizeof(exercise) / sizeof(exercise[0]) : 1); i++) {
        add(p, exercise[i][0], rpm * exercise[i][1], wob * exercise[i][2]);
    }
    p->period = p->points[p->count - 1].time;
}

void profile_at(const bench_profile *p, double time, double *rpm, double *wob)
{
    unsigned i = 0;

    if (p->period > 0) {
        time -= p->period * (double)(uint64_t)(time / p->period);
    }
    while (i + 1 < p->count && p->points[i + 1].time <= time) {
        i++;
    }
    *rpm = p->points[i].rpm;
    *wob = p->points[i].wob;
    if (i + 1 < p->count && time > p->points[i].time) {
        const double part = (time - p->points[i].time) / (p->points[i + 1].time - p->points[i].time);

        *rpm += part * (p->points[i + 1].rpm - *rpm);
        *wob += part * (p->points[i + 1].wob - *wob);
    }
}
