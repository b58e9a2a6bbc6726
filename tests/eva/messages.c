/* Every body of any size against each message; what is accepted goes back. */
#include "link/messages.h"

#define MESSAGES(with) \
    with(hello) with(hello_reply) with(error) with(case_set) with(case_reply) with(run) with(result) with(status) with(stop) \
    with(plant_start) with(plant_reply) with(lock_step) with(lock_answer) with(rt_command) with(rt_ack) with(rt_sample) with(rt_query) \
    with(rt_report) with(wits_query) with(wits)

/* Any body of any size against each message; what is accepted goes back. */
static void bodies(void)
{
    static uint8_t body[KELLY_BODY_MAX + 1], out[KELLY_BODY_MAX];
    const size_t size = Frama_C_size_t_interval(0, sizeof(body));

    ANY(body);
#define BODY(name) \
    { \
        static kelly_msg_##name message; \
        if (kelly_get_##name(body, size, &message)) { \
            const size_t n = kelly_put_##name(out, &message); \
            /*@ assert n <= sizeof(out); */ \
        } \
    }
    MESSAGES(BODY)
}

int main(void)
{
    bodies();
    return 0;
}
