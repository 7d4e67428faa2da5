/* Explicit methods: step control for one rod (lengths of steps, whether they are accepted, states in between), and sums
   of stages. */

#ifndef RODGEN_CONTROL_H
#define RODGEN_CONTROL_H

#include "run.h"

#include "tableaux.h"

/* End of an equal step from the start of a stretch, the last one shortened to meet its end; a step that would be
   shorter than a millionth of the others is not taken. */
static inline double end_of_equal_step(const rodgen_run *is)
{
    const double span = is->end - is->start;
    const int last = (double)(is->taken + 1) >= span / is->step - 1e-6;
    return last ? is->end : is->start + (double)(is->taken + 1) * is->step;
}

/* Time of a stage at a share of a step h from t to next. */
static inline double stage_time(double share, double t, double next, double h)
{
    return share == 1.0 ? next : t + share * h;
}

/* A cubic at the share x of a step h, from y to on with their rates. */
static inline double hermite(double y, double on, double f_before, double f, double h, double x)
{
    const double rest = 1.0 - x;
    const double bend = (1.0 - 2.0 * x) * (on - y) + h * ((x - 1.0) * f_before + x * f);
    return rest * y + x * on - x * rest * bend;
}

/* Steps between two looks at the largest eigenvalue; how often it is looked at first. */
enum { LOOK = 32, FIRST_LOOK = 8 };

static inline int looks_due(const rodgen_run *is)
{
    return is->looked < 0 ? FIRST_LOOK : is->looked >= LOOK;
}

/* How far a look moves the positions along a direction of that squared length: angles are of order one, and the
   rounding of the difference is that of the rates. Then how far the velocities, by the squared frequency. */
static inline double turn_by(double length)
{
    return 1e-6 / sqrt(length);
}

static inline double speed_by(double by, double squared_frequency)
{
    return by * fmax(1.0, sqrt(fabs(squared_frequency)));
}

/* How far a look moves a state that is added; then the longest stable step of DOP853 for one whose rate has that slope
   by the state itself: of a lag, one over its time. */
static inline double state_by(double state)
{
    return 1e-6 * fmax(1.0, fabs(state));
}

static inline double longest_of_state(double slope)
{
    enum { CREEPS = sizeof dop853.limits / sizeof *dop853.limits - 1 };
    return slope < 0.0 ? dop853.limits[CREEPS] / -slope : INFINITY;
}

/* The longest stable step of DOP853 for the roots of z^2 + damping z + squared frequency. */
static inline double longest_stable(rodgen_run *is, double squared_frequency, double damping)
{
    /* Largest stable step times the modulus of an eigenvalue, by its direction. */
    const double *const limit = dop853.limits;
    enum { DIRECTIONS = sizeof dop853.limits / sizeof *dop853.limits };
    const double half = damping / 2.0, rest = squared_frequency - half * half;
    const double modulus
        = rest > 0.0 ? sqrt(squared_frequency > 0.0 ? squared_frequency : 0.0) : half + sqrt(-rest);
    if (!(modulus > 0.0))
        return INFINITY;
    is->modulus = modulus;
    const double angle = rest > 0.0 ? asin(fmin(1.0, fmax(0.0, half / modulus))) : asin(1.0);
    const double place = angle / asin(1.0) * (DIRECTIONS - 1);
    const int left = place < DIRECTIONS - 2 ? (int)place : DIRECTIONS - 2;
    const double bound = limit[left] + (place - left) * (limit[left + 1] - limit[left]);
    return bound / modulus;
}

/* The step that DOP853 tries next, 0 where it would be too small; cut: whether it is short only to meet an end. */
static inline double step_to_try(const rodgen_run *is, int *cut)
{
    const double most = is->most < is->longest ? is->most : is->longest;
    const double wanted = is->step < most ? is->step : most, left = left_of(is);
    if (!(wanted > least_step(is->t - is->start)))
        return 0.0;
    /* The last two steps share what is left, so that none is tiny. */
    const double h = wanted >= left * (1.0 - 1e-12) ? left : 2.0 * wanted > left ? left / 2.0 : wanted;
    *cut = h < is->step && h < most;
    return h;
}

/* The error of a step h from squares of its estimates of order 5 and 3 over what is tolerated, summed. */
static inline double error_of_both(double five, double three, double h, double states)
{
    return five > 0.0 ? h * five / sqrt((five + 0.01 * three) * states) : five;
}

