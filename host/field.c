/* field.c - displacement and twist of every node of the string in time.
 *
 *     u(x, t) - u_S(x) = sum phi^a_j(x) p_j(t)         [m]     relative to the prestressed string, the rigid motion included
 *     theta(x, t) - theta_top(t) = sum phi_i(x) q_i(t)  [rad]   relative to the rotation of the top
 *
 * with the shapes at the weight of the run. One record a node and instant: time_s, x_m, displacement_m, twist_rad; CSV lists
 * them, NPY holds them as a structured array [time, node]: numpy.load(F)["twist_rad"] is a matrix.
 */
#include <stdlib.h>
#include <string.h>

#include "host.h"

#define COLUMNS 4
#define DIGITS (sizeof(real) > sizeof(float) ? 17 : 9)

/* Shapes [mode * nodes] of the first `modes` modes at weight fc. */
static real *shapes_at(const real *polynomials, unsigned modes, real fc)
{
    const real s = (fc - kelly_string.fc_mid) * kelly_string.fc_scale;
    const unsigned values = modes * kelly_string.nodes, degree = kelly_string.degree;
    real *const shape = malloc(values * sizeof(real));

    if (!shape) {
        die(EXIT_FAILED, "out of memory");
    }
    for (unsigned k = 0; k < values; k++) {
        shape[k] = kelly_poly(&polynomials[(size_t)k * (degree + 1)], degree, s);
    }
    return shape;
}

static int ends_with(const char *path, const char *suffix)
{
    const size_t n = strlen(path), m = strlen(suffix);

    return n > m && strcmp(path + n - m, suffix) == 0;
}

void field_open(field_file *field, const char *path, const options *opts, const kelly_draw *draw)
{
    static const char type[] = "[('time_s', '<f8'), ('x_m', '<f8'), ('displacement_m', '<f8'), ('twist_rad', '<f8')]";
    const uint64_t shape[2] = { opts->run.ticks / opts->out_ticks + 1u, kelly_string.nodes };

    *field = (field_file){ 0 };
    if (!path) {
        return;
    }
    field->npy = ends_with(path, ".npy");
    if (!field->npy && !ends_with(path, ".csv")) {
        die(EXIT_USAGE, "--field %s: unknown kind of file; give a name that ends in .npy or .csv", path);
    }
    field->torsional = opts->run.torsional;
    field->axial = opts->run.axial;
    field->twist = shapes_at(kelly_string_shapes.twist, field->torsional, draw->fc);
    field->displacement = shapes_at(kelly_string_shapes.axial, field->axial, draw->fc);
    field->row = malloc(COLUMNS * sizeof(double) * kelly_string.nodes);
    if (!field->row) {
        die(EXIT_FAILED, "out of memory");
    }
    outfile_open(&field->file, path);
    if (field->npy) {
        npy_header(field->file.stream, type, 2, shape);
    } else {
        fputs("time_s,x_m,displacement_m,twist_rad\n", field->file.stream);
    }
}

/* sum over the modes of shape times amplitude, at one node. */
static double superpose(const real *shape, const real *amplitude, unsigned modes, unsigned node)
{
    double sum = 0;

    for (unsigned i = 0; i < modes; i++) {
        sum += (double)shape[i * kelly_string.nodes + node] * (double)amplitude[i];
    }
    return sum;
}

static void fill_row(field_file *field, const kelly_plant *plant, double time)
{
    real q[KELLY_MODES_MAX], v[KELLY_MODES_MAX];

    kelly_plant_modal(plant, q, v);
    for (unsigned k = 0; k < kelly_string.nodes; k++) {
        double *const record = &field->row[(size_t)k * COLUMNS];

        record[0] = time;
        record[1] = (double)kelly_string_shapes.x[k];
        record[2] = superpose(field->displacement, plant->axial.p, field->axial, k);
        record[3] = superpose(field->twist, q, field->torsional, k);
    }
}

void field_write(field_file *field, const kelly_plant *plant, double time)
{
    if (field->axial == 0) {
        return;
    }
    fill_row(field, plant, time);
    if (field->npy) {
        fwrite(field->row, COLUMNS * sizeof(double), kelly_string.nodes, field->file.stream);
        return;
    }
    for (unsigned k = 0; k < kelly_string.nodes; k++) {
        const double *const r = &field->row[(size_t)k * COLUMNS];

        fprintf(field->file.stream, "%.12g,%.*g,%.*g,%.*g\n", r[0], DIGITS, r[1], DIGITS, r[2], DIGITS, r[3]);
    }
}

void field_close(field_file *field)
{
    if (field->axial == 0) {
        return;
    }
    outfile_close(&field->file);
    free(field->twist);
    free(field->displacement);
    free(field->row);
}
