/* cmd_advise.c - the nearest settings that bring the probability of stick-slip under a limit.
 *
 * Four rays leave the setting: more and less speed, more and less weight. All go out in equal steps of their axis until P is below the
 * limit or the range ends; then the last step is halved to RESOLUTION. Every P on the way is that of a whole cell,
 * so what is printed is what `montecarlo` says there. Between two steps of a ray P is assumed to cross the limit once.
 */
#include <math.h>
#include <string.h>

#include "../firmware/link/crc32c.h"
#include "map.h"
#include "outcome.h"
#include "team.h"

#define RESOLUTION 0.1           /* [rpm], [kN] */
#define STEPS 50.0               /* of a ray over the whole range of its axis, about */
#define RECORDS 1024u            /* cells of a search, at most: four rays of 75 steps, and as many halvings as a step has bits */

typedef struct {
    double lo, hi;               /* searched [rpm], [kN] */
} range;

/* One direction: offsets are counted in RESOLUTION from the setting. */
typedef struct {
    int weight, sign;            /* axis; which way */
    uint32_t reach, step;        /* the farthest offset, that of a step */
    uint32_t no, yes;            /* the farthest offset known not to do, the nearest known to; yes 0: none yet */
    uint32_t next;               /* offset being tried, 0: nothing */
    cell at_yes;                 /* what was found there */
} ray;

typedef struct {
    options opts;
    study how;
    double limit;
    range range[2];              /* speed, weight */
    int f0_given;
    cell now;
    ray rays[4];
    const ray *best[2];          /* by speed, by weight; 0: none within the range */
    double lowest[2];            /* smallest P met on each axis, of settings where a realisation could be trusted; NaN: none */
    uint32_t trusted;            /* such settings, the present one with them */
    journal log;
    uint32_t ran;                /* cells so far, in an order that their results decide: the same in every run */
    cell known[RECORDS];         /* what an earlier run had found of each */
} advice;

static const option_help advise_options[] = {
    { "--below", "P", "the limit of P (default 0.05)" },
    { "--search-rpm", "LO:HI", "speeds that may be advised [rpm] (default: half to twice the speed)" },
    { "--search-wob", "LO:HI", "weights that may be advised [kN] (default: a quarter to twice the weight)" },
    { "--f0", "KN", "amplitude of the weight [kN] at every setting (default: its ratio to the weight stays the well file's)" },
    { "--samples", "N", "realisations of every setting (default 400)" },
    { "--cov", "D", "coefficients of variation 0..0.5: one for all, or fc=D,mu=D,a1=D,a2=D,rpm=D (default: the well file's)" },
    { "--seed", "S", "of the random streams (default 1)" },
    { "--first", "J", "index of the first realisation (default 0)" },
    { "--threads", "T", "threads (default: one a processor); no result depends on it" },
    { "--engine", "NAME", "vector unit: scalar, sse2, avx2, avx512 (default: the widest here); no result depends on it" },
    { "--twice", 0, TWICE_HELP },
    { 0 },
};

const command_help advise_help = {
    .brief = "the nearest speed, and the nearest weight, at which P(stick-slip) is under a limit",
    .synopsis = "--rpm R --wob W [case] [--below P] [--samples N] [--json F] [--resume] ...",
    .takes = TAKES_CASE | TAKES_JSON | TAKES_RESUME,
    .own = advise_options,
    .notes = "Speed and weight are changed one at a time, with the same realisations everywhere; f0 keeps its ratio to the weight unless\n"
             "--f0 is given. Each axis is searched outwards in steps of a fiftieth of its range, then to 0.1 rpm or 0.1 kN, for the smallest\n"
             "change whose P (refused realisations counted as stuck) is below the limit. P of so many realisations has ups and downs;\n"
             "what lies between two steps is not looked at. The interval is printed beside it: with more --samples it narrows.\n"
             "--start rotating advises for a string that already turns.\n"
             "F.json.journal beside the JSON holds what is done and goes when all is written.",
    .example = "kelly advise --rpm 100 --wob 100 --mu 0.004 --start rotating --below 0.05",
};

/* ---- what is asked for --------------------------------------------------------------------------------------------- */

static range parse_range(const char *option, const char *text, double at, double lo, double hi)
{
    const char *const colon = text ? strchr(text, ':') : 0;
    char copy[128];
    range r;

    if (!text) {
        return (range){ decimal(lo), decimal(hi) };
    }
    if (!colon || strlen(text) >= sizeof(copy)) {
        die(EXIT_USAGE, "%s %s: not a range; give LO:HI", option, text);
    }
    strcpy(copy, text);
    copy[colon - text] = '\0';
    r.lo = option_number(option, copy, 1e-3, 1e6, "LO:HI, both > 0");
    r.hi = option_number(option, colon + 1, 1e-3, 1e6, "LO:HI, both > 0");
    if (!(r.lo <= at && at <= r.hi)) {
        die(EXIT_USAGE, "%s %s: leaves out the present %.6g; give a range around it", option, text, at);
    }
    return r;
}

