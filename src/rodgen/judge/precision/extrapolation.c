/* Extrapolation methods on the equations of a generated module, for reference solutions.

   Included after the text of the module in one translation unit, where `double` may have been
   `long double`: `real` is what the equations are computed in.

   explicit:  the midpoint rule with 2, 4, .., 2 columns substeps of Gragg, Bulirsch and Stoer;
              order 2 columns (E. Hairer, S. P. Norsett, G. Wanner, Solving ODEs I, II.9).
   implicit:  the linearly implicit Euler method with 2, 3, .., columns + 1 substeps, SEULEX;
              order columns (E. Hairer, G. Wanner, Solving ODEs II, IV.9).

   Both with steps controlled by the difference of the last two columns, relative to what exceeds one,
   and onto every time that is asked for. */

struct extrapolation {
    real y[STATES], f0[STATES], f[STATES], old[STATES], change[STATES];
    real table[24][STATES];
    real low, high;
    const double *weights;
    real p[PARAMETER_COUNT];
    struct rhs rhs;
    struct newton newton;
    struct real_cells cells;
    long long counts[5]; /* steps, rejected, rhs, jacobian, factorisations */
    clock_t begun;
};

static void rates_at(struct extrapolation *x, real t, const real *y, real *dy)
{
    rhs(t < x->low ? x->low : t > x->high ? x->high : t, y, x->p, dy, &x->rhs);
    ++x->counts[2];
}

static void by_midpoints(struct extrapolation *x, real t, real H, int parts, real *restrict out)
{
    const real h = H / parts;
    for (ptrdiff_t i = 0; i < STATES; ++i) {
        x->old[i] = x->y[i];
        out[i] = x->y[i] + h * x->f0[i];
    }
    for (int part = 1; part < parts; ++part) {
        rates_at(x, t + part * h, out, x->f);
        for (ptrdiff_t i = 0; i < STATES; ++i) {
            const real next = x->old[i] + 2 * h * x->f[i];
            x->old[i] = out[i];
            out[i] = next;
        }
    }
}

static void by_euler(struct extrapolation *x, real t, real H, int parts, real *restrict out)
{
    const real h = H / parts;
    real_factor(&x->newton, 1 / h, &x->cells);
    ++x->counts[4];
    memcpy(out, x->y, sizeof x->y);
    for (int part = 1; part <= parts; ++part) {
        rates_at(x, t + part * h, out, x->f);
        real_solve(&x->newton, &x->cells, x->f, x->change);
        for (ptrdiff_t i = 0; i < STATES; ++i)
            out[i] += x->change[i];
    }
}

/* A step; the largest weighted difference of the last two columns, the result in table[0]. */
static real extrapolated(struct extrapolation *x, int implicit, int columns, real t, real H)
{
    real (*const T)[STATES] = x->table;
    real error = 0;
    for (int j = 0; j < columns; ++j) {
        const int parts = implicit ? j + 2 : 2 * (j + 1);
        (implicit ? by_euler : by_midpoints)(x, t, H, parts, T[j]);
        for (int k = j; k > 0; --k) {
            const real r = (real)parts / (implicit ? k + 1 : 2 * k);
            const real over = 1 / ((implicit ? r : r * r) - 1);
            const int last = j == columns - 1 && k == 1;
            for (ptrdiff_t i = 0; i < STATES; ++i) {
                const real more = (T[k][i] - T[k - 1][i]) * over;
                if (last) {
                    const real size = T[k][i] < 0 ? -T[k][i] : T[k][i];
                    const real scale = size > 1 ? x->weights[i] * size : x->weights[i];
                    const real off = (more < 0 ? -more : more) / scale;
                    error = off > error || !(off >= 0) ? off : error;
                }
                T[k - 1][i] = T[k][i] + more;
            }
        }
    }
    return error;
}

static int finite_state(const real *values)
{
    for (ptrdiff_t i = 0; i < STATES; ++i)
        if (!(values[i] - values[i] == 0))
            return 0;
    return 1;
}

/* To the next time; h: the step to try, kept for the next call. Ends with 0, -1 where steps become
   too small, -2 where the quota of steps is used up, -4 where the seconds of processor time since
   x->begun are, -5 where rates are not finite. */
