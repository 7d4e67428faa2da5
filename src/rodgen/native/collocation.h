/* Memory and polynomial of a step by collocation, which the step shares with its dense output and tangents. */

#ifndef RODGEN_COLLOCATION_H
#define RODGEN_COLLOCATION_H

#include "run.h"

#include "tableaux.h"

/* Where arrays of a step by collocation lie among the stages. BEGIN, END: h times what the slope of
   the polynomial lacks there; BEND: how far the step's end is from the trapezoidal rule; LAST: these
   three of the last step. MISSING: what its polynomial lacks, in three parts. */
enum { Z = 0, W = 3, F = 6, Q = 9, SCALE = 12, BEGIN = 13, END = 14, BEND = 15, LAST = 16, MISSING = 19 };

static inline const struct collocation *method_of(const struct run *r)
{
    return r->is->method == RADAU ? &radau : &gauss;
}

/* State of the collocation polynomial of the last step, less the state at its start. */
static inline double polynomial(double *const *q, double x, ptrdiff_t i)
{
    return x * (q[Q][i] + x * (q[Q + 1][i] + x * q[Q + 2][i]));
}

static inline double quintic(const double *part, double x)
{
    return x * (part[0] + x * (part[1] + x * (part[2] + x * (part[3] + x * part[4]))));
}

/* Whether there are derivatives of the equations, and of which step. */
enum { NONE, OLD, FRESH };

/* A shift and the derivatives that belong to it, where they are not there yet: collocation.c. */
void rodgen_collocation_prepare(struct run *r, const struct collocation *m, double h);

/* The tangents of a step whose stages are known: collocation_tangents.c. Returns 0 where they are not found. */
int rodgen_collocation_tangents(struct run *r, const struct collocation *m, double h);

/* Have what the polynomial of the last step lacks: collocation_dense.c. */
void rodgen_collocation_complete(struct run *r, const struct collocation *m);

#endif