/* A setting as the decimal number that was typed: run.w0 is not, in float. The well's own to the digits of a float. */
static double setting(const char *option, const char *text, double most, const char *right, double fallback)
{
    char digits[40];

    if (text) {
        return decimal(option_number(option, text, 1e-3, most, right));
    }
    snprintf(digits, sizeof(digits), "%.7g", fallback);
    return option_number(option, digits, 0, most, right);
}

static void parse(advice *a, int argc, char **argv)
{
    const char *const below = take_option(&argc, argv, "--below"), *const rpm = take_option(&argc, argv, "--search-rpm");
    const char *const wob = take_option(&argc, argv, "--search-wob");
    const double at_rpm = setting("--rpm", take_option(&argc, argv, "--rpm"), 1e4, "top speed in rpm, 0.001..10000",
                                  (double)kelly_string.nominal.w0 / RPM);
    const double at_wob = setting("--wob", take_option(&argc, argv, "--wob"), 1e6, "weight on bit in kN, > 0",
                                  (double)kelly_string.nominal.fc / 1000.0);

    a->f0_given = has_option(argc, argv, "--f0");
    if (has_option(argc, argv, "--csv") || has_option(argc, argv, "--convergence")) {
        die(EXIT_USAGE, "advise: %s does not belong here; see kelly advise --help", has_option(argc, argv, "--csv") ? "--csv" : "--convergence");
    }
    options_parse(&a->opts, argc, argv, TAKES_CASE | TAKES_ENSEMBLE | TAKES_JSON | TAKES_RESUME, "advise", 0, 0);
    check_indices(&a->opts);
    a->limit = below ? option_number("--below", below, 1e-9, 1.0, "a probability, 0 < P <= 1, e.g. 0.05") : 0.05;
    a->how = (study){ .opts = &a->opts, .engine = engine_choose(a->opts.engine), .silent = 1 };
    a->range[0] = parse_range("--search-rpm", rpm, at_rpm, at_rpm / 2, at_rpm * 2);
    a->range[1] = parse_range("--search-wob", wob, at_wob, at_wob / 4, at_wob * 2);
    a->now = (cell){ .rpm = at_rpm, .wob_kN = at_wob, .f0_kN = f0_at(&a->opts, a->f0_given, at_wob), .rotating = a->opts.run.rotating };
}

/* ---- journal --------------------------------------------------------------------------------------------------------- */

static void open_journal(advice *a)
{
    const char *const beside = outcome_beside(&a->opts);
    char text[256];

    snprintf(text, sizeof(text), "%08x %u %u %d %a %a %a %a %a %a %a", case_identity(&a->opts.run), a->opts.samples, a->opts.first, a->f0_given,
             a->limit, a->now.rpm, a->now.wob_kN, a->range[0].lo, a->range[0].hi, a->range[1].lo, a->range[1].hi);
    if (beside) {
        journal_open(&a->log, beside, &(journal_run){ .kind = "advise", .model = kelly_string.id, .seed = a->opts.seed,
                     .parameters = kelly_crc32c(0, (const uint8_t *)text, strlen(text)), .records = RECORDS, .payload = CELL_PAYLOAD,
                     .twice = a->opts.twice, .sound = cell_sound },
                     a->opts.resume);
        cells_recall(&a->log, a->known);
        a->how.log = &a->log;
    }
}

/* Run cells that have a setting, from where the journal leaves them. */
static void run_cells(advice *a, cell *cells, uint32_t count)
{
    for (uint32_t k = 0; k < count && a->ran + count <= RECORDS; k++) {
        const cell *const known = &a->known[a->ran + k];

        cells[k].tally = known->tally;
        cells[k].lo = known->lo;
        cells[k].hi = known->hi;
    }
    cells_run(&a->how, cells, count, a->ran);
    a->ran += count;
    for (uint32_t k = 0; k < count; k++) {
        a->trusted += cell_trusted(&cells[k]) ? 1u : 0u;
    }
}

/* ---- the search -------------------------------------------------------------------------------------------------------- */

/* Refused realisations count as stuck: advice leans to the safe side. */
static double cautious(const cell *c)
{
    return (double)(c->tally.stuck + kelly_refused(&c->tally)) / (double)c->tally.samples;
}

