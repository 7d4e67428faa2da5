/* Collocation at three points: Gauss and Radau IIA. */

#include "collocation.h"

/* Iterations of a step that may be made shorter, and of one of equal steps. */
enum { ITERATIONS = 7, MOST_ITERATIONS = 50 };
/* So fast do changes shrink, from the first to the second, that equal steps keep their derivatives. */
static const double FAST = 5e-2;

/* Whether there is a last step to go on from, and how. */
enum { ROUGH = 1, SMOOTH = 2 };
/* Newton's method for the three stages, in the variables in which the matrix falls apart. Returns
   the number of iterations, 0 if it does not converge; rate: how fast the changes shrink, in equal steps
   the first ones. */
static int solve_stages(struct run *r, const struct collocation *m, double h, double *rate)
{
    double *const *const k = r->k;
    double *const pair = r->shifted;
    const double real_shift = m->real / h, shift[2] = {m->pair[0] / h, m->pair[1] / h};
    EACH_STATE
        r->error[i] = square((fabs(r->before[i]) + fabs(k[Z + 2][i])) * k[SCALE][i]);
    const double rounding = 2.2e-16 * sqrt(total(r->error, r->states) / (double)r->states);
    const double wanted = fmax(10.0 * rounding, fmin(0.03, sqrt(r->is->rtol)));
    const int equal = r->is->method == GAUSS_EQUAL_STEPS, most = equal ? MOST_ITERATIONS : ITERATIONS;
    double last = 0.0;
    *rate = 0.0;
    for (int iteration = 1; iteration <= most; ++iteration) {
        for (int s = 0; s < 3; ++s) {
            const double *const stage = k[Z + s];
            EACH
                r->trial[i] = r->before[i] + stage[i];
            flow_at(r, r->is->t + h * m->c[s], r->trial, k[F + s]);
        }
        double *const real = r->trial;
        EACH_STATE {
            const double a = k[F][i], b = k[F + 1][i], c = k[F + 2][i];
            real[i] = m->TI[0][0] * a + m->TI[0][1] * b + m->TI[0][2] * c - real_shift * k[W][i];
            const double re = m->TI[1][0] * a + m->TI[1][1] * b + m->TI[1][2] * c;
            const double im = m->TI[2][0] * a + m->TI[2][1] * b + m->TI[2][2] * c;
            const double w = k[W + 1][i], v = k[W + 2][i];
            pair[2 * i] = re - (shift[0] * w - shift[1] * v);
            pair[2 * i + 1] = im - (shift[0] * v + shift[1] * w);
        }
        r->of->solve_real(real, r->newton);
        r->of->solve_complex(pair, r->newton);
        EACH_STATE {
            const double a = real[i], b = pair[2 * i], c = pair[2 * i + 1], over = k[SCALE][i];
            r->error[i] = square(a * over) + square(b * over) + square(c * over);
            k[W][i] += a;
            k[W + 1][i] += b;
            k[W + 2][i] += c;
            for (int s = 0; s < 3; ++s)
                k[Z + s][i] = m->T[s][0] * k[W][i] + m->T[s][1] * k[W + 1][i] + m->T[s][2] * k[W + 2][i];
        }
        const double size = sqrt(total(r->error, r->states) / (double)(3 * r->states));
        if (!(size < INFINITY))
            return 0;
        /* Where the first guess is right, changes are rounding, and do not shrink. */
        if (size <= rounding)
            return iteration;
        if (iteration > 1) {
            /* Equal steps are those of the method itself, to what rounding in the rates leaves: what tells of
               the derivatives is how they begin. */
            if (equal && size >= last && size <= 1e6 * rounding)
                return iteration;
            if (!equal || iteration == 2)
                *rate = size / last;
            const double ahead = pow(*rate, ITERATIONS - iteration) / (1.0 - *rate) * size;
            if (!equal && (*rate >= 1.0 || ahead > wanted))
                return 0;
            if (!equal && *rate / (1.0 - *rate) * size < wanted)
                return iteration;
        }
        last = size;
    }
    return 0;
}

