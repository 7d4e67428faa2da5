/* Steps of rods side by side, by explicit methods. No mechanics. */

#include "lane_moves.h"

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

/* The largest stable steps for the states that are added, in the lanes of a mask: no longer than those of the rod. A law
   that switches is not run in lanes, so that one side is as good as the other. */
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

/* A step of DOP853 of every lane that goes, and which are kept. */
static void try_dop853(struct many *m, const double *going, const double *h, const double *next, double *kept)
{
    double start[LANES], zeros[LANES] = {0.0}, five[LANES] = {0.0}, three[LANES] = {0.0};
    starts(m, start);
    stages(m, going, m->k, m->y, start, h, dop853.stages, STEPS, 1);
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
