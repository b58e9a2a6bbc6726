/* emulator.c - a board of linker/ in QEMU: the same machine and options as tests/run_target.py. */
#include <errno.h>
#include <fcntl.h>
#include <glob.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#ifdef __linux__
#include <sys/prctl.h>
#endif
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include "elf.h"
#include "emulator.h"
#include "host.h"

#define RUNNING_MOST 16
#define EM_ARM 40u
#define EM_RISCV 243u

#ifndef WELL_SUFFIX               /* "-NAME" where WELL=.../NAME.toml was built: Makefile */
#define WELL_SUFFIX ""
#endif

static pid_t running[RUNNING_MOST];   /* ended by exit() */

/* Targets that this tree has, for a message. */
static void list_targets(char *to, size_t room)
{
    glob_t found;

    *to = '\0';
    if (glob("linker/*.mk", 0, 0, &found) == 0) {
        for (size_t i = 0; i < found.gl_pathc; i++) {
            const char *const name = found.gl_pathv[i] + strlen("linker/");

            if (strcmp(name, "targets.mk") != 0) {
                snprintf(to + strlen(to), room - strlen(to), "%s%.*s", *to ? ", " : "", (int)(strlen(name) - 3), name);
            }
        }
        globfree(&found);
    }
}

/* The value of `NAME := value` in linker/TARGET.mk; 0 where it has none. */
static int setting(const char *target, const char *name, char *value, size_t room)
{
    char path[PORT_TEXT], line[PORT_TEXT] = "", targets[256];
    const size_t length = strlen(name);
    int found = 0;
    FILE *file;

    snprintf(path, sizeof(path), "linker/%.200s.mk", target);
    file = strchr(target, '/') || strcmp(target, "targets") == 0 ? 0 : fopen(path, "r");
    if (!file) {
        list_targets(targets, sizeof(targets));
        die(EXIT_USAGE, "--port qemu:%s: there is no %s below this folder; %s%s", target, path,
            *targets ? "give one of " : "start from the top of the tree", targets);
    }
    while (!found && fgets(line, sizeof(line), file)) {
        found = strncmp(line, name, length) == 0 && strncmp(line + length, " := ", 4) == 0;
    }
    (void)fclose(file);
    line[strcspn(line, "\n")] = '\0';
    snprintf(value, room, "%s", found ? line + length + 4 : "");
    return found;
}

/* The image of this target for this program: build/NAME[-double][-WELL]/device.elf. */
static void image_of(port *p)
{
    const int own = sizeof(WELL_SUFFIX) > 1, wide_real = sizeof(real) > sizeof(float);

    snprintf(p->image, sizeof(p->image), "build/%.200s%s%s/device.elf", p->where, wide_real ? "-double" : "", WELL_SUFFIX);
    if (access(p->image, R_OK) != 0) {
        die(EXIT_USAGE, "--port qemu:%s: there is no %s; make it: make TARGET=%s%s%s%s%s", p->where, p->image, p->where,
            wide_real ? " REAL=double" : "", own ? " WELL=.../" : "", &WELL_SUFFIX[own], own ? ".toml" : "");
    }
}

/* One word more, for execvp and for people. */
static void add_word(port *p, unsigned *n, const char *word)
{
    const size_t used = strlen(p->command);

    if (*word == '\0') {
        return;
    }
    if (*n + 1 >= PORT_WORDS || used + strlen(word) + 2 > sizeof(p->command)) {
        die(EXIT_USAGE, "--port %s: the emulator's command line is too long", p->text);
    }
    snprintf(p->command + used, sizeof(p->command) - used, "%s%s", *n > 0 ? " " : "", word);
    p->words[(*n)++] = word;
}

static void add_words(port *p, unsigned *n, const char *const words[])
{
    for (; *words; words++) {
        add_word(p, n, *words);
    }
}

