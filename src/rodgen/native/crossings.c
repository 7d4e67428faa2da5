/* Crossings of levels by numbers of rods side by side: detected at points within their steps, then located along the
   dense output. EventDetector in integrate/events.py tells what counts as a crossing. */

#include "many.h"

/* A step is looked at in so many parts; a rod whose number passes the level in each of them has as many brackets. */
enum { PARTS = WATCHED - 1, LOCATED = 128 };
/* Where the dense output is looked at before a root is sought: at all shares that are one of up to eight parts. */
static const double along[] = {0.0,       1.0 / 8.0, 1.0 / 7.0, 1.0 / 6.0, 1.0 / 5.0, 1.0 / 4.0, 2.0 / 7.0, 1.0 / 3.0,
                               3.0 / 8.0, 2.0 / 5.0, 3.0 / 7.0, 1.0 / 2.0, 4.0 / 7.0, 3.0 / 5.0, 5.0 / 8.0, 2.0 / 3.0,
                               5.0 / 7.0, 3.0 / 4.0, 4.0 / 5.0, 5.0 / 6.0, 6.0 / 7.0, 7.0 / 8.0, 1.0};
enum { LAST = sizeof along / sizeof *along - 1 };

/* Where a number has been in a step, less its level: a row for every point. */
static double *row_of(const struct many *m, size_t watched, int point)
{
    return m->levels + (watched * WATCHED + (size_t)point) * LANES;
}

static double value_of(const struct many *m, const struct rodgen_watched *of, const double *states, int w)
{
    return rodgen_value(m, of->first, of->terms, states, w);
}

static double sign(double v)
{
    return v > 0.0 ? 1.0 : v < 0.0 ? -1.0 : v;
}

/* Whether a number that was on one side has reached the level, or passed it. */
static int passes(const struct rodgen_watched *of, double before, double after)
{
    return (before < 0.0 && after >= 0.0 && of->rising) || (before > 0.0 && after <= 0.0 && of->falling);
}

/* Of a number that is infinite nothing is known. */
static double known(double v)
{
    return 0.0 * v == 0.0 ? v : NAN;
}

/* States at the share x of the steps that are tried, by the cubic through both ends with their rates: constant ones
   to the last bit. */
static double cubic(double y, double on, double f_before, double f, double h, double x)
{
    const double rest = 1.0 - x;
    return y + (x * x * (3.0 - 2.0 * x) * (on - y) + x * rest * rest * (h * f_before) - x * x * rest * (h * f));
}

static void cubics(const struct many *m, const double *h, double x, double *restrict out)
{
    for (ptrdiff_t j = 0; j < m->all; ++j)
        SIDE_BY_SIDE {
            const ptrdiff_t i = j * LANES + w;
            out[i] = cubic(m->y[i], m->on[i], m->k[0][i], m->k[AFTER][i], h[w], x);
        }
}

void rodgen_watch_start(struct many *m, const double *mask, const double *t, const double *states)
{
    if (m->job->looks)
        rodgen_observe(m, t, states);
    for (size_t at = 0; at < m->job->watched; ++at) {
        const struct rodgen_watched *const of = m->job->watch + at;
        double *const last = row_of(m, at, PARTS);
        SIDE_BY_SIDE
            last[w] = mask[w] > 0.0 ? known(value_of(m, of, states, w) - of->level) : last[w];
    }
}

int rodgen_watch(struct many *m, const double *kept, const double *h, const double *next, double *crossed)
{
    int any = 0;
    for (int point = 1; point <= PARTS; ++point) {
        const double x = (double)point / PARTS;
        const double *const states = point < PARTS ? m->sample : m->on;
        if (m->job->looks) {
            double t[LANES];
            SIDE_BY_SIDE
                t[w] = point < PARTS ? m->lane[w].is.t + x * (next[w] - m->lane[w].is.t) : next[w];
            if (point < PARTS)
                cubics(m, h, x, m->sample);
            rodgen_observe(m, t, states);
        }
        for (size_t at = 0; at < m->job->watched; ++at) {
            const struct rodgen_watched *const of = m->job->watch + at;
            const double *const first = row_of(m, at, PARTS);
            double *const here = row_of(m, at, point == PARTS ? 0 : point);
            SIDE_BY_SIDE {
                double value = 0.0;
                if (of->looks || point == PARTS)
                    value = value_of(m, of, states, w);
                else
                    value = cubic(value_of(m, of, m->y, w), value_of(m, of, m->on, w), value_of(m, of, m->k[0], w),
                                  value_of(m, of, m->k[AFTER], w), h[w], x);
                value = known(value - of->level);
                here[w] = point < PARTS && value != value ? first[w] : value;
            }
        }
    }
    /* What was last is first now. */
    SIDE_BY_SIDE
        crossed[w] = 0.0;
    for (size_t at = 0; at < m->job->watched; ++at) {
        double *const begin = row_of(m, at, 0), *const end = row_of(m, at, PARTS);
        SIDE_BY_SIDE {
            const double before = end[w];
            end[w] = kept[w] > 0.0 ? begin[w] : before;
            begin[w] = before;
            for (int point = 0; kept[w] > 0.0 && point < PARTS; ++point)
                if (passes(m->job->watch + at, row_of(m, at, point)[w], row_of(m, at, point + 1)[w]))
                    crossed[w] = 1.0;
            any |= crossed[w] > 0.0;
        }
    }
    return any;
}

