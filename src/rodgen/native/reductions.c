/* Reductions of the samples of rods side by side. */

#include "many.h"

double rodgen_value(const struct many *m, size_t first, size_t terms, const double *states, int w)
{
    double value = 0.0;
    for (size_t at = first; at < first + terms; ++at) {
        const ptrdiff_t row = (ptrdiff_t)m->job->rows[at];
        const double *const from = row < m->all ? states + row * LANES : m->observed + (row - m->all) * LANES;
        value += m->job->weights[at] * from[w];
    }
    return value;
}

/* The value of a reduction's number in a lane. */
static double value_of(const struct many *m, const struct rodgen_kept *kept, const double *states, int w)
{
    return rodgen_value(m, kept->first, kept->terms, states, w);
}

void rodgen_observe(struct many *m, const double *t, const double *states)
{
    m->of->observe(t, states, m->p, m->q, m->observed, m->work);
}

void rodgen_masses_gain(struct many *m, const double *states, const double *before, const double *after, double *gain)
{
    const double *const times[2] = {before, after};
    SIDE_BY_SIDE
        gain[w] = 0.0;
    for (int of = 0; of < 2; ++of) {
        rodgen_observe(m, times[of], states);
        for (size_t at = 0; at < m->job->energies; ++at)
            SIDE_BY_SIDE
                gain[w] += (of ? 1.0 : -1.0) * m->observed[at * LANES + (size_t)w];
    }
    SIDE_BY_SIDE
        gain[w] = 0.0 * gain[w] == 0.0 ? gain[w] : 0.0;
}

/* Take a number into a reduction; what is not a number stays. */
static void take(long long reduction, struct tally *tally, int w, double t, double value)
{
    const double count = tally->count[w] += 1.0, before = tally->a[w];
    switch (reduction) {
    case RODGEN_KEEP_LAST:
        tally->a[w] = value;
        break;
    case RODGEN_KEEP_MIN:
        tally->a[w] = count == 1.0 || value < before || value != value ? value : before;
        break;
    case RODGEN_KEEP_MAX:
    case RODGEN_KEEP_TIME_OF_MAX:
        if (count == 1.0 || value > before || (value != value && before == before)) {
            tally->a[w] = value;
            tally->b[w] = t;
        }
        break;
    case RODGEN_KEEP_MEAN:
        tally->a[w] = before + value;
        break;
    case RODGEN_KEEP_RMS:
        tally->a[w] = before + square(value);
        break;
    case RODGEN_KEEP_STD: /* B. P. Welford 1962 */
        tally->a[w] = before + (value - before) / count;
        tally->b[w] += (value - before) * (value - tally->a[w]);
        break;
    }
}

static double result(long long reduction, const struct tally *tally, int w)
{
    const double count = tally->count[w], a = tally->a[w];
    if (!(count > 0.0))
        return NAN;
    switch (reduction) {
    case RODGEN_KEEP_MEAN:
        return a / count;
    case RODGEN_KEEP_RMS:
        return sqrt(a / count);
    case RODGEN_KEEP_STD:
        return sqrt(tally->b[w] / count);
    case RODGEN_KEEP_TIME_OF_MAX:
        return tally->b[w];
    default:
        return a;
    }
}

void rodgen_take_samples(struct many *m, const double *mask, const double *t, const double *states)
{
    if (m->job->observes)
        rodgen_observe(m, t, states);
    SIDE_BY_SIDE {
        if (!(mask[w] > 0.0))
            continue;
        const size_t sample = m->lane[w].sampled++;
        for (size_t at = 0; at < m->job->traced; ++at) {
            const struct rodgen_number *const number = m->job->trace + at;
            const size_t row = m->lane[w].rod * m->job->traced + at;
            m->job->traces[row * (m->job->samples + 1) + sample]
                = rodgen_value(m, number->first, number->terms, states, w);
        }
        for (size_t at = 0; at < m->job->kept; ++at) {
            const struct rodgen_kept *const kept = m->job->keep + at;
            struct tally *const tally = m->tally + at;
            if (t[w] >= kept->from && t[w] <= kept->to)
                take(kept->reduction, tally, w, t[w], value_of(m, kept, states, w) - tally->start[w]);
        }
    }
}

void rodgen_note_start(struct many *m, const double *mask, const double *t, const double *states)
{
    if (m->job->observes)
        rodgen_observe(m, t, states);
    for (size_t at = 0; at < m->job->kept; ++at)
        SIDE_BY_SIDE
            if (mask[w] > 0.0)
                m->tally[at].start[w] = m->job->keep[at].less_start ? value_of(m, m->job->keep + at, states, w) : 0.0;
}

void rodgen_write_results(const struct many *m, int w, int whole)
{
    double *const values = m->job->values + m->lane[w].rod * m->job->kept;
    for (size_t at = 0; at < m->job->kept; ++at)
        values[at] = whole ? result(m->job->keep[at].reduction, m->tally + at, w) : NAN;
}
