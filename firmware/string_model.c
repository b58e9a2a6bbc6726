#include "string_model.h"

const char *kelly_table_error(const kelly_table *table)
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
    return 0;
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
