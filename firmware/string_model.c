#include "string_model.h"

#include "link/crc32c.h"

static uint32_t crc_word(uint32_t crc, uint32_t word)
{
    const uint8_t bytes[4] = { (uint8_t)word, (uint8_t)(word >> 8), (uint8_t)(word >> 16), (uint8_t)(word >> 24) };

    return kelly_crc32c(crc, bytes, sizeof(bytes));
}

static uint32_t crc_words(uint32_t crc, const uint32_t *words, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        crc = crc_word(crc, words[i]);
    }
    return crc;
}

static uint32_t crc_reals(uint32_t crc, const real *values, size_t count)
{
    uint8_t bytes[sizeof(real)];

    for (size_t i = 0; i < count; i++) {
        crc = kelly_crc32c(crc, bytes, kelly_put_real(bytes, values[i]));
    }
    return crc;
}

/* What _head of gen/emit_c.py lists, in its order. */
static uint32_t head_crc(const kelly_table *t)
{
    const kelly_case *const n = &t->nominal;
    const uint32_t counts[] = { t->torsional, t->axial, t->degree, t->nodes, n->step_ns, n->ticks, n->window_first, n->window_last,
                                n->torsional, n->axial, n->rotating };
    const real numbers[] = { t->fc_min, t->fc_max, t->fc_mid, t->fc_scale, t->alpha, t->beta, t->inertia, t->impedance,
                             n->fc, n->mu, n->a1, n->a2, n->w0, n->f0, n->limit, n->drive.inertia, n->drive.impedance, n->drive.hz };
    uint32_t crc = crc_words(0, counts, sizeof(counts) / sizeof(counts[0]));

    crc = crc_reals(crc, numbers, sizeof(numbers) / sizeof(numbers[0]));
    for (unsigned k = 0; k < KELLY_PARAMETERS; k++) {
        crc = crc_word(crc, (union { float x; uint32_t bits; }){ .x = n->cov[k] }.bits);
    }
    for (unsigned k = 0; k < KELLY_ID_MAX && t->id[k] != '\0'; k++) {
        crc = kelly_crc32c(crc, &(const uint8_t){ (uint8_t)t->id[k] }, 1);
    }
    return crc;
}

static uint32_t arrays_crc(const kelly_table *t)
{
    const size_t torsion = (size_t)t->torsional * (t->degree + 1u), axial = (size_t)t->axial * (t->degree + 1u);
    uint32_t crc = crc_reals(0, t->w2, torsion);

    crc = crc_reals(crc, t->b, torsion);
    crc = crc_reals(crc, t->d, torsion);
    crc = crc_reals(crc, t->axial_w2, axial);
    crc = crc_reals(crc, t->axial_b, axial);
    crc = crc_reals(crc, t->free_w2, t->torsional);
    return crc_reals(crc, t->axial_free_w2, t->axial);
}

static const char damaged[] = "table is damaged, its CRC is another: rebuild, and look at the memory that holds it";

const char *kelly_table_head_error(const kelly_table *table)
{
    if (table->schema != KELLY_SCHEMA) {
        return "table schema differs from the kernel's: regenerate it";
    }
    if (table->real_bytes != sizeof(real)) {
        return "table precision differs from the kernel's: rebuild both with the same REAL";
    }
    if (table->torsional < 1 || table->torsional > KELLY_MODES_MAX || table->axial < 1 || table->axial > KELLY_MODES_MAX) {
        return "table carries no mode, or more than the kernel's limit";
    }
    return table->degree <= KELLY_DEGREE_MAX && table->head_crc == head_crc(table) ? 0 : damaged;
}

const char *kelly_table_error(const kelly_table *table)
{
    const char *const error = kelly_table_head_error(table);

    return error != 0 || table->arrays_crc == arrays_crc(table) ? error : damaged;
}

static int same_text(const char *a, const char *b)
{
    while (*a != '\0' && *a == *b) {
        a++;
        b++;
    }
    return *a == *b;
}

const char *kelly_shapes_error(const kelly_table *table, const kelly_shapes *shapes)
{
    const size_t n = table->degree + 1u, t = table->torsional, a = table->axial, nodes = table->nodes;
    uint32_t crc;

    if (shapes->schema != KELLY_SCHEMA || shapes->real_bytes != sizeof(real) || !same_text(shapes->id, table->id)) {
        return "the mode shapes are those of another table: rebuild";
    }
    crc = crc_reals(0, shapes->x, nodes);
    crc = crc_reals(crc, shapes->twist, t * nodes * n);
    crc = crc_reals(crc, shapes->axial, a * nodes * n);
    crc = crc_reals(crc, shapes->twist_gram, t * (t + 1u) / 2u * n);
    crc = crc_reals(crc, shapes->axial_gram, a * (a + 1u) / 2u * n);
    return crc == shapes->crc ? 0 : "the mode shapes are damaged, their CRC is another: rebuild";
}

real kelly_poly(const real *p, unsigned degree, real s)
{
    real value = p[degree];

    for (unsigned k = degree; k > 0; k--) {
        value = value * s + p[k - 1];
    }
    return value;
}

static int in_range(const kelly_table *table, real fc)
{
    return fc >= table->fc_min && fc <= table->fc_max;
}

int kelly_modes_at(const kelly_table *table, real fc, unsigned count, kelly_modes *out)
{
    const unsigned degree = table->degree;

    if (!in_range(table, fc) || count > table->torsional) {
        return 0;
    }
    const real s = (fc - table->fc_mid) * table->fc_scale;
    out->count = count;
    for (unsigned i = 0; i < count; i++) {
        const unsigned at = i * (degree + 1);

        out->w2[i] = kelly_poly(&table->w2[at], degree, s);
        out->b[i] = kelly_poly(&table->b[at], degree, s);
        out->d[i] = kelly_poly(&table->d[at], degree, s);
    }
    return 1;
}

int kelly_axial_modes_at(const kelly_table *table, real fc, unsigned count,
                         real w2[KELLY_MODES_MAX], real b[KELLY_MODES_MAX])
{
    const unsigned degree = table->degree;

    if (!in_range(table, fc) || count > table->axial) {
        return 0;
    }
    const real s = (fc - table->fc_mid) * table->fc_scale;
    for (unsigned j = 0; j < count; j++) {
        const unsigned at = j * (degree + 1);

        w2[j] = kelly_poly(&table->axial_w2[at], degree, s);
        b[j] = kelly_poly(&table->axial_b[at], degree, s);
    }
    return 1;
}
