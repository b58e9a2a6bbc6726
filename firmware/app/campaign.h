/* campaign.h - realisations of a range in order, one at a time, in slices.
 *
 * The last results are kept, by job (case and seed) and index, for a host that has not heard them: they are sent again at once.
 */
#ifndef KELLY_CAMPAIGN_H
#define KELLY_CAMPAIGN_H

#include "../ensemble.h"
#include "../link/messages.h"

#define CAMPAIGN_KEPT 8u

typedef struct kelly_bench kelly_bench;

typedef struct {
    uint32_t job, index;
    uint8_t filled;
    kelly_result result;
} kelly_kept;

typedef struct {
    kelly_work work;
    kelly_kept at;              /* in the works where filled */
    kelly_kept kept[CAMPAIGN_KEPT];
    uint32_t kept_next;
    uint64_t seed;
    uint32_t job;
    uint32_t next;               /* index that is to be sent next */
    uint32_t left;               /* results still to be sent, that one included */
    uint32_t chunk;              /* steps between two looks at the clock */
} kelly_campaign;

/* Request `run`: begin, or go on with what is under way. */
void campaign_run(kelly_bench *bench, uint32_t seq, const kelly_msg_run *ask);

/* Compute until the tick changes, or send one result. */
void campaign_slice(kelly_bench *bench);

#endif
