/* failing_disk.c - a disk that fails when it is told to. Built as a shared object, loaded with LD_PRELOAD.
 *
 *     KELLY_FAULT=WHICH:N:HOW     WHICH: write, sync, rename, unlink, truncate, any.   N: the first that is hit, from 1.
 *     HOW  kill    killed before the call          torn  killed after half of the bytes, or right after the call
 *          enospc  half of the bytes get through, from then on nothing: the disk is full
 *          eio     nothing gets through from then on
 *     KELLY_FAULT_COUNT=FILE      at the end, how many calls of that kind there were
 *
 * stdio's own writes do not pass through the symbol `write`: streams opened with fdopen for writing become cookies that do.
 */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <signal.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/syscall.h>
#include <unistd.h>

enum how { NONE, KILL, TORN, ENOSPC_, EIO_ };

static char which[16];
static int from;
static enum how how;
static atomic_int seen;

__attribute__((constructor)) static void read_orders(void)
{
    const char *const text = getenv("KELLY_FAULT");
    char word[16];

    if (text && sscanf(text, "%15[a-z]:%d:%15[a-z]", which, &from, word) == 3) {
        how = strcmp(word, "kill") == 0 ? KILL : strcmp(word, "torn") == 0 ? TORN : strcmp(word, "enospc") == 0 ? ENOSPC_
            : strcmp(word, "eio") == 0 ? EIO_ : NONE;
    }
}

__attribute__((destructor)) static void report(void)
{
    const char *const path = getenv("KELLY_FAULT_COUNT");
    FILE *const to = path ? fopen(path, "w") : 0;

    if (to) {
        fprintf(to, "%d\n", (int)seen);
        fclose(to);
    }
}

/* What is to happen to this call: NONE, or `how`; *first: it is the first that is hit. */
static enum how hit(const char *kind, int *first)
{
    int n;

    if (strcmp(which, "any") != 0 && strcmp(which, kind) != 0) {
        return NONE;
    }
    n = ++seen;
    *first = n == from;
    return n < from ? NONE : how;
}

static void die_now(void)
{
    kill(getpid(), SIGKILL);
    for (;;) {
        pause();
    }
}

static ssize_t faulty_write(int fd, const void *bytes, size_t count)
{
    int first = 0;
    const enum how what = hit("write", &first);

    if (what == KILL) {
        die_now();
    }
    if (what == TORN) {
        (void)!syscall(SYS_write, fd, bytes, count / 2);
        die_now();
    }
    if (what == ENOSPC_ && first && count > 1) {
        return syscall(SYS_write, fd, bytes, count / 2);
    }
    if (what != NONE) {
        errno = what == EIO_ ? EIO : ENOSPC;
        return -1;
    }
    return syscall(SYS_write, fd, bytes, count);
}

/* The same for calls without bytes: 0 go on, -1 failed; TORN is up to the caller, after the call. */
static int before(const char *kind, enum how *what)
{
    int first = 0;

    *what = hit(kind, &first);
    if (*what == KILL) {
        die_now();
    }
    if (*what == ENOSPC_ || *what == EIO_) {
        errno = *what == EIO_ ? EIO : ENOSPC;
        return -1;
    }
    return 0;
}

static int after(enum how what, int result)
{
    if (what == TORN) {
        die_now();
    }
    return result;
}

ssize_t write(int fd, const void *bytes, size_t count)
{
    return fd > 2 ? faulty_write(fd, bytes, count) : syscall(SYS_write, fd, bytes, count);
}

int fsync(int fd)
{
    enum how what;

    return before("sync", &what) ? -1 : after(what, (int)syscall(SYS_fsync, fd));
}

int fdatasync(int fd)
{
    enum how what;

    return before("sync", &what) ? -1 : after(what, (int)syscall(SYS_fdatasync, fd));
}

int ftruncate(int fd, off_t length)
{
    enum how what;

    return before("truncate", &what) ? -1 : after(what, (int)syscall(SYS_ftruncate, fd, length));
}

int rename(const char *old, const char *new)
{
    int (*const real)(const char *, const char *) = (int (*)(const char *, const char *))dlsym(RTLD_NEXT, "rename");
    enum how what;

    return before("rename", &what) ? -1 : after(what, real(old, new));
}

int unlink(const char *path)
{
    int (*const real)(const char *) = (int (*)(const char *))dlsym(RTLD_NEXT, "unlink");
    enum how what;

    return before("unlink", &what) ? -1 : after(what, real(path));
}

/* ---- stdio's writes ---------------------------------------------------------------------------------------------- */

static ssize_t cookie_write(void *cookie, const char *bytes, size_t count)
{
    const ssize_t n = faulty_write((int)(long)cookie - 1, bytes, count);

    return n < 0 ? 0 : n;   /* a cookie says 0 for an error */
}

static int cookie_close(void *cookie)
{
    return close((int)(long)cookie - 1);
}

FILE *fdopen(int fd, const char *mode)
{
    FILE *(*const real)(int, const char *) = (FILE * (*)(int, const char *)) dlsym(RTLD_NEXT, "fdopen");

    if (mode[0] != 'w') {
        return real(fd, mode);
    }
    return fopencookie((void *)(long)(fd + 1), mode, (cookie_io_functions_t){ .write = cookie_write, .close = cookie_close });
}
