/* test_string_model.c - the table: refused where it does not fit, evaluated as written. */
#include "../firmware/link/crc32c.h"
#include "check.h"
#include "fixture.h"

static int starts_with(const char *text, const char *start)
{
    while (*start && *text == *start) {
        text++;
        start++;
    }
    return *start == '\0';
}

static void refuses_other_tables(void)
{
    kelly_table table = kelly_string;

    CHECK(kelly_table_error(&kelly_string) == 0);
    table.schema = KELLY_SCHEMA + 1u;
    CHECK(kelly_table_error(&table) != 0 && starts_with(kelly_table_error(&table), "table schema"));
    table = kelly_string;
    table.real_bytes = (uint32_t)(12u - sizeof(real));     /* of the other precision */
    CHECK(kelly_table_error(&table) != 0 && starts_with(kelly_table_error(&table), "table and kernel differ"));
    table = kelly_string;
    table.torsional = 0;
    CHECK(kelly_table_error(&table) != 0 && starts_with(kelly_table_error(&table), "table has no mode"));
    table.torsional = KELLY_MODES_MAX + 1;
    CHECK(kelly_table_error(&table) != 0 && starts_with(kelly_table_error(&table), "table has no mode"));
    table = kelly_string;
    table.axial = 0;
    CHECK(kelly_table_error(&table) != 0 && starts_with(kelly_table_error(&table), "table has no mode"));
    table.axial = KELLY_MODES_MAX + 1;
    CHECK(kelly_table_error(&table) != 0 && starts_with(kelly_table_error(&table), "table has no mode"));
}

static int damaged(const kelly_table *table)
{
    const char *const error = kelly_table_error(table);

    return error != 0 && starts_with(error, "table is damaged");
}

/* Any number that is not what the generator wrote is found, before a degree or a count leads out of the arrays. */
static void finds_damage(void)
{
    kelly_table table = kelly_string;
    real w2[KELLY_MODES_MAX * (KELLY_DEGREE_MAX + 1)];
    const unsigned n = kelly_string.torsional * (kelly_string.degree + 1u);

    table.axial = KELLY_MODES_MAX;
    CHECK(damaged(&table));
    table = kelly_string;
    table.degree += 1;
    CHECK(damaged(&table));
    table.degree = UINT16_MAX;
    CHECK(damaged(&table));
    table = kelly_string;
    table.beta = table.beta * R(1.000001);
    CHECK(damaged(&table));
    table = kelly_string;
    table.nominal.rotating ^= 1u;
    CHECK(damaged(&table));
    table = kelly_string;
    table.w2 = w2;
    for (unsigned k = 0; k < n; k++) {
        w2[k] = kelly_string.w2[k];
    }
    CHECK(kelly_table_error(&table) == 0);
    w2[n - 1] += 1;
    CHECK(damaged(&table));
}

/* An id without an end is read no further than it may be long. */
static void bounds_the_id(void)
{
    char id[KELLY_ID_MAX + 1];
    kelly_table table = kelly_string;

    for (unsigned k = 0; k < sizeof(id); k++) {
        id[k] = 'x';
    }
    table.id = id;
    CHECK(damaged(&table));
}

static uint32_t add_bytes(uint32_t crc, uint64_t bits, unsigned count)
{
    for (unsigned k = 0; k < count; k++) {
        const uint8_t byte = (uint8_t)(bits >> (8 * k));

        crc = kelly_crc32c(crc, &byte, 1);
    }
    return crc;
}

static uint32_t add_real(uint32_t crc, real x)
{
    return add_bytes(crc, fixture_bits(x), sizeof(real));
}

