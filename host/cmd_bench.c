/* cmd_bench.c - boards on a line instead of this machine. */
#include <stdlib.h>
#include <string.h>

#include "bench.h"
#include "map.h"
#include "outcome.h"

static const option_help bench_options[] = {
    { "--port", "P", "a board: /dev/ttyACM0[,baud=N] (115200, 8N1), tcp:HOST:PORT, unix:PATH, or qemu:NAME, a target of linker/ in its emulator; "
      "a campaign takes several, of any kinds" },
    { "--mode", "campaign|lockstep|realtime|wits", "campaign (default): an ensemble, as montecarlo; lockstep: frame by frame beside this program, "
      "equal bits demanded; realtime: on the board's own tick; wits: what a rig display would read, -9999 where the board has nothing to tell yet" },
    { "--image", "F.elf", "the image of the --port before it: its flash must be that file's (default for qemu: build/NAME/device.elf)" },
    { "--icount", "TEXT", "-icount of the emulator of the --port before it, shift=0..10 or auto, e.g. shift=5,sleep=off: time by its instructions" },
    { "--give-up", "S", "seconds without any board after which the run fails (default 60)" },
    { 0 },
};

static const option_help mode_options[] = {
    { "--samples", "N", "campaign: realisations (default 400)" },
    { "--first", "J", "campaign: index of the first one (default 0)" },
    { "--csv", "F", "campaign: one line a realisation, in the order of the indices; - is stdout" },
    { "--sample", "J", "lockstep, realtime: realisation J of --seed and --cov instead of the nominal case" },
    { "--out", "F.csv", "lockstep, realtime: the run in time, columns as in simulate; - is stdout" },
    { "--profile", "F.csv", "lockstep, realtime: time_s,rpm,wob_kN, straight lines between (default: lockstep has an exercise of its own, "
      "realtime stays at --rpm); realtime without --icount" },
    { "--frame-ticks", "N", "lockstep: steps a frame (default 10)" },
    { "--stream-hz", "F", "realtime: samples a second, 0 none (default 10)" },
    { "--command-timeout", "S", "realtime: seconds of silence of this program after which the board acts by --policy; 0 not watched (default 1; "
      "with --icount 0)" },
    { "--policy", "hold|ramp|stop", "realtime: then hold the last command, ramp the top down (default), or stop" },
    { "--ramp", "S", "realtime: seconds of that ramp (default 5)" },
    { "--overload", "N:US", "realtime, a test: one step in each of the first N seconds takes US microseconds longer" },
    { "--wits", "F", "realtime without --icount: append a WITS level 0 frame a second to this file or device" },
    { 0 },
};

const command_help bench_help = {
    .brief = "boards on a serial line, real or emulated: campaigns, lockstep, real time",
    .synopsis = "--port P [--port P ...] [--mode campaign|lockstep|realtime|wits] [case] ...",
    .takes = TAKES_CASE | TAKES_JSON | TAKES_BENCH | TAKES_RESUME,
    .own = bench_options,
    .also = mode_options,
    .notes = "Campaign: CSV, JSON, summary and digest of montecarlo, whichever board computed what; a board that goes away is waited for, its\n"
             "range goes to others. OUTPUT.journal beside the CSV or the JSON holds what was delivered; --resume asks the boards for the rest.\n"
             "The JSON names the boards, the CRC of the image in each one's flash, and the emulators' command lines.\n"
             "Lockstep: this program steps its own plant beside the board; a bit that differs ends it with exit 1. --drive soft there is a\n"
             "controller in this program, fed with the surface torque of the board.\n"
             "Real time: prints late steps, the worst lateness and the load. The page firmware/link/PROTOCOL.md describes the line.",
    .example = "kelly bench --port qemu:stm32f405 --port qemu:rv32 --duration 4 --samples 48",
};

static int add_port(bench_request *ask, const char *value)
{
    if (ask->ports == BENCH_PORTS) {
        die(EXIT_USAGE, "--port %s: too many; give at most %d", value, BENCH_PORTS);
    }
    ask->port[ask->ports++].text = value;
    return 1;
}

/* Which of the words, in order, the value is; -1: none. */
static int index_of(const char *value, const char *const words[], unsigned count)
{
    for (unsigned i = 0; i < count; i++) {
        if (strcmp(value, words[i]) == 0) {
            return (int)i;
        }
    }
    return -1;
}

static int word_of(const char *name, const char *value, const char *const words[], unsigned count, const char *right)
{
    const int index = index_of(value, words, count);

    if (index < 0) {
        die(EXIT_USAGE, "%s %s: unknown; give %s", name, value, right);
    }
    return index;
}

