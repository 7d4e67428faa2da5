/* Runs of many rods side by side: a rod that has ended makes room for the next. No mechanics. */

#include "control.h"
#include "many.h"

/* A memory that parts are taken from; of none, only its size is known. */
struct store {
    char *memory;
    size_t size;
};

static void *part(struct store *store, size_t bytes)
{
    const size_t at = store->size;
    store->size += lined(bytes);
    return store->memory ? store->memory + at : NULL;
}

/* The parts of a memory, and how large it is. */
static size_t parts(struct many *m, const struct rodgen_lanes *system, struct rodgen_many *job, void *memory)
{
    const size_t lanes = LANES * sizeof(double), all = system->states + system->works;
    struct store store = {.memory = memory};
    m->of = system;
    m->job = job;
    m->states = (ptrdiff_t)system->states;
    m->half = (ptrdiff_t)((system->states - system->added) / 2);
    m->all = (ptrdiff_t)all;
    m->base = (ptrdiff_t)system->base;
    m->block = part(&store, sizeof *m->block);
    m->lane = m->block ? m->block->lane : NULL;
    m->y = part(&store, all * lanes);
    m->on = part(&store, all * lanes);
    m->trial = part(&store, all * lanes);
    m->sample = part(&store, all * lanes);
    for (int row = 0; row < ROWS; ++row)
        m->k[row] = part(&store, all * lanes);
    m->direction = part(&store, (size_t)m->half * lanes);
    m->observed = part(&store, system->observed * lanes);
    m->come = part(&store, lanes);
    m->p = part(&store, system->parameters * lanes);
    m->q = part(&store, system->parameters * lanes);
    m->tally = part(&store, job->kept * sizeof *m->tally);
    m->levels = part(&store, job->watched * WATCHED * lanes);
    m->work = part(&store, system->work_size);
    return store.size;
}

void rodgen_finish(struct many *m, int w, long long status)
{
    struct lane *const lane = m->lane + w;
    struct rodgen_many *const job = m->job;
    for (ptrdiff_t j = 0; j < m->all; ++j)
        job->state[lane->rod * (size_t)m->all + (size_t)j] = m->y[j * LANES + w];
    rodgen_write_results(m, w, status == REACHED || status == RODGEN_STOPPED);
    const struct rodgen_outcome outcome
        = {lane->is.t, status, lane->is.steps, lane->is.rejected, lane->is.rhs, lane->stopped};
    job->outcome[lane->rod] = outcome;
    lane->phase = EMPTY;
}

/* Give rods that wait to empty lanes; whether lanes are empty and there will be more rods. */
static int fill(struct many *m)
{
    struct rodgen_many *const job = m->job;
    SIDE_BY_SIDE {
        struct lane *const lane = m->lane + w;
        if (lane->phase != EMPTY)
            continue;
        if (job->next == job->end) {
            if (job->more)
                return 1;
            continue;
        }
        const size_t rod = job->next++;
        const double *const p = job->p + rod * job->p_stride, *const y = job->y + rod * job->y_stride;
        const ptrdiff_t parameters = (ptrdiff_t)m->of->parameters;
        memset(lane, 0, sizeof *lane);
        lane->phase = FRESH;
        lane->rod = rod;
        lane->is.method = job->method;
        lane->is.t = job->start;
        lane->is.step = job->step;
        lane->is.rtol = job->rtol;
        lane->is.atol = job->atol;
        for (ptrdiff_t j = 0; j < parameters; ++j)
            m->p[w * parameters + j] = m->q[j * LANES + w] = p[j];
        for (ptrdiff_t j = 0; j < m->all; ++j)
            m->y[j * LANES + w] = j < m->states ? y[j] : 0.0;
        for (size_t at = 0; at < job->kept; ++at)
            m->tally[at].count[w] = m->tally[at].a[w] = m->tally[at].b[w] = m->tally[at].start[w] = 0.0;
    }
    return 0;
}

static const struct rodgen_course *course_of(const struct many *m, const struct lane *lane)
{
    return m->job->courses + (m->job->course_of ? m->job->course_of[lane->rod] : 0);
}

/* The stretch that a lane is to begin. */
static void set_stretch(struct many *m, int w)
{
    struct lane *const lane = m->lane + w;
    rodgen_run *const is = &lane->is;
    const struct rodgen_course *const course = course_of(m, lane);
    const struct rodgen_stretch *const stretch = m->job->stretches + course->first + lane->stretch;
    is->start = is->before = is->t;
    is->end = stretch->end;
    is->low = stretch->low;
    is->high = stretch->high;
    is->longest = course->longest > 0.0 ? course->longest : INFINITY;
    is->lag = is->lag_before = 0.0;
    is->taken = is->dense = is->broken = 0;
    is->looked = -1;
    lane->again = 0;
    lane->seen = is->t;
    lane->creep = m->job->creep * (is->end - is->t);
    lane->look_at = (size_t)(is->steps + m->job->stride);
    for (ptrdiff_t j = 0; j < m->half; ++j)
        m->direction[j * LANES + w] = j < m->base ? 0.0 : j % 2 ? -1.0 : 1.0;
}