static int to(struct extrapolation *x, int implicit, int columns, double tolerance, real *t, real end,
              real *h, long long quota, double seconds)
{
    const double power = implicit ? 1.0 / columns : 1.0 / (2 * columns - 1);
    int fresh = 0;
    while (*t < end) {
        if (!fresh) {
            rates_at(x, *t, x->y, x->f0);
            if (!finite_state(x->f0))
                return -5;
            if (implicit) {
                const real inside = *t < x->low ? x->low : *t > x->high ? x->high : *t;
                linearise(inside, x->y, x->p, &x->newton, &x->cells);
                ++x->counts[3];
            }
            fresh = 1;
        }
        const real left = end - *t;
        const double parts = ceil((double)(left / *h));
        const real H = parts <= 1 ? left : left / parts;
        const double error = (double)(extrapolated(x, implicit, columns, *t, H) / tolerance);
        double factor = error > 0 ? 0.9 * pow(error, -power) : 4.0;
        factor = error >= 0 ? factor : 0.1; /* not a number */
        factor = factor < 0.1 ? 0.1 : factor > 4.0 ? 4.0 : factor;
        if (error <= 1.0) {
            memcpy(x->y, x->table[0], sizeof x->y);
            *t = parts <= 1 ? end : *t + H;
            ++x->counts[0];
            fresh = 0;
            if (factor < 1.0 || H >= 0.5 * *h)
                *h = H * factor > *h || factor < 1.0 ? H * factor : *h;
        } else {
            ++x->counts[1];
            *h = H * factor;
            if (!(*h > 1e-17 * (end > 1 ? end : 1)))
                return -1;
        }
        if (--quota < 0)
            return -2;
        if ((double)(clock() - x->begun) > seconds * CLOCKS_PER_SEC)
            return -4;
    }
    return 0;
}

/* States at the times that follow the first. times, low, high: (count), the loads on the way to
   times[i] are asked for between low[i] and high[i]; counts: (5); reached: where it ended. */
int extrapolate(int implicit, int columns, double tolerance, double first, const double *p,
                const double *weights, size_t count, const double *times, const double *low,
                const double *high, double *states, long long *counts, long long quota,
                double seconds, double *reached)
{
    struct extrapolation *const x = calloc(1, sizeof *x);
    if (!x)
        return -3;
    for (ptrdiff_t i = 0; i < STATES; ++i)
        x->y[i] = states[i];
    for (ptrdiff_t i = 0; i < PARAMETER_COUNT; ++i)
        x->p[i] = p[i];
    x->weights = weights;
    x->begun = clock();
    real t = times[0], h = first;
    int status = 0;
    for (size_t i = 1; i < count && status == 0; ++i) {
        x->low = low[i];
        x->high = high[i];
        status = to(x, implicit, columns, tolerance, &t, times[i], &h,
                    quota - x->counts[0] - x->counts[1], seconds);
        for (ptrdiff_t k = 0; k < STATES; ++k)
            states[i * STATES + k] = (double)x->y[k];
    }
    memcpy(counts, x->counts, sizeof x->counts);
    *reached = (double)t;
    free(x);
    return status;
}

/* Rates as sums of two doubles, so that what long doubles hold is not rounded away. */
void rates_in_two(double t, const double *y, const double *p, double *dy, double *rest)
{
    struct extrapolation *const x = calloc(1, sizeof *x);
    if (!x)
        return;
    for (ptrdiff_t i = 0; i < STATES; ++i)
        x->y[i] = y[i];
    for (ptrdiff_t i = 0; i < PARAMETER_COUNT; ++i)
        x->p[i] = p[i];
    x->low = x->high = t;
    rates_at(x, t, x->y, x->f);
    for (ptrdiff_t i = 0; i < STATES; ++i) {
        dy[i] = (double)x->f[i];
        rest[i] = (double)(x->f[i] - dy[i]);
    }
    free(x);
}

/* Bits of the significand. */
int digits_of_real(void)
{
    return sizeof(real) > sizeof(double) ? LDBL_MANT_DIG : DBL_MANT_DIG;
}