static void start_rays(advice *a)
{
    for (unsigned i = 0; i < 4; i++) {
        ray *const r = &a->rays[i];
        const range *const within = &a->range[i / 2];
        const double at = i / 2 ? a->now.wob_kN : a->now.rpm;
        const double span = i % 2 ? at - within->lo : within->hi - at;
        const double step = floor((within->hi - within->lo) / STEPS / RESOLUTION + 0.5);

        *r = (ray){ .weight = i / 2 != 0, .sign = i % 2 ? -1 : 1, .reach = (uint32_t)floor(span / RESOLUTION + 1e-6),
                    .step = step > 1 ? (uint32_t)step : 1 };
    }
}

static cell on_ray(const advice *a, const ray *r, uint32_t offset)
{
    const double change = r->sign * RESOLUTION * (double)offset;
    cell c = a->now;

    c.tally = (kelly_tally){ 0 };
    if (r->weight) {
        c.wob_kN = decimal(c.wob_kN + change);
        c.f0_kN = f0_at(&a->opts, a->f0_given, c.wob_kN);
    } else {
        c.rpm = decimal(c.rpm + change);
    }
    return c;
}

/* What to try next on a ray: a step further out, the middle of what was found, or nothing (0). A ray gives up once the
 * other one of its axis has found something at least as near as all that it could still find. */
static uint32_t next_offset(const ray *r, const ray *other)
{
    if (other->yes && (other->yes <= r->no || (r->yes && other->yes <= r->no + 1))) {
        return 0;
    }
    if (r->yes) {
        return r->yes - r->no > 1 ? (r->yes + r->no) / 2 : 0;
    }
    if (r->no == r->reach || (other->yes && r->no + 1 >= other->yes)) {
        return 0;
    }
    return r->no + r->step < r->reach ? r->no + r->step : r->reach;
}

/* Try every ray's next offset, all at once; returns how many there were. */
static unsigned advance(advice *a)
{
    cell cells[4];
    ray *which[4];
    unsigned count = 0;

    for (unsigned i = 0; i < 4; i++) {
        a->rays[i].next = next_offset(&a->rays[i], &a->rays[i ^ 1u]);
        if (a->rays[i].next) {
            cells[count] = on_ray(a, &a->rays[i], a->rays[i].next);
            which[count++] = &a->rays[i];
        }
    }
    if (count > 0) {
        run_cells(a, cells, count);
    }
    for (unsigned k = 0; k < count; k++) {
        ray *const r = which[k];
        const double p = cautious(&cells[k]);

        if (cell_trusted(&cells[k])) {
            a->lowest[r->weight] = fmin(p, a->lowest[r->weight]);
        }
        if (p < a->limit) {
            r->yes = r->next;
            r->at_yes = cells[k];
        } else {
            r->no = r->next;
        }
    }
    return count;
}

static void search(advice *a)
{
    start_rays(a);
    while (advance(a) > 0) {
    }
    for (unsigned i = 0; i < 4; i++) {
        const ray *const r = &a->rays[i];

        if (r->yes && (!a->best[r->weight] || r->yes < a->best[r->weight]->yes)) {
            a->best[r->weight] = r;
        }
    }
}

/* ---- output ---------------------------------------------------------------------------------------------------------- */

static void print_probability(const cell *c)
{
    const double p = cell_probability(c);

    if (isnan(p)) {
        fputs("P(stick-slip) is unknown: every realisation was refused", stdout);
    } else {
        printf("P(stick-slip) = %.4f   95 %% interval %.4f .. %.4f   (%u of %u", p, c->lo, c->hi, c->tally.stuck,
               c->tally.samples - kelly_refused(&c->tally));
        if (kelly_refused(&c->tally) > 0) {
            printf(", %u refused: step %u, range %u, nonfinite %u", kelly_refused(&c->tally), c->tally.status[KELLY_STEP], c->tally.status[KELLY_RANGE],
                   c->tally.status[KELLY_NONFINITE]);
        }
        putchar(')');
    }
    putchar('\n');
}

static void print_axis(const advice *a, unsigned weight)
{
    static const char *const names[2] = { "speed ", "weight" }, *const units[2] = { "rpm", "kN" };
    const ray *const r = a->best[weight];

    if (r) {
        printf("%s  %+8.1f %-3s -> %.6g rpm, %.6g kN, f0 %.6g kN: ", names[weight], r->sign * RESOLUTION * (double)r->yes, units[weight],
               r->at_yes.rpm, r->at_yes.wob_kN, r->at_yes.f0_kN);
        print_probability(&r->at_yes);
        return;
    }
    printf("%s  none in %.6g..%.6g %s is below %.6g; ", names[weight], a->range[weight].lo, a->range[weight].hi, units[weight], a->limit);
    if (isnan(a->lowest[weight])) {
        puts("no realisation there can be trusted");
    } else {
        printf("the lowest P found is %.4f\n", a->lowest[weight]);
    }
}

