/* main.c - every test, one after another; the last line is `N passed, N failed`.
 *
 * The host and each board build the same list. -DTEST_ONLY=NAME runs test_NAME alone, for a part whose flash does not
 * hold them all. The board's own start-up calls main and ends with its value.
 */
#include "check.h"

#if __STDC_HOSTED__
#include <stdio.h>

void check_put(char c)
{
    (void)putchar(c);
}
#endif

/* In the order in which data flows: the first failure is the one to look at. */
#define EACH(test) \
    test(detmath) test(random) test(seal) test(string_model) test(bitrock) test(severity) test(realisation) test(integrator) test(axial) \
    test(plant) test(drive) test(guard) test(energy) test(trajectories) test(ensemble) test(tally) test(envelope) test(sequence) test(sobol) test(reweight) \
    test(rare_guide) test(rare_walk) test(rare) test(bits) test(frame) test(messages) test(wits)

#ifdef TEST_ONLY
#define CHOSEN(test) test(TEST_ONLY)
#else
#define CHOSEN(test) EACH(test)
#endif

#define DECLARE(name) void test_##name(void);
#define DECLARE_IT(name) DECLARE(name)
CHOSEN(DECLARE_IT)

/* A line a test, so that a run that stops says where. */
static void begin(const char *name)
{
    check_text(name);
    check_put('\n');
}

#define QUOTE(name) #name
#define RUN(name) begin(QUOTE(name)); test_##name();
#define RUN_IT(name) RUN(name)

int main(void);
int main(void)
{
    CHOSEN(RUN_IT)
    check_decimal((int64_t)check_passed);
    check_text(" passed, ");
    check_decimal((int64_t)check_failed);
    check_text(" failed\n");
    return check_failed != 0;
}