/* Ends of the shares of a step that belong to one crossing each, in parts of it; how many crossings there are. */
static int brackets(const struct many *m, size_t watched, int w, int *cuts)
{
    int count = 0, before = 0;
    for (int point = 0; point < PARTS; ++point) {
        if (!passes(m->job->watch + watched, row_of(m, watched, point)[w], row_of(m, watched, point + 1)[w]))
            continue;
        /* A step that starts on the level starts with what is no crossing. */
        cuts[count] = count ? (before + 2 + point) / 2 : row_of(m, watched, 0)[w] == 0.0 ? point : 0;
        before = point;
        ++count;
    }
    cuts[count] = PARTS;
    return count;
}

/* A time in the steps that are kept, and what of it the number is off its level, in the lanes of a mask. */
static void differences(struct many *m, const struct rodgen_watched *of, const double *mask, const double *h,
                        const double *next, const double *t, double *g)
{
    rodgen_between(m, mask, h, next, t, m->sample);
    if (of->looks)
        rodgen_observe(m, t, m->sample);
    SIDE_BY_SIDE
        g[w] = mask[w] > 0.0 ? value_of(m, of, m->sample, w) - of->level : NAN;
}

/* The first crossing between two times, in the lanes of a mask; where there is none, not-a-number. The time is one at
   which the level is reached or passed: by T. R. Chandrupatla, Adv. Eng. Softw. 28 (1997) 145. */
static void locate(struct many *m, const struct rodgen_watched *of, const double *mask, const double *low,
                   const double *high, const double *h, const double *next, double *root)
{
    double t[LANES], g[LANES], a[LANES], b[LANES], c[LANES], fa[LANES], fb[LANES], fc[LANES], share[LANES];
    double first[LANES], most[LANES] = {0.0}, going[LANES], before[LANES], least[LANES];
    int any = 0, looking = 1;
    SIDE_BY_SIDE {
        root[w] = NAN;
        going[w] = 0.0;
        b[w] = low[w];
        fb[w] = NAN;
        before[w] = 0.0;
        least[w] = fabs(low[w]) > fabs(high[w]) ? fabs(low[w]) : fabs(high[w]);
        least[w] *= 2.0 * 2.220446049250313e-16; /* of a time: some roundings */
    }
    for (int point = 0; point <= LAST && looking; ++point) {
        looking = 0;
        SIDE_BY_SIDE
            t[w] = point == LAST ? high[w] : low[w] + (high[w] - low[w]) * along[point];
        differences(m, of, mask, h, next, t, g);
        SIDE_BY_SIDE {
            if (!(mask[w] > 0.0) || going[w] > 0.0)
                continue;
            first[w] = point ? first[w] : g[w];
            most[w] = fabs(g[w]) > most[w] ? fabs(g[w]) : most[w];
            a[w] = b[w];
            fa[w] = fb[w];
            b[w] = t[w];
            fb[w] = g[w];
            if (point && ((fa[w] < 0.0 && of->rising) || (fa[w] > 0.0 && of->falling)) && sign(fa[w]) * sign(g[w]) <= 0.0) {
                going[w] = 1.0;
                before[w] = sign(fa[w]);
                share[w] = 0.5;
            }
            looking |= !(going[w] > 0.0);
        }
    }
    SIDE_BY_SIDE {
        any |= going[w] > 0.0;
        if (!(mask[w] > 0.0) || going[w] > 0.0)
            continue;
        /* An end that is on the level but for rounding, on the wrong side of it. */
        const double near = 1e-12 * most[w];
        if (fabs(first[w]) <= near && ((fb[w] > 0.0 && of->rising) || (fb[w] < 0.0 && of->falling)))
            root[w] = low[w];
        else if (fabs(fb[w]) <= near && ((first[w] < 0.0 && of->rising) || (first[w] > 0.0 && of->falling)))
            root[w] = high[w];
    }
    for (int round = 0; any && round < LOCATED; ++round) {
        any = 0;
        SIDE_BY_SIDE
            t[w] = going[w] > 0.0 ? a[w] + share[w] * (b[w] - a[w]) : low[w];
        differences(m, of, going, h, next, t, g);
        SIDE_BY_SIDE {
            if (!(going[w] > 0.0))
                continue;
            const int same = sign(g[w]) == sign(fa[w]);
            c[w] = same ? a[w] : b[w];
            fc[w] = same ? fa[w] : fb[w];
            b[w] = same ? b[w] : a[w];
            fb[w] = same ? fb[w] : fa[w];
            a[w] = t[w];
            fa[w] = g[w];
            const double end = least[w] / fabs(b[w] - a[w]);
            if (fa[w] == 0.0 || fb[w] == 0.0 || !(end < 0.5) || round == LOCATED - 1) {
                root[w] = sign(fa[w]) == before[w] ? b[w] : a[w];
                going[w] = 0.0;
                continue;
            }
            const double xi = (a[w] - b[w]) / (c[w] - b[w]), phi = (fa[w] - fb[w]) / (fc[w] - fb[w]);
            double x = 0.5;
            if (square(phi) < xi && square(1.0 - phi) < 1.0 - xi)
                x = fa[w] / (fb[w] - fa[w]) * (fc[w] / (fb[w] - fc[w]))
                    + (c[w] - a[w]) / (b[w] - a[w]) * (fa[w] / (fc[w] - fa[w])) * (fb[w] / (fc[w] - fb[w]));
            share[w] = x < end ? end : x > 1.0 - end ? 1.0 - end : x;
            any = 1;
        }
    }
}

