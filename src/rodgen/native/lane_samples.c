/* Samples, crossings of watched numbers and ends of runs within the steps of rods side by side. */

#include "many.h"

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
        rodgen_prepare_dense(m, inner, h);
    if (crossing)
        rodgen_cross(m, crossed, h, next, until);
    samples(m, kept, h, next, until);
    if (crossing)
        stop(m, h, next, until);
}
