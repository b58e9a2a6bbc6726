/* files.c - messages, and files that appear whole or not at all. */
#include <errno.h>
#include <signal.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "host.h"

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
    char text[4096];
    va_list args;

    va_start(args, format);
    (void)vsnprintf(text, sizeof(text), format, args);
    va_end(args);
    for (char *c = text; *c; c++) {   /* one line, whatever a file or an argument holds */
        *c = (unsigned char)*c < ' ' || *c == 0x7f ? '?' : *c;
    }
    fprintf(stderr, "kelly: %s\n", text);
    remove_temporaries();
    exit(status);
}

/* A device, a pipe or a directory that is there already: nothing to be renamed over. */
static int special(const char *path)
{
    struct stat there;

    return stat(path, &there) == 0 && !S_ISREG(there.st_mode);
}

void outfile_open(outfile *file, const char *path)
{
    const mode_t mask = umask(0);
    int fd;

    umask(mask);
    *file = (outfile){ 0 };
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
    if (fclose(file->stream) != 0 || rename(file->temporary, file->path) != 0) {
        die(EXIT_FAILED, "%s: could not be written: %s", file->path, strerror(errno));
    }
    forget(file);
    free(file->path);
    free(file->temporary);
}