/* Dies with exit 2 where no folder of PATH has the emulator. */
static void check_installed(const port *p)
{
    char path[PORT_TEXT];

    for (const char *at = getenv("PATH"); at && *at; at += strcspn(at, ":"), at += *at == ':') {
        snprintf(path, sizeof(path), "%.*s/%s", (int)strcspn(at, ":"), at, p->words[0]);
        if (access(path, X_OK) == 0) {
            return;
        }
    }
    die(EXIT_USAGE, "--port %s: %s is not installed; Debian: apt install qemu-system-arm qemu-system-misc", p->text, p->words[0]);
}

void emulator_command(port *p, const char *image, const char *icount)
{
    static const char *const line[] = { "-display", "none", "-monitor", "none", "-serial", "stdio", 0 };
    static const char *const semihosting[] = { "-semihosting-config", "enable=on,target=native", 0 };
    char family[64], *rest = p->machine;
    unsigned n = 0;
    int wide_file;

    if (!setting(p->where, "QEMU", p->machine, sizeof(p->machine))) {
        die(EXIT_USAGE, "--port qemu:%s: linker/%s.mk names no emulator; this board is only real", p->where, p->where);
    }
    (void)setting(p->where, "FAMILY", family, sizeof(family));
    if (image) {
        snprintf(p->image, sizeof(p->image), "%s", image);
        if (elf_machine(image, &wide_file) != (strcmp(family, "riscv") == 0 ? EM_RISCV : EM_ARM) || wide_file != (strstr(p->machine, "riscv64") != 0)) {
            die(EXIT_USAGE, "--image %s: for another processor than qemu:%s has; give the .elf that make TARGET=%s wrote", image, p->where, p->where);
        }
    } else {
        image_of(p);
    }
    while (rest) {
        add_word(p, &n, strsep(&rest, " "));
    }
    add_words(p, &n, line);
    if (strcmp(family, "cortexm") == 0) {
        add_words(p, &n, semihosting);
    }
    if (icount) {
        add_words(p, &n, (const char *const[]){ "-icount", icount, 0 });
    }
    add_words(p, &n, (const char *const[]){ "-kernel", p->image, 0 });
    p->words[n] = 0;
    check_installed(p);
}

/* ---- the process --------------------------------------------------------------------------------------------- */

static void end_all(void)
{
    for (unsigned i = 0; i < RUNNING_MOST; i++) {
        if (running[i] > 0) {
            kill(running[i], SIGKILL);
        }
    }
}

static void remember(pid_t child)
{
    static int registered;

    if (!registered) {
        registered = atexit(end_all) == 0;
    }
    for (unsigned i = 0; i < RUNNING_MOST; i++) {
        if (running[i] == 0) {
            running[i] = child;
            return;
        }
    }
}

static void forget(pid_t child)
{
    for (unsigned i = 0; i < RUNNING_MOST; i++) {
        running[i] = running[i] == child ? 0 : running[i];
    }
}

/* In the child: its stdin and stdout are the line. */
static _Noreturn void become(const port *p, int line, pid_t parent)
{
    (void)signal(SIGPIPE, SIG_DFL);
#ifdef __linux__
    prctl(PR_SET_PDEATHSIG, SIGKILL);   /* however this program ends */
#endif
    if (getppid() == parent && dup2(line, STDIN_FILENO) >= 0 && dup2(line, STDOUT_FILENO) >= 0) {
        execvp(p->words[0], (char *const *)(uintptr_t)p->words);   /* execvp does not write to them */
    }
    fprintf(stderr, "kelly: %s: cannot be started: %s\n", p->words[0], strerror(errno));
    _exit(127);
}

int emulator_start(port *p)
{
    const pid_t parent = getpid();
    int line[2];

    if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, line) != 0) {
        return -1;
    }
    (void)fflush(0);
    p->child = fork();
    if (p->child == 0) {
        become(p, line[1], parent);
    }
    close(line[1]);
    if (p->child < 0 || fcntl(line[0], F_SETFL, O_NONBLOCK) != 0) {
        close(line[0]);
        return -1;
    }
    remember(p->child);
    return line[0];
}

void emulator_end(port *p)
{
    if (p->child > 0) {
        kill(p->child, SIGKILL);
        waitpid(p->child, 0, 0);
        forget(p->child);
    }
    p->child = 0;
}
