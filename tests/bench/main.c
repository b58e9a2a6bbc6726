/* main.c - kelly, its peers and the machine, timed in turns on one core.
 *
 *     bench OUT KELLY KELLY_DOUBLE [--long] [--scan PEER] [-- PYTHON peers.py]
 *
 * Times are ns of processor time for one simulated 1 ms of one realisation: medians over rounds. A peer that does not
 * meet its tolerance is recorded as failed and not timed; the exit status is then 1.
 */
#include <math.h>
#include <sched.h>
#include <signal.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "run.h"

#define NOMINAL_ROUNDS 7
#define DRAWN_ROUNDS 3
#define SLOW 300.0               /* [ns] peers above run every third round */
#define CONTESTANTS_MAX 96
#define SMOOTH 0.1               /* [rpm] error of kelly's RK4 on a realisation that is not chaotic */

/* Somebody who integrates: a peer, kelly on one engine, or a peer behind the pipe. */
typedef struct {
    const peer *who;
    const side *kelly;
    unsigned engine, count;      /* kelly's */
    char name[80], told[80];     /* the setting that the other side told */
    double ns[NOMINAL_ROUNDS], drawn[DRAWN_ROUNDS];
    unsigned n, n_drawn;
    double error, worst;         /* on the nominal realisation, on the drawn ones [rpm] */
    int good;
} contestant;

#define SIDES 4u
static const side *const sides[SIDES] = { &side_float, &side_double, &side_float_bare, &side_double_bare };
static contestant list[CONTESTANTS_MAX];
static unsigned contestants;
static problem nominal, drawn[DRAWS];
static long draws[DRAWS];          /* their indices */
static double *reference, *drawn_reference[DRAWS];
static FILE *results;
static FILE *to_python, *from_python;
static cpu_set_t everywhere;

void record(const char *kind, const char *format, ...)
{
    va_list arguments;

    va_start(arguments, format);
    fprintf(results, "{\"kind\": \"%s\", ", kind);
    vfprintf(results, format, arguments);
    fputs("}\n", results);
    va_end(arguments);
    fflush(results);
}

void spread(int out)
{
    cpu_set_t one;

    if (out) {
        sched_setaffinity(0, sizeof(everywhere), &everywhere);
        return;
    }
    sched_getaffinity(0, sizeof(everywhere), &everywhere);
    CPU_ZERO(&one);
    CPU_SET(sched_getcpu(), &one);
    sched_setaffinity(0, sizeof(one), &one);
}

/* ---- one run of one contestant: ns a step ----------------------------------------------------------------------- */

static double run_peer(const peer *p, const problem *what, const setting *set, const double *against, observer *o)
{
    double begin;

    *o = (observer){ .lowest = 1e9, .highest = -1e9, .reference = against };
    begin = busy();
    p->run(what, set, o);
    return 1e9 * (busy() - begin) / ((double)STEPS * p->lanes);
}

static double run_kelly(const contestant *c)
{
    const double begin = busy();

    c->kelly->run(c->engine, -1.0, MODES, STEPS, 0, c->count);
    return 1e9 * (busy() - begin) / ((double)STEPS * c->count);
}

/* The other side times itself, on the same core, and answers "ns error_rpm". */
static double run_python(contestant *c)
{
    double ns = (double)NAN;

    fprintf(to_python, "%s\n", c->name);
    fflush(to_python);
    if (fscanf(from_python, "%lf %lf", &ns, &c->error) != 2) {
        ns = (double)NAN;
    }
    return ns;
}

static double run_once(contestant *c)
{
    observer o;

    return c->kelly ? run_kelly(c) : c->who ? run_peer(c->who, &nominal, &c->who->set, 0, &o) : run_python(c);
}

/* ---- who takes part --------------------------------------------------------------------------------------------- */

static contestant *add(const char *name)
{
    contestant *const c = &list[contestants++];

    if (contestants > CONTESTANTS_MAX) {
        abort();
    }
    snprintf(c->name, sizeof(c->name), "%.79s", name);
    return c;
}

static void add_kelly(const side *s)
{
    unsigned width, lanes;
    const char *engine;

    for (unsigned e = 0; (engine = s->engine(e, &width, &lanes)) != 0; e++) {
        char name[80];

        for (unsigned count = lanes; s->guarded || count > 1; count = 1) {
            contestant *c;

            snprintf(name, sizeof(name), "kelly %s, %s, %u%s", s->precision, engine, count, s->guarded ? "" : ", unguarded");
            c = add(name);
            c->kelly = s;
            c->engine = e;
            c->count = count;
            if (count == 1) {
                break;
            }
        }
    }
}

static const peer *const peers[] = {
    textbook_O2, textbook_O3, textbook_fast, own_double_O2, own_double_O3, own_float_O2, own_float_O3, lanes_double, lanes_float,
    gsl_O2, gsl_O3, gsl_fast, sundials_O2, sundials_O3, sundials_fast, boost_O2, boost_O3, boost_fast,
};

