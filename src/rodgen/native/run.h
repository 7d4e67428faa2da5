/* Memory of a run, and functions that its methods share. */

#ifndef RODGEN_RUN_H
#define RODGEN_RUN_H

#include "steps.h"

#if defined(__FAST_MATH__) || defined(__ASSOCIATIVE_MATH__) || (defined(__FINITE_MATH_ONLY__) && __FINITE_MATH_ONLY__)
#error "not with -ffast-math: not-a-number, infinity and the order of a sum must keep their meaning"
#endif

#include <math.h>
#include <stdint.h>
#include <string.h>

/* Compilers of C++ take these files, too. */
#ifdef __cplusplus
#define restrict __restrict
#endif

/* Methods that are not alone in what they do, and what a step or a stretch of steps ends with. */
enum {
    DOP853 = RODGEN_DOP853,
    GAUSS = RODGEN_GAUSS,
    RADAU = RODGEN_RADAU,
    GAUSS_EQUAL_STEPS = RODGEN_GAUSS_EQUAL_STEPS
};
enum {
    PAUSED = RODGEN_PAUSED,
    REACHED = RODGEN_REACHED,
    FULL = RODGEN_FULL,
    NOT_FINITE = RODGEN_NOT_FINITE,
    TOO_SMALL = RODGEN_TOO_SMALL,
    DIVERGED = RODGEN_DIVERGED,
    REFUSED = RODGEN_REFUSED
};

/* Stages of a step, and what dense output needs of them. */
enum { STAGES = 22 };

/* One run. Arrays are of all states and works, and of tangents behind these, which explicit methods move
   as they move states: for them all counts these too, and directions says how many; but for direction (of the positions) and shifted
   (real and imaginary parts of the states). */
struct run {
    rodgen_run *is;
    const struct rodgen_system *of;
    const double *p;
    ptrdiff_t states, half, all, base, width;
    size_t directions;
    double *y, *f;             /* at the end of the last step */
    double *before, *f_before; /* at its start */
    double *trial, *error;
    double *k[STAGES];
    double *direction; /* of the highest mode, in the positions */
    double *shifted;
    void *flow, *newton; /* memory of the equations */
};

/* Before a loop in which no state needs another: compilers need not look whether arrays overlap. */
#if defined(__clang__)
#define INDEPENDENT _Pragma("clang loop vectorize(assume_safety)")
#elif defined(__GNUC__)
#define INDEPENDENT _Pragma("GCC ivdep")
#else
#define INDEPENDENT
#endif

/* Loops over all states and works, over the states, over the works. */
#define EACH INDEPENDENT for (ptrdiff_t i = 0; i < r->all; ++i)
#define EACH_STATE INDEPENDENT for (ptrdiff_t i = 0; i < r->states; ++i)
#define EACH_WORK for (ptrdiff_t i = r->states; i < r->all; ++i)

/* Bytes of an array up to the next cache line. */
static inline size_t lined(size_t bytes)
{
    return (bytes + 63) / 64 * 64;
}

static inline double square(double v)
{
    return v * v;
}

/* Sum in eight lanes, so that no term waits for the one before it. */
static inline double total(const double *x, ptrdiff_t count)
{
    double lane[8] = {0.0};
    ptrdiff_t i = 0;
    for (; i + 8 <= count; i += 8)
        for (int w = 0; w < 8; ++w)
            lane[w] += x[i + w];
    for (int w = 0; w < 8 && i < count; ++i, ++w)
        lane[w] += x[i];
    return ((lane[0] + lane[4]) + (lane[1] + lane[5])) + ((lane[2] + lane[6]) + (lane[3] + lane[7]));
}

static inline int all_finite(const double *x, ptrdiff_t count)
{
    double sum[8] = {0.0};
    ptrdiff_t i = 0;
    for (; i + 8 <= count; i += 8)
        for (int w = 0; w < 8; ++w)
            sum[w] += 0.0 * x[i + w];
    for (; i < count; ++i)
        sum[0] += 0.0 * x[i];
    return total(sum, 8) == 0.0;
}

static inline void copy(const struct run *r, double *to, const double *from)
{
    memcpy(to, from, (size_t)r->all * sizeof *to);
}

/* A sum of stages: how many, which, and the number of each. */
enum { LONGEST_SUM = 12 };
struct sum {
    int count, at[LONGEST_SUM];
    double value[LONGEST_SUM];
};

/* A stage of an explicit method: its share of the step, and the stages before it. */
struct stage {
    double at;
    struct sum sum;
};

/* An explicit Runge-Kutta method of fixed step: times of its stages as shares of the step; sums for
   the stages after the first, then for the step. Where positions follow, they move over the whole
   step by the velocities that a stage or the step arrives at. */
struct tableau {
    int stages, follow;
    double at[LONGEST_SUM];
    struct sum sums[LONGEST_SUM];
};

