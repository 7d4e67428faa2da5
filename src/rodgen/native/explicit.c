/* Explicit methods: of fixed step, and DOP853. */

#include "control.h"

#define CASE(number, value) \
    case number: \
        for (ptrdiff_t i = low; i < count; ++i) \
            out[i] = value(PRODUCT_##number); \
        break;

/* A sum of stages. */
static void add(const struct sum *sum, double *const *k, ptrdiff_t count, double *restrict out)
{
    const ptrdiff_t low = 0;
    STAGES_OF_SUM;
#define VALUE(products) products
    CASES(VALUE)
#undef VALUE
}

/* A state moved on by a step times a sum of stages. */
static void move(const double *restrict y, double h, const struct sum *sum, double *const *k, ptrdiff_t low,
                 ptrdiff_t count, double *restrict out)
{
    STAGES_OF_SUM;
#define VALUE(products) y[i] + h * (products)
    CASES(VALUE)
#undef VALUE
}

/* Cubic through both ends of the last step with their rates. */
void rodgen_hermite(struct run *r, double h, double x, double *out)
{
    EACH
        out[i] = hermite(r->before[i], r->y[i], r->f_before[i], r->f[i], h, x);
}

/* From the start of a step by a sum of the rates of its stages. */
static void advance(const struct run *r, const struct tableau *m, double h, const struct sum *sum, double *out)
{
    const ptrdiff_t own = m->follow ? r->half : 0;
    move(r->before, h, sum, r->k, own, r->all, out);
    for (ptrdiff_t i = 0; i < own; ++i)
        out[i] = r->before[i] + h * out[r->half + i];
}

/* Equal steps from the start of a stretch, the last one shortened to meet its end; a step that
   would be shorter than a millionth of the others is not taken. */
int rodgen_fixed_step(struct run *r)
{
    rodgen_run *const is = r->is;
    const struct tableau *const m = &fixed_tableaux[is->method];
    const double t = is->t, next = end_of_equal_step(is), h = next - t;
    copy(r, r->before, r->y);
    copy(r, r->f_before, r->f);
    copy(r, r->k[0], r->f);
    for (int stage = 1; stage < m->stages; ++stage) {
        advance(r, m, h, &m->sums[stage - 1], r->trial);
        flow_at(r, stage_time(m->at[stage], t, next, h), r->trial, r->k[stage]);
    }
    advance(r, m, h, &m->sums[m->stages - 1], r->y);
    flow_at(r, next, r->y, r->f);
    if (!all_finite(r->y, r->all) || !all_finite(r->f, r->all)) {
        copy(r, r->y, r->before);
        copy(r, r->f, r->f_before);
        return NOT_FINITE;
    }
    is->before = t;
    is->t = next;
    ++is->taken;
    return PAUSED;
}

/* The largest stable step for the eigenvalue of largest modulus, of which frequency and damping
   are found by an iteration on the highest mode, a turn at every look (Sommeijer, Shampine,
   Verwer: RKC, 1997, do so for real spectra). */
static double stable_step(struct run *r)
{
    const ptrdiff_t count = r->half;
    const double *const d = r->direction;
    double *const turned = r->k[14], *const at = r->trial;
    double length = 0.0;
    for (ptrdiff_t i = 0; i < count; ++i)
        length += d[i] * d[i];
    if (!(length > 0.0))
        return INFINITY;
    const double by = turn_by(length);
    double found[2];
    for (int part = 0; part < 2; ++part) {
        copy(r, at, r->y);
        const double by_part = part == 0 ? by : speed_by(by, found[0]);
        for (ptrdiff_t i = 0; i < count; ++i)
            at[part * count + i] += by_part * d[i];
        flow_at(r, r->is->t, at, r->k[15]);
        double along = 0.0;
        for (ptrdiff_t i = 0; i < count; ++i) {
            const double change = (r->k[15][count + i] - r->f[count + i]) / by_part;
            if (part == 0)
                turned[i] = change;
            along += d[i] * change;
        }
        found[part] = -along / length;
    }
    double norm = 0.0;
    for (ptrdiff_t i = 0; i < count; ++i)
        norm += turned[i] * turned[i];
    if (norm > 0.0 && all_finite(turned, count))
        for (ptrdiff_t i = 0; i < count; ++i)
            r->direction[i] = -turned[i] / sqrt(norm);
    return longest_stable(r->is, found[0], found[1]);
}

/* The largest stable step for the states that are added, each by what it does alone: on the side where it does less,
   for beside a jump of its rate the slope over the jump says nothing. */
static double stable_step_of_states(struct run *r)
{
    double *const at = r->trial, most = INFINITY;
    copy(r, at, r->y);
    for (ptrdiff_t i = 2 * r->half; i < r->states; ++i) {
        double longest = 0.0;
        for (int side = -1; side <= 1; side += 2) {
            const double by = side * state_by(r->y[i]);
            at[i] = r->y[i] + by;
            flow_at(r, r->is->t, at, r->k[15]);
            longest = fmax(longest, longest_of_state((r->k[15][i] - r->f[i]) / by));
        }
        at[i] = r->y[i];
        most = fmin(most, longest);
    }
    return most;
}

/* Stages of DOP853 behind the first; those and sums of dense output; states at both ends of a part of a step. */
enum {
    STEPS = sizeof dop853.stages / sizeof *dop853.stages,
    MORE = sizeof dop853.more / sizeof *dop853.more,
    FIRST = STEPS + 2,
    SUMS = FIRST + MORE,
    PART = SUMS + 4
};
typedef char room_for_parts[PART + 2 <= STAGES ? 1 : -1];

/* Squares of the two estimates of the error over what is tolerated, summed. */
static void errors(struct run *r, double *five, double *three)
{
    double *const restrict error5 = r->error, *const restrict error3 = r->trial;
    const double *const restrict y = r->before, *const restrict on = r->y;
    add(&dop853.error5, r->k, r->states, error5);
    add(&dop853.error3, r->k, r->states, error3);
    for (int number = 0; number < GROUPS; ++number) {
        const struct group group = group_of(r, number);
        for (ptrdiff_t i = group.low; i < group.high; ++i) {
            const double u = fabs(y[i]), v = fabs(on[i]);
            const double over = 1.0 / tolerated(r->is, u > v ? u : v, group.limit);
            error5[i] = square(over * error5[i]);
            error3[i] = square(over * error3[i]);
        }
    }
    *five = total(error5, r->states);
    *three = total(error3, r->states);
}

/* Rates of so many stages of a step of DOP853, h from t and y, the first of them in a row of k. */
static void stages(struct run *r, const double *y, double t, double h, const struct stage *of, int count, int row)
{
    for (int stage = 0; stage < count; ++stage) {
        move(y, h, &of[stage].sum, r->k, 0, r->all, r->trial);
        flow_at(r, t + of[stage].at * h, r->trial, r->k[row + stage]);
    }
}

/* A step of Dormand and Prince's method of order 8 (Hairer, Norsett, Wanner: Solving Ordinary
   Differential Equations I, II.5). Steps end just inside the region of stability: there the
   estimated error says nothing of it until it is left. */
int rodgen_dop853_step(struct run *r)
{
    rodgen_run *const is = r->is;
    double *const *const k = r->k;
    const double t = is->t, *const y = r->before;
    double next, lag;
    int again = 0, cut;
    for (int look = looks_due(is); look > 0; --look) {
        is->most = stable_step(r);
        if (look == 1)
            is->most = fmin(is->most, stable_step_of_states(r));
        is->looked = 0;
    }
    copy(r, r->before, r->y);
    copy(r, r->f_before, r->f);
    copy(r, k[0], r->f);
    for (;; again = 1) {
        const double h = step_to_try(is, &cut);
        if (!(h > 0.0))
            return again ? (int)is->broken : TOO_SMALL;
        next = later(is, h, &lag);
        stages(r, y, t, h, dop853.stages, STEPS, 1);
        move(y, h, &dop853.weights, k, 0, r->all, r->y);
        flow_at(r, next, r->y, k[STEPS + 1]);
        double five, three;
        errors(r, &five, &three);
        const double error = error_of_both(five, three, h, (double)r->states);
        const int whole = all_finite(k[STEPS + 1], r->all) && all_finite(r->y, r->all);
        if (is_kept(is, h, error, whole, again, cut))
            break;
        copy(r, r->y, r->before);
    }
    copy(r, r->f, k[STEPS + 1]);
    arrive(is, next, lag);
    return PAUSED;
}

/* What dense output of order 7 needs of a step h from t and y (the same book, II.6): three more stages, then four sums
   of all. */
static void prepare_dense(struct run *r, const double *y, double t, double h)
{
    double *const *const k = r->k;
    stages(r, y, t, h, dop853.more, MORE, FIRST);
    for (int sum = 0; sum < 4; ++sum)
        add(&dop853.dense[sum], k, r->all, k[SUMS + sum]);
}

/* In how many parts the last step, of length h, has a dense output that is good enough. */
static int parts(struct run *r, double h)
{
    double *const error = r->error;
    const double *const y = r->before, *const on = r->y, *const last = r->k[SUMS + 3];
    for (int number = 0; number < GROUPS; ++number) {
        const struct group group = group_of(r, number);
        for (ptrdiff_t i = group.low; i < group.high; ++i) {
            const double u = fabs(y[i]), v = fabs(on[i]);
            error[i] = square(last[i] / tolerated(r->is, u > v ? u : v, group.limit));
        }
    }
    return parts_of(total(error, r->states), h, (double)r->states);
}

/* Step from part to part of the last step, each of length h, as far as a part that is counted from 1. */
static void reach(struct run *r, double h, int part)
{
    rodgen_run *const is = r->is;
    double *const *const k = r->k, *const y = k[PART], *const on = k[PART + 1], *const after = k[STEPS + 1];
    if (is->part == part)
        return;
    if (is->part > part)
        is->part = 0;
    while (is->part < part) {
        const double t = is->before + (double)is->part * h;
        copy(r, y, is->part == 0 ? r->before : on);
        copy(r, k[0], is->part == 0 ? r->f_before : after);
        stages(r, y, t, h, dop853.stages, STEPS, 1);
        move(y, h, &dop853.weights, k, 0, r->all, on);
        flow_at(r, t + h, on, after);
        ++is->part;
    }
    prepare_dense(r, y, is->before + (double)(part - 1) * h, h);
}

void rodgen_dop853_dense(struct run *r, double h, double x, double *out)
{
    rodgen_run *const is = r->is;
    double *const *const k = r->k;
    const double *y = r->before, *on = r->y, *f = r->f_before, *after = r->f;
    if (is->dense == 0) {
        prepare_dense(r, y, is->before, h);
        is->dense = parts(r, h);
    }
    if (is->dense > 1) {
        const double many = (double)is->dense;
        const int within = (int)(x * many), part = within < is->dense ? within : (int)is->dense - 1;
        h /= many;
        x = x * many - part;
        reach(r, h, part + 1);
        y = k[PART], on = k[PART + 1], f = k[0], after = k[STEPS + 1];
    }
    const double *const f3 = k[SUMS], *const f4 = k[SUMS + 1], *const f5 = k[SUMS + 2], *const f6 = k[SUMS + 3];
    EACH {
        const double inner = dop853_inner(f3[i], f4[i], f5[i], f6[i], h, x);
        out[i] = dop853_between(y[i], on[i], f[i], after[i], h, x, inner);
    }
}
