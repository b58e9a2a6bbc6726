/* files.c - messages, and files that appear whole or not at all. */
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <poll.h>
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
#define LINKS_MOST 40u           /* as the kernel follows */

static outfile *open_files[OPEN_MAX_FILES];   /* removed by die() and by a signal */
static volatile sig_atomic_t journals;

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
    static const char told[] = "kelly: interrupted; with --resume the run goes on from its journal\n";
    struct pollfd to = { .fd = STDERR_FILENO, .events = POLLOUT };

    remove_temporaries();
    (void)signal(SIGPIPE, SIG_IGN);
    if (journals > 0 && poll(&to, 1, 0) == 1 && to.revents == POLLOUT && write(STDERR_FILENO, told, sizeof(told) - 1) < 0) {
        journals = 0;            /* a full pipe, or one without a reader, holds nobody up */
    }
    (void)signal(signal_number, SIG_DFL);
    (void)raise(signal_number);
}

static void catch_signals(void)
{
    static const int caught[] = { SIGINT, SIGTERM, SIGHUP, SIGQUIT };

    for (unsigned i = 0; i < sizeof(caught) / sizeof(caught[0]); i++) {
        if (signal(caught[i], interrupted) == SIG_IGN) {
            (void)signal(caught[i], SIG_IGN);
        }
    }
}

