/* string_model.h - the drill string as the generator left it, and its modes at a given weight on bit.
 *
 * gen/ writes one `kelly_table` (tables/NAME.c, symbol kelly_string) and one `kelly_shapes` (tables/NAME_shapes.c,
 * symbol kelly_string_shapes; an object of its own, so that an image that never looks at the displacement field does
 * not carry it). Both are const and lie in flash.
 *
 * The prestress depends on the weight on bit, so frequencies and mode shapes do too. Each quantity is a polynomial
 *     value(s) = p[0] + s (p[1] + s (p[2] + ...)),   s = (fc - fc_mid) * fc_scale  in [-1, 1],
 * with relative error below 1e-9 against the eigenvalue solution for fc_min <= fc <= fc_max (proved by gen/certify.py).
 * Coefficients of one quantity lie together: p = &w2[i * (degree + 1)].
 *
 * fc is |f_c| of the paper: the weight on bit as a positive force [N].
 */
#ifndef KELLY_STRING_MODEL_H
#define KELLY_STRING_MODEL_H

#include "real.h"

#define KELLY_SCHEMA 2u          /* raised whenever a field of the table changes its meaning */
#define KELLY_MODES_MAX 20       /* most torsional modes, and most axial modes, that a table or a run may have */
#define KELLY_DEGREE_MAX 7       /* of the polynomials of a table */
#define KELLY_ID_MAX 64          /* characters of a table's id, the 0 at its end included */
#define KELLY_PARAMETERS 5       /* random parameters: fc, mu, a1, a2, w0, in this order everywhere */

/* A soft drive at the top: J_d theta_top'' = 4 Z e + (2 pi f)^2 J_d int e dt - T_top, e = w0 - theta_top'. */
typedef struct {
    real inertia;                 /* J_d [kg m2], 1..1e12; 0: stiff, the top turns at w0 whatever the torque */
    real impedance;               /* Z [N m s/rad], > 0 */
    real hz;                      /* f [Hz], > 0 */
} kelly_drive;

/* What is run: one operating point, its uncertainty and its time grid. All times are whole steps.
 *
 * Overflow, in float, with the modes of the committed table. In range are draws with fc and f0 <= 1e9 N, mu (fc + f0) <= 5e6 N m (under a
 * soft drive or a commanded top 2e6 each of mu fc and mu f0), mu <= 1800 (plant.h: 3), a1 <= 1000, 1e-4 <= a2 <= 1.8e7, w0 <= 1e4, and
 * steps of 2 beta and more. For them tests/eva proves, piece by piece, that no operation gives an infinity or a NaN: checking the draw,
 * setting up, one step from any state within the bounds of its driver, and every reading of a state that is sane. Not proved is that step
 * after step stays within those bounds, which is the stability of RK4: it is looked at when a run ends. Beyond these ranges no operation
 * is promised to stay finite: a bound of the step that does not is refused as `step`, and a state that is not finite when the run ends is
 * `nonfinite`. */
typedef struct {
    real fc;                      /* mean weight on bit |f_c| [N], > 0 */
    real mu;                      /* mean bit-rock factor [m], > 0 */
    real a1, a2;                  /* means of alpha_1 [s/rad], alpha_2 [s2/rad2], > 0 */
    real w0;                      /* mean top speed [rad/s], > 0 */
    real f0;                      /* amplitude of the weight [N], >= 0; not random */
    float cov[KELLY_PARAMETERS];  /* coefficients of variation of the gamma laws, 0..0.5; below 1e-4 that parameter is not random */
    real limit;                   /* severity above which a realisation counts as stick-slip, 0..10 */
    uint32_t step_ns;             /* RK4 step [ns], 1000..1000000000 */
    uint32_t ticks;               /* length of the run [steps], > 0 */
    uint32_t window_first;        /* first and last tick whose bit speed counts, first < last <= ticks */
    uint32_t window_last;
    uint8_t torsional;            /* modes used, 1..torsional of the table */
    uint8_t axial;                /* 1..axial of the table, the rigid one included */
    uint8_t rotating;             /* 0: from rest, q = 0 and theta' = 0; 1: the untwisted string already turns at w0 */
    kelly_drive drive;            /* of the top; zeros: stiff */
} kelly_case;

/* The CRCs find a table that has changed where it lies: CRC-32C of the values as this build holds them, least significant byte
 * first, computed by the generator for float and for double (gen/emit_c.py). The head says how long the arrays are, so that its
 * own is looked at first. A pointer is in neither: what it leads to is. */
