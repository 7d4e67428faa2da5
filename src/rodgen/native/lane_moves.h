/* Parts of explicit steps of rods side by side: sums of stages, states moved on by them, errors. */

#ifndef RODGEN_LANE_MOVES_H
#define RODGEN_LANE_MOVES_H

#include "control.h"
#include "many.h"

/* Stages of DOP853 behind the first. */
enum { STEPS = sizeof dop853.stages / sizeof *dop853.stages };
/* many.h has room for these. */
typedef char room_for_stages[STEPS + 1 == AFTER && sizeof dop853.more / sizeof *dop853.more == MORE ? 1 : -1];

#define CASE(number, value) \
    case number: \
        for (ptrdiff_t j = low; j < count; ++j) \
            SIDE_BY_SIDE { \
                const ptrdiff_t i = j * LANES + w; \
                out[i] = value(PRODUCT_##number); \
            } \
        break;

static inline void add(const struct sum *sum, double *const *k, ptrdiff_t count, double *restrict out)
{
    const ptrdiff_t low = 0;
    STAGES_OF_SUM;
#define VALUE(products) products
    CASES(VALUE)
#undef VALUE
}

/* States moved on by a step of each times a sum of stages. */
static inline void move(const double *restrict y, const double *restrict h, const struct sum *sum, double *const *k,
                        ptrdiff_t low, ptrdiff_t count, double *restrict out)
{
    STAGES_OF_SUM;
#define VALUE(products) y[i] + h[w] * (products)
    CASES(VALUE)
#undef VALUE
}

/* Group of the states by its number, as run.h has them. */
static inline struct group group_at(const struct many *m, int number)
{
    const struct run r = {.base = m->base, .half = m->half, .states = m->states};
    return group_of(&r, number);
}

/* Sums over the states of squares of errors over what is tolerated for states between two. */
static inline void add_squares(const struct many *m, const double *restrict error, const double *restrict a,
                               const double *restrict b, double *restrict sums)
{
    const rodgen_run is = {.rtol = m->job->rtol, .atol = m->job->atol};
    for (int number = 0; number < GROUPS; ++number) {
        const struct group group = group_at(m, number);
        for (ptrdiff_t j = group.low; j < group.high; ++j)
            SIDE_BY_SIDE {
                const double u = fabs(a[j * LANES + w]), v = fabs(b[j * LANES + w]);
                sums[w] += square(error[j * LANES + w] / tolerated(&is, u > v ? u : v, group.limit));
            }
    }
}

/* Rates k of so many stages of steps of DOP853 from times and states of each, the first of them in a row. */
static inline void stages(struct many *m, const double *mask, double *const *k, const double *y, const double *start,
                          const double *h, const struct stage *of, int count, int row)
{
    double t[LANES];
    for (int stage = 0; stage < count; ++stage) {
        move(y, h, &of[stage].sum, k, 0, m->all, m->trial);
        SIDE_BY_SIDE
            t[w] = start[w] + of[stage].at * h[w];
        rates(m, t, mask, m->trial, k[row + stage]);
    }
}

/* Where the steps that are tried begin. */
static inline void starts(const struct many *m, double *start)
{
    SIDE_BY_SIDE
        start[w] = m->lane[w].is.t;
}

#endif
