/* alone.c - team.h for a program that knows of no other process. */
#include "team.h"

unsigned team_rank(void)
{
    return 0;
}

unsigned team_others(void)
{
    return 0;
}

void team_lead(const team_source *source)
{
    (void)source;
}

void team_tell(uint32_t first, uint32_t count, const void *results, size_t result_size)
{
    (void)first, (void)count, (void)results, (void)result_size;
}

void team_dismiss(void)
{
}

void team_follow(void (*run)(void *context, const errand *e), void *run_context, size_t result_size, batch_sink sink, void *sink_context)
{
    (void)run, (void)run_context, (void)result_size, (void)sink, (void)sink_context;
}

void team_share(void *bytes, size_t count)
{
    (void)bytes, (void)count;
}

void team_end(void)
{
}

void team_abort(int status)
{
    (void)status;
}