void journals_open(int by)
{
    journals += by;
    catch_signals();
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
        if ((unsigned char)*c < ' ' || *c == 0x7f) {
            *c = '?';
        }
    }
    if (team_rank() == 0 || status != EXIT_USAGE) {   /* a mistake in the arguments is found by all; one says so */
        fprintf(stderr, "kelly: %s\n", text);
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

/* A file that its last writer renamed or removed between the opening and the lock is not the one at the path any more: again. */
int open_locked(const char *path)
{
    struct stat here, there;

    for (;;) {
        const int fd = open(path, O_RDWR | O_CREAT | O_CLOEXEC | O_APPEND | O_NOFOLLOW, 0666);

        if (fd < 0 || fstat(fd, &here) != 0) {
            die(EXIT_FAILED, "%s: cannot write here: %s", path, strerror(errno));
        }
        if (!S_ISREG(here.st_mode)) {
            die(EXIT_USAGE, "%s: not a file; move it away", path);
        }
        if (flock(fd, LOCK_EX | LOCK_NB) != 0) {
            die(EXIT_FAILED, "%s: %s", path, errno == EWOULDBLOCK ? "another process writes it; wait for it, or give another output" : strerror(errno));
        }
        if (stat(path, &there) == 0 && here.st_ino == there.st_ino && here.st_dev == there.st_dev) {
            return fd;
        }
        close(fd);
    }
}

int is_plain_file(const char *path)
{
    return path && strcmp(path, "-") != 0 && !special(path);
}

__attribute__((format(printf, 1, 2))) static char *format_text(const char *format, ...)
{
    va_list args;
    char *text;
    int n;

    va_start(args, format);
    n = vasprintf(&text, format, args);
    va_end(args);
    if (n < 0) {
        die(EXIT_FAILED, "out of memory");
    }
    return text;
}

/* The absolute path of a name, whether or not there is such a file, and if it is a link; as given where there is no such directory. */
static char *place_of_name(const char *path)
{
    const char *const slash = strrchr(path, '/'), *const name = slash ? slash + 1 : path;
    char *const parent = format_text("%.*s.", (int)(name - path), path), *const directory = realpath(parent, 0);
    char *const place = directory ? format_text("%s/%s", directory[1] ? directory : "", name) : format_text("%s", path);

    free(parent);
    free(directory);
    return place;
}

/* The same of what it leads to, also by links to a file that is not there yet. */
static char *place_of(const char *path)
{
    char target[PATH_MAX], *at = place_of_name(path);
    ssize_t n;

    for (unsigned links = 0; links < LINKS_MOST && (n = readlink(at, target, sizeof(target) - 1)) >= 0; links++) {
        const char *const slash = strrchr(at, '/');
        char *next;

        target[n] = '\0';
        next = format_text("%.*s%s", slash && target[0] != '/' ? (int)(slash - at) + 1 : 0, at, target);
        free(at);
        at = place_of_name(next);
        free(next);
    }
    return at;
}

/* Whether `path` is `output`, or what is written beside it while the run goes on. */
static int is_of(const char *path, const char *output)
{
    static const char *const beside[] = { "", ".part", ".journal", ".convergence.journal", ".envelope.journal", ".journal.old", ".convergence.journal.old",
                                         ".envelope.journal.old" };
    const size_t n = strlen(output);

    for (unsigned i = 0; i < sizeof(beside) / sizeof(beside[0]); i++) {
        if (strncmp(path, output, n) == 0 && strcmp(path + n, beside[i]) == 0) {
            return 1;
        }
    }
    return 0;
}

/* Whether a run that writes `output` would write over what `path` leads to. */
static int writes_over(const char *output, const char *path)
{
    char *const at = place_of(path), *const target = place_of(output), *const name = place_of_name(output);
    const int hit = is_of(at, target) || is_of(at, name);   /* the journals lie beside a link, the .part beside its target */

    free(at);
    free(target);
    free(name);
    return hit;
}

void check_outputs(const char *const outputs[], unsigned count)
{
    for (unsigned i = 0; i < count; i++) {
        for (unsigned j = 0; j < count; j++) {
            const char *const a = outputs[i], *const b = outputs[j];

            if (i < j && a && b && strcmp(a, "-") == 0 && strcmp(b, "-") == 0) {
                die(EXIT_USAGE, "two results to stdout; give each its own place");
            }
            if (i != j && is_plain_file(a) && is_plain_file(b) && writes_over(a, b)) {
                die(EXIT_USAGE, "%s, %s: one place for two results, or for one and what is kept beside the other while it is made; give each its own", a, b);
            }
        }
    }
}

void check_input(const char *input, const char *const outputs[], unsigned count)
{
    for (unsigned i = 0; i < count; i++) {
        if (is_plain_file(outputs[i]) && writes_over(outputs[i], input)) {
            die(EXIT_USAGE, "%s: is read here, and %s would be written over it; give the result another place", input, outputs[i]);
        }
    }
}

void outfile_open(outfile *file, const char *path)
{
    *file = (outfile){ .fd = -1, .name = path };
    if (!is_plain_file(path)) {
        file->stream = strcmp(path, "-") == 0 ? stdout : fopen(path, "w");
        if (!file->stream) {
            die(EXIT_FAILED, "%s: cannot write here: %s", path, strerror(errno));
        }
        return;
    }
    file->path = place_of(path);             /* a link stays a link, its target is made or replaced */
    file->temporary = format_text("%s.part", file->path);
    file->fd = open_locked(file->temporary);
    remember(file);
    catch_signals();
    file->stream = ftruncate(file->fd, 0) == 0 ? fdopen(file->fd, "w") : 0;
    if (!file->stream) {
        die(EXIT_FAILED, "%s: cannot write here: %s", file->path, strerror(errno));
    }
}

void outfile_close(outfile *file)
{
    const int bad = ferror(file->stream) | fflush(file->stream);

    if (bad) {
        die(EXIT_FAILED, "%s: could not be written: %s", strcmp(file->name, "-") == 0 ? "the output" : file->name, strerror(errno));
    }
    if (!file->path) {
        if (file->stream != stdout) {
            (void)fclose(file->stream);   /* flushed above */
        }
        return;
    }
    if (fsync(file->fd) != 0 || rename(file->temporary, file->path) != 0) {   /* the lock is held until it has its name */
        die(EXIT_FAILED, "%s: could not be written: %s", file->path, strerror(errno));
    }
    forget(file);
    if (fclose(file->stream) != 0) {
        die(EXIT_FAILED, "%s: could not be written: %s", file->path, strerror(errno));
    }
    free(file->path);
    free(file->temporary);
}

void outfile_drop(outfile *file)
{
    if (file->path) {
        (void)unlink(file->temporary);
        forget(file);
    }
    (void)fclose(file->stream);
    free(file->path);
    free(file->temporary);
}
