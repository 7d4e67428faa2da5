/* Steps of rods side by side, by explicit methods. No mechanics. */

#include "control.h"
#include "many.h"
#include "sums.h"

/* Stages of DOP853; the first of those of its dense output. */
enum { STEPS = sizeof dop853.stages / sizeof *dop853.stages, FIRST = AFTER + 1 };
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

static void add(const struct sum *sum, double *const *k, ptrdiff_t count, double *restrict out)
{
    const ptrdiff_t low = 0;
    STAGES_OF_SUM;
#define VALUE(products) products
    CASES(VALUE)
#undef VALUE
}

/* States moved on by a step of each times a sum of stages. */
static void move(const double *restrict y, const double *restrict h, const struct sum *sum, double *const *k,
                 ptrdiff_t low, ptrdiff_t count, double *restrict out)
{
    STAGES_OF_SUM;
#define VALUE(products) y[i] + h[w] * (products)
    CASES(VALUE)
#undef VALUE
}

/* Group of the states by its number, as run.h has them. */
static struct group group_at(const struct many *m, int number)
{
    const struct run r = {.base = m->base, .half = m->half, .states = m->states};
    return group_of(&r, number);
}

/* Sums over the states of squares of errors over what is tolerated for states between two. */
static void add_squares(const struct many *m, const double *restrict error, const double *restrict a,
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

/* Root mean squares of these. */
static void scaled_rows(const struct many *m, const double *error, double *out)
{
    double sums[LANES] = {0.0};
    add_squares(m, error, m->y, m->y, sums);
    SIDE_BY_SIDE
        out[w] = sqrt(sums[w] / (double)m->states);
}

void rodgen_first_steps(struct many *m, double *mask)
{
    double d0[LANES], d1[LANES], d2[LANES], h[LANES], at[LANES], span[LANES];
    double *const other = m->k[1];
    int any = 0;
    SIDE_BY_SIDE {
        mask[w] = mask[w] > 0.0 && !(m->lane[w].is.step > 0.0) ? 1.0 : 0.0;
        any |= mask[w] > 0.0;
    }
    if (!any)
        return;
    scaled_rows(m, m->y, d0);
    scaled_rows(m, m->k[0], d1);
    SIDE_BY_SIDE {
        span[w] = m->lane[w].is.end - m->lane[w].is.t;
        h[w] = mask[w] > 0.0 ? guessed_step(d0[w], d1[w], span[w]) : 0.0;
        at[w] = m->lane[w].is.t + h[w];
    }
    for (ptrdiff_t j = 0; j < m->all; ++j)
        SIDE_BY_SIDE
            m->trial[j * LANES + w] = m->y[j * LANES + w] + h[w] * m->k[0][j * LANES + w];
    rates(m, at, mask, m->trial, other);
    for (ptrdiff_t i = 0; i < m->all * LANES; ++i)
        other[i] -= m->k[0][i];
    scaled_rows(m, other, d2);
    SIDE_BY_SIDE
        if (mask[w] > 0.0)
            m->lane[w].is.step = first_step(h[w], d1[w], d2[w] / h[w], 7.0, span[w]);
}

/* The largest stable steps of the lanes of a mask, as rodgen_dop853_step has them for one rod: a turn of the iteration
   on the highest mode. */
static void stable_steps(struct many *m, const double *mask)
{
    const ptrdiff_t count = m->half, velocities = count * LANES;
    double *const restrict d = m->direction, *const turned = m->k[14], *const f = m->k[15], *const at = m->trial;
    double length[LANES] = {0.0}, along[2][LANES] = {{0.0}}, norm[LANES] = {0.0}, zeros[LANES] = {0.0};
    double by[LANES], t[LANES], turn[LANES];
    for (ptrdiff_t j = 0; j < count; ++j)
        SIDE_BY_SIDE
            length[w] += square(d[j * LANES + w]);
    SIDE_BY_SIDE {
        by[w] = mask[w] > 0.0 && length[w] > 0.0 ? turn_by(length[w]) : 0.0;
        t[w] = m->lane[w].is.t;
    }
    for (int of = 0; of < 2; ++of) {
        if (of == 1)
            SIDE_BY_SIDE
                by[w] = speed_by(by[w], -along[0][w] / length[w]);
        memcpy(at, m->y, (size_t)(m->all * LANES) * sizeof *at);
        for (ptrdiff_t j = 0; j < count; ++j)
            SIDE_BY_SIDE
                at[of * velocities + j * LANES + w] += by[w] * d[j * LANES + w];
        rates(m, t, mask, at, f);
        for (ptrdiff_t j = 0; j < count; ++j)
            SIDE_BY_SIDE {
                const ptrdiff_t i = j * LANES + w;
                const double change = (f[velocities + i] - m->k[0][velocities + i]) / by[w];
                turned[i] = of == 0 ? change : turned[i];
                along[of][w] += d[i] * change;
            }
    }
    for (ptrdiff_t j = 0; j < count; ++j)
        SIDE_BY_SIDE
            norm[w] += square(turned[j * LANES + w]);
    add_zeros(turned, count, zeros);
    SIDE_BY_SIDE {
        rodgen_run *const is = &m->lane[w].is;
        if (mask[w] > 0.0)
            is->most = length[w] > 0.0 ? longest_stable(is, -along[0][w] / length[w], -along[1][w] / length[w]) : INFINITY;
        turn[w] = mask[w] > 0.0 && length[w] > 0.0 && norm[w] > 0.0 && zeros[w] == 0.0 ? 1.0 : 0.0;
        norm[w] = sqrt(norm[w]);
    }
    for (ptrdiff_t j = 0; j < count; ++j)
        SIDE_BY_SIDE {
            const ptrdiff_t i = j * LANES + w;
            d[i] = turn[w] > 0.0 ? -turned[i] / norm[w] : d[i];
        }
}

/* The largest stable steps for the states that are added, in the lanes of a mask: no longer than those of the rod. */
static void stable_steps_of_states(struct many *m, const double *mask)
{
    double *const restrict at = m->trial, *const f = m->k[15], by[LANES], t[LANES];
    memcpy(at, m->y, (size_t)(m->all * LANES) * sizeof *at);
    SIDE_BY_SIDE
        t[w] = m->lane[w].is.t;
    for (ptrdiff_t j = 2 * m->half; j < m->states; ++j) {
        SIDE_BY_SIDE {
            by[w] = state_by(m->y[j * LANES + w]);
            at[j * LANES + w] += by[w];
        }
        rates(m, t, mask, at, f);
        SIDE_BY_SIDE {
            const ptrdiff_t i = j * LANES + w;
            double *const most = &m->lane[w].is.most;
            at[i] = m->y[i];
            *most = mask[w] > 0.0 ? fmin(*most, longest_of_state((f[i] - m->k[0][i]) / by[w])) : *most;
        }
    }
}

/* Look at the largest eigenvalue in all lanes in which it is time to. */
static void look(struct many *m)
{
    int most = 0;
    SIDE_BY_SIDE {
        struct lane *const lane = m->lane + w;
        lane->due = lane->phase == GOING && !lane->again ? looks_due(&lane->is) : 0;
        most = lane->due > most ? lane->due : most;
    }
    for (; most > 0; --most) {
        double mask[LANES];
        SIDE_BY_SIDE {
            mask[w] = m->lane[w].due > 0 ? 1.0 : 0.0;
            m->lane[w].due -= m->lane[w].due > 0;
        }
        stable_steps(m, mask);
        int last = 0;
        SIDE_BY_SIDE {
            mask[w] = mask[w] > 0.0 && m->lane[w].due == 0 ? 1.0 : 0.0;
            last |= mask[w] > 0.0;
            m->lane[w].is.looked = mask[w] > 0.0 ? 0 : m->lane[w].is.looked;
        }
        if (last)
            stable_steps_of_states(m, mask);
    }
}

/* Lengths and ends of the steps that are tried; the lanes that try one. */
static void choose(struct many *m, double *going, double *h, double *next)
{
    SIDE_BY_SIDE {
        struct lane *const lane = m->lane + w;
        rodgen_run *const is = &lane->is;
        lane->h = 0.0;
        lane->next = is->t;
        if (lane->phase == GOING && is->method == DOP853) {
            lane->h = step_to_try(is, &lane->cut);
            if (lane->h > 0.0)
                lane->next = later(is, lane->h, &lane->lag);
            else
                rodgen_finish(m, w, lane->again ? is->broken : TOO_SMALL);
        } else if (lane->phase == GOING) {
            lane->next = end_of_equal_step(is);
            lane->h = lane->next - is->t;
        }
        going[w] = lane->phase == GOING ? 1.0 : 0.0;
        h[w] = lane->h;
        next[w] = lane->next;
    }
}

/* Rates of the stages of steps of DOP853 from times and states of each, behind the first. */
static void stages(struct many *m, const double *mask, double *const *k, const double *y, const double *start,
                   const double *h)
{
    double t[LANES];
    for (int stage = 0; stage < STEPS; ++stage) {
        move(y, h, &dop853.stages[stage].sum, k, 0, m->all, m->trial);
        SIDE_BY_SIDE
            t[w] = start[w] + dop853.stages[stage].at * h[w];
        rates(m, t, mask, m->trial, k[stage + 1]);
    }
}

/* Rates of the stages that dense output needs beside them. */
static void more_stages(struct many *m, const double *mask, double *const *k, const double *y, const double *start,
                        const double *h)
{
    double t[LANES];
    for (int stage = 0; stage < MORE; ++stage) {
        move(y, h, &dop853.more[stage].sum, k, 0, m->all, m->trial);
        SIDE_BY_SIDE
            t[w] = start[w] + dop853.more[stage].at * h[w];
        rates(m, t, mask, m->trial, k[FIRST + stage]);
    }
}

/* Where the steps that are tried begin. */
static void starts(const struct many *m, double *start)
{
    SIDE_BY_SIDE
        start[w] = m->lane[w].is.t;
}

/* A step of DOP853 of every lane that goes, and which are kept. */
static void try_dop853(struct many *m, const double *going, const double *h, const double *next, double *kept)
{
    double start[LANES], zeros[LANES] = {0.0}, five[LANES] = {0.0}, three[LANES] = {0.0};
    starts(m, start);
    stages(m, going, m->k, m->y, start, h);
    move(m->y, h, &dop853.weights, m->k, 0, m->all, m->on);
    rates(m, next, going, m->on, m->k[AFTER]);
    add(&dop853.error5, m->k, m->states, m->trial);
    add_squares(m, m->trial, m->y, m->on, five);
    add(&dop853.error3, m->k, m->states, m->trial);
    add_squares(m, m->trial, m->y, m->on, three);
    add_zeros(m->on, m->all, zeros);
    add_zeros(m->k[AFTER], m->all, zeros);
    SIDE_BY_SIDE {
        struct lane *const lane = m->lane + w;
        kept[w] = 0.0;
        if (!(going[w] > 0.0))
            continue;
        const double error = error_of_both(five[w], three[w], h[w], (double)m->states);
        if (is_kept(&lane->is, h[w], error, zeros[w] == 0.0, (int)lane->again, lane->cut))
            kept[w] = 1.0;
        else
            lane->again = 1;
    }
}

/* A step of fixed length of every lane that goes. */
static void try_fixed(struct many *m, const double *going, const double *h, const double *next, double *kept)
{
    const struct tableau *const of = &fixed_tableaux[m->job->method];
    const ptrdiff_t own = of->follow ? m->half : 0;
    double t[LANES], zeros[LANES] = {0.0};
    for (int stage = 1; stage <= of->stages; ++stage) {
        double *const out = stage < of->stages ? m->trial : m->on;
        move(m->y, h, &of->sums[stage - 1], m->k, own, m->all, out);
        for (ptrdiff_t j = 0; j < own; ++j)
            SIDE_BY_SIDE
                out[j * LANES + w] = m->y[j * LANES + w] + h[w] * out[(m->half + j) * LANES + w];
        SIDE_BY_SIDE
            t[w] = stage < of->stages ? stage_time(of->at[stage], m->lane[w].is.t, next[w], h[w]) : next[w];
        rates(m, t, going, out, m->k[stage < of->stages ? stage : AFTER]);
    }
    add_zeros(m->on, m->all, zeros);
    add_zeros(m->k[AFTER], m->all, zeros);
    SIDE_BY_SIDE {
        kept[w] = going[w] > 0.0 && zeros[w] == 0.0 ? 1.0 : 0.0;
        if (going[w] > kept[w])
            rodgen_finish(m, w, NOT_FINITE);
    }
}

void rodgen_prepare_dense(struct many *m, const double *mask, const double *h)
{
    double start[LANES], last[LANES] = {0.0};
    starts(m, start);
    more_stages(m, mask, m->k, m->y, start, h);
    for (int sum = 0; sum < 4; ++sum)
        add(&dop853.dense[sum], m->k, m->all, m->k[SUMS + sum]);
    add_squares(m, m->k[SUMS + 3], m->y, m->on, last);
    SIDE_BY_SIDE {
        m->lane[w].is.dense = parts_of(last[w], h[w], (double)m->states);
        m->lane[w].is.part = 0;
    }
}

/* Step from part to part of the steps that are kept, of lengths h, as far as those of the lanes of a mask that are
   counted from 1: explicit.c has the same for one rod. */
static void reach(struct many *m, const double *mask, const double *h, const int *part)
{
    double *k[ROWS], *const y = m->k[PART], *const on = m->k[PART + 1];
    memcpy(k, m->k, sizeof k);
    k[0] = m->k[PART_RATES];
    k[AFTER] = m->k[PART_RATES + 1];
    for (;;) {
        double going[LANES], first[LANES], later_on[LANES], last[LANES], length[LANES], start[LANES], end[LANES];
        int any = 0, reached = 0;
        SIDE_BY_SIDE {
            rodgen_run *const is = &m->lane[w].is;
            if (mask[w] > 0.0 && is->part > part[w])
                is->part = 0;
            going[w] = mask[w] > 0.0 && is->part < part[w] ? 1.0 : 0.0;
            first[w] = is->part == 0 ? going[w] : 0.0;
            later_on[w] = going[w] - first[w];
            last[w] = is->part + 1 == part[w] ? going[w] : 0.0;
            length[w] = going[w] > 0.0 ? h[w] : 0.0;
            start[w] = is->t + (double)is->part * length[w];
            end[w] = start[w] + length[w];
            is->part += going[w] > 0.0;
            any |= going[w] > 0.0;
            reached |= last[w] > 0.0;
        }
        if (!any)
            return;
        blend(first, m->y, m->all, y);
        blend(first, m->k[0], m->all, k[0]);
        blend(later_on, on, m->all, y);
        blend(later_on, k[AFTER], m->all, k[0]);
        stages(m, going, k, y, start, length);
        move(y, length, &dop853.weights, k, 0, m->all, m->trial);
        blend(going, m->trial, m->all, on);
        rates(m, end, going, on, m->trial);
        blend(going, m->trial, m->all, k[AFTER]);
        if (!reached)
            continue;
        more_stages(m, last, k, y, start, length);
        for (int sum = 0; sum < 4; ++sum) {
            add(&dop853.dense[sum], k, m->all, m->trial);
            blend(last, m->trial, m->all, m->k[PART_SUMS + sum]);
        }
    }
}

/* States at shares x of steps of lengths h from y to on with their rates, by the sums of their dense output. */
static void between(const struct many *m, const double *y, const double *on, const double *f, const double *after,
                    double *const *sums, const double *h, const double *x, double *restrict out)
{
    if (m->job->method != DOP853) {
        for (ptrdiff_t j = 0; j < m->all; ++j)
            SIDE_BY_SIDE {
                const ptrdiff_t i = j * LANES + w;
                out[i] = hermite(y[i], on[i], f[i], after[i], h[w], x[w]);
            }
        return;
    }
    for (ptrdiff_t j = 0; j < m->all; ++j)
        SIDE_BY_SIDE {
            const ptrdiff_t i = j * LANES + w;
            const double inner = dop853_inner(sums[0][i], sums[1][i], sums[2][i], sums[3][i], h[w], x[w]);
            out[i] = dop853_between(y[i], on[i], f[i], after[i], h[w], x[w], inner);
        }
}

void rodgen_between(struct many *m, const double *mask, const double *h, const double *next, const double *t, double *out)
{
    double *const *const k = m->k;
    double ends[LANES], x[LANES], parted[LANES], length[LANES], inside_part[LANES];
    int part[LANES], dense = 0, parts = 0;
    SIDE_BY_SIDE {
        const rodgen_run *const is = &m->lane[w].is;
        const int inner = mask[w] > 0.0 && t[w] < next[w];
        const int many = m->job->method == DOP853 && inner ? (int)is->dense : 1;
        ends[w] = inner ? 0.0 : 1.0;
        x[w] = inner ? ((t[w] - is->t) - is->lag) / h[w] : 1.0;
        const int within = (int)(x[w] * many);
        part[w] = within < many ? within : many - 1;
        parted[w] = many > 1 ? 1.0 : 0.0;
        length[w] = h[w] / many;
        inside_part[w] = x[w] * many - part[w];
        ++part[w];
        dense |= inner;
        parts |= many > 1;
    }
    if (dense)
        between(m, m->y, m->on, k[0], k[AFTER], k + SUMS, h, x, out);
    if (parts) {
        reach(m, parted, length, part);
        between(m, k[PART], k[PART + 1], k[PART_RATES], k[PART_RATES + 1], k + PART_SUMS, length, inside_part, m->trial);
        blend(parted, m->trial, m->all, out);
    }
    blend(ends, m->on, m->all, out);
    SIDE_BY_SIDE
        out[(m->all - 1) * LANES + w] += ends[w] * m->come[w];
}

/* The work, until now, of masses that jump where the stretches of steps that are kept end. */
static void have_come(struct many *m, const double *kept, const double *next)
{
    double high[LANES];
    int any = 0;
    SIDE_BY_SIDE {
        any |= kept[w] > 0.0 && next[w] == m->lane[w].is.end;
        high[w] = m->lane[w].is.high;
        m->come[w] = 0.0;
    }
    if (!any || !m->job->energies)
        return;
    rodgen_masses_gain(m, m->on, high, next, m->come);
    SIDE_BY_SIDE
        m->come[w] = kept[w] > 0.0 && next[w] == m->lane[w].is.end ? m->come[w] : 0.0;
}

void rodgen_lanes_step(struct many *m, double *kept)
{
    const int dop853_too = m->job->method == DOP853;
    double going[LANES], h[LANES], next[LANES];
    if (dop853_too)
        look(m);
    choose(m, going, h, next);
    (dop853_too ? try_dop853 : try_fixed)(m, going, h, next, kept);
    have_come(m, kept, next);
    rodgen_inside_steps(m, kept, next);
    blend(kept, m->on, m->all, m->y);
    SIDE_BY_SIDE
        m->y[(m->all - 1) * LANES + w] += m->come[w];
    blend(kept, m->k[AFTER], m->all, m->k[0]);
    SIDE_BY_SIDE {
        struct lane *const lane = m->lane + w;
        if (!(kept[w] > 0.0))
            continue;
        arrive(&lane->is, next[w], lane->lag);
        ++lane->is.taken;
        ++lane->is.steps;
        lane->again = 0;
    }
}