/* What QEMU takes of -icount: of what it does not take it says so in several lines, each time that it is started. */
static void check_icount(const char *text)
{
    static const char right[] = "shift=0..10 or shift=auto, then ,sleep=off or ,align=on where it is wanted";
    static const char *const shifts[] = { "auto", "0", "1", "2", "3", "4", "5", "6", "7", "8", "9", "10" };
    static const char *const others[] = { "sleep=on", "sleep=off", "align=on", "align=off" };
    char copy[64], *rest = copy, *part;
    int known;

    snprintf(copy, sizeof(copy), "%s", text);
    part = strsep(&rest, ",");
    known = strlen(text) < sizeof(copy) && index_of(part + (strncmp(part, "shift=", 6) == 0 ? 6 : 0), shifts, 12) >= 0;
    while ((part = strsep(&rest, ",")) != 0) {
        known = known && index_of(part, others, 4) >= 0;
    }
    if (!known || (strstr(text, "align=on") && strstr(text, "sleep=off"))) {
        die(EXIT_USAGE, "--icount %s: %s; give %s", text, known ? "align=on wants to sleep" : "unknown", right);
    }
}

/* Of the port before it, or of all. */
static int of_port(bench_request *ask, const char *name, const char *value)
{
    const int image = strcmp(name, "--image") == 0;

    if (!image) {
        check_icount(value);
    }
    if (ask->ports > 0) {
        *(image ? &ask->port[ask->ports - 1].image : &ask->port[ask->ports - 1].icount) = value;
    } else {
        *(image ? &ask->image : &ask->icount) = value;
    }
    return 1;
}

static void overload_of(bench_request *ask, const char *value)
{
    static const char right[] = "N:US, steps and microseconds, 1..1000000 each, e.g. 7:1500";
    char steps[16];
    const char *const colon = strchr(value, ':');

    if (!colon || (size_t)(colon - value) >= sizeof(steps)) {
        die(EXIT_USAGE, "--overload %s: not two numbers; give %s", value, right);
    }
    memcpy(steps, value, (size_t)(colon - value));
    steps[colon - value] = '\0';
    ask->overload_steps = (uint32_t)option_whole("--overload", steps, 1, 1000000, right);
    ask->overload_us = (uint32_t)option_whole("--overload", colon + 1, 1, 1000000, right);
}

static int mode_option(bench_request *ask, const char *name, const char *value)
{
    static const char *const policies[] = { "hold", "ramp", "stop" };

    if (strcmp(name, "--profile") == 0) {
        ask->profile = value;
    } else if (strcmp(name, "--wits") == 0) {
        ask->wits = value;
    } else if (strcmp(name, "--frame-ticks") == 0) {
        ask->frame_ticks = (uint32_t)option_whole(name, value, 1, 1000000, "steps a frame, 1..1000000");
    } else if (strcmp(name, "--stream-hz") == 0) {
        ask->stream_hz = option_number(name, value, 0, 1000, "samples a second, 0 or 0.001..1000");
        if (ask->stream_hz > 0 && ask->stream_hz < 0.001) {
            die(EXIT_USAGE, "%s %s: too seldom; give samples a second, 0 or 0.001..1000", name, value);
        }
    } else if (strcmp(name, "--command-timeout") == 0) {
        ask->command_timeout = option_number(name, value, 0, 3600, "seconds, 0..3600");
    } else if (strcmp(name, "--policy") == 0) {
        ask->policy = word_of(name, value, policies, 3, "hold, ramp or stop");
    } else if (strcmp(name, "--ramp") == 0) {
        ask->ramp = option_number(name, value, 0.001, 3600, "seconds, 0.001..3600");
    } else if (strcmp(name, "--overload") == 0) {
        overload_of(ask, value);
    } else {
        return 0;
    }
    return 1;
}

static int own_option(void *context, const char *name, const char *value)
{
    static const char *const modes[] = { "campaign", "lockstep", "realtime", "wits" };
    bench_request *const ask = context;

    if (strcmp(name, "--port") == 0) {
        return add_port(ask, value);
    }
    if (strcmp(name, "--image") == 0 || strcmp(name, "--icount") == 0) {
        return of_port(ask, name, value);
    }
    if (strcmp(name, "--mode") == 0) {
        ask->mode = word_of(name, value, modes, 4, "campaign, lockstep, realtime or wits");
    } else if (strcmp(name, "--give-up") == 0) {
        ask->give_up = option_number(name, value, 0.1, 1e6, "seconds, 0.1..1e6");
    } else {
        return mode_option(ask, name, value);
    }
    return 1;
}

/* Dies with exit 2 on an option that the mode does not know. */
static void check_mode(int mode, int argc, char **argv)
{
    static const struct {
        const char *name;
        unsigned modes;          /* 1 << mode, or'ed */
    } only[] = {
        { "--samples", 1 }, { "--first", 1 }, { "--csv", 1 }, { "--resume", 1 }, { "--json", 7 }, { "--sample", 6 }, { "--out", 6 }, { "--profile", 6 },
        { "--frame-ticks", 2 }, { "--stream-hz", 4 }, { "--command-timeout", 4 }, { "--policy", 4 }, { "--ramp", 4 }, { "--overload", 4 },
        { "--wits", 4 }, { "--seed", 7 }, { "--cov", 7 },
    };
    static const char *const modes[] = { "campaign", "lockstep", "realtime", "wits" };

    for (unsigned i = 0; i < sizeof(only) / sizeof(only[0]); i++) {
        if (!(only[i].modes >> mode & 1u) && has_option(argc, argv, only[i].name)) {
            die(EXIT_USAGE, "%s: not in --mode %s; see kelly bench --help", only[i].name, modes[mode]);
        }
    }
}