static void print_advice(const advice *a)
{
    char drive[DRIVE_TEXT];

    printf("%s, start %s, mu %.6g, f0 %.6g kN, %u samples, seed %llu%s\n", kelly_string.id, a->now.rotating ? "rotating" : "rest",
           (double)a->opts.run.mu, a->now.f0_kN, a->opts.samples, (unsigned long long)a->opts.seed,
           drive_remark(&a->opts.run.drive, drive));
    printf("now                  %.6g rpm, %.6g kN: ", a->now.rpm, a->now.wob_kN);
    print_probability(&a->now);
    if (cautious(&a->now) < a->limit) {
        printf("already below %.6g: nothing to change\n", a->limit);
        return;
    }
    print_axis(a, 0);
    print_axis(a, 1);
    if (!a->best[0] && !a->best[1]) {
        return;
    }
    printf("each is an estimate below %.6g from %u realisations, and its interval says how sure; f0 %s\n", a->limit, a->opts.samples,
           a->f0_given ? "as given" : "keeps its ratio to the weight: give --f0 as printed to run a setting with montecarlo");
}

static void json_setting(FILE *to, const char *name, const cell *c, const char *end)
{
    const double p = c ? cell_probability(c) : (double)NAN;

    if (!c) {
        fprintf(to, "  \"%s\": null%s\n", name, end);
        return;
    }
    fprintf(to, "  \"%s\": {\"rpm\": %.12g, \"wob_kN\": %.12g, \"f0_kN\": %.12g, \"probability\": ", name, c->rpm, c->wob_kN, c->f0_kN);
    if (isnan(p)) {
        fputs("null", to);
    } else {
        fprintf(to, "%.17g", p);
    }
    fprintf(to, ", \"ci95\": [%.17g, %.17g], \"samples\": %u, \"stuck\": %u, \"refused\": %u, \"digest\": \"%08x\"}%s\n", c->lo, c->hi, c->tally.samples,
            c->tally.stuck, kelly_refused(&c->tally), c->tally.digest, end);
}

static void write_json(FILE *to, const advice *a)
{
    char drive[DRIVE_TEXT];

    fprintf(to, "{\n  \"model\": \"%s\",\n  \"real\": \"%s\",\n  \"seed\": %llu,\n  \"first\": %u,\n  \"start\": \"%s\",\n  \"below\": %.12g,\n",
            kelly_string.id, sizeof(real) > 4 ? "double" : "float", (unsigned long long)a->opts.seed, a->opts.first,
            a->now.rotating ? "rotating" : "rest", a->limit);
    fprintf(to, "  \"drive\": \"%s\",\n", drive_text(&a->opts.run.drive, drive));
    fprintf(to, "  \"searched_rpm\": [%.12g, %.12g],\n  \"searched_wob_kN\": [%.12g, %.12g],\n  \"below_already\": %s,\n", a->range[0].lo,
            a->range[0].hi, a->range[1].lo, a->range[1].hi, cautious(&a->now) < a->limit ? "true" : "false");
    json_setting(to, "now", &a->now, ",");
    json_setting(to, "by_rpm", a->best[0] ? &a->best[0]->at_yes : 0, ",");
    json_setting(to, "by_wob", a->best[1] ? &a->best[1]->at_yes : 0, "");
    fputs("}\n", to);
}

/* A search that met nothing that can be trusted is no answer. */
static int answered(const advice *a)
{
    const kelly_case run = cell_case(&a->how, &a->now);
    char text[ADVICE_TEXT];

    if (a->trusted > 0) {
        return EXIT_DONE;
    }
    fprintf(stderr, "kelly: advise: no answer: no realisation of any setting can be trusted: %s\n", advice_on(&run, &a->now.tally, text));
    return EXIT_FAILED;
}

int command_advise(int argc, char **argv)
{
    static advice a = { .lowest = { (double)NAN, (double)NAN } };
    outfile json = { 0 };

    parse(&a, argc, argv);
    if (team_rank() > 0) {
        cells_follow(&a.how);
        return EXIT_DONE;
    }
    if (a.opts.json) {
        outfile_open(&json, a.opts.json);
    }
    open_journal(&a);
    run_cells(&a, &a.now, 1);
    if (!(cautious(&a.now) < a.limit)) {
        search(&a);
    }
    team_dismiss();
    if (a.opts.json) {
        write_json(json.stream, &a);
        outfile_close(&json);
    }
    journal_remove(&a.log);
    if (!a.opts.quiet && !(a.opts.json && strcmp(a.opts.json, "-") == 0)) {
        print_advice(&a);
    }
    return answered(&a);
}
