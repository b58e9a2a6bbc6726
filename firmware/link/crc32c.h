/* crc32c.h - CRC-32C (Castagnoli), reflected polynomial 82F63B78, init and final xor FFFFFFFF.
 *
 * crc("123456789") = E3069283. Finds every error of up to 5 bits in 655 bytes. 64 bytes of table, two look-ups a byte.
 */
#ifndef KELLY_CRC32C_H
#define KELLY_CRC32C_H

#include <stddef.h>
#include <stdint.h>

/* CRC of what `crc` covers followed by these bytes; 0 covers nothing. */
uint32_t kelly_crc32c(uint32_t crc, const uint8_t *bytes, size_t count);

#endif