static void tell_emulators(const board *boards, unsigned count)
{
    for (unsigned i = 0; i < count; i++) {
        if (boards[i].port.command[0]) {
            fprintf(stderr, "emulator: %s\n", boards[i].port.command);
        }
    }
}

void bench_case(const kelly_case *run, kelly_msg_case_set *set)
{
    *set = (kelly_msg_case_set){
        .fc = run->fc, .mu = run->mu, .a1 = run->a1, .a2 = run->a2, .w0 = run->w0, .f0 = run->f0, .cov0 = run->cov[0], .cov1 = run->cov[1],
        .cov2 = run->cov[2], .cov3 = run->cov[3], .cov4 = run->cov[4], .limit = run->limit, .step_ns = run->step_ns, .ticks = run->ticks,
        .window_first = run->window_first, .window_last = run->window_last, .torsional = run->torsional, .axial = run->axial,
        .rotating = run->rotating, .drive_inertia = run->drive.inertia, .drive_impedance = run->drive.impedance, .drive_hz = run->drive.hz,
    };
}

int bench_speaks(const options *opts)
{
    return outcome_speaks(opts) && !(opts->out && strcmp(opts->out, "-") == 0);
}

static void write_text(FILE *to, const char *name, const char *text)
{
    fprintf(to, "\"%s\": \"", name);
    for (; *text; text++) {
        fprintf(to, *text == '"' || *text == '\\' ? "\\%c" : (unsigned char)*text < ' ' ? " " : "%c", *text);
    }
    fputs("\", ", to);
}

void bench_write_board(FILE *to, const board *b)
{
    write_text(to, "port", b->port.text);
    write_text(to, "board", b->is.board);
    write_text(to, "version", b->is.version);
    write_text(to, "emulator", b->port.command);
    fprintf(to, "\"image_crc\": \"%08x\", \"image_bytes\": %u, \"image_checked\": %s, \"watchdog\": \"%s\", \"connections\": %u, \"requests_repeated\": %u, "
            "\"frames\": %u, \"bad_frames\": %u, \"bad_frames_there\": %u", b->is.image_crc, b->is.image_size, b->image_known ? "true" : "false",
            b->is.watchdog == KELLY_WATCHDOG_NONE ? "none" : b->is.watchdog == KELLY_WATCHDOG_SOFTWARE ? "software" : "hardware", b->ups,
            b->retries, b->good + b->receiver.good, b->bad + b->receiver.bad, b->bad_there);
}

int command_bench(int argc, char **argv)
{
    static int (*const modes[])(const bench_request *, board *) = { bench_campaign, bench_lockstep, bench_realtime, bench_wits };
    static bench_request ask = { .give_up = 60, .frame_ticks = 10, .stream_hz = 10, .command_timeout = -1, .policy = KELLY_POLICY_RAMP, .ramp = 5 };
    board *boards;

    options_parse(&ask.opts, argc, argv, bench_help.takes, "bench", own_option, &ask);
    check_mode(ask.mode, argc, argv);
    const char *const outputs[] = { ask.opts.csv, ask.opts.json, ask.opts.out, ask.wits };

    check_outputs(outputs, 4);
    if (ask.profile) {
        check_input(ask.profile, outputs, 4);
    }
    if (ask.mode == BENCH_LOCKSTEP || ask.mode == BENCH_REALTIME) {
        check_nominal(&ask.opts);
    }
    ask.duration_given = has_option(argc, argv, "--duration");
    if (ask.ports == 0) {
        die(EXIT_USAGE, "bench: no board; give --port /dev/ttyACM0, tcp:HOST:PORT, unix:PATH or qemu:NAME");
    }
    if (ask.ports > 1 && ask.mode != BENCH_CAMPAIGN) {
        die(EXIT_USAGE, "--port %s: only a campaign takes several boards", ask.port[1].text);
    }
    boards = calloc(ask.ports, sizeof(*boards));
    if (!boards) {
        die(EXIT_FAILED, "out of memory");
    }
    for (unsigned i = 0; i < ask.ports; i++) {
        const char *const image = ask.port[i].image ? ask.port[i].image : ask.image;

        board_parse(&boards[i], ask.port[i].text, image, ask.port[i].icount ? ask.port[i].icount : ask.icount);
        if (ask.port[i].icount && !boards[i].port.command[0]) {
            die(EXIT_USAGE, "--icount %s: --port %s is no emulator; give it behind a qemu:NAME", ask.port[i].icount, ask.port[i].text);
        }
    }
    if (!ask.opts.quiet) {
        tell_emulators(boards, ask.ports);
    }
    return modes[ask.mode](&ask, boards);
}
