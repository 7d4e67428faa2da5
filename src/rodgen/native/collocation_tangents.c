/* Tangents of a step by collocation: derivatives of the state at its end by that at its start, from the equations of the
   step itself.

   With the stages known, those of a tangent are the solution of linear equations, the derivatives of the rates in each
   stage times it. They are solved as the stages are, by the factors of one matrix for all three, which differ from those of
   the stages by less than a step changes them. */

#include "collocation.h"

enum { MOST = 100, OFTEN = 8 };
/* Of a tangent: what is left is rounding; and what no longer shrinks may be. */
static const double DONE = 1e-14, ROUNDED = 1e-8;

/* Rates of the tangents in all stages, for the changes of these that are known so far. */
static void products(struct run *r, const struct collocation *m, double h)
{
    const ptrdiff_t first = r->states + (ptrdiff_t)r->of->works;
    for (int s = 0; s < 3; ++s) {
        const double *const stage = r->k[Z + s];
        EACH_STATE
            r->trial[i] = r->before[i] + stage[i];
        INDEPENDENT for (ptrdiff_t i = first; i < r->width; ++i)
            r->trial[i] = r->y[i] + stage[i];
        r->of->variations(inside(r->is, r->is->t + h * m->c[s]), r->trial, r->p, r->k[F + s], r->of->tangents, r->flow);
    }
}

/* Correct the stages of the tangent whose numbers begin at a place; by how much, over its size. */
static double correct(struct run *r, const struct collocation *m, double h, ptrdiff_t at)
{
    double *const *const k = r->k, *const real = r->trial, *const pair = r->shifted;
    const double real_shift = m->real / h, shift[2] = {m->pair[0] / h, m->pair[1] / h};
    EACH_STATE {
        const double a = k[F][at + i], b = k[F + 1][at + i], c = k[F + 2][at + i];
        real[i] = m->TI[0][0] * a + m->TI[0][1] * b + m->TI[0][2] * c - real_shift * k[W][at + i];
        const double re = m->TI[1][0] * a + m->TI[1][1] * b + m->TI[1][2] * c;
        const double im = m->TI[2][0] * a + m->TI[2][1] * b + m->TI[2][2] * c;
        const double w = k[W + 1][at + i], v = k[W + 2][at + i];
        pair[2 * i] = re - (shift[0] * w - shift[1] * v);
        pair[2 * i + 1] = im - (shift[0] * v + shift[1] * w);
    }
    r->of->solve_real(real, r->newton);
    r->of->solve_complex(pair, r->newton);
    double change = 0.0, size = 0.0;
    EACH_STATE {
        const double a = real[i], b = pair[2 * i], c = pair[2 * i + 1], over = k[SCALE][i];
        change += square(a * over) + square(b * over) + square(c * over);
        size += square(r->y[at + i] * over) + square(k[W][at + i] * over);
        k[W][at + i] += a;
        k[W + 1][at + i] += b;
        k[W + 2][at + i] += c;
        for (int s = 0; s < 3; ++s)
            k[Z + s][at + i] = m->T[s][0] * k[W][at + i] + m->T[s][1] * k[W + 1][at + i] + m->T[s][2] * k[W + 2][at + i];
    }
    return size > 0.0 ? sqrt(change / size) : change > 0.0 ? INFINITY : 0.0;
}

/* Whether the stages of all tangents are found. */
static int solved(struct run *r, const struct collocation *m, double h, int most)
{
    const ptrdiff_t first = r->states + (ptrdiff_t)r->of->works;
    double last = INFINITY;
    for (int iteration = 0; iteration < most; ++iteration) {
        products(r, m, h);
        double largest = 0.0;
        for (ptrdiff_t at = first; at < r->width; at += r->states) {
            const double change = correct(r, m, h, at);
            if (!(change < INFINITY))
                return 0;
            largest = change > largest ? change : largest;
        }
        if (largest <= DONE || (largest <= ROUNDED && largest >= last / 2.0))
            return 1;
        last = largest;
    }
    return 0;
}

int rodgen_collocation_tangents(struct run *r, const struct collocation *m, double h)
{
    double *const *const k = r->k;
    const ptrdiff_t first = r->states + (ptrdiff_t)r->of->works;
    if (first == r->width)
        return 1;
    for (int s = 0; s < 3; ++s) {
        memset(k[Z + s] + first, 0, (size_t)(r->width - first) * sizeof **k);
        memset(k[W + s] + first, 0, (size_t)(r->width - first) * sizeof **k);
    }
    if (!solved(r, m, h, r->is->blocks == FRESH ? MOST : OFTEN)) {
        if (r->is->blocks == FRESH)
            return 0;
        r->is->blocks = NONE;
        rodgen_collocation_prepare(r, m, h);
        if (!solved(r, m, h, MOST))
            return 0;
    }
    INDEPENDENT for (ptrdiff_t i = first; i < r->width; ++i)
        r->y[i] += m->end[0] * k[Z][i] + m->end[1] * k[Z + 1][i] + m->end[2] * k[Z + 2][i];
    return all_finite(r->y + first, r->width - first);
}