/* The work of masses that jump where the stretches of a mask begin. */
static void have_come(struct many *m, const double *mask, const double *t)
{
    double low[LANES], *const work = m->y + (m->all - 1) * LANES;
    if (!m->job->energies)
        return;
    SIDE_BY_SIDE
        low[w] = m->lane[w].is.low;
    rodgen_masses_gain(m, m->y, t, low, m->come);
    SIDE_BY_SIDE
        work[w] += mask[w] > 0.0 ? m->come[w] : 0.0;
}

/* Begin all stretches that wait for it. */
static void begin(struct many *m)
{
    double mask[LANES], fresh[LANES], t[LANES], zeros[LANES] = {0.0}, *const f = m->k[1];
    int any = 0;
    SIDE_BY_SIDE {
        struct lane *const lane = m->lane + w;
        mask[w] = lane->phase == FRESH || lane->phase == BEFORE ? 1.0 : 0.0;
        fresh[w] = lane->phase == FRESH ? 1.0 : 0.0;
        any |= lane->phase == FRESH;
        if (mask[w] > 0.0)
            set_stretch(m, w);
        t[w] = lane->is.t;
    }
    rates(m, t, mask, m->y, f);
    blend(mask, f, m->all, m->k[0]);
    add_zeros(m->y, m->all, zeros);
    add_zeros(m->k[0], m->all, zeros);
    if (any) {
        double due[LANES];
        rodgen_note_start(m, fresh, t, m->y);
        rodgen_watch_start(m, fresh, t, m->y);
        SIDE_BY_SIDE
            due[w] = fresh[w] > 0.0 && next_sample(m, m->lane + w) <= t[w] ? 1.0 : 0.0;
        rodgen_take_samples(m, due, t, m->y);
    }
    have_come(m, mask, t);
    SIDE_BY_SIDE {
        if (!(mask[w] > 0.0))
            continue;
        m->lane[w].phase = GOING;
        if (zeros[w] != 0.0) {
            rodgen_finish(m, w, NOT_FINITE);
            mask[w] = 0.0;
        }
    }
    if (m->job->method == DOP853)
        rodgen_first_steps(m, mask);
}

/* A lane at the end of a step: it goes on, begins another stretch, or has ended. */
static void settle(struct many *m, int w)
{
    struct lane *const lane = m->lane + w;
    rodgen_run *const is = &lane->is;
    const struct rodgen_course *const course = course_of(m, lane);
    if (lane->stopped) {
        rodgen_finish(m, w, RODGEN_STOPPED);
        return;
    }
    if (is->t >= is->end) {
        lane->phase = BEFORE;
        if (++lane->stretch == course->count) {
            rodgen_finish(m, w, course->pole ? RODGEN_POLE : REACHED);
            return;
        }
    }
    if (is->steps >= m->job->budget) {
        rodgen_finish(m, w, RODGEN_SPENT);
        return;
    }
    if (lane->phase == GOING && (size_t)is->steps >= lane->look_at) {
        if (is->t - lane->seen < lane->creep)
            rodgen_finish(m, w, RODGEN_CREEPING);
        lane->seen = is->t;
        lane->look_at = (size_t)(is->steps + m->job->stride);
    }
}

/* A step of every lane that is under way. */
static void advance(struct many *m)
{
    double kept[LANES];
    rodgen_lanes_step(m, kept);
    SIDE_BY_SIDE
        if (kept[w] > 0.0)
            settle(m, w);
}

/* Whether rods that wait should begin: as long as it costs those under way more than they have waited, they do not. */
static int may_begin(struct many *m)
{
    const int dop853_too = m->job->method == DOP853;
    const double each = dop853_too ? AFTER : fixed_tableaux[m->job->method].stages;
    const double cost = dop853_too ? 2.0 + 2.0 * FIRST_LOOK : 1.0;
    int waiting = 0, going = 0;
    SIDE_BY_SIDE {
        waiting += m->lane[w].phase == FRESH || m->lane[w].phase == BEFORE;
        going += m->lane[w].phase == GOING;
    }
    m->block->waited += waiting;
    if (waiting == 0 || (going > 0 && m->block->waited * each < cost * going))
        return 0;
    m->block->waited = 0.0;
    return 1;
}

size_t rodgen_many_size(const struct rodgen_lanes *system, const struct rodgen_many *many)
{
    struct many m;
    struct rodgen_many job = *many;
    return parts(&m, system, &job, NULL);
}

int rodgen_many_on(const struct rodgen_lanes *system, struct rodgen_many *many, void *memory, long long steps)
{
    struct many view, *const m = &view;
    const int adapts = many->method == DOP853, explicit = adapts || (many->method >= 0 && many->method < DOP853);
    if (!explicit || !(adapts || many->step > 0.0) || !(many->rtol >= 0.0 && many->atol >= 0.0))
        return REFUSED;
    parts(m, system, many, memory);
    for (; steps > 0; --steps) {
        if (fill(m))
            return RODGEN_HUNGRY;
        if (may_begin(m))
            begin(m);
        int busy = 0, going = 0;
        SIDE_BY_SIDE {
            busy |= m->lane[w].phase != EMPTY;
            going |= m->lane[w].phase == GOING;
        }
        if (going)
            advance(m);
        else if (!busy && many->next == many->end)
            return many->more ? RODGEN_HUNGRY : REACHED;
    }
    return PAUSED;
}