/* Collocation at three nodes, in the variables in which its matrix falls apart. */
struct collocation {
    double c[3], A[3][3], b[3], T[3][3], TI[3][3], real, pair[2], end[3], error[3], dense[3][3];
    double slope[3], missing[3][5], power, weight;
};

/* A time at which loads may be asked for their values: at a break point, this side of it. */
static inline double inside(const rodgen_run *is, double t)
{
    return t < is->low ? is->low : t > is->high ? is->high : t;
}

/* Rates and powers. */
static inline void flow_at(struct run *r, double t, const double *y, double *dy)
{
    if (r->of->variations != NULL)
        r->of->variations(inside(r->is, t), y, r->p, dy, r->directions, r->flow);
    else
        r->of->flow(inside(r->is, t), y, r->p, dy, r->flow);
    ++r->is->rhs;
}

/* What is tolerated of an error in a state of that size, of which no more than a limit counts. */
static inline double tolerated(const rodgen_run *is, double size, double limit)
{
    const double least = 16.0 * 2.220446049250313e-16 * size, share = is->rtol * (size > limit ? limit : size);
    return is->atol + (share > least ? share : least);
}

/* Groups of states: positions of joint 0, angles, velocities, those that are added; and what of their size counts: whole turns of an angle make it no more (a rod
   that has turned bends as before), but for what they cost in rounding. */
struct group {
    ptrdiff_t low, high;
    double limit;
};

enum { VELOCITIES = 2, ADDED = 3, GROUPS = 4 };

static inline struct group group_of(const struct run *r, int number)
{
    const struct group groups[GROUPS] = {{0, r->base, INFINITY},
                                         {r->base, r->half, 6.283185307179586},
                                         {r->half, 2 * r->half, INFINITY},
                                         {2 * r->half, r->states, INFINITY}};
    return groups[number];
}

/* Root mean square of an error over what is tolerated for states between two. Gauss's method is for
   motions whose fastest modes are noise: of them the velocities are large, the positions small. */
static inline double scaled(struct run *r, const double *error, const double *a, const double *b)
{
    double *const squares = r->error;
    const int positions = r->is->method == GAUSS;
    const ptrdiff_t less = positions ? r->half : 0, count = r->states - less;
    for (int number = 0; number < GROUPS; ++number) {
        const struct group group = group_of(r, number);
        const ptrdiff_t to = number == ADDED ? less : 0;
        for (ptrdiff_t i = group.low; i < group.high && !(positions && number == VELOCITIES); ++i) {
            const double u = fabs(a[i]), v = fabs(b[i]);
            squares[i - to] = square(error[i] / tolerated(r->is, u > v ? u : v, group.limit));
        }
    }
    return sqrt(total(squares, count) / (double)count);
}

/* What is left of the stretch. */
static inline double left_of(const rodgen_run *is)
{
    return (is->end - is->t) - is->lag;
}

/* The time a step on. What rounding takes from the sum is kept: far from zero, steps that are not
   those of the time would add up to another motion. */
static inline double later(const rodgen_run *is, double h, double *lag)
{
    const double on = h + is->lag, next = h == left_of(is) ? is->end : is->t + on;
    *lag = h == left_of(is) ? 0.0 : on - (next - is->t);
    return next;
}

/* A first step for a method of some order, from the size of the state and of the rates (d0, d1), then of their change
   over a first guess (Hairer, Norsett, Wanner: Solving Ordinary Differential Equations I, II.4). */
static inline double guessed_step(double d0, double d1, double span)
{
    const double h = d0 < 1e-5 || d1 < 1e-5 ? 1e-6 : 0.01 * d0 / d1;
    return h < span ? h : span;
}

static inline double first_step(double guessed, double d1, double d2, double order, double span)
{
    const double d = d1 > d2 ? d1 : d2, least = 1e-3 * guessed;
    const double next = d <= 1e-15 ? (least > 1e-6 ? least : 1e-6) : pow(0.01 / d, 1.0 / (order + 1.0));
    const double h = 100.0 * guessed < next ? 100.0 * guessed : next;
    return h < span && h > 0.0 ? h : span;
}

static inline double last_step(const rodgen_run *is)
{
    return (is->t - is->before) + (is->lag - is->lag_before);
}

/* The smallest step that time since the start of a stretch can be counted in. */
static inline double least_step(double past)
{
    return 16.0 * 2.220446049250313e-16 * (past > 1e-290 ? past : 1e-290);
}

/* Steps by a method, and states inside the last one: explicit.c, collocation.c, collocation_dense.c. h: length of the
   last step; x: share of it. */
int rodgen_fixed_step(struct run *r);
void rodgen_hermite(struct run *r, double h, double x, double *out);
int rodgen_dop853_step(struct run *r);
void rodgen_dop853_dense(struct run *r, double h, double x, double *out);
int rodgen_collocation_step(struct run *r);
int rodgen_collocation_equal_step(struct run *r);
void rodgen_collocation_dense(struct run *r, double x, double *out);

#endif
