/* A try of kelly_normal for every pair of words, in slices of their sizes: a value is large only where both words are small. */
#include "../../firmware/random.c"

/* Slice 0: the word 0; then words of 0 .. 3 bits, 4 .. 7 and so on, positive and negative; the last: the lowest word. */
static float unit_of(unsigned slice)
{
    const unsigned size = (slice - 1u) / 2u;
    unsigned word;

    if (slice == 0) {
        return signed_unit(0);
    }
    if (slice == 17) {
        return signed_unit(0x80000000u);
    }
    word = Frama_C_unsigned_int_interval(1u << 4u * size, size == 7 ? 0x7fffffffu : (1u << 4u * (size + 1u)) - 1u);
    return signed_unit(slice % 2u ? word : 0u - word);
}

int main(void)
{
    kelly_rng rng = { { any_u32(), any_u32(), any_u32(), any_u32() } };

    (void)kelly_normal(&rng);
    //@ loop unroll 18;
    for (unsigned a = 0; a < 18; a++) {
        //@ loop unroll 18;
        for (unsigned b = 0; b < 18; b++) {
            float x = 0;

            (void)polar(unit_of(a), unit_of(b), &x);
            //@ assert -200 <= x <= 200;
        }
    }
    return 0;
}
