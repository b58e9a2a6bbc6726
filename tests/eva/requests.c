/* bench.h: any byte after any bytes, whatever the bench does and holds; a slice of its work. Stubs: the string (plant.c), realisations
 * (ensemble.c), the console (console.c), what packs and unpacks (messages.c, link.c) and what sends (text.c). */
#include "app/bench.h"
#include "app/out.h"
#include "link/fields.h"
#include "link/keys.h"
#include "board.h"
#include "contracts.h"

#define any_speed() any_real(R(-1e6), R(1e6))
#define any_torque() any_real(R(-1e20), R(1e20))

static int yes_or_no(void) { return Frama_C_interval(0, 1); }

const uint8_t *board_image(uint32_t *size)
{
    static uint8_t image[64];

    ANY(image);
    *size = Frama_C_unsigned_int_interval(1, sizeof(image));
    return image;
}

void console_line(kelly_bench *bench, const char *line) { (void)bench, (void)line; }
void console_tick(kelly_bench *bench) { (void)bench; }

const char *kelly_case_error(const kelly_table *table, const kelly_case *run) { (void)table, (void)run; return yes_or_no() ? "refused" : 0; }

static void any_draw(kelly_draw *draw)
{
    draw->fc = draw->mu = draw->a1 = draw->a2 = draw->w0 = any_real(0, R(1e30));
}

void kelly_draw_nominal(const kelly_case *run, kelly_draw *draw)
{
    (void)run;
    any_draw(draw);
}

void kelly_draw_sample(const kelly_case *run, uint64_t seed, uint32_t index, kelly_draw *draw)
{
    (void)run, (void)seed, (void)index;
    any_draw(draw);
}

int kelly_plant_allows(const kelly_plant *plant, real top_speed, real weight) { (void)plant, (void)top_speed, (void)weight; return yes_or_no(); }
void kelly_plant_command(kelly_plant *plant, real top_speed, real weight, uint32_t ticks) { (void)plant, (void)top_speed, (void)weight, (void)ticks; }
void kelly_plant_advance(kelly_plant *plant, uint32_t ticks) { (void)plant, (void)ticks; }
int kelly_plant_sane(const kelly_plant *plant) { (void)plant; return yes_or_no(); }

kelly_status kelly_plant_start_commanded(kelly_plant *plant, const kelly_table *table, const kelly_case *run, const kelly_draw *draw, real top_speed)
{
    (void)plant, (void)table, (void)run, (void)draw, (void)top_speed;
    return (kelly_status)Frama_C_interval(KELLY_OK, KELLY_RANGE);
}

void kelly_plant_look(const kelly_plant *plant, kelly_sight *sight)
{
    (void)plant;
    *sight = (kelly_sight){ .bit_speed = any_speed(), .top_speed = any_speed(), .axial_speed = any_speed(), .bit_torque = any_torque(),
                            .surface_torque = any_torque(), .f_bit = any_torque() };
}

static void any_result(kelly_result *result)
{
    any_draw(&result->draw);
    result->lowest = result->highest = result->mean = any_speed();
    result->ss = any_real(0, R(1e30));
    result->status = Frama_C_unsigned_char_interval(0, KELLY_STATUSES - 1);
    result->stuck = result->liftoff = Frama_C_unsigned_char_interval(0, 1);
}

void kelly_run_begin(const kelly_table *table, const kelly_case *run, uint64_t seed, uint32_t first, unsigned count,
                     kelly_result *results, kelly_work *work)
{
    (void)table, (void)run, (void)seed, (void)first, (void)count, (void)work;
    any_result(results);
}

uint32_t kelly_run_advance(const kelly_table *table, const kelly_case *run, unsigned count, kelly_result *results,
                           kelly_work *work, uint32_t ticks)
{
    (void)table, (void)run, (void)count, (void)work, (void)ticks;
    any_result(results);
    return any_u32();
}

void kelly_run_finish(const kelly_table *table, const kelly_case *run, unsigned count, kelly_result *results, kelly_work *work)
{
    (void)table, (void)run, (void)count, (void)work;
    any_result(results);
}

