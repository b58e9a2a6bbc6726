/* bench.h - boards as the drill string: the modes of `kelly bench`. */
#ifndef KELLY_BENCH_H
#define KELLY_BENCH_H

#include "host.h"
#include "link.h"

#define BENCH_PORTS 16

enum { BENCH_CAMPAIGN, BENCH_LOCKSTEP, BENCH_REALTIME, BENCH_WITS };

/* What the command line asked for. */
typedef struct {
    options opts;
    int mode;
    unsigned ports;
    struct {
        const char *text, *image, *icount;
    } port[BENCH_PORTS];
    const char *image, *icount;   /* given before any --port: of all that do not say otherwise */
    double give_up;               /* [s] */
    const char *profile, *wits;   /* files, or 0 */
    uint32_t frame_ticks;
    double stream_hz;
    double command_timeout;       /* [s], 0: commands are not watched */
    int policy;                   /* KELLY_POLICY_... */
    double ramp;                  /* [s] */
    uint32_t overload_steps, overload_us;
    int duration_given;
} bench_request;

/* Case, seed and draw as they travel. */
void bench_case(const kelly_case *run, kelly_msg_case_set *set);


/* Members of a JSON object: port, board, image, emulator, the line's counts; the last without its comma. */
void bench_write_board(FILE *to, const board *b);


/* Whether a summary is wanted on stdout: no --quiet, and stdout is not one of the files. */
int bench_speaks(const options *opts);

/* The modes: boards are parsed, nothing is open. Return the exit status. */
int bench_campaign(const bench_request *ask, board *boards);
int bench_lockstep(const bench_request *ask, board *b);
int bench_realtime(const bench_request *ask, board *b);
int bench_wits(const bench_request *ask, board *b);

#endif
