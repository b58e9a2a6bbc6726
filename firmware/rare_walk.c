/* rare_walk.c - one move of a chain along the axes of the seeds' scatter. See rare.h. */
#include "detmath.h"
#include "rare.h"

#define SIZE KELLY_PARAMETERS
#define SWEEPS 6                 /* of Jacobi's method: quadratic once it is near, 4 are enough for float */

/* Covariance of the seeds. */
static void covariance(const kelly_rare *rare, float c[SIZE][SIZE])
{
    const float n = (float)(int32_t)rare->chains;
    float mean[SIZE] = { 0.0f };

    for (uint32_t i = 0; i < rare->chains; i++) {
        for (unsigned k = 0; k < SIZE; k++) {
            mean[k] += rare->samples[i].x[k] / n;
        }
    }
    for (unsigned k = 0; k < SIZE; k++) {
        for (unsigned l = 0; l < SIZE; l++) {
            c[k][l] = 0.0f;
            for (uint32_t i = 0; i < rare->chains; i++) {
                c[k][l] += (rare->samples[i].x[k] - mean[k]) * (rare->samples[i].x[l] - mean[l]) / n;
            }
        }
    }
}

/* Columns p and q of m turned by the angle of cosine c and sine s; rows where `rows`. */
static void turn(float m[SIZE][SIZE], unsigned p, unsigned q, float c, float s, int rows)
{
    for (unsigned k = 0; k < SIZE; k++) {
        float *const a = rows ? &m[p][k] : &m[k][p], *const b = rows ? &m[q][k] : &m[k][q];
        const float x = *a, y = *b;

        *a = c * x - s * y;
        *b = s * x + c * y;
    }
}

/* Jacobi's rotation that takes m[p][q] away (Golub and Van Loan, 8.5). What is not random has zeros and is never turned. */
static void rotate(float m[SIZE][SIZE], float axis[SIZE][SIZE], unsigned p, unsigned q)
{
    float tau, root, t, c;

    if (!(m[p][q] > 1e-9f || m[p][q] < -1e-9f)) {
        return;
    }
    tau = (m[q][q] - m[p][p]) / (2.0f * m[p][q]);          /* below 1e10: covariances are of order 1 */
    root = kelly_sqrt32(1.0f + tau * tau);
    t = tau < 0.0f ? -1.0f / (root - tau) : 1.0f / (root + tau);
    c = 1.0f / kelly_sqrt32(1.0f + t * t);
    turn(m, p, q, c, t * c, 0);
    turn(m, p, q, c, t * c, 1);
    turn(axis, p, q, c, t * c, 0);
}

void kelly_rare_fit(kelly_rare *rare)
{
    float m[SIZE][SIZE];

    covariance(rare, m);
    for (unsigned k = 0; k < SIZE; k++) {
        for (unsigned l = 0; l < SIZE; l++) {
            rare->axis[k][l] = k == l ? 1.0f : 0.0f;
        }
    }
    for (unsigned sweep = 0; sweep < SWEEPS; sweep++) {
        for (unsigned p = 0; p + 1 < SIZE; p++) {
            for (unsigned q = p + 1; q < SIZE; q++) {
                rotate(m, rare->axis, p, q);
            }
        }
    }
    for (unsigned k = 0; k < SIZE; k++) {
        rare->scatter[k] = m[k][k] >= 1.0f ? 1.0f : m[k][k] > 0.0f ? kelly_sqrt32(m[k][k]) : 0.0f;
    }
}

/* The same length whether the laws keep it or not, so that the stream is read the same way. */
int kelly_rare_move(const kelly_rare *rare, kelly_rng *rng, const float old[SIZE], float next[SIZE])
{
    float gain = 0.0f;

    for (unsigned k = 0; k < SIZE; k++) {
        next[k] = 0.0f;
    }
    for (unsigned j = 0; j < SIZE; j++) {
        const float far = rare->step * rare->scatter[j], s = far < 1.0f ? far : 1.0f;
        float along = 0.0f;

        if (!(rare->cov[j] > 0.0f)) {
            continue;
        }
        for (unsigned k = 0; k < SIZE; k++) {
            along += rare->axis[k][j] * old[k];
        }
        along = kelly_sqrt32(1.0f - s * s) * along + s * kelly_normal(rng);
        for (unsigned k = 0; k < SIZE; k++) {
            next[k] += rare->axis[k][j] * along;
        }
    }
    for (unsigned k = 0; k < SIZE; k++) {
        if (rare->cov[k] > 0.0f) {
            gain += kelly_gamma_log_weight(next[k], rare->cov[k]) - kelly_gamma_log_weight(old[k], rare->cov[k]);
        }
    }
    return kelly_log32(kelly_open01(kelly_rng_next(rng))) < gain;
}