typedef struct {
    uint32_t schema;              /* KELLY_SCHEMA of the generator */
    uint32_t real_bytes;          /* sizeof(real) that the table was compiled with */
    uint32_t head_crc;            /* of the id and of every number of this struct */
    uint32_t arrays_crc;          /* of w2, b, d, axial_w2, axial_b, free_w2, axial_free_w2 */
    const char *id;               /* name and CRC of the values, "paper-1a2b3c4d" */
    uint16_t torsional;           /* torsional modes carried */
    uint16_t axial;               /* axial modes carried; mode 0 is the rigid one, w2 = 0 */
    uint16_t degree;              /* of every polynomial in s */
    uint16_t nodes;               /* of the finite-element model, top node included */
    real fc_min, fc_max;          /* [N] range of the fit; outside: refused with status `range` */
    real fc_mid, fc_scale;        /* [N], [1/N] */
    real alpha, beta;             /* damping: mass proportional [1/s], stiffness proportional [s] */
    real inertia;                 /* J = 1'M1, polar moment of inertia of the whole string [kg m2] */
    real impedance;               /* Ip sqrt(rho G) of the uppermost section, what a soft drive matches [N m s/rad]; 0: unknown */
    const real *w2;               /* [torsional * (degree + 1)]  squared natural frequency [rad2/s2] */
    const real *b;                /* [torsional * (degree + 1)]  mode shape at the bit, > 0 [kg^-1/2 m^-1] */
    const real *d;                /* [torsional * (degree + 1)]  phi' M 1 [kg^1/2 m] */
    const real *axial_w2;         /* [axial * (degree + 1)] */
    const real *axial_b;          /* [axial * (degree + 1)]  mode shape at the bit, > 0 [kg^-1/2] */
    const real *free_w2;          /* [torsional]  without prestress */
    const real *axial_free_w2;    /* [axial]      without prestress */
    kelly_case nominal;           /* [case], [uncertainty], [modes] and [run] of the well file */
} kelly_table;

/* Shapes at every node, top first, same polynomials in s. Host and field output only. */
typedef struct {
    uint32_t schema;
    uint32_t real_bytes;
    uint32_t crc;                 /* of the arrays, in this order */
    const char *id;               /* equals that of the table */
    const real *x;                /* [nodes] distance from the top [m] */
    const real *twist;            /* [torsional * nodes * (degree + 1)]: p = &twist[(i * nodes + k) * (degree + 1)] */
    const real *axial;            /* [axial * nodes * (degree + 1)] */
    const real *twist_gram;       /* lower triangle, row by row: entry (i, j <= i) at i (i + 1) / 2 + j, each (degree + 1);  sum over nodes of phi_i phi_j */
    const real *axial_gram;       /* the same for the axial shapes */
} kelly_shapes;

extern const kelly_table kelly_string;
extern const kelly_shapes kelly_string_shapes;

/* Torsional modes at one weight on bit. */
typedef struct {
    unsigned count;
    real w2[KELLY_MODES_MAX];
    real b[KELLY_MODES_MAX];
    real d[KELLY_MODES_MAX];
} kelly_modes;

/* 0 if the table fits this build (schema, precision, counts within the limits) and is as it was generated (its CRCs), otherwise a
 * short reason. Cost: a CRC of some 2 KB in float. To be called before anything else is done with a table, and now and then. */
const char *kelly_table_error(const kelly_table *table);

/* The same of the head alone, some 200 bytes: enough for every index to stay inside the arrays. */
const char *kelly_table_head_error(const kelly_table *table);

/* The same for the shapes of a table that is sound; some 85 KB in float. */
const char *kelly_shapes_error(const kelly_table *table, const kelly_shapes *shapes);

/* Polynomial p[0..degree] at s, by Horner's rule. */
real kelly_poly(const real *p, unsigned degree, real s);

/* The first `count` torsional modes at weight fc [N]. Returns 0 and touches nothing where fc is outside the fit. */
int kelly_modes_at(const kelly_table *table, real fc, unsigned count, kelly_modes *out);

/* The first `count` axial modes at weight fc: same rule. */
int kelly_axial_modes_at(const kelly_table *table, real fc, unsigned count,
                         real w2[KELLY_MODES_MAX], real b[KELLY_MODES_MAX]);

#endif
