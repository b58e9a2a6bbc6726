/* peers_sundials.c - SUNDIALS: ERKStep with the classical RK4 table and with its own pairs, CVODE with Adams formulas.
 *
 * ARKODE 6.4 takes a user table whose last stage is at the end of the step for one that reuses its last stage (FSAL),
 * and gives wrong results for RK4: hence c4 = 1 - 1e-9.
 */
#include <arkode/arkode_erkstep.h>
#include <cvode/cvode.h>
#include <nvector/nvector_serial.h>
#include <sunnonlinsol/sunnonlinsol_fixedpoint.h>

#define BENCH_RHS
#include "bench.h"

static int derive(realtype t, N_Vector y, N_Vector dy, void *params)
{
    rhs(params, t, N_VGetArrayPointer(y), N_VGetArrayPointer(dy));
    return 0;
}

static void erk_with(const problem *p, const setting *set, observer *o, ARKodeButcherTable table)
{
    problem copy = *p;
    SUNContext context;
    N_Vector y;
    void *memory;
    realtype t = 0;

    SUNContext_Create(0, &context);
    y = N_VNew_Serial(2 * MODES, context);
    start(p, N_VGetArrayPointer(y));
    memory = ERKStepCreate(derive, 0, y, context);
    ERKStepSetTable(memory, table);
    ERKStepSetUserData(memory, &copy);
    if (set->rtol > 0) {
        ERKStepSStolerances(memory, set->rtol, set->atol);
        ERKStepSetMaxStep(memory, set->h);
    } else {
        ERKStepSetFixedStep(memory, set->h);
    }
    ERKStepSetMaxNumSteps(memory, 10000000);
    ERKStepSetStopTime(memory, SECONDS);
    observe(o, 0, speed_of(p, N_VGetArrayPointer(y)));
    while (t < SECONDS - 1e-9 && ERKStepEvolve(memory, SECONDS, y, &t, ARK_ONE_STEP) >= 0) {
        observe(o, t, speed_of(p, N_VGetArrayPointer(y)));
    }
    ERKStepFree(&memory);
    ARKodeButcherTable_Free(table);
    N_VDestroy(y);
    SUNContext_Free(&context);
}

static void erk_rk4(const problem *p, const setting *set, observer *o)
{
    double c[4] = { 0, 0.5, 0.5, 1 - 1e-9 }, b[4] = { 1.0 / 6, 1.0 / 3, 1.0 / 3, 1.0 / 6 };
    double a[16] = { 0, 0, 0, 0, 0.5, 0, 0, 0, 0, 0.5, 0, 0, 0, 0, 1, 0 };

    erk_with(p, set, o, ARKodeButcherTable_Create(4, 4, 0, c, a, b, 0));
}

static void erk_pair(const problem *p, const setting *set, observer *o)
{
    erk_with(p, set, o, ARKodeButcherTable_LoadERK(ARKODE_DORMAND_PRINCE_7_4_5));
}

static void adams(const problem *p, const setting *set, observer *o)
{
    problem copy = *p;
    SUNContext context;
    SUNNonlinearSolver solver;
    N_Vector y;
    void *memory;
    realtype t = 0;

    SUNContext_Create(0, &context);
    y = N_VNew_Serial(2 * MODES, context);
    start(p, N_VGetArrayPointer(y));
    memory = CVodeCreate(CV_ADAMS, context);
    CVodeInit(memory, derive, 0, y);
    CVodeSetUserData(memory, &copy);
    CVodeSStolerances(memory, set->rtol, set->atol);
    CVodeSetMaxStep(memory, set->h);
    CVodeSetStopTime(memory, SECONDS);
    solver = SUNNonlinSol_FixedPoint(y, 0, context);
    CVodeSetNonlinearSolver(memory, solver);
    observe(o, 0, speed_of(p, N_VGetArrayPointer(y)));
    while (t < SECONDS - 1e-9 && CVode(memory, SECONDS, y, &t, CV_ONE_STEP) >= 0) {
        observe(o, t, speed_of(p, N_VGetArrayPointer(y)));
    }
    CVodeFree(&memory);
    SUNNonlinSolFree(solver);
    N_VDestroy(y);
    SUNContext_Free(&context);
}

const peer NAME[] = {
    { "SUNDIALS ERKStep, RK4", FLAGS, { .h = 1e-3 }, ERROR_LIMIT, 1, erk_rk4 },
    { "SUNDIALS ERKStep, Dormand-Prince 5", FLAGS, { .h = 4.4e-3, .rtol = 1.8e-5, .atol = 1.8e-4 }, ERROR_LIMIT, 1, erk_pair },
    { "SUNDIALS CVODE, Adams", FLAGS, { .h = 1, .rtol = 1.65e-7, .atol = 1.65e-7 }, ERROR_LIMIT, 1, adams },
    { 0 },
};
