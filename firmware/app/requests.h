/* requests.h - frames from a host: link/PROTOCOL.md says what each asks for. */
#ifndef KELLY_REQUESTS_H
#define KELLY_REQUESTS_H

typedef struct kelly_bench kelly_bench;

/* Carry out the request that bench->receiver has just completed; exactly one answer, now or when the work is done. */
void request(kelly_bench *bench);

#endif