/* Factor of the next step by what two steps in a row reach (K. Gustafsson's predictive control). */
static double predicted(const struct run *r, double h, double reach)
{
    if (!(r->is->last_step > 0.0) || !(reach < INFINITY))
        return reach;
    const double change = h / r->is->last_step * (reach / r->is->last_reach);
    return change < 1.0 ? change * reach : reach;
}

/* A shift and the derivatives that belong to it, where they are not there yet. */
void rodgen_collocation_prepare(struct run *r, const struct collocation *m, double h)
{
    if (r->is->blocks == NONE) {
        r->of->linearise(inside(r->is, r->is->t), r->before, r->p, r->newton);
        ++r->is->jacobian;
        r->is->blocks = FRESH;
        r->is->factored = 0.0;
    }
    if (r->is->factored != h) {
        const double shift[2] = {m->pair[0] / h, m->pair[1] / h};
        r->of->factor(m->real / h, shift, r->newton);
        ++r->is->factorisations;
        r->is->factored = h;
    }
}

/* Where Newton's method begins: on the polynomial of the last step, with what it lacks where that is
   small, or at the state. */
static void predict(struct run *r, const struct collocation *m, double ratio)
{
    double *const *const k = r->k;
    double lack[3][3];
    for (int s = 0; s < 3; ++s)
        for (int part = 0; part < 3; ++part)
            lack[s][part] = r->is->predicts == SMOOTH ? quintic(m->missing[part], 1.0 + m->c[s] * ratio) : 0.0;
    EACH_STATE {
        double z[3] = {0.0, 0.0, 0.0};
        if (ratio > 0.0)
            for (int s = 0; s < 3; ++s)
                z[s] = polynomial(k, 1.0 + m->c[s] * ratio, i) - polynomial(k, 1.0, i) + lack[s][0] * k[MISSING][i]
                    + lack[s][1] * k[MISSING + 1][i] + lack[s][2] * k[MISSING + 2][i];
        for (int s = 0; s < 3; ++s) {
            k[Z + s][i] = z[s];
            k[W + s][i] = m->TI[s][0] * z[0] + m->TI[s][1] * z[1] + m->TI[s][2] * z[2];
        }
    }
    for (int number = 0; number < GROUPS; ++number) {
        const struct group group = group_of(r, number);
        for (ptrdiff_t i = group.low; i < group.high; ++i)
            k[SCALE][i] = 1.0 / tolerated(r->is, fabs(r->before[i]), group.limit);
    }
    for (int s = 0; s < 3; ++s)
        memset(k[Z + s] + r->states, 0, (size_t)(r->all - r->states) * sizeof **k);
}

/* Where the step ends: state, works, and the rates there. Whether all of that is finite. */
static int arrive(struct run *r, const struct collocation *m, double h, double next)
{
    double *const *const k = r->k;
    EACH_STATE
        r->y[i] = r->before[i] + (m->end[0] * k[Z][i] + m->end[1] * k[Z + 1][i] + m->end[2] * k[Z + 2][i]);
    EACH_WORK {
        for (int s = 0; s < 3; ++s)
            k[Z + s][i] = h * (m->A[s][0] * k[F][i] + m->A[s][1] * k[F + 1][i] + m->A[s][2] * k[F + 2][i]);
        r->y[i] = r->before[i] + h * (m->b[0] * k[F][i] + m->b[1] * k[F + 1][i] + m->b[2] * k[F + 2][i]);
    }
    flow_at(r, next, r->y, r->f);
    const double ends = r->is->method == RADAU ? 0.0 : h;
    EACH {
        const double a = k[Z][i], b = k[Z + 1][i], c = k[Z + 2][i];
        k[BEGIN][i] = h * r->f_before[i] + (m->error[0] * a + m->error[1] * b + m->error[2] * c);
        k[END][i] = ends * r->f[i] - (m->slope[0] * a + m->slope[1] * b + m->slope[2] * c);
        k[BEND][i] = (r->y[i] - r->before[i]) - h / 2.0 * (r->f_before[i] + r->f[i]);
    }
    return all_finite(r->y, r->all) && all_finite(r->f, r->all);
}

