/* Runs: memory, samples between steps, and the loop over steps. No mechanics. */

#include "run.h"

/* How many positions there are. */
static size_t positions(const struct rodgen_system *system)
{
    return (system->states - system->added) / 2;
}

/* The parts of a run's memory, of which the first is the run itself: rows of all states and works,
   then the direction, the shifted states, and memory of the equations. */
enum { ROWS = 6 + STAGES };

/* Numbers of a row. */
static size_t width_of(const struct rodgen_system *system)
{
    return system->states + system->works + system->tangents * system->states;
}

size_t rodgen_run_size(const struct rodgen_system *system)
{
    const size_t states = system->states, row = lined(width_of(system) * sizeof(double));
    return lined(sizeof(rodgen_run)) + ROWS * row + lined(positions(system) * sizeof(double))
        + lined(2 * states * sizeof(double)) + lined(system->flow_size) + lined(system->newton_size);
}

/* Whether the run's method solves for its stages: tangents are solved for once these are known. */
static int implicit(const rodgen_run *is)
{
    return is->method == GAUSS || is->method == RADAU || is->method == GAUSS_EQUAL_STEPS;
}

static struct run run_of(const struct rodgen_system *system, rodgen_run *run, const double *p)
{
    const size_t states = system->states, row = lined(width_of(system) * sizeof(double));
    const size_t directions = implicit(run) ? 0 : system->tangents;
    char *at = (char *)run + lined(sizeof *run);
    double *rows[ROWS];
    for (int number = 0; number < ROWS; ++number, at += row)
        rows[number] = (double *)(void *)at;
    struct run r = {
        .is = run,
        .of = system,
        .p = p,
        .states = (ptrdiff_t)states,
        .half = (ptrdiff_t)positions(system),
        .all = (ptrdiff_t)(states + system->works + directions * states),
        .base = (ptrdiff_t)system->base,
        .width = (ptrdiff_t)width_of(system),
        .directions = directions,
        .y = rows[0],
        .f = rows[1],
        .before = rows[2],
        .f_before = rows[3],
        .trial = rows[4],
        .error = rows[5],
    };
    memcpy(r.k, rows + 6, sizeof r.k);
    r.direction = (double *)(void *)at;
    at += lined(positions(system) * sizeof(double));
    r.shifted = (double *)(void *)at;
    at += lined(2 * states * sizeof(double));
    r.flow = at;
    r.newton = at + lined(system->flow_size);
    return r;
}

double *rodgen_run_state(const struct rodgen_system *system, rodgen_run *run)
{
    return run_of(system, run, NULL).y;
}

double *rodgen_run_rates(const struct rodgen_system *system, rodgen_run *run)
{
    return run_of(system, run, NULL).f;
}

/* A step by the run's method; t, y, f and what lies before it are moved on. */
static int step(struct run *r)
{
    switch (r->is->method) {
    case DOP853:
        return rodgen_dop853_step(r);
    case GAUSS:
    case RADAU:
        return rodgen_collocation_step(r);
    case GAUSS_EQUAL_STEPS:
        return rodgen_collocation_equal_step(r);
    default:
        return rodgen_fixed_step(r);
    }
}

/* The state inside the last step. */
static void dense(struct run *r, double t, double *out)
{
    const double h = last_step(r->is), x = ((t - r->is->before) - r->is->lag_before) / h;
    switch (r->is->method) {
    case DOP853:
        rodgen_dop853_dense(r, h, x, out);
        break;
    case GAUSS:
    case RADAU:
    case GAUSS_EQUAL_STEPS:
        rodgen_collocation_dense(r, x, out);
        break;
    default:
        rodgen_hermite(r, h, x, out);
    }
}

/* A first step for a method of some order. */
static double step_to_begin(struct run *r, double order)
{
    const double span = r->is->end - r->is->t;
    double *const other = r->k[1];
    memset(r->before, 0, (size_t)r->all * sizeof *r->before);
    const double d0 = scaled(r, r->y, r->y, r->y), d1 = scaled(r, r->f, r->y, r->y);
    const double h = guessed_step(d0, d1, span);
    EACH
        r->trial[i] = r->y[i] + h * r->f[i];
    flow_at(r, r->is->t + h, r->trial, other);
    EACH
        r->trial[i] = other[i] - r->f[i];
    return first_step(h, d1, scaled(r, r->trial, r->y, r->y) / h, order, span);
}

/* Whether the run's method chooses its steps. */
static int adapts(const rodgen_run *is)
{
    return is->method == DOP853 || is->method == GAUSS || is->method == RADAU;
}

/* Whether there is no such run, whatever the equations. */
static int impossible(const rodgen_run *is)
{
    const int known = is->method >= 0 && is->method < RODGEN_METHODS;
    const int has_step = adapts(is) || (is->step > 0.0 && is->step < INFINITY);
    const int tolerates = !adapts(is) || (is->rtol >= 0.0 && is->atol >= 0.0);
    return !(known && has_step && tolerates && is->t <= is->end && fabs(is->t) < INFINITY);
}

int rodgen_run_start(const struct rodgen_system *system, rodgen_run *run, const double *p)
{
    if (impossible(run))
        return REFUSED;
    struct run view = run_of(system, run, p), *const r = &view;
    run->start = run->before = run->t;
    run->lag = run->lag_before = 0.0;
    if (!(run->longest > 0.0))
        run->longest = INFINITY;
    run->taken = run->dense = run->part = run->predicts = run->smooth = run->blocks = run->broken = 0;
    run->factored = run->last_step = run->last_reach = 0.0;
    run->looked = -1;
    for (ptrdiff_t i = 0; i < r->half; ++i)
        r->direction[i] = i < r->base ? 0.0 : i % 2 ? -1.0 : 1.0;
    flow_at(r, run->t, r->y, r->f);
    copy(r, r->before, r->y);
    copy(r, r->f_before, r->f);
    if (!all_finite(r->f, r->all) || !all_finite(r->y, r->all))
        return NOT_FINITE;
    if (adapts(run) && !(run->step > 0.0))
        run->step = step_to_begin(r, run->method == DOP853 ? 7.0 : 3.0);
    return PAUSED;
}

int rodgen_run_on(const struct rodgen_system *system, rodgen_run *run, const double *p, long long quota,
                  size_t count, const double *times, double *samples, size_t *sampled, double *trace)
{
    /* A run that was begun has a longest step. */
    if (impossible(run) || !(run->longest > 0.0))
        return REFUSED;
    struct run view = run_of(system, run, p), *const r = &view;
    for (;; --quota) {
        while (*sampled < count && times[*sampled] <= run->t) {
            double *const out = samples + *sampled * (size_t)r->width;
            if (times[*sampled] == run->t)
                copy(r, out, r->y);
            else
                dense(r, times[*sampled], out);
            ++*sampled;
        }
        if (count > 0 && *sampled == count)
            return FULL;
        if (run->t >= run->end)
            return REACHED;
        if (quota <= 0)
            return PAUSED;
        const int status = step(r);
        if (status < 0)
            return status;
        ++run->steps;
        if (trace != NULL) {
            *trace++ = run->t;
            memcpy(trace, r->y, system->states * sizeof *trace);
            memcpy(trace + system->states, r->f, system->states * sizeof *trace);
            trace += 2 * system->states;
        }
    }
}

void rodgen_run_at(const struct rodgen_system *system, rodgen_run *run, const double *p, double t, double *y)
{
    struct run r = run_of(system, run, p);
    dense(&r, t, y);
}
