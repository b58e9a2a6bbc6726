/* fuzz_elf.c - the ELF of a board that `kelly bench --image` compares with what runs there (host/elf.c).
 *
 * What is accepted has a size that a part can have, the same CRC when it is read again, and another one, or another size, when a byte
 * that belongs to the flash is another.
 */
#include "caught.h"

#include "../../host/elf.c"

/* The byte of the file that this segment's first one is, or -1. */
static long first_byte(const uint8_t *data, size_t size)
{
    const elf_file f = { .bytes = data, .size = size, .path = "in.elf" };
    const unsigned count = (unsigned)number(&f, data[4] == 2 ? 56 : 44, 2);
    segment s;

    return count == 1 && segment_at(&f, 0, &s) ? (long)s.offset : -1;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static uint8_t other[1 << 16];
    uint32_t crc = 0, length = 0, again = 0, length_again = 0;
    long at = -1;
    int status;

    CATCH(status, elf_image(caught_file(".elf", data, size), &crc, &length));
    if (status == 0) {
        must(length > 0 && length <= IMAGE_MOST);
        CATCH(status, elf_image(caught_file(".elf", data, size), &again, &length_again));
        must(status == 0 && again == crc && length_again == length);
        CATCH(status, at = first_byte(data, size));
        must(status == 0);
        if (at >= 64 && size <= sizeof(other)) {     /* behind the header; of one segment: none lies over it */
            memcpy(other, data, size);
            other[at] ^= 1;
            CATCH(status, elf_image(caught_file(".elf", other, size), &again, &length_again));
            must(status != 0 || again != crc || length_again != length);
        }
    }
    must(status != EXIT_FAILED);      /* the file can be read: what is wrong is the user's */
    caught_clear();
    return 0;
}
