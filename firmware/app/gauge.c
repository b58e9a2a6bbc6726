#include "gauge.h"
#include "../severity.h"

#define SECOND_NS 1000000000u

void gauge_clear(kelly_gauge *gauge)
{
    gauge->now = (kelly_gauge_second){ 0 };
    gauge->last = gauge->now;
    gauge->seconds = 0;
}

void gauge_job(kelly_gauge *gauge, uint32_t job)
{
    if (gauge->job != job) {
        gauge->job = job;
        gauge->next = 0;
        gauge->samples = 0;
        gauge->stuck = 0;
    }
}

/* In increasing order: one that comes again counts once. Refused ones do not count. */
void gauge_count(kelly_gauge *gauge, uint32_t index, const kelly_result *result)
{
    if (index < gauge->next) {
        return;
    }
    gauge->next = index + 1u;
    if (result->status == KELLY_OK) {
        gauge->samples++;
        gauge->stuck += result->stuck;
    }
}

static void close_second(kelly_gauge *gauge)
{
    const uint32_t at = gauge->seconds % GAUGE_SECONDS;

    gauge->lowest[at] = gauge->now.lowest;
    gauge->highest[at] = gauge->now.highest;
    gauge->mean[at] = gauge->now.speed / (real)gauge->now.looks;
    gauge->last = gauge->now;
    gauge->now = (kelly_gauge_second){ 0 };
    gauge->seconds++;
}

static void add(real *sum, real *highest, real value, int first)
{
    *sum += value;
    if (first || value > *highest) {
        *highest = value;
    }
}

void gauge_look(kelly_gauge *gauge, const kelly_sight *sight, uint32_t tick, uint32_t step_ns)
{
    kelly_gauge_second *const s = &gauge->now;
    const uint32_t second = (uint32_t)((uint64_t)tick * step_ns / SECOND_NS);
    int first;

    if (second != gauge->second && s->looks > 0) {
        close_second(gauge);
    }
    gauge->second = second;
    first = s->looks == 0;
    s->looks++;
    s->lowest = first || sight->bit_speed < s->lowest ? sight->bit_speed : s->lowest;
    s->top += sight->top_speed;
    add(&s->speed, &s->highest, sight->bit_speed, first);
    add(&s->torque, &s->torque_high, sight->surface_torque, first);
    add(&s->weight, &s->weight_high, -sight->f_bit, first);
    add(&s->bit_torque, &s->bit_torque_high, -sight->bit_torque, first);
}

/* The last seconds together. */
static void show_bit(const kelly_gauge *gauge, kelly_wits *values)
{
    const uint32_t seconds = gauge->seconds < GAUGE_SECONDS ? gauge->seconds : GAUGE_SECONDS;
    real sum = 0;

    values->bit_lowest = gauge->lowest[0];
    values->bit_highest = gauge->highest[0];
    for (uint32_t k = 0; k < seconds; k++) {
        values->bit_lowest = gauge->lowest[k] < values->bit_lowest ? gauge->lowest[k] : values->bit_lowest;
        values->bit_highest = gauge->highest[k] > values->bit_highest ? gauge->highest[k] : values->bit_highest;
        sum += gauge->mean[k];
    }
    values->bit_mean = sum / (real)seconds;
    values->ss = kelly_severity(values->bit_lowest, values->bit_highest);
}

/* The last whole second. The model has one weight: what the rock feels is what the surface shows. */
static void show_second(const kelly_gauge_second *last, kelly_wits *values)
{
    const real looks = (real)last->looks;

    values->bit_wob_mean = last->weight / looks;
    values->bit_wob_max = last->weight_high;
    values->wob_mean = values->bit_wob_mean;
    values->wob_max = values->bit_wob_max;
    values->torque_mean = last->torque / looks;
    values->torque_max = last->torque_high;
    values->bit_torque_mean = last->bit_torque / looks;
    values->bit_torque_max = last->bit_torque_high;
    values->top_speed = last->top / looks;
}

void gauge_wits(const kelly_gauge *gauge, char *text, size_t room)
{
    kelly_wits values = { 0 };

    if (gauge->seconds > 0) {
        values.known |= KELLY_WITS_SURFACE | KELLY_WITS_BIT;
        values.activity = 2;
        show_second(&gauge->last, &values);
        show_bit(gauge, &values);
    }
    if (gauge->samples > 0) {
        values.known |= KELLY_WITS_STUDY;
        values.samples = gauge->samples;
        values.probability = (real)gauge->stuck / (real)gauge->samples;
    }
    (void)kelly_wits_frame(text, room, &values);
}
