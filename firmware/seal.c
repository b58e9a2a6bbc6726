#include "seal.h"

uint32_t kelly_seal(uint32_t seal, const void *from, size_t bytes)
{
    const uint8_t *const at = (const uint8_t *)from;

    for (size_t i = 0; i < bytes; i += 4) {
        seal = seal * KELLY_SEAL_FACTOR +
               ((uint32_t)at[i] | (uint32_t)at[i + 1] << 8 | (uint32_t)at[i + 2] << 16 | (uint32_t)at[i + 3] << 24);
    }
    return seal;
}
