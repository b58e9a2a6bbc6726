/* link_tool.c - the C side of the link as a filter, for tests/check_link.py.
 *
 *   link_tool echo   bytes on stdin -> for each frame received, the same message read into its struct and written again; an
 *                    error message (3: body refused, 2: unknown type) in its place where that cannot be; at the end a status
 *                    message with the counts of frames received and dropped
 *   link_tool wits   lines of numbers on stdin, the fields of kelly_wits in order -> a WITS frame each
 */
#include <stdio.h>
#include <string.h>

#include "../firmware/link/wits.h"
#include "each_message.h"

static void send(uint8_t type, uint32_t seq, const uint8_t *body, size_t size)
{
    uint8_t wire[KELLY_WIRE_MAX];

    fwrite(wire, 1, kelly_frame(wire, type, seq, body, size), stdout);
}

static void refuse(uint8_t type, uint32_t seq, uint8_t code)
{
    const kelly_msg_error error = { .code = code, .of_type = type };
    uint8_t body[KELLY_ERROR_MAX];

    send(KELLY_MSG_ERROR, seq, body, kelly_put_error(body, &error));
}

static void answer(const kelly_receiver *receiver)
{
    const uint8_t type = kelly_received_type(receiver);
    const uint32_t seq = kelly_received_seq(receiver);
    uint8_t again[KELLY_BODY_MAX];
    size_t size;
    const uint8_t *const body = kelly_received_body(receiver, &size);
    const int written = read_and_write(type, body, size, again);

    if (written < 0) {
        refuse(type, seq, written == -1 ? KELLY_ERR_BODY : KELLY_ERR_TYPE);
    } else {
        send(type, seq, again, (size_t)written);
    }
}

static int echo(void)
{
    kelly_receiver receiver = { 0 };
    uint8_t body[KELLY_STATUS_MAX];

    for (int byte; (byte = getchar()) != EOF;) {
        if (kelly_receive(&receiver, (uint8_t)byte) > 0) {
            answer(&receiver);
        }
    }
    send(KELLY_MSG_STATUS, 0, body, kelly_put_status(body, &(kelly_msg_status){ .good = receiver.good, .bad = receiver.bad }));
    return 0;
}

static int wits(void)
{
    char line[1024], text[KELLY_WITS_TEXT + 1];

    while (fgets(line, sizeof(line), stdin)) {
        kelly_wits v = { 0 };
        double d[16];

        if (sscanf(line, "%u %u %u %u %lf %lf %lf %lf %lf %lf %lf %lf %lf %lf %lf %lf %lf %lf %lf %u", &v.known, &v.activity, &v.date, &v.time,
                   &d[0], &d[1], &d[2], &d[3], &d[4], &d[5], &d[6], &d[7], &d[8], &d[9], &d[10], &d[11], &d[12], &d[13], &d[14],
                   &v.samples) != 20) {
            return 2;
        }
        real *const fields[] = { &v.depth, &v.wob_mean, &v.wob_max, &v.torque_mean, &v.torque_max, &v.top_speed, &v.bit_wob_mean, &v.bit_wob_max,
                                 &v.bit_torque_mean, &v.bit_torque_max, &v.bit_lowest, &v.bit_highest, &v.bit_mean, &v.ss, &v.probability };
        for (unsigned k = 0; k < 15; k++) {
            *fields[k] = (real)d[k];
        }
        fwrite(text, 1, kelly_wits_frame(text, sizeof(text), &v), stdout);
    }
    return 0;
}

int main(int argc, char **argv)
{
    if (argc == 2 && strcmp(argv[1], "echo") == 0) {
        return echo();
    }
    if (argc == 2 && strcmp(argv[1], "wits") == 0) {
        return wits();
    }
    fprintf(stderr, "usage: link_tool echo|wits\n");
    return 2;
}
