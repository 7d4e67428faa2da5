/* What lies within steps of rods side by side, by explicit methods: states, samples, crossings of watched numbers and
   ends of runs. No mechanics. */

#include "lane_moves.h"

/* Sums of DOP853's dense output in the steps of lengths h, for the lanes of a mask that have asked for it. */
static void prepare_dense(struct many *m, const double *mask, const double *h)
{
    double start[LANES], last[LANES] = {0.0};
    starts(m, start);
    stages(m, mask, m->k, m->y, start, h, dop853.more, MORE, AFTER + 1);
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
        stages(m, going, k, y, start, length, dop853.stages, STEPS, 1);
        move(y, length, &dop853.weights, k, 0, m->all, m->trial);
        blend(going, m->trial, m->all, on);
        rates(m, end, going, on, m->trial);
        blend(going, m->trial, m->all, k[AFTER]);
        if (!reached)
            continue;
        stages(m, last, k, y, start, length, dop853.more, MORE, AFTER + 1);
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

/* Samples that lie in the steps that are kept: in which lanes there is one up to some times. */
static int samples_due(const struct many *m, const double *kept, const double *until, double *due)
{
    int any = 0;
    SIDE_BY_SIDE {
        due[w] = kept[w] > 0.0 && next_sample(m, m->lane + w) <= until[w] ? 1.0 : 0.0;
        any |= due[w] > 0.0;
    }
    return any;
}

/* All samples in the steps that are kept, up to some times. */
static void samples(struct many *m, const double *kept, const double *h, const double *next, const double *until)
{
    double due[LANES], t[LANES];
    while (samples_due(m, kept, until, due)) {
        SIDE_BY_SIDE
            t[w] = due[w] > 0.0 ? next_sample(m, m->lane + w) : next[w];
        rodgen_between(m, due, h, next, t, m->sample);
        rodgen_take_samples(m, due, t, m->sample);
    }
}

/* Steps that are kept end where a run is stopped, with a sample. */
static void stop(struct many *m, const double *h, double *next, const double *until)
{
    double stopped[LANES], due[LANES];
    int any = 0;
    SIDE_BY_SIDE {
        const struct lane *const lane = m->lane + w;
        stopped[w] = lane->stopped ? 1.0 : 0.0;
        due[w] = lane->stopped && !(lane->sampled > 0 && m->job->times[lane->sampled - 1] == until[w]) ? 1.0 : 0.0;
        any |= lane->stopped != 0;
    }
    if (!any)
        return;
    rodgen_between(m, stopped, h, next, until, m->sample);
    rodgen_take_samples(m, due, until, m->sample);
    blend(stopped, m->sample, m->all, m->on);
    SIDE_BY_SIDE {
        m->come[w] = stopped[w] > 0.0 ? 0.0 : m->come[w];
        next[w] = until[w];
    }
}

void rodgen_inside_steps(struct many *m, const double *kept, double *next)
{
    double h[LANES], until[LANES], inner[LANES], crossed[LANES] = {0.0};
    int dense = 0;
    SIDE_BY_SIDE {
        const struct lane *const lane = m->lane + w;
        const double lag = m->job->method == DOP853 ? lane->lag - lane->is.lag : 0.0;
        h[w] = kept[w] > 0.0 ? (next[w] - lane->is.t) + lag : 0.0;
        until[w] = next[w];
    }
    const int crossing = m->job->watched > 0 && rodgen_watch(m, kept, h, next, crossed);
    SIDE_BY_SIDE {
        const int sampled = kept[w] > 0.0 && next_sample(m, m->lane + w) < next[w];
        inner[w] = sampled || crossed[w] > 0.0 ? 1.0 : 0.0;
        dense |= inner[w] > 0.0;
    }
    if (dense && m->job->method == DOP853)
        prepare_dense(m, inner, h);
    if (crossing)
        rodgen_cross(m, crossed, h, next, until);
    samples(m, kept, h, next, until);
    if (crossing)
        stop(m, h, next, until);
}
