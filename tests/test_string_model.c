/* test_string_model.c - the table: refused where it does not fit, evaluated as written. */
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
    CHECK(kelly_table_error(&table) != 0 && starts_with(kelly_table_error(&table), "table precision"));
    table = kelly_string;
    table.torsional = 0;
    CHECK(kelly_table_error(&table) != 0 && starts_with(kelly_table_error(&table), "table carries"));
    table.torsional = KELLY_MODES_MAX + 1;
    CHECK(kelly_table_error(&table) != 0);
    table = kelly_string;
    table.axial = 0;
    CHECK(kelly_table_error(&table) != 0);
    table.axial = KELLY_MODES_MAX + 1;
    CHECK(kelly_table_error(&table) != 0);
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
    evaluates_polynomials();
    gives_the_paper_modes();
    keeps_to_its_range();
    orders_the_modes();
}