/* What is given is whole: a text has begun, a number has been set and is finite. */
size_t kelly_put_fields(uint8_t *to, const void *from, const kelly_field *fields, size_t count)
{
    for (size_t k = 0; k < count; k++) {
        const char *const at = (const char *)from + fields[k].offset;
        const unsigned kind = fields[k].what & 15u;

        //@ assert kind != KELLY_FIELD_TEXT || \initialized(at);
        if (kind == KELLY_FIELD_REAL) {
            const real number = *(const real *)at;
        } else if (kind == KELLY_FIELD_F32) {
            const float number = *(const float *)at;
        } else if (kind == KELLY_FIELD_U32) {
            const uint32_t number = *(const uint32_t *)at;
        }
    }
    Frama_C_make_unknown((char *)to, KELLY_BODY_MAX);
    return Frama_C_size_t_interval(0, KELLY_BODY_MAX);
}

/* Fields within their ranges, or none. */
int kelly_get_fields(const uint8_t *body, size_t size, void *to, const kelly_field *fields, size_t count)
{
    //@ assert size == 0 || \valid_read(body + (0 .. size - 1));
    if (yes_or_no()) {
        return 0;
    }
    for (size_t k = 0; k < count; k++) {
        char *const at = (char *)to + fields[k].offset;
        const unsigned what = fields[k].what;

        switch (what & 15u) {
        case KELLY_FIELD_U8:
            *(uint8_t *)at = Frama_C_unsigned_char_interval(what >> 4 & 15u, what >> 8);
            break;
        case KELLY_FIELD_U16:
            *(uint16_t *)at = Frama_C_unsigned_short_interval(0, 65535);
            break;
        case KELLY_FIELD_U32:
            *(uint32_t *)at = any_u32();
            break;
        case KELLY_FIELD_U64:
            *(uint64_t *)at = any_u64();
            break;
        case KELLY_FIELD_F32:
            *(float *)at = Frama_C_float_interval(-ANY_FLOAT, ANY_FLOAT);
            break;
        case KELLY_FIELD_REAL:
            *(real *)at = any_real(-ANY_REAL, ANY_REAL);
            break;
        default:
            Frama_C_make_unknown(at, what >> 4);
            at[what >> 4] = '\0';
        }
    }
    return 1;
}

void kelly_set_text(char *to, size_t room, const char *from)
{
    //@ assert \valid_read(from);
    Frama_C_make_unknown(to, room);
    to[room - 1] = '\0';
}

size_t kelly_wits_frame(char *text, size_t room, const kelly_wits *values)
{
    //@ assert room > KELLY_WITS_TEXT;
    //@ assert -1e30 <= values->torque_mean <= 1e30 && -1e30 <= values->wob_mean <= 1e30 && -1e30 <= values->bit_torque_max <= 1e30;
    Frama_C_make_unknown(text, room);
    text[room - 1] = '\0';
    return room;
}

uint32_t kelly_job_key(uint32_t case_crc, uint64_t seed) { (void)case_crc, (void)seed; return any_u32(); }
uint32_t kelly_draw_key(const kelly_draw *draw) { (void)draw; return any_u32(); }

void out_defer(int on) { (void)on; }
int out_pump(void) { return yes_or_no(); }
int out_room(size_t bytes) { (void)bytes; return yes_or_no(); }

void out_frame(uint8_t wire[KELLY_WIRE_MAX], uint8_t type, uint32_t seq, size_t size)
{
    (void)type, (void)seq;
    //@ assert \valid(wire + (0 .. KELLY_WIRE_MAX - 1));
    //@ assert size <= KELLY_BODY_MAX && \initialized(wire + (KELLY_WIRE_BODY .. KELLY_WIRE_BODY + KELLY_BODY_MAX - 1));
}

/* ---- */

static kelly_bench bench;

static void any_second(kelly_gauge_second *second)
{
    second->lowest = second->highest = second->speed = second->top = any_real(R(-1e12), R(1e12));
    second->torque = second->torque_high = second->bit_torque = second->bit_torque_high = any_real(R(-1e26), R(1e26));
    second->weight = second->weight_high = second->torque;
    second->looks = any_u32();
}

