/* emulator.h - a board of linker/ in QEMU, its UART a socket. */
#ifndef KELLY_EMULATOR_H
#define KELLY_EMULATOR_H

#include "port.h"

/* The command line for the target p->where, from linker/NAME.mk below the current folder; dies with exit 2 where there is no such
 * target or no image of it for this program's precision and string. */
void emulator_command(port *p, const char *image, const char *icount);

/* Start it: the file descriptor of its UART, or -1 with errno. It ends with this program. */
int emulator_start(port *p);

/* End it, if it runs. */
void emulator_end(port *p);

#endif