/* In how many parts of a step h its dense output is good enough, from the squares of the last part of the dense output
   over what is tolerated, summed. */
static inline int parts_of(double last, double h, double states)
{
    const double over = h * sqrt(last / states) / dop853.largest_last;
    int parts = 1;
    for (double left = over; !(left < 1.0) && parts < dop853.most_parts; left /= dop853.halved)
        parts *= 2;
    return parts;
}

/* Whether a step of that error is kept, and the length of the next; whole: all of it is finite; again: it was tried
   before with another length. */
static inline int is_kept(rodgen_run *is, double h, double error, int whole, int again, int cut)
{
    is->broken = whole ? TOO_SMALL : NOT_FINITE;
    if (whole && error < 1.0) {
        double factor = error > 0.0 ? 0.9 * pow(error, -0.125) : 10.0;
        factor = factor < 10.0 ? factor : 10.0;
        factor = again && factor > 1.0 ? 1.0 : factor;
        is->step = cut && h * factor < is->step ? is->step : h * factor;
        return 1;
    }
    const double factor = whole ? 0.9 * pow(error, -0.125) : 0.1;
    is->step = h * (factor > 0.2 ? factor : 0.2);
    ++is->rejected;
    return 0;
}

/* The end of a step that is kept. */
static inline void arrive(rodgen_run *is, double next, double lag)
{
    is->before = is->t;
    is->lag_before = is->lag;
    is->t = next;
    is->lag = lag;
    is->dense = is->part = 0;
    ++is->looked;
}

/* DOP853 at the share x of a step h, from y to on with their rates: its inner part by four sums of the stages, then
   the state. */
static inline double dop853_inner(double f3, double f4, double f5, double f6, double h, double x)
{
    return h * f3 + x * (h * f4 + (1.0 - x) * (h * f5 + x * (h * f6)));
}

static inline double dop853_between(double y, double on, double f_before, double f, double h, double x, double inner)
{
    const double rest = 1.0 - x, by = on - y;
    const double f1 = h * f_before - by, f2 = 2.0 * by - h * (f + f_before);
    return y + x * (by + rest * (f1 + x * (f2 + rest * inner)));
}

/* Sums of stages, written out for each count of them, so that they take one pass over the states. The file that includes
   this defines CASE(count, value): the case of a sum of so many products, and how its value is used. */
#define PRODUCT_0 0.0
#define PRODUCT_1 c[0] * k0[i]
#define PRODUCT_2 PRODUCT_1 + c[1] * k1[i]
#define PRODUCT_3 PRODUCT_2 + c[2] * k2[i]
#define PRODUCT_4 PRODUCT_3 + c[3] * k3[i]
#define PRODUCT_5 PRODUCT_4 + c[4] * k4[i]
#define PRODUCT_6 PRODUCT_5 + c[5] * k5[i]
#define PRODUCT_7 PRODUCT_6 + c[6] * k6[i]
#define PRODUCT_8 PRODUCT_7 + c[7] * k7[i]
#define PRODUCT_9 PRODUCT_8 + c[8] * k8[i]
#define PRODUCT_10 PRODUCT_9 + c[9] * k9[i]
#define PRODUCT_11 PRODUCT_10 + c[10] * k10[i]
#define PRODUCT_12 PRODUCT_11 + c[11] * k11[i]
#define STAGE(number) const double *const restrict k##number = k[sum->at[number < sum->count ? number : 0]]
#define CASES(value) \
    switch (sum->count) { \
        CASE(0, value) \
        CASE(1, value) \
        CASE(2, value) \
        CASE(3, value) \
        CASE(4, value) \
        CASE(5, value) \
        CASE(6, value) \
        CASE(7, value) \
        CASE(8, value) \
        CASE(9, value) \
        CASE(10, value) \
        CASE(11, value) \
        CASE(12, value) \
    }
#define STAGES_OF_SUM \
    const double *const restrict c = sum->value; \
    STAGE(0); \
    STAGE(1); \
    STAGE(2); \
    STAGE(3); \
    STAGE(4); \
    STAGE(5); \
    STAGE(6); \
    STAGE(7); \
    STAGE(8); \
    STAGE(9); \
    STAGE(10); \
    STAGE(11)

#endif
