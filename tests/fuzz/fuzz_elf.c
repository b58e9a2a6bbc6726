/* fuzz_elf.c - the ELF of a board that `kelly bench --image` compares with what runs there (host/elf.c).
 *
 * What is accepted has a size that a part can have, and the same CRC when it is read again. Where it has one segment, another byte in that
 * makes another CRC: the last byte of the file says which.
 */
#include "caught.h"

#define FILE_MOST (1u << 16)
#include "../../host/elf.c"

/* Where in the file a byte lies that goes to the flash and is no part of the headers; -1: there is none. */
static long flash_byte(const uint8_t *data, size_t size)
{
    const elf_file f = { .bytes = data, .size = size, .path = "in.elf" };
    const uint64_t table = data[4] == 2 ? number(&f, 32, 8) : number(&f, 28, 4);
    const uint64_t each = number(&f, data[4] == 2 ? 54 : 42, 2);
    uint64_t at;
    segment s;

    if (number(&f, data[4] == 2 ? 56 : 44, 2) != 1 || !segment_at(&f, 0, &s)) {
        return -1;
    }
    at = s.offset + data[size - 1] % s.size;
    return at >= 64 && (at < table || at >= table + each) ? (long)at : -1;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static uint8_t other[FILE_MOST];
    uint32_t crc = 0, length = 0, again = 0, length_again = 0;
    long at = -1;
    int status;

    if (size > FILE_MOST) {
        return 0;
    }
    CATCH(status, elf_image(caught_file(".elf", data, size), &crc, &length));
    if (status == 0) {
        must(length > 0 && length <= IMAGE_MOST);
        CATCH(status, elf_image(caught_file(".elf", data, size), &again, &length_again));
        must(status == 0 && again == crc && length_again == length);
        CATCH(status, at = flash_byte(data, size));
        must(status == 0);
    }
    if (at >= 0) {
        memcpy(other, data, size);
        other[at] ^= 1;
        CATCH(status, elf_image(caught_file(".elf", other, size), &again, &length_again));
        must(status == 0 && length_again == length && again != crc);
    }
    must(status != EXIT_FAILED);      /* the file can be read: what is wrong is the user's */
    caught_clear();
    return 0;
}
