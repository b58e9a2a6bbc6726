#include "fields.h"
#include "../real.h"

/* Where a value stands: its bytes on the wire in two halves. */
typedef struct {
    uint32_t low, high;
} pair;

static const uint8_t wire_bytes[] = { 1, 2, 4, 8, 4, 8, 2 };   /* of a text: its length */

static pair take(const uint8_t *from, unsigned bytes)
{
    pair value = { 0, 0 };

    for (unsigned k = 0; k < bytes; k++) {
        if (k < 4) {
            value.low |= (uint32_t)from[k] << (8 * k);
        } else {
            value.high |= (uint32_t)from[k] << (8 * (k - 4));
        }
    }
    return value;
}

static void give(uint8_t *to, pair value, unsigned bytes)
{
    for (unsigned k = 0; k < bytes; k++) {
        to[k] = (uint8_t)(k < 4 ? value.low >> (8 * k) : value.high >> (8 * (k - 4)));
    }
}

/* Whether the upper bits of a number are below those of infinity, without its sign or with it. */
static int is_finite(uint32_t upper, uint32_t infinity)
{
    return upper < infinity || (upper >= 0x80000000u && upper < 0x80000000u + infinity);
}

/* ---- a real and the 64 bits of its double ---- */

#ifdef KELLY_DOUBLE
static pair bits_of(real value)
{
    const union { real value; uint64_t bits; } u = { value };

    return (pair){ (uint32_t)u.bits, (uint32_t)(u.bits >> 32) };
}

static int real_of(pair bits, real *value)
{
    union { uint64_t bits; real value; } u;

    if (!is_finite(bits.high, 0x7ff00000u)) {
        return 0;
    }
    u.bits = ((uint64_t)bits.high << 32) + bits.low;
    *value = u.value;
    return 1;
}
#else
/* Exponents: a float has 8 bits, bias 127; a double 11 bits, bias 1023. */
#define BIAS_STEP 896

static pair bits_of(real value)
{
    const union { real value; uint32_t bits; } u = { value };
    const uint32_t sign = u.bits & 0x80000000u;
    uint32_t fraction = u.bits & 0x7fffffu;
    int exponent = (int)(u.bits >> 23 & 0xffu) + BIAS_STEP;

    if (exponent == 255 + BIAS_STEP) {
        exponent = 0x7ff;
    } else if (exponent == BIAS_STEP && fraction == 0) {
        exponent = 0;
    } else if (exponent == BIAS_STEP) {          /* subnormal as a float, normal as a double */
        exponent++;
        //@ loop unroll 24;
        while (fraction < 0x800000u) {
            fraction <<= 1;
            exponent--;
        }
        fraction &= 0x7fffffu;
    }
    return (pair){ fraction << 29, sign | (uint32_t)exponent << 20 | fraction >> 3 };
}

static int real_of(pair bits, real *value)
{
    union { uint32_t bits; real value; } u = { bits.high & 0x80000000u };
    const int exponent = (int)(bits.high >> 20 & 0x7ffu) - BIAS_STEP;
    const uint32_t fraction = (bits.high & 0xfffffu) << 3 | bits.low >> 29;
    const uint32_t whole = fraction | 0x800000u;
    const unsigned lost = exponent > 0 ? 0u : (unsigned)(1 - exponent);   /* bits that a subnormal gives up */

    //@ split u.bits;
    if ((bits.high & 0x7fffffffu) != 0 || bits.low != 0) {
        if ((bits.low & 0x1fffffffu) != 0 || exponent >= 255 || lost > 23u || (whole & ((1u << lost) - 1u)) != 0) {
            return 0;
        }
        u.bits += exponent > 0 ? ((uint32_t)exponent << 23) + fraction : whole >> lost;
    }
    *value = u.value;
    return 1;
}
#endif

/* ---- text ---- */

static int may_stand(char c)
{
    return (c >= ' ' && c <= '~') || c == '\r' || c == '\n';
}

