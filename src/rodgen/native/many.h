/* Lanes, their memory, and functions that the steps of many rods side by side share. All that is computed of a lane
   follows from its own rod alone. */

#ifndef RODGEN_MANY_H
#define RODGEN_MANY_H

#include "lanes.h"
#include "run.h"

enum { LANES = RODGEN_LANES };
#define SIDE_BY_SIDE for (int w = 0; w < LANES; ++w)

/* Where a lane is: without a rod, before a run or a stretch, or under way. */
enum { EMPTY = 0, FRESH, BEFORE, GOING };

struct lane {
    rodgen_run is;
    long long phase, again;
    size_t rod, stretch, sampled, look_at;
    long long stopped; /* by what the run ends in this step */
    double seen, creep;
    /* The step that is tried: its length, its end, what rounding takes from that. */
    double h, next, lag;
    int cut, due;
};

/* A reduction as far as it has come: samples, and two numbers. */
struct tally {
    double count[LANES], a[LANES], b[LANES], start[LANES];
};

/* Memory begins with this. */
struct block {
    struct lane lane[LANES];
    double waited; /* rods that waited while others took a step, summed */
};

/* The parts of the memory: rows of all states and works are (states + works, LANES). Stages are followed by the rates at
   the end of a step, and these by what dense output needs; then, of a part of a step, states and rates at both ends, and
   sums of its dense output. */
enum { AFTER = 12, MORE = 3, SUMS = AFTER + 1 + MORE, PART = SUMS + 4, PART_RATES = PART + 2, PART_SUMS = PART + 4 };
enum { ROWS = PART_SUMS + 4 };
struct many {
    const struct rodgen_lanes *of;
    struct rodgen_many *job;
    struct block *block;
    struct lane *lane;
    ptrdiff_t states, half, all, base;
    double *y, *on, *trial, *sample, *direction, *observed, *p, *q;
    double *come; /* energy of the masses that have come at the end of a stretch, of each lane */
    double *k[ROWS]; /* the first: rates at the start of a step */
    struct tally *tally;
    double *levels; /* of all numbers that are watched, at the points of a step */
    void *work;
};

/* Have other rows in the lanes of a mask. */
static inline void blend(const double *restrict mask, const double *restrict other, ptrdiff_t count, double *restrict rows)
{
    for (ptrdiff_t j = 0; j < count; ++j)
        SIDE_BY_SIDE
            rows[j * LANES + w] = mask[w] > 0.0 ? other[j * LANES + w] : rows[j * LANES + w];
}

/* Sums over rows of zero times each number: zero where all are finite. */
static inline void add_zeros(const double *restrict rows, ptrdiff_t count, double *restrict sums)
{
    for (ptrdiff_t j = 0; j < count; ++j)
        SIDE_BY_SIDE
            sums[w] += 0.0 * rows[j * LANES + w];
}

/* Rates and powers at times of each; those of a mask have asked for them. */
static inline void rates(struct many *m, const double *t, const double *mask, const double *y, double *dy)
{
    double at[LANES];
    SIDE_BY_SIDE {
        at[w] = inside(&m->lane[w].is, t[w]);
        m->lane[w].is.rhs += mask[w] > 0.0;
    }
    m->of->flow(at, y, m->p, m->q, dy, m->work);
}

/* The time of the next sample of a lane; infinity after the last. */
static inline double next_sample(const struct many *m, const struct lane *lane)
{
    return lane->sampled < m->job->samples ? m->job->times[lane->sampled] : INFINITY;
}

/* The length of a first step where there is none, of the lanes of a mask: lane_steps.c. A step of every lane that is
   under way: which are kept; they are moved on. */
void rodgen_first_steps(struct many *m, double *mask);
void rodgen_lanes_step(struct many *m, double *kept);

/* What lies within the steps that are kept: lane_dense.c. Where a run is stopped in one, that is where it ends. */
void rodgen_inside_steps(struct many *m, const double *kept, double *next);

/* States inside steps: lane_dense.c. States at times of each within the steps that are kept, in the lanes of a mask; in the others, at their ends. */
void rodgen_between(struct many *m, const double *mask, const double *h, const double *next, const double *t, double *out);

/* Numbers that are watched: crossings.c. What they are at the start of the lanes of a mask; in which lanes some pass
   their level in the steps of lengths h that are kept, if any; then where, which is written, but not behind a time at
   which a run is stopped, to which until is set. */
enum { WATCHED = 9 }; /* points of a step, both ends among them */
void rodgen_watch_start(struct many *m, const double *mask, const double *t, const double *states);
int rodgen_watch(struct many *m, const double *kept, const double *h, const double *next, double *crossed);
void rodgen_cross(struct many *m, const double *crossed, const double *h, const double *next, double *until);

/* The weighed sum of rows in a lane; what is observed of states at times of each. */
double rodgen_value(const struct many *m, size_t first, size_t terms, const double *states, int w);
void rodgen_observe(struct many *m, const double *t, const double *states);

/* What is made of samples: reductions.c. Values at the start of the lanes of a mask; a sample at times of each; results
   of a lane whose run has come to its end, or not. */
void rodgen_note_start(struct many *m, const double *mask, const double *t, const double *states);
void rodgen_take_samples(struct many *m, const double *mask, const double *t, const double *states);

/* What the energy of states gains by masses of other times: the work of masses that jump in between. */
void rodgen_masses_gain(struct many *m, const double *states, const double *before, const double *after, double *gain);
void rodgen_write_results(const struct many *m, int w, int whole);

/* A lane without a rod again: lanes.c. */
void rodgen_finish(struct many *m, int w, long long status);

#endif