/* Write a crossing of a lane: its time, and numbers of the states there. */
static void write_crossing(const struct many *m, const struct rodgen_watched *of, int w, double t, const double *states)
{
    double *const to = m->job->crossed + m->lane[w].rod * m->job->crossed_width + of->place;
    const double count = to[0];
    to[0] = count + 1.0;
    if (!(count < (double)of->most))
        return;
    double *out = to + 1 + (size_t)count * (1 + of->numbers);
    *out++ = t;
    for (size_t at = 0; at < of->numbers; ++at) {
        const struct rodgen_number *const number = m->job->numbers + of->first_number + at;
        out[at] = rodgen_value(m, number->first, number->terms, states, w);
    }
}

/* The crossings of one number in the steps that are kept, of lanes that have some, up to a time; of one that stops a
   run, the first of them is that time. */
static void cross(struct many *m, size_t watched, const double *crossed, const double *h, const double *next, double *until)
{
    const struct rodgen_watched *const of = m->job->watch + watched;
    int cuts[LANES][PARTS + 1], count[LANES], most = 0;
    SIDE_BY_SIDE {
        count[w] = crossed[w] > 0.0 ? brackets(m, watched, w, cuts[w]) : 0;
        most = count[w] > most ? count[w] : most;
    }
    for (int at = 0; at < most; ++at) {
        double mask[LANES], low[LANES], high[LANES], root[LANES];
        int any = 0;
        SIDE_BY_SIDE {
            const double t = m->lane[w].is.t, part = (next[w] - t) / PARTS;
            const int there = at < count[w];
            low[w] = there ? t + part * cuts[w][at] : t;
            high[w] = !there ? t : cuts[w][at + 1] == PARTS ? next[w] : t + part * cuts[w][at + 1];
            mask[w] = there && high[w] >= of->from && low[w] <= of->to && low[w] <= until[w] ? 1.0 : 0.0;
            any |= mask[w] > 0.0;
        }
        if (!any)
            continue;
        locate(m, of, mask, low, high, h, next, root);
        any = 0;
        SIDE_BY_SIDE {
            if (!(mask[w] > 0.0 && root[w] >= of->from && root[w] <= of->to && root[w] <= until[w]))
                mask[w] = 0.0;
            if (mask[w] > 0.0 && of->stops) {
                m->lane[w].stopped = m->lane[w].stopped && root[w] == until[w] ? m->lane[w].stopped : of->stops;
                until[w] = root[w];
            }
            any |= mask[w] > 0.0 && !of->stops;
        }
        if (!any)
            continue;
        rodgen_between(m, mask, h, next, root, m->sample);
        if (m->job->observes)
            rodgen_observe(m, root, m->sample);
        SIDE_BY_SIDE
            if (mask[w] > 0.0)
                write_crossing(m, of, w, root[w], m->sample);
    }
}

void rodgen_cross(struct many *m, const double *crossed, const double *h, const double *next, double *until)
{
    for (int stops = 1; stops >= 0; --stops)
        for (size_t at = 0; at < m->job->watched; ++at)
            if (!m->job->watch[at].stops == !stops)
                cross(m, at, crossed, h, next, until);
}
