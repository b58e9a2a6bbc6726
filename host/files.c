/* files.c - messages, and files that appear whole or not at all. */
#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include "host.h"
#include "team.h"

#define OPEN_MAX_FILES 8u

static outfile *open_files[OPEN_MAX_FILES];   /* removed by die() and by a signal */

/* Only unlink: this runs in a signal handler too. */
static void remove_temporaries(void)
{
    for (unsigned i = 0; i < OPEN_MAX_FILES; i++) {
        if (open_files[i] && open_files[i]->temporary) {
            unlink(open_files[i]->temporary);
        }
    }
}

static void interrupted(int signal_number)
{
    remove_temporaries();
    signal(signal_number, SIG_DFL);
    raise(signal_number);
}

static void catch_signals(void)
{
    static const int caught[] = { SIGINT, SIGTERM, SIGHUP };

    for (unsigned i = 0; i < sizeof(caught) / sizeof(caught[0]); i++) {
        if (signal(caught[i], interrupted) == SIG_IGN) {
            signal(caught[i], SIG_IGN);
        }
    }
}

static void forget(const outfile *file)
{
    for (unsigned i = 0; i < OPEN_MAX_FILES; i++) {
        if (open_files[i] == file) {
            open_files[i] = 0;
        }
    }
}

static void remember(outfile *file)
{
    for (unsigned i = 0; i < OPEN_MAX_FILES; i++) {
        if (!open_files[i]) {
            open_files[i] = file;
            return;
        }
    }
}

_Noreturn void die(int status, const char *format, ...)
{
    va_list args;

    if (team_rank() == 0 || status != EXIT_USAGE) {   /* a mistake in the arguments is found by all; one says so */
        va_start(args, format);
        fputs("kelly: ", stderr);
        vfprintf(stderr, format, args);
        fputc('\n', stderr);
        va_end(args);
    }
    remove_temporaries();
    team_abort(status);
    exit(status);
}

/* A device, a pipe or a directory that is there already: nothing to be renamed over. */
static int special(const char *path)
{
    struct stat there;

    return stat(path, &there) == 0 && !S_ISREG(there.st_mode);
}

/* Of several processes the first alone writes. */
static const char *mine(const char *path)
{
    return team_rank() == 0 ? path : "/dev/null";
}

void outfile_open(outfile *file, const char *path)
{
    const mode_t mask = umask(0);
    int fd;

    umask(mask);
    path = mine(path);
    *file = (outfile){ .fd = -1 };
    if (strcmp(path, "-") == 0 || special(path)) {
        file->stream = strcmp(path, "-") == 0 ? stdout : fopen(path, "w");
        if (!file->stream) {
            die(EXIT_FAILED, "%s: cannot write here: %s", path, strerror(errno));
        }
        return;
    }
    file->path = realpath(path, 0);          /* a link stays a link, its target is replaced */
    if (!file->path) {
        file->path = strdup(path);
    }
    path = file->path ? file->path : path;
    file->temporary = malloc(strlen(path) + 16);
    if (!file->path || !file->temporary) {
        die(EXIT_FAILED, "%s: out of memory", path);
    }
    sprintf(file->temporary, "%s.XXXXXX", path);
    fd = mkstemp(file->temporary);
    if (fd < 0) {
        die(EXIT_FAILED, "%s: cannot write here: %s", path, strerror(errno));
    }
    remember(file);
    catch_signals();
    file->stream = fdopen(fd, "w");
    if (!file->stream) {
        die(EXIT_FAILED, "%s: cannot write here: %s", path, strerror(errno));
    }
    (void)fchmod(fd, 0666 & ~mask);
}

/* The file at PATH.part, locked. One that its last writer renamed or removed between the two is not ours: again. */
static int open_part(const outfile *file)
{
    for (;;) {
        const int fd = open(file->temporary, O_WRONLY | O_CREAT | O_CLOEXEC, 0666);
        struct stat here, there;

        if (fd < 0 || fstat(fd, &here) != 0) {
            die(EXIT_FAILED, "%s: cannot write here: %s", file->path, strerror(errno));
        }
        if (flock(fd, LOCK_EX | LOCK_NB) != 0) {
            die(EXIT_FAILED, "%s: %s", file->temporary, errno == EWOULDBLOCK ? "another process writes it; wait for it, or give another output"
                                                                           : strerror(errno));
        }
        if (stat(file->temporary, &there) == 0 && here.st_ino == there.st_ino && here.st_dev == there.st_dev) {
            return fd;
        }
        close(fd);
    }
}

void outfile_open_kept(outfile *file, const char *path)
{
    path = mine(path);
    if (strcmp(path, "-") == 0 || special(path)) {
        outfile_open(file, path);
        return;
    }
    *file = (outfile){ .path = strdup(path), .temporary = malloc(strlen(path) + sizeof(".part")) };
    if (!file->path || !file->temporary) {
        die(EXIT_FAILED, "%s: out of memory", path);
    }
    sprintf(file->temporary, "%s.part", path);
    file->fd = open_part(file);
    remember(file);
    catch_signals();
    if (ftruncate(file->fd, 0) != 0 || !(file->stream = fdopen(file->fd, "w"))) {
        die(EXIT_FAILED, "%s: cannot write here: %s", path, strerror(errno));
    }
}

void outfile_close(outfile *file)
{
    const int bad = ferror(file->stream) | fflush(file->stream);

    if (bad) {
        die(EXIT_FAILED, "%s: could not be written: %s", file->path ? file->path : "the output", strerror(errno));
    }
    if (!file->path) {
        if (file->stream != stdout) {
            fclose(file->stream);
        }
        return;
    }
    if (file->fd >= 0 && fsync(file->fd) != 0) {
        die(EXIT_FAILED, "%s: could not be written: %s", file->path, strerror(errno));
    }
    if (fclose(file->stream) != 0 || rename(file->temporary, file->path) != 0) {
        die(EXIT_FAILED, "%s: could not be written: %s", file->path, strerror(errno));
    }
    forget(file);
    free(file->path);
    free(file->temporary);
}
