/* States inside a step by collocation, with corrections of its polynomial. */

#include "collocation.h"

/* Over h, what is stiff in a defect damped by the Newton matrix. */
static void damped(struct run *r, const struct collocation *m, double h, double *defect)
{
    EACH_STATE
        defect[i] *= m->real / h;
    r->of->solve_real(defect, r->newton);
}

/* The state at a share of the last step, by its polynomial and what that lacks. */
static void between(struct run *r, const struct collocation *m, double x, double *out)
{
    const double a = quintic(m->missing[0], x), b = quintic(m->missing[1], x), c = quintic(m->missing[2], x);
    double *const *const k = r->k;
    EACH
        out[i] = r->before[i] + polynomial(k, x, i)
            + (a * k[MISSING][i] + b * k[MISSING + 1][i] + c * k[MISSING + 2][i]);
}

/* How far along a change of the states a difference of rates goes: by 1e-7 of a state, or of one. */
static double nudge(const struct run *r, const double *change)
{
    double most = 0.0;
    EACH_STATE
        most = fmax(most, fabs(change[i]) / fmax(1.0, fabs(r->before[i])));
    return most > 0.0 && most < INFINITY ? 1e-7 / most : 0.0;
}

/* What the collocation polynomial lacks between the ends of the last step, since its stages are of
   order 3 alone. With y4 and y5 the derivatives: h^4 y4 / 6 and, where both ends tell, h^5 y5 / 24
   and h^5 J y4 / 6, by a difference of rates, since the derivatives in Newton's matrix may be those
   of an older step; for works it comes from the power in the middle. */
static void complete(struct run *r, const struct collocation *m, double h)
{
    double *const *const k = r->k, *const one = k[MISSING], *const two = k[MISSING + 1], *const three = k[MISSING + 2];
    const int ends = r->is->method != RADAU;
    EACH {
        one[i] = k[LAST + 1][i] - k[LAST][i];
        two[i] = ends ? k[LAST + 1][i] + k[LAST][i] : 0.0;
        three[i] = 0.0;
    }
    damped(r, m, h, one);
    if (ends) {
        const double by = nudge(r, one);
        memcpy(three, one, (size_t)r->states * sizeof *three);
        damped(r, m, h, three);
        damped(r, m, h, two);
        EACH_STATE
            r->trial[i] = r->before[i] + by * one[i];
        flow_at(r, r->is->before, r->trial, r->error);
        EACH_STATE {
            one[i] -= three[i] - one[i];
            three[i] = by > 0.0 ? 10.0 * h * (r->error[i] - r->f_before[i]) / by : 0.0;
        }
    }
    EACH {
        one[i] *= 10.0;
        two[i] = 20.0 * two[i] + 0.25 * three[i];
    }
    if (ends && r->all > r->states) {
        between(r, m, 0.5, r->trial);
        flow_at(r, r->is->before + 0.5 * h, r->trial, r->error);
        EACH_WORK {
            three[i] = 320.0 * h * (r->error[i] - k[F + 1][i]);
            two[i] += 0.25 * three[i];
        }
    }
}

void rodgen_collocation_complete(struct run *r, const struct collocation *m)
{
    if (!r->is->dense)
        complete(r, m, r->is->last_step);
    r->is->dense = 1;
}

void rodgen_collocation_dense(struct run *r, double x, double *out)
{
    const struct collocation *const m = method_of(r);
    rodgen_collocation_complete(r, m);
    between(r, m, x, out);
}