static size_t put_text(uint8_t *to, const char *text, unsigned longest)
{
    unsigned n = 0;

    for (; n < longest && text[n] != '\0'; n++) {
        to[2 + n] = (uint8_t)(may_stand(text[n]) ? text[n] : '?');
    }
    give(to, (pair){ n, 0 }, 2);
    return 2u + n;
}

static int get_text(const uint8_t *from, size_t n, char *text)
{
    for (size_t i = 0; i < n; i++) {
        text[i] = (char)from[i];
        if (!may_stand(text[i])) {
            return 0;
        }
    }
    text[n] = '\0';
    return 1;
}

void kelly_set_text(char *to, size_t room, const char *from)
{
    size_t n = 0;

    for (; n < room - 1 && from[n] != '\0'; n++) {
        to[n] = from[n];
    }
    to[n] = '\0';
}

/* ---- fields ---- */

static pair load(const void *at, unsigned kind)
{
    union { float value; uint32_t bits; } narrow;

    switch (kind) {
    case KELLY_FIELD_U8:
        return (pair){ *(const uint8_t *)at, 0 };
    case KELLY_FIELD_U16:
        return (pair){ *(const uint16_t *)at, 0 };
    case KELLY_FIELD_U32:
        return (pair){ *(const uint32_t *)at, 0 };
    case KELLY_FIELD_U64:
        return (pair){ (uint32_t)*(const uint64_t *)at, (uint32_t)(*(const uint64_t *)at >> 32) };
    case KELLY_FIELD_F32:
        narrow.value = *(const float *)at;
        return (pair){ narrow.bits, 0 };
    default:
        return bits_of(*(const real *)at);
    }
}

static int store(void *at, pair value, unsigned what)
{
    union { uint32_t bits; float value; } narrow;

    switch (what & 15u) {
    case KELLY_FIELD_U8:
        *(uint8_t *)at = (uint8_t)value.low;
        return value.low >= (what >> 4 & 15u) && value.low <= what >> 8;
    case KELLY_FIELD_U16:
        *(uint16_t *)at = (uint16_t)value.low;
        return 1;
    case KELLY_FIELD_U32:
        *(uint32_t *)at = value.low;
        return 1;
    case KELLY_FIELD_U64:
        *(uint64_t *)at = (uint64_t)value.high << 32 | value.low;
        return 1;
    case KELLY_FIELD_F32:
        if (!is_finite(value.low, 0x7f800000u)) {
            return 0;
        }
        narrow.bits = value.low;
        *(float *)at = narrow.value;
        return 1;
    default:
        return real_of(value, at);
    }
}

size_t kelly_put_fields(uint8_t *to, const void *from, const kelly_field *fields, size_t count)
{
    size_t size = 0;

    for (size_t k = 0; k < count; k++) {
        const kelly_field *const f = &fields[k];
        const unsigned kind = f->what & 15u;
        const unsigned char *const at = (const unsigned char *)from + f->offset;

        if (kind == KELLY_FIELD_TEXT) {
            size += put_text(to + size, (const char *)at, f->what >> 4);
        } else {
            give(to + size, load(at, kind), wire_bytes[kind]);
            size += wire_bytes[kind];
        }
    }
    return size;
}

int kelly_get_fields(const uint8_t *body, size_t size, void *to, const kelly_field *fields, size_t count)
{
    size_t read = 0;

    for (size_t k = 0; k < count; k++) {
        const kelly_field *const f = &fields[k];
        const unsigned kind = f->what & 15u, bytes = wire_bytes[kind];
        unsigned char *const at = (unsigned char *)to + f->offset;
        pair value;

        if (size - read < bytes) {
            return 0;
        }
        value = take(body + read, bytes);
        read += bytes;
        if (kind != KELLY_FIELD_TEXT) {
            if (!store(at, value, f->what)) {
                return 0;
            }
        } else if (value.low > f->what >> 4 || value.low > size - read || !get_text(body + read, value.low, (char *)at)) {
            return 0;
        } else {
            read += value.low;
        }
    }
    return read == size;
}
