/* each_message.h - every message of messages.h once, for tests that go through them all. */
#ifndef KELLY_EACH_MESSAGE_H
#define KELLY_EACH_MESSAGE_H

#include "../firmware/link/frame.h"
#include "../firmware/link/messages.h"

#define EACH_MESSAGE(each) \
    each(hello, HELLO) each(hello_reply, HELLO_REPLY) each(error, ERROR) each(case_set, CASE_SET) each(case_reply, CASE_REPLY) \
    each(run, RUN) each(result, RESULT) each(status, STATUS) each(stop, STOP) each(plant_start, PLANT_START) \
    each(plant_reply, PLANT_REPLY) each(lock_step, LOCK_STEP) each(lock_answer, LOCK_ANSWER) each(rt_command, RT_COMMAND) \
    each(rt_ack, RT_ACK) each(rt_sample, RT_SAMPLE) each(rt_query, RT_QUERY) each(rt_report, RT_REPORT) \
    each(wits_query, WITS_QUERY) each(wits, WITS)

/* Read a body into its struct and write it again: the new size; -1 if the message refuses it, -2 if the type is unknown. */
static inline int read_and_write(uint8_t type, const uint8_t *body, size_t size, uint8_t again[KELLY_BODY_MAX])
{
    switch (type) {
#define CASE(name, NAME) \
    case KELLY_MSG_##NAME: { \
        kelly_msg_##name message; \
        return kelly_get_##name(body, size, &message) ? (int)kelly_put_##name(again, &message) : -1; \
    }
    EACH_MESSAGE(CASE)
#undef CASE
    default:
        return -2;
    }
}

#endif