/* By string_model.h, number by number. */
static uint32_t head_of(const kelly_table *t)
{
    const kelly_case *const n = &t->nominal;
    const uint16_t counts[] = { t->torsional, t->axial, t->degree, t->nodes };
    const real model[] = { t->fc_min, t->fc_max, t->fc_mid, t->fc_scale, t->alpha, t->beta, t->inertia, t->impedance };
    const real means[] = { n->fc, n->mu, n->a1, n->a2, n->w0, n->f0 }, drive[] = { n->drive.inertia, n->drive.impedance, n->drive.hz };
    const uint32_t times[] = { n->step_ns, n->ticks, n->window_first, n->window_last };
    const uint8_t modes[] = { n->torsional, n->axial, n->rotating };
    uint32_t crc = 0;

    for (unsigned k = 0; k < 4; k++) crc = add_bytes(crc, counts[k], 2);
    for (unsigned k = 0; k < 8; k++) crc = add_real(crc, model[k]);
    for (unsigned k = 0; k < 6; k++) crc = add_real(crc, means[k]);
    for (unsigned k = 0; k < KELLY_PARAMETERS; k++) {
        const union { float x; uint32_t bits; } u = { .x = n->cov[k] };

        crc = add_bytes(crc, u.bits, 4);
    }
    crc = add_real(crc, n->limit);
    for (unsigned k = 0; k < 4; k++) crc = add_bytes(crc, times[k], 4);
    crc = kelly_crc32c(crc, modes, sizeof(modes));
    for (unsigned k = 0; k < 3; k++) crc = add_real(crc, drive[k]);
    for (const char *c = t->id; *c != '\0'; c++) crc = add_bytes(crc, (uint8_t)*c, 1);
    return crc;
}

/* The highest degree is a degree, one more is none whatever its CRC says. */
static void bounds_the_degree(void)
{
    kelly_table table = kelly_string;

    EQUAL(kelly_string.head_crc, head_of(&kelly_string));
    table.degree = KELLY_DEGREE_MAX;
    table.head_crc = head_of(&table);
    CHECK(kelly_table_head_error(&table) == 0);
    table.degree = KELLY_DEGREE_MAX + 1;
    table.head_crc = head_of(&table);
    CHECK(kelly_table_head_error(&table) != 0);
}

static int shapes_say(const kelly_table *table, const kelly_shapes *shapes, const char *what)
{
    const char *const error = kelly_shapes_error(table, shapes);

    return error != 0 && starts_with(error, what);
}

/* Shapes of two torsional modes and one axial at three nodes, by straight lines in s: 6, 12, 6, 6 and 2 numbers after the nodes. */
static void checks_the_shapes(void)
{
    static const char other[] = "the mode shapes are those of another table", spoilt[] = "the mode shapes are damaged";
    real numbers[3 + 12 + 6 + 6 + 2];
    kelly_table table = { .id = "small-1", .torsional = 2, .axial = 1, .degree = 1, .nodes = 3 };
    kelly_shapes shapes = { .schema = KELLY_SCHEMA, .real_bytes = sizeof(real), .id = "small-1", .x = numbers, .twist = numbers + 3,
                            .axial = numbers + 15, .twist_gram = numbers + 21, .axial_gram = numbers + 27 };

    for (unsigned k = 0; k < sizeof(numbers) / sizeof(numbers[0]); k++) {
        numbers[k] = (real)(k + 1u) * R(0.3);
        shapes.crc = add_real(shapes.crc, numbers[k]);
    }
    CHECK(kelly_shapes_error(&table, &shapes) == 0);
    for (unsigned k = 0; k < sizeof(numbers) / sizeof(numbers[0]); k++) {
        numbers[k] += R(1.0);
        CHECK(shapes_say(&table, &shapes, spoilt));
        numbers[k] = (real)(k + 1u) * R(0.3);
    }
    shapes.id = "small-2";
    CHECK(shapes_say(&table, &shapes, other));
    shapes.id = "small";
    CHECK(shapes_say(&table, &shapes, other));
    shapes.id = "small-10";
    CHECK(shapes_say(&table, &shapes, other));
    shapes.id = table.id;
    shapes.schema++;
    CHECK(shapes_say(&table, &shapes, other));
    shapes.schema--;
    shapes.real_bytes++;
    CHECK(shapes_say(&table, &shapes, other));
}

static void evaluates_polynomials(void)
{
    static const real p[4] = { R(3.0), R(-2.0), R(0.5), R(4.0) };

    CHECK(kelly_poly(p, 0, R(7.0)) == R(3.0));
    CHECK(kelly_poly(p, 1, R(7.0)) == R(-11.0));
    CHECK(kelly_poly(p, 3, R(0.0)) == R(3.0));
    CHECK(kelly_poly(p, 3, R(-1.0)) == R(1.5));            /* 3 + 2 + 0.5 - 4 */
    CHECK(kelly_poly(p, 3, R(2.0)) == R(33.0));            /* 3 - 4 + 2 + 32: exact */
}