static void add_peers(void)
{
    for (size_t i = 0; i < sizeof(peers) / sizeof(peers[0]); i++) {
        for (const peer *p = peers[i]; p->name; p++) {
            add(p->name)->who = p;
        }
    }
}

/* Start the other side and ask who is there: a line each, then an empty one. */
static void add_python(char **command)
{
    int ours[2], theirs[2];
    char line[160];

    if (pipe(ours) != 0 || pipe(theirs) != 0) {
        return;
    }
    if (fork() == 0) {
        dup2(ours[0], STDIN_FILENO);
        dup2(theirs[1], STDOUT_FILENO);
        close(ours[1]);
        close(theirs[0]);
        execvp(command[0], command);
        _exit(127);
    }
    close(ours[0]);
    close(theirs[1]);
    to_python = fdopen(ours[1], "w");
    from_python = fdopen(theirs[0], "r");
    fwrite(&nominal, sizeof(nominal), 1, to_python);
    fwrite(reference, sizeof(*reference), STEPS * FINE + 1, to_python);
    fflush(to_python);
    while (fgets(line, sizeof(line), from_python) && line[0] != '\n') {
        char *const tab = strchr(line, '\t');

        line[strcspn(line, "\n")] = '\0';
        if (tab) {
            *tab = '\0';
            snprintf(add(line)->told, sizeof(list[0].told), "%.79s", tab + 1);
        }
    }
}

/* ---- the contest ------------------------------------------------------------------------------------------------ */

/* The nominal realisation and the first drawn ones that are not chaotic, with their references. */
static void choose_problems(void)
{
    unsigned found = 0;

    side_double.problem(-1, &nominal);
    reference = make_reference(&nominal);
    for (long j = 0; found < DRAWS; j++) {
        side_double.problem(j, &drawn[found]);
        drawn_reference[found] = make_reference(&drawn[found]);
        if (side_double.trace(j, drawn_reference[found]) < SMOOTH * RPM) {
            draws[found++] = j;
        } else {
            free(drawn_reference[found]);
        }
    }
}

/* Nobody's time counts before the trajectory is right. Returns the number of failures. */
static unsigned check_all(void)
{
    unsigned failed = 0;

    for (unsigned i = 0; i < contestants; i++) {
        contestant *const c = &list[i];
        const double limit = c->who ? c->who->limit : ERROR_LIMIT;
        observer o;

        if (c->kelly) {
            c->error = c->kelly->trace(-1, reference) / RPM;
            for (unsigned j = 0; j < DRAWS; j++) {
                c->worst = fmax(c->worst, c->kelly->trace(draws[j], drawn_reference[j]) / RPM);
            }
        } else if (c->who) {
            run_peer(c->who, &nominal, &c->who->set, reference, &o);
            c->error = o.steps > 1 ? o.error / RPM : (double)NAN;
        } else {
            c->ns[c->n++] = run_python(c);
        }
        c->good = c->error <= limit;
        if (!c->good) {
            fprintf(stderr, "FAILED  %s (%s): %g rpm from the reference, %g allowed\n", c->name, c->who ? c->who->flags : "", c->error, limit);
            failed++;
        }
    }
    return failed;
}

static void check_digests(const side *s)
{
    unsigned width, lanes;
    const char *engine;

    for (unsigned e = 0; (engine = s->engine(e, &width, &lanes)) != 0; e++) {
        record("digest", "\"real\": \"%s\", \"engine\": \"%s\", \"width\": %u, \"lanes\": %u, \"digest\": \"%08x\"", s->precision, engine, width,
               lanes, s->run(e, -1.0, MODES, STEPS, 0, 96));
    }
}

static void nominal_rounds(void)
{
    for (unsigned r = 0; r < NOMINAL_ROUNDS; r++) {
        for (unsigned i = 0; i < contestants; i++) {
            contestant *const c = &list[i];

            if (c->good && (r % 3 == 0 || c->n == 0 || c->ns[0] < SLOW)) {
                c->ns[c->n < NOMINAL_ROUNDS ? c->n++ : 0] = run_once(c);
            }
        }
        peaks_round(r);
        fprintf(stderr, "\rround %u of %u  ", r + 1, NOMINAL_ROUNDS);
    }
    peaks_record(NOMINAL_ROUNDS);
}

/* Whether no other build of the same peer was faster. */
static int best_build(const contestant *c)
{
    for (unsigned i = 0; i < contestants; i++) {
        if (strcmp(list[i].name, c->name) == 0 && list[i].good && median(list[i].ns, list[i].n) < median(c->ns, c->n)) {
            return 0;
        }
    }
    return 1;
}

