/* port.c - lines to boards; what a target's emulator is called with is in emulator.c. */
#include <errno.h>
#include <fcntl.h>
#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <termios.h>
#include <time.h>
#include <unistd.h>

#include "emulator.h"
#include "host.h"

#define PAUSE_FIRST 0.1          /* [s] before a line is tried again */
#define PAUSE_MOST 2.0
#define STARTS_MOST 20u          /* of an emulator in all, */
#define TRIES_MOST 5u            /* and without an answer */

double port_now(void)
{
    struct timespec t;

    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* ---- what a --port says -------------------------------------------------------------------------------------- */

static void keep(char *to, size_t room, const port *p, const char *from, size_t length)
{
    if (length == 0 || length >= room) {
        die(EXIT_USAGE, "--port %s: %s; give /dev/ttyACM0, tcp:HOST:PORT, unix:PATH or qemu:NAME", p->text,
            length == 0 ? "something is missing" : "too long");
    }
    memcpy(to, from, length);
    to[length] = '\0';
}

static void parse_tcp(port *p, const char *rest)
{
    const char *const colon = strrchr(rest, ':');

    p->kind = PORT_TCP;
    keep(p->where, sizeof(p->where), p, rest, colon ? (size_t)(colon - rest) : 0);
    keep(p->service, sizeof(p->service), p, colon + 1, strlen(colon + 1));
    (void)option_whole("--port tcp:HOST:PORT", p->service, 1, 65535, "a TCP port, 1..65535");
}

static const struct {
    unsigned baud;
    speed_t speed;
} speeds[] = {
    { 9600, B9600 }, { 19200, B19200 }, { 38400, B38400 }, { 57600, B57600 }, { 115200, B115200 }, { 230400, B230400 },
#ifdef B921600
    { 460800, B460800 }, { 921600, B921600 },
#endif
};

static _Noreturn void refuse_no_device(const port *p)
{
    die(EXIT_USAGE, "--port %s: not a serial device; give /dev/ttyACM0, tcp:HOST:PORT, unix:PATH or qemu:NAME", p->text);
}

static void parse_serial(port *p, const char *text)
{
    struct stat there;
    const char *const comma = strrchr(text, ',');
    const int given = comma && strncmp(comma, ",baud=", 6) == 0;
    unsigned known = 0;

    p->kind = PORT_SERIAL;
    p->baud = given ? (unsigned)option_whole("--port ...,baud", comma + 6, 1, 100000000, "bits a second, 9600..921600, e.g. 115200") : 115200;
    keep(p->where, sizeof(p->where), p, text, given ? (size_t)(comma - text) : strlen(text));
    while (known < sizeof(speeds) / sizeof(speeds[0]) && speeds[known].baud != p->baud) {
        known++;
    }
    if (known == sizeof(speeds) / sizeof(speeds[0])) {
        die(EXIT_USAGE, "--port %s: %u baud is not offered; give 9600, 19200, 38400, 57600, 115200, 230400, 460800 or 921600", text, p->baud);
    }
    if (stat(p->where, &there) != 0) {   /* one that goes away later is waited for */
        die(EXIT_USAGE, "--port %s: %s; plug the board in, or give its path, e.g. /dev/ttyACM0", text, strerror(errno));
    }
    if (!S_ISCHR(there.st_mode)) {
        refuse_no_device(p);
    }
}

void port_parse(port *p, const char *text, const char *image, const char *icount)
{
    p->text = text;
    p->fd = -1;
    if (strncmp(text, "tcp:", 4) == 0) {
        parse_tcp(p, text + 4);
    } else if (strncmp(text, "unix:", 5) == 0) {
        p->kind = PORT_UNIX;
        keep(p->where, sizeof(((struct sockaddr_un *)0)->sun_path), p, text + 5, strlen(text + 5));
    } else if (strncmp(text, "qemu:", 5) == 0) {
        p->kind = PORT_EMULATOR;
        keep(p->where, sizeof(p->where), p, text + 5, strlen(text + 5));
        emulator_command(p, image, icount);
    } else if (strchr(text, '/')) {
        parse_serial(p, text);
    } else {
        die(EXIT_USAGE, "--port %s: not a port; give /dev/ttyACM0, tcp:HOST:PORT, unix:PATH or qemu:NAME", text);
    }
    if (image) {
        keep(p->image, sizeof(p->image), p, image, strlen(image));
    }
}

/* ---- opening ------------------------------------------------------------------------------------------------- */

static int fail(port *p)
{
    const double pause = PAUSE_FIRST * (double)(1u << (p->tries < 5 ? p->tries : 5));

    p->tries++;
    p->again = port_now() + (pause < PAUSE_MOST ? pause : PAUSE_MOST);
    p->fd = -1;
    p->connecting = 0;
    p->hopeless = p->kind == PORT_EMULATOR && (p->tries >= TRIES_MOST || p->opened >= STARTS_MOST);
    return 0;
}

static int fail_at(port *p, const char *what)
{
    snprintf(p->why, sizeof(p->why), "%s: %s", what, strerror(errno));
    if (p->fd >= 0) {
        close(p->fd);
    }
    return fail(p);
}

int port_settle(int fd, unsigned baud)
{
    struct termios line;
    speed_t speed = B115200;

    if (tcgetattr(fd, &line) != 0) {
        return 0;
    }
    for (unsigned i = 0; i < sizeof(speeds) / sizeof(speeds[0]); i++) {
        speed = speeds[i].baud == baud ? speeds[i].speed : speed;
    }
    cfmakeraw(&line);
    line.c_cflag |= CLOCAL | CREAD;
    line.c_cc[VMIN] = 1;         /* a read of nothing is the end of the line and not a pause */
    line.c_cc[VTIME] = 0;
    return cfsetispeed(&line, speed) == 0 && cfsetospeed(&line, speed) == 0 && tcsetattr(fd, TCSANOW, &line) == 0 &&
           tcflush(fd, TCIOFLUSH) == 0;
}

static int open_serial(port *p)
{
    p->fd = open(p->where, O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
    if (p->fd < 0 && errno == EACCES) {
        die(EXIT_FAILED, "%s: no permission; on Debian add yourself to the group dialout", p->where);
    }
    if (p->fd >= 0 && !isatty(p->fd)) {
        refuse_no_device(p);
    }
    if (p->fd < 0 || !port_settle(p->fd, p->baud)) {
        return fail_at(p, p->where);
    }
    return 1;
}

static int start_connect(port *p, const struct sockaddr *address, socklen_t size, int family)
{
    p->fd = socket(family, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
    if (p->fd < 0) {
        return fail_at(p, "socket");
    }
    p->connecting = connect(p->fd, address, size) != 0;
    return !p->connecting || errno == EINPROGRESS ? 1 : fail_at(p, p->where);
}

static int open_unix(port *p)
{
    struct sockaddr_un address = { .sun_family = AF_UNIX };

    memcpy(address.sun_path, p->where, strlen(p->where) + 1);
    return start_connect(p, (const struct sockaddr *)&address, sizeof(address), AF_UNIX);
}

static int open_tcp(port *p)
{
    const struct addrinfo want = { .ai_socktype = SOCK_STREAM };
    struct addrinfo *found;
    const int at_once = 1, error = getaddrinfo(p->where, p->service, &want, &found);
    int fine;

    if (error) {
        snprintf(p->why, sizeof(p->why), "%.100s: %.50s", p->where, gai_strerror(error));
        return fail(p);
    }
    fine = start_connect(p, found->ai_addr, found->ai_addrlen, found->ai_family);
    (void)setsockopt(p->fd, IPPROTO_TCP, TCP_NODELAY, &at_once, sizeof(at_once));
    freeaddrinfo(found);
    return fine;
}

static int open_emulator(port *p)
{
    p->fd = emulator_start(p);
    return p->fd >= 0 ? 1 : fail_at(p, p->words[0]);
}

int port_open(port *p)
{
    int fine;

    if (p->fd >= 0) {
        return 1;
    }
    if (p->hopeless || port_now() < p->again) {
        return 0;
    }
    p->waiting = 0;
    fine = p->kind == PORT_SERIAL ? open_serial(p) : p->kind == PORT_TCP ? open_tcp(p) : p->kind == PORT_UNIX ? open_unix(p) : open_emulator(p);
    p->opened += fine ? 1u : 0u;
    return fine;
}

int port_ready(port *p)
{
    int error = 0;
    socklen_t size = sizeof(error);

    if (!p->connecting) {
        return 1;
    }
    if (getsockopt(p->fd, SOL_SOCKET, SO_ERROR, &error, &size) != 0 || error != 0) {
        errno = error;
        p->opened--;
        (void)fail_at(p, p->where);
        return -1;
    }
    p->connecting = 0;
    return 1;
}

/* ---- use ----------------------------------------------------------------------------------------------------- */

void port_close(port *p, const char *why)
{
    snprintf(p->why, sizeof(p->why), "%s", why);
    if (p->fd >= 0) {
        close(p->fd);
    }
    emulator_end(p);
    (void)fail(p);
}

long port_read(port *p, uint8_t *bytes, size_t room)
{
    const ssize_t n = read(p->fd, bytes, room);

    if (n > 0) {
        return (long)n;
    }
    if (n < 0 && (errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR)) {
        return 0;
    }
    port_close(p, n == 0 || errno == EIO || errno == ECONNRESET || errno == EPIPE ? "the line was closed at the other end" : strerror(errno));
    return -1;
}

/* As many as the line takes. A write that fails for good shows as the end of the line in the next read, and as no signal. */
static size_t write_some(const port *p, const uint8_t *bytes, size_t count)
{
    const ssize_t n = count == 0 ? 0 : p->kind == PORT_SERIAL ? write(p->fd, bytes, count) : send(p->fd, bytes, count, MSG_NOSIGNAL);

    return n > 0 ? (size_t)n : 0;
}

void port_write(port *p, const uint8_t *bytes, size_t count)
{
    size_t gone;

    if (p->fd < 0 || p->connecting) {
        return;
    }
    gone = write_some(p, p->out, p->waiting);
    memmove(p->out, p->out + gone, p->waiting - gone);
    p->waiting -= gone;
    if (p->waiting == 0) {
        gone = write_some(p, bytes, count);
        bytes += gone;
        count -= gone;
    }
    if (count > 0 && count <= sizeof(p->out) - p->waiting) {
        memcpy(p->out + p->waiting, bytes, count);
        p->waiting += count;
    }
}
