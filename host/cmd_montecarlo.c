/* cmd_montecarlo.c - the probability of stick-slip. */
#include "map.h"
#include "outcome.h"
#include "team.h"

static const kelly_engine *engine;   /* chosen once, before the threads start */

static void work_piece(const options *opts, uint32_t first, uint32_t count, void *results, void *work)
{
    engine_run(engine, opts, &opts->run, first, count, results, work);
}

const command_help montecarlo_help = {
    .brief = "probability of stick-slip with its 95 % interval",
    .synopsis = "[case] [--samples N] [--cov D] [--seed S] [--json F] [--csv F] [--resume] ...",
    .takes = TAKES_CASE | TAKES_ENSEMBLE | TAKES_JSON | TAKES_RESUME,
    .own = envelope_options,
    .also = until_options,
    .notes = "CSV: index,fc_kN,mu,alpha1,alpha2,rpm,bit_min_rpm,bit_max_rpm,bit_mean_rpm,ss,stuck,status,liftoff.\n"
             "ss = (max - min)/(max + min) of the bit speed over the window decides (10 where max + min <= 0);\n"
             "SSI = (max - min)/(2 mean), the index of rig displays, is reported beside it (JSON: ssi).\n"
             "A realisation that cannot be trusted has a status (step, range, nonfinite, corrupt) and is never counted.\n"
             "OUTPUT.journal beside the first output that is a file holds what is done, 48 bytes a realisation (88 in double), and goes when all\n"
             "is written; OUTPUT.convergence.journal and OUTPUT.envelope.journal are those of --convergence and of --envelope and --traces (as\n"
             "long as all traces). --resume runs only what is missing in them.",
    .example = "kelly montecarlo --mu 0.004 --samples 4000 --json run.json --csv runs.csv",
};

static int own_option(void *context, const char *name, const char *value)
{
    outcome *const out = context;

    return until_option(&out->until, name, value) || envelope_option(&out->envelope, name, value);
}

int command_montecarlo(int argc, char **argv)
{
    static outcome out;
    options opts;
    const char *beside;

    options_parse(&opts, argc, argv, montecarlo_help.takes, "montecarlo", own_option, &out);
    if (out.until.rule.alpha > 0 && !has_option(argc, argv, "--samples")) {
        const uint32_t behind = UINT32_MAX - opts.first;   /* indices after the first one */

        opts.samples = UNTIL_MOST - 1 < behind ? UNTIL_MOST : behind + 1;
    }
    check_indices(&opts);
    if (!out.envelope.envelope && has_option(argc, argv, "--quantiles")) {
        die(EXIT_USAGE, "--quantiles: of an envelope, and none is asked for; give --envelope F.npy too");
    }
    if (!out.envelope.traces && has_option(argc, argv, "--trace-of")) {
        die(EXIT_USAGE, "--trace-of: of the traces, and none are asked for; give --traces F.npy too");
    }
    const char *const outputs[] = { opts.csv, opts.json, out.envelope.envelope, out.envelope.traces };

    check_outputs(outputs, 4);
    beside = first_output(&opts, outputs, 4, "--csv, --json, --envelope or --traces");
    engine = engine_choose(opts.engine);
    if (team_rank() == 0) {
        envelope_reserve(&out.envelope, &opts);
        outcome_open(&out, &opts, engine->name);
    }
    job_log(&out.log, &opts, beside, &(journal_run){ .kind = "montecarlo", .records = opts.samples, .payload = sizeof(kelly_result), .in_order = 1, .sound = results_sound });
    run_job(&opts, &(job){ .work = work_piece, .work_size = engine->work_size, .result_size = sizeof(kelly_result),
                           .width = engine->width, .lanes = engine_lanes(engine, &opts.run), .log = &out.log,
                           .enough = out.until.rule.alpha > 0 ? &out.until.enough : 0 }, outcome_take, &out);
    if (team_rank() == 0) {
        opts.samples = out.tally.samples;   /* of a run that stopped itself, all that follows is about these */
    }
    if (opts.convergence) {
        convergence_run(&opts, beside, &out.convergence_log, &out.convergence);
    }
    if (team_rank() == 0) {
        envelope_run(&out.envelope, &opts, beside, &out.envelope_log);
        return outcome_close(&out);
    }
    return EXIT_DONE;
}