/* Error by one step, of the power 4; after a rejection looked at once more. */
static double error_of_one(struct run *r, double h, int again)
{
    double *const *const k = r->k, *const error = r->trial;
    EACH_STATE
        error[i] = k[BEGIN][i] / h;
    r->of->solve_real(error, r->newton);
    const double size = scaled(r, error, r->before, r->y);
    if (!again || !(size > 1.0))
        return size;
    EACH_STATE
        error[i] += r->before[i];
    flow_at(r, r->is->t, error, k[W]);
    EACH_STATE
        error[i] = k[BEGIN][i] / h + (k[W][i] - r->f_before[i]);
    r->of->solve_real(error, r->newton);
    return scaled(r, error, r->before, r->y);
}

/* Error by this step and the last one, of the method's own power: what the fourth derivative changes
   by from one to the other; for Gauss's method, less what the third says of that at their ends. */
static double error_of_two(struct run *r, const struct collocation *m, double h)
{
    double *const *const k = r->k, *const error = r->trial;
    const double ratio = h / last_step(r->is), square_of = ratio * ratio, turn = 0.1 * (ratio - 1.0) / (ratio + 1.0);
    const int radau = r->is->method == RADAU;
    const double now = radau ? 1.0 / (0.45 + 0.55 / ratio) : -0.25 - 0.5 * turn;
    const double then = square_of * square_of * (radau ? -now : -0.25 + 0.5 * turn);
    const double bend = radau ? 0.0 : 0.2 * ratio / (ratio + 1.0);
    EACH_STATE
        error[i] = (now * (k[END][i] - k[BEGIN][i]) + then * (k[LAST + 1][i] - k[LAST][i])
            + bend * (square_of * ratio * k[LAST + 2][i] - k[BEND][i])) / h;
    r->of->solve_real(error, r->newton);
    return m->weight * scaled(r, error, r->before, r->y);
}

/* By how much the step could have been longer (below 1: shorter) for the tolerance. The second
   estimate holds where the motion is smooth over two steps, the first at every step, that after a
   break too, and where a step is longer than the fastest motion. */
static double reached(struct run *r, const struct collocation *m, double h, int again)
{
    const double one = pow(error_of_one(r, h, again), -0.25);
    const double two = r->is->predicts ? pow(error_of_two(r, m, h), -1.0 / m->power) : 0.0;
    r->is->smooth = two > one;
    return two > one ? two : one;
}

/* A step that is taken is kept: its polynomial, and what the next one asks of it. */
static int keep(struct run *r, const struct collocation *m, double h, double next, double lag)
{
    double *const *const k = r->k;
    EACH {
        const double a = k[Z][i], b = k[Z + 1][i], c = k[Z + 2][i];
        for (int s = 0; s < 3; ++s)
            k[Q + s][i] = m->dense[s][0] * a + m->dense[s][1] * b + m->dense[s][2] * c;
    }
    for (int part = 0; part < 3; ++part)
        copy(r, k[LAST + part], k[BEGIN + part]);
    r->is->last_step = h;
    r->is->predicts = r->is->smooth ? SMOOTH : ROUGH;
    r->is->dense = 0;
    r->is->before = r->is->t;
    r->is->lag_before = r->is->lag;
    r->is->t = next;
    r->is->lag = lag;
    return PAUSED;
}

/* Whether the rates of all stages are finite. */
static int finite_stages(const struct run *r)
{
    return all_finite(r->k[F], r->all) && all_finite(r->k[F + 1], r->all) && all_finite(r->k[F + 2], r->all);
}

static int given_up(struct run *r, int why)
{
    copy(r, r->y, r->before);
    copy(r, r->f, r->f_before);
    return why;
}

