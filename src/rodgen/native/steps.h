/* Runs in compiled steps of any rod whose equations a struct rodgen_system gives. */

#ifndef RODGEN_STEPS_H
#define RODGEN_STEPS_H

#include <stddef.h>

#include "methods.h"

#ifdef __cplusplus
extern "C" {
#endif

/* The equations of a rod: sizes, and functions of them, each with memory of its own, aligned as
   malloc's. Explicit methods ask for flow alone. */
struct rodgen_system {
    size_t states, works; /* numbers of y, and loads without potential */
    size_t base;          /* numbers of y before the angles */
    size_t added;         /* numbers of y behind positions and velocities */
    size_t tangents;      /* small changes of the state that go on with it, each as long as it */
    size_t flow_size, newton_size; /* bytes of memory that flow and the others work in */
    /* Rates dy of the state y at time t, then the power of every load without potential. Nothing
       of y may be read after the first of dy is written. */
    void (*flow)(double t, const double *y, const double *p, double *dy, void *memory);
    /* The same with the first so many tangents behind the works. Asked for in place of flow, if it
       is given. */
    void (*variations)(double t, const double *y, const double *p, double *dy, size_t count, void *memory);
    /* Derivatives of the equations at a state; then factors of (shift I - J) for a real shift and
       for a complex one, given by its real and imaginary part; then what they solve in place:
       numbers (states), and (states, 2) real and imaginary parts. */
    void (*linearise)(double t, const double *y, const double *p, void *newton);
    void (*factor)(double real, const double *complex_shift, void *newton);
    void (*solve_real)(double *x, void *newton);
    void (*solve_complex)(double *x, void *newton);
};

/* What the functions of a run end with. */
enum {
    RODGEN_PAUSED = 0,      /* the quota is used */
    RODGEN_REACHED = 1,     /* the end is reached */
    RODGEN_FULL = 2,        /* all samples are taken */
    RODGEN_NOT_FINITE = -1, /* the state or the rates stop being finite */
    RODGEN_TOO_SMALL = -2,  /* the step becomes too small */
    RODGEN_DIVERGED = -3,   /* Newton's method finds no solution */
    RODGEN_REFUSED = -4     /* no such run: method, times, step or tolerances, or it was not begun */
};

/* A run: where it is and what it has cost. The caller sets method, t, end, low, high, step, rtol and
   atol, and the state; the rest is the run's own. */
typedef struct {
    double t, before;        /* end and start of the last step */
    double lag, lag_before;  /* what rounding has taken from both: steps are of any length */
    double start, end;       /* of the stretch: from break point to break point */
    double low, high;        /* at what times loads may be asked for their values */
    double longest;          /* step that is taken where methods choose it (0: any) */
    double step; /* a fixed one, or the next to try (0: to be found) */
    double rtol, atol; /* what the estimated error of one step may be */
    double most, modulus;    /* largest stable step; modulus of the eigenvalue that it is for */
    double last_step, last_reach, factored;
    long long method, steps, rejected, rhs, jacobian, factorisations;
    long long taken, looked, predicts, smooth, blocks, broken;
    long long dense, part; /* what dense output is known: 0, or in how many parts of the last step, up to which of them */
} rodgen_run;

/* Memory of a run, all zero at first and aligned as malloc's, without pointers: whoever copies it
   can go on from the copy. Its state: y, then the work of every load without potential, then tangents. */
size_t rodgen_run_size(const struct rodgen_system *system);
double *rodgen_run_state(const struct rodgen_system *system, rodgen_run *run);

/* Its rates, then the powers. */
double *rodgen_run_rates(const struct rodgen_system *system, rodgen_run *run);

/* Begin a stretch at run->t. Ends with PAUSED, NOT_FINITE or REFUSED. */
int rodgen_run_start(const struct rodgen_system *system, rodgen_run *run, const double *p);

/* Take at most quota steps towards run->end and write the states and works at times that are passed
   (count, states + works + tangents * states), from *sampled on, of which methods by collocation write no tangents; trace, if it is given: t, y and dy of every step. Ends
   with any of the above. */
int rodgen_run_on(const struct rodgen_system *system, rodgen_run *run, const double *p, long long quota,
                  size_t count, const double *times, double *samples, size_t *sampled, double *trace);

/* State and works at a time inside the last step. */
void rodgen_run_at(const struct rodgen_system *system, rodgen_run *run, const double *p, double t, double *y);

#ifdef __cplusplus
}
#endif

#endif
