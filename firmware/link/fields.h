/* fields.h - a struct to the bytes of a message body and back, by a list of its fields. messages.c holds the lists.
 *
 * On the wire everything is little-endian and packed. A `real` is the 8 bytes of an IEEE double in both builds; a float build
 * widens and narrows by integer operations, exactly, and refuses what is not a float. A text is u16 length, then that many
 * characters, each printable ASCII, CR or LF.
 */
#ifndef KELLY_FIELDS_H
#define KELLY_FIELDS_H

#include <stddef.h>
#include <stdint.h>

enum { KELLY_FIELD_U8, KELLY_FIELD_U16, KELLY_FIELD_U32, KELLY_FIELD_U64, KELLY_FIELD_F32, KELLY_FIELD_REAL, KELLY_FIELD_TEXT };

typedef struct {
    uint16_t offset;                     /* in the struct [bytes] */
    uint16_t what;                       /* the kind in the low 4 bits; then least (4) and largest (8) value of a u8, or the
                                          * longest text (12) */
} kelly_field;

/* -> bytes written. Numbers that are not finite are written as they are and refused at the other end; characters that a text
 * may not have become '?', and a text ends at its 00 or its longest length. */
size_t kelly_put_fields(uint8_t *to, const void *from, const kelly_field *fields, size_t count);

/* 1 if the body has exactly these fields and each value is right: a u8 within its range, a number finite and a `real` of this
 * build, a text as above. 0 if not, and then `to` is not to be read. */
int kelly_get_fields(const uint8_t *body, size_t size, void *to, const kelly_field *fields, size_t count);

/* What fits of `from` in a field text<room - 1>, 00 included; room >= 1. */
void kelly_set_text(char *to, size_t room, const char *from);

#endif
