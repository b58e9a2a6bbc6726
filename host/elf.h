/* elf.h - the bytes that an image leaves in flash. */
#ifndef KELLY_ELF_H
#define KELLY_ELF_H

#include <stdint.h>

/* CRC-32C and size of what the loadable segments of an ELF put into memory, by physical address, gaps as zero bytes: what the device
 * program says of itself. Dies with exit 2 where the file cannot be read or is no such image. */
void elf_image(const char *path, uint32_t *crc, uint32_t *size);

/* e_machine of the ELF, 40 ARM, 243 RISC-V, and whether it is of 64 bits. Dies like that. */
unsigned elf_machine(const char *path, int *wide_file);

#endif