/* A step; its control is that of RADAU5. */
int rodgen_collocation_step(struct run *r)
{
    const struct collocation *const m = method_of(r);
    const double t = r->is->t, left = left_of(r->is);
    if (r->is->predicts == SMOOTH)
        rodgen_collocation_complete(r, m);
    copy(r, r->before, r->y);
    copy(r, r->f_before, r->f);
    r->is->broken = TOO_SMALL;
    for (int again = 0;;) {
        if (!(r->is->step > least_step(t - r->is->start)))
            return given_up(r, (int)r->is->broken);
        const double wanted = r->is->step < r->is->longest ? r->is->step : r->is->longest;
        /* The last two steps share what is left, so that none is tiny. */
        const double h = wanted >= left * (1.0 - 1e-12) ? left : 2.0 * wanted > left ? left / 2.0 : wanted;
        rodgen_collocation_prepare(r, m, h);
        predict(r, m, r->is->predicts ? h / last_step(r->is) : 0.0);
        double rate, lag;
        const int iterations = solve_stages(r, m, h, &rate);
        if (!iterations) {
            ++r->is->rejected;
            r->is->broken = finite_stages(r) ? DIVERGED : NOT_FINITE;
            if (r->is->blocks == OLD && r->is->broken == DIVERGED)
                r->is->blocks = NONE;
            else
                r->is->step = h / 2.0;
            continue;
        }
        const double next = later(r->is, h, &lag);
        const int whole = arrive(r, m, h, next);
        const double reach = whole ? reached(r, m, h, again) : 0.0;
        const double safety = 0.9 * (2.0 * ITERATIONS + 1.0) / (2.0 * ITERATIONS + iterations);
        const double factor = safety * predicted(r, h, reach);
        if (!(reach >= 1.0)) {
            ++r->is->rejected;
            r->is->broken = whole ? TOO_SMALL : NOT_FINITE;
            r->is->step = h * (!whole ? 0.5 : factor > 0.2 ? factor : 0.2);
            again = whole;
            continue;
        }
        if (!rodgen_collocation_tangents(r, m, h))
            return given_up(r, DIVERGED);
        const int kept = iterations <= 3 || rate <= 0.02;
        const double grown = factor > 10.0 ? 10.0 : factor > 0.2 ? factor : 0.2;
        const double chosen = kept && grown >= 1.0 && grown < 1.2 ? h : h * grown;
        r->is->blocks = kept ? OLD : NONE;
        /* An error of next to nothing says nothing of the next one. */
        r->is->last_reach = reach < 3.0 ? reach : 3.0;
        r->is->step = h < wanted && chosen < wanted ? wanted : chosen;
        return keep(r, m, h, next, lag);
    }
}

/* One of equal steps by Gauss's method: symmetric, and nothing adapts. As with the other methods of
   fixed step, the last one is shortened to meet the end. */
int rodgen_collocation_equal_step(struct run *r)
{
    const struct collocation *const m = method_of(r);
    const double taken = (double)r->is->taken, span = r->is->end - r->is->start;
    const int last = taken + 1.0 >= span / r->is->step - 1e-6;
    const double h = last ? span - taken * r->is->step : r->is->step;
    const double next = last ? r->is->end : r->is->start + (taken + 1.0) * r->is->step;
    copy(r, r->before, r->y);
    copy(r, r->f_before, r->f);
    double rate;
    int iterations;
    do {
        rodgen_collocation_prepare(r, m, h);
        predict(r, m, r->is->predicts ? h / r->is->last_step : 0.0);
        iterations = solve_stages(r, m, h, &rate);
        if (!iterations && r->is->blocks == FRESH)
            return given_up(r, finite_stages(r) ? DIVERGED : NOT_FINITE);
        r->is->blocks = iterations && rate <= FAST ? OLD : NONE;
    } while (!iterations);
    if (!arrive(r, m, h, next))
        return given_up(r, NOT_FINITE);
    if (!rodgen_collocation_tangents(r, m, h))
        return given_up(r, DIVERGED);
    ++r->is->taken;
    return keep(r, m, h, next, 0.0);
}