/* What model.md gives for the paper's string at 100 kN. */
static void gives_the_paper_modes(void)
{
    kelly_modes modes;
    wide sum = 0;

    CHECK(kelly_modes_at(&kelly_string, R(100000.0), 10, &modes));
    EQUAL(modes.count, 10);
    for (unsigned i = 0; i < 10; i++) {
        sum += (wide)modes.b[i] * (wide)modes.b[i];
    }
    CLOSE(sum, W(0.0428560), W(1e-7));
    CLOSE(textbook_sqrt((wide)modes.w2[0]) / W(6.28318530717958648), W(0.36808567), W(3e-8));
    CLOSE((wide)modes.b[0], W(0.0922678), W(1e-7));
    CLOSE((wide)modes.b[1], W(0.0605054), W(1e-7));
    CLOSE(fixture_abs((wide)modes.d[0]), W(12.89665), W(1e-5));
    CLOSE(fixture_abs((wide)modes.d[1]), W(4.270786), W(1e-6));
    CLOSE((wide)kelly_string.inertia, W(201.325), W(1e-3));
}

static void keeps_to_its_range(void)
{
    const real low = kelly_string.fc_min, high = kelly_string.fc_max;
    kelly_modes modes = { .count = 77, .w2 = { R(1.25) } };
    real w2[KELLY_MODES_MAX] = { R(1.25) }, b[KELLY_MODES_MAX];

    CHECK(!kelly_modes_at(&kelly_string, low - R(1.0), 10, &modes));
    CHECK(!kelly_modes_at(&kelly_string, high + R(1.0), 10, &modes));
    CHECK(!kelly_modes_at(&kelly_string, CHECK_NAN, 10, &modes));
    CHECK(!kelly_modes_at(&kelly_string, low, kelly_string.torsional + 1u, &modes));
    CHECK(modes.count == 77 && modes.w2[0] == R(1.25));    /* untouched */
    CHECK(!kelly_axial_modes_at(&kelly_string, low - R(1.0), 2, w2, b));
    CHECK(!kelly_axial_modes_at(&kelly_string, high + R(1.0), 2, w2, b));
    CHECK(!kelly_axial_modes_at(&kelly_string, CHECK_NAN, 2, w2, b));
    CHECK(!kelly_axial_modes_at(&kelly_string, low, kelly_string.axial + 1u, w2, b));
    CHECK(w2[0] == R(1.25));
    CHECK(kelly_modes_at(&kelly_string, low, kelly_string.torsional, &modes));
    CHECK(kelly_modes_at(&kelly_string, high, 1, &modes));
    EQUAL(modes.count, 1);
    CHECK(kelly_axial_modes_at(&kelly_string, high, kelly_string.axial, w2, b));
}

/* Ascending frequencies, b > 0, d alternating, and the rigid axial mode: all over the range. */
static void orders_the_modes(void)
{
    kelly_modes modes;
    real w2[KELLY_MODES_MAX], b[KELLY_MODES_MAX];
    int ascending = 1, positive = 1, alternating = 1, rigid = 1;

    for (int k = 0; k <= 8; k++) {
        const real fc = kelly_string.fc_min + (kelly_string.fc_max - kelly_string.fc_min) * (real)k / R(8.0);

        CHECK(kelly_modes_at(&kelly_string, fc, kelly_string.torsional, &modes));
        CHECK(kelly_axial_modes_at(&kelly_string, fc, kelly_string.axial, w2, b));
        for (unsigned i = 0; i < modes.count; i++) {
            ascending &= i == 0 || modes.w2[i] > modes.w2[i - 1];
            positive &= modes.b[i] > 0 && modes.w2[i] > 0;
            alternating &= (modes.d[i] > 0) == (i % 2 == 0);
        }
        rigid &= w2[0] == 0 && w2[1] > 0 && b[0] > 0;
    }
    CHECK(ascending);
    CHECK(positive);
    CHECK(alternating);
    CHECK(rigid);
}

void test_string_model(void);
void test_string_model(void)
{
    refuses_other_tables();
    finds_damage();
    bounds_the_id();
    bounds_the_degree();
    checks_the_shapes();
    evaluates_polynomials();
    gives_the_paper_modes();
    keeps_to_its_range();
    orders_the_modes();
}