/* The same peers at their best flags and the same settings over the drawn realisations: adaptive ones take other steps there. */
static void drawn_rounds(void)
{
    for (unsigned r = 0; r < DRAWN_ROUNDS; r++) {
        for (unsigned i = 0; i < contestants; i++) {
            contestant *const c = &list[i];
            double sum = 0;
            observer o;

            if (!c->who || !c->good || !best_build(c)) {
                continue;
            }
            for (unsigned j = 0; j < DRAWS; j++) {
                if (r == 0) {
                    run_peer(c->who, &drawn[j], &c->who->set, drawn_reference[j], &o);
                    c->worst = o.error / RPM > c->worst ? o.error / RPM : c->worst;
                }
                sum += run_peer(c->who, &drawn[j], &c->who->set, 0, &o);
            }
            c->drawn[c->n_drawn++] = sum / DRAWS;
        }
        fprintf(stderr, "\rdrawn round %u of %u  ", r + 1, DRAWN_ROUNDS);
    }
    fputs("\n", stderr);
}

static void record_contestants(void)
{
    for (unsigned i = 0; i < contestants; i++) {
        const contestant *const c = &list[i];
        char extra[200] = "", error[24] = "null";

        if (isfinite(c->error)) {
            snprintf(error, sizeof(error), "%.4g", c->error);
        }

        if (c->kelly) {
            unsigned width, lanes;

            snprintf(extra, sizeof(extra), ", \"kelly\": \"%s\", \"guarded\": %s, \"engine\": \"%s\", \"count\": %u, \"drawn_error_rpm\": %.4g",
                     c->kelly->precision, c->kelly->guarded ? "true" : "false", c->kelly->engine(c->engine, &width, &lanes), c->count, c->worst);
        } else if (c->n_drawn > 0) {
            snprintf(extra, sizeof(extra), ", \"drawn_ns\": %.4f, \"drawn_error_rpm\": %.4g", median(c->drawn, c->n_drawn), c->worst);
        }
        record("time", "\"name\": \"%s\", \"flags\": \"%s\", \"told\": \"%s\", \"h\": %g, \"rtol\": %g, \"atol\": %g, \"ok\": %s, \"error_rpm\": %s, \"rounds\": %u, \"ns\": %.4f%s",
               c->name, c->who ? c->who->flags : c->kelly ? (c->kelly->guarded ? "as built" : "-DKELLY_GUARD=0") : "", c->told, c->who ? c->who->set.h : 1e-3, c->who ? c->who->set.rtol : 0, c->who ? c->who->set.atol : 0,
               c->good ? "true" : "false", error, c->n, c->good ? median(c->ns, c->n) : -1.0, extra);
    }
}

/* How the settings of the adaptive peers were found: error, steps and least time against tolerances and longest step. */
static void scan(const char *name)
{
    static const double ratios[] = { 0.1, 1, 10, 100 }, longest[] = { 1, 4.4e-3, 4.2e-3, 4e-3, 3.6e-3 };

    for (unsigned i = 0; i < contestants; i++) {
        const peer *const p = list[i].who;

        for (unsigned k = 0; p && strstr(p->name, name) && p->set.rtol > 0 && strstr(p->flags, "fast") && k < sizeof(ratios) / sizeof(ratios[0]) * 5; k++) {
            for (double rtol = 1e-4; rtol > 2e-8; rtol *= 0.56234132519034907) {
                const setting set = { longest[k % 5], rtol, rtol * ratios[k / 5] };
                double ns = 1e9;
                observer o;

                for (int again = 0; again < 3; again++) {
                    ns = fmin(ns, run_peer(p, &nominal, &set, reference, &o));
                }
                printf("%-36s h <= %.4g rtol %.2e atol %.2e  %8.4f rpm  %8ld steps  %7.1f ns\n", p->name, set.h, set.rtol, set.atol,
                       o.error / RPM, o.steps, ns);
            }
        }
    }
}

int main(int argc, char **argv)
{
    int is_long = 0;
    const char *scanned = 0;
    unsigned failed, width, lanes;

    if (argc < 4 || !(results = fopen(argv[1], "w"))) {
        fputs("bench OUT KELLY KELLY_DOUBLE [--long] [--scan PEER] [-- PYTHON peers.py]\n", stderr);
        return 2;
    }
    signal(SIGPIPE, SIG_IGN);
    spread(0);
    choose_problems();
    for (unsigned i = 0; i < SIDES; i++) {
        add_kelly(sides[i]);
    }
    add_peers();
    for (int i = 4; i < argc; i++) {
        is_long = is_long || strcmp(argv[i], "--long") == 0;
        scanned = strcmp(argv[i], "--scan") == 0 && i + 1 < argc ? argv[i + 1] : scanned;
        if (strcmp(argv[i], "--") == 0) {
            add_python(&argv[i + 1]);
            break;
        }
    }
    if (scanned) {
        scan(scanned);
        return 0;
    }
    failed = check_all();
    for (unsigned i = 0; i < SIDES; i++) {
        check_digests(sides[i]);
    }
    nominal_rounds();
    drawn_rounds();
    record_contestants();
    for (unsigned e = 1; side_float.engine(e, &width, &lanes); e++) {
        for (unsigned i = 0; i < SIDES; i++) {
            count_steps(sides[i], e);
        }
    }
    growth(argv[2], argv[3], is_long);
    return failed > 0;
}