static void any_gauge(void)
{
    kelly_gauge *const gauge = &bench.gauge;

    any_second(&gauge->last);
    gauge->last.looks = Frama_C_unsigned_int_interval(1, UINT32_MAX);
    any_second(&gauge->now);
    for (unsigned k = 0; k < GAUGE_SECONDS; k++) {
        gauge->lowest[k] = gauge->highest[k] = gauge->mean[k] = any_real(R(-1e12), R(1e12));
    }
    gauge->seconds = any_u32();
    gauge->second = any_u32();
    gauge->job = any_u32();
    gauge->next = any_u32();
    gauge->samples = any_u32();
    gauge->stuck = any_u32();
}

static void any_campaign(kelly_campaign *c)
{
    any_result(&c->at.result);
    for (unsigned k = 0; k < CAMPAIGN_KEPT; k++) {
        c->kept[k].job = c->kept[k].index = any_u32();
        c->kept[k].filled = any_byte();
        any_result(&c->kept[k].result);
    }
    c->at.job = c->at.index = any_u32();
    c->at.filled = any_byte();
    c->kept_next = any_u32();
    c->seed = any_u64();
    c->job = any_u32();
    c->next = any_u32();
    c->left = any_u32();
    c->chunk = any_u32();
}

static void any_lockstep(kelly_lockstep *lock)
{
    kelly_msg_lock_answer *const a = &lock->answer;

    lock->frame = lock->seq = lock->left = any_u32();
    a->session = a->frame = a->tick = any_u32();
    a->bit_speed = a->axial_speed = a->top_speed = any_speed();
    a->bit_torque = a->f_bit = a->surface_torque = any_torque();
    a->sane = any_byte();
}

static void any_realtime(kelly_realtime *rt)
{
    ANY(*rt);
    rt->weight = any_torque();
    rt->policy = Frama_C_unsigned_char_interval(0, 2);
    rt->period = Frama_C_unsigned_int_interval(1, 1000);       /* steps of 1 s at most: kelly_case_error */
}

static void any_bench(uint8_t holds)
{
    bench.receiver.good = any_u32();
    bench.receiver.bad = any_u32();
    bench.receiver.size = Frama_C_unsigned_short_interval(0, KELLY_FRAME_MAX);
    bench.receiver.left = any_byte();
    bench.receiver.code = any_byte();
    bench.receiver.inside = any_byte();
    bench.receiver.fresh = any_byte();
    ANY(bench.receiver.payload);
    ANY(bench.line);
    bench.length = Frama_C_unsigned_char_interval(0, LINE_MAX - 1);
    bench.dirty = any_byte();
    bench.decided = any_byte();
    bench.greeted = any_byte();
    bench.holds = holds;
    bench.state = Frama_C_nondet(KELLY_STATE_IDLE, holds);
    bench.case_set = any_byte();
    bench.case_crc = any_u32();
    bench.status_tick = any_u32();
    bench.run.step_ns = any_u32();
    if (holds == KELLY_STATE_CAMPAIGN) {
        any_campaign(&bench.now.campaign);
    } else if (holds != KELLY_STATE_IDLE) {
        bench.now.session.id = any_u32();
        bench.now.session.status = any_byte();
        bench.now.session.known = any_byte();
        if (holds == KELLY_STATE_LOCKSTEP) {
            any_lockstep(&bench.now.session.by.lock);
        } else {
            any_realtime(&bench.now.session.by.real_time);
        }
    }
    any_gauge();
}

int main(void)
{
    //@ loop unroll 4;
    for (uint8_t holds = KELLY_STATE_IDLE; holds <= KELLY_STATE_REALTIME; holds++) {
        any_bench(holds);
        (void)bench_take(&bench, any_byte());
        //@ assert bench.length < LINE_MAX;
    }
    any_bench(KELLY_STATE_CAMPAIGN);
    campaign_slice(&bench);
    any_bench(KELLY_STATE_LOCKSTEP);
    (void)lockstep_slice(&bench);
    any_bench(KELLY_STATE_REALTIME);
    (void)realtime_slice(&bench);
    realtime_busy(&bench, any_u32());
    return 0;
}
