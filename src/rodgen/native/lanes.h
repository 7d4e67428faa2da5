/* Runs of many rods of one structure, RODGEN_LANES of them side by side, each with a step of its own. */

#ifndef RODGEN_LANES_H
#define RODGEN_LANES_H

#include <stddef.h>

#include "steps.h"

#ifdef __cplusplus
extern "C" {
#endif

enum { RODGEN_LANES = 8 };

/* The equations of that many rods. Arrays have one number of all rods after the other; p alone lies rod by
   rod, and q is p side by side. */
struct rodgen_lanes {
    size_t states, works; /* numbers of y, and loads without potential */
    size_t base;          /* numbers of y before the angles */
    size_t added;         /* numbers of y behind positions and velocities */
    size_t parameters, observed;
    size_t work_size; /* bytes of memory that both functions work in */
    /* Rates dy of the states y at times t, then the power of every load without potential. */
    void (*flow)(const double *t, const double *y, const double *p, const double *q, double *dy, void *work);
    void (*observe)(const double *t, const double *y, const double *p, const double *q, double *out, void *work);
};

/* What is made of a number at the samples of a run. */
enum {
    RODGEN_KEEP_LAST = 0,
    RODGEN_KEEP_MIN = 1,
    RODGEN_KEEP_MAX = 2,
    RODGEN_KEEP_MEAN = 3,
    RODGEN_KEEP_RMS = 4,
    RODGEN_KEEP_STD = 5,
    RODGEN_KEEP_TIME_OF_MAX = 6
};

/* A reduction of a number: the weighed sum of rows of states, works and what is observed; less its value at the
   start, if that is asked for; over the samples between two times. */
struct rodgen_kept {
    long long reduction, less_start;
    size_t first, terms; /* among rows and weights */
    double from, to;
};

/* A number as the weighed sum of some rows. */
struct rodgen_number {
    size_t first, terms; /* among rows and weights */
};

/* A number that is watched: where it passes a level, from below or from above, between two times. Of its crossings the
   first ones are kept, each with its time and some numbers; or a run ends with the first of them. */
struct rodgen_watched {
    long long rising, falling;
    long long looks; /* whether one of the rows is observed */
    long long stops; /* 0, or what the outcome of a run that it ends tells */
    double level, from, to;
    size_t first, terms; /* among rows and weights */
    size_t place;        /* of what is kept, among what is kept of a rod: how many crossings there are, then each of them */
    size_t most;         /* how many of them are kept */
    size_t first_number, numbers; /* of each of them */
};

/* A stretch of a run up to a time that steps must meet, and between what times loads may be asked for their values
   there; and what rods of the same loads in time share: their stretches, and the longest step. */
struct rodgen_stretch {
    double end, low, high;
};
struct rodgen_course {
    size_t first, count; /* among stretches */
    double longest;
    long long pole; /* whether a load grows beyond all bounds where the last one ends */
};

/* How a rod has ended, by the statuses of steps.h or of these. */
enum {
    RODGEN_HUNGRY = 3,    /* of many rods: some lanes are empty, and no rod waits */
    RODGEN_STOPPED = 4,   /* by a number that was watched */
    RODGEN_SPENT = -5,    /* its budget of steps is used up */
    RODGEN_CREEPING = -6, /* many steps brought it no further */
    RODGEN_POLE = -7      /* a load grows beyond all bounds */
};
struct rodgen_outcome {
    double t;
    long long status, steps, rejected, rhs, stopped;
};

/* Many runs by one method. The caller sets everything: rods from next to end are taken one by one; whoever sets
   more will give others when these are taken. Values that are kept are those of runs that reach their end. */
struct rodgen_many {
    long long method;
    double start, step, rtol, atol;
    long long budget, stride; /* steps in all, and between two looks at how far they bring it */
    double creep;             /* the least share of a stretch that they are to bring it */
    const double *p, *y;
    size_t p_stride, y_stride; /* from rod to rod, 0: one for all */
    size_t samples;
    const double *times;
    const long long *course_of; /* of every rod; NULL: the first of all */
    const struct rodgen_course *courses;
    const struct rodgen_stretch *stretches;
    long long observes; /* whether a number that is kept asks for what is observed */
    size_t energies;    /* where masses may jump, whose work is the last: how many of what is observed, from the first
                           on, are parts of the energy; else 0 */
    size_t kept;
    const struct rodgen_kept *keep;
    const long long *rows;
    const double *weights;
    size_t watched;
    long long looks; /* whether one of these looks at what is observed */
    const struct rodgen_watched *watch;
    const struct rodgen_number *numbers;
    size_t crossed_width; /* of what is kept of the crossings of a rod */
    size_t traced; /* numbers of which all samples are kept */
    const struct rodgen_number *trace;
    double *traces; /* (rods, traced, samples + 1): of a run that is stopped, the last is where it ends */
    double *state;  /* (rods, states + works) at the end */
    double *values; /* (rods, kept) */
    double *crossed; /* (rods, crossed_width), zero at first */
    struct rodgen_outcome *outcome;
    size_t next, end;
    long long more;
};

/* Bytes of memory that many runs work in, all zero at first and aligned as malloc's. */
size_t rodgen_many_size(const struct rodgen_lanes *system, const struct rodgen_many *many);

/* Take at most so many steps of all lanes. Ends with PAUSED, with REACHED when all rods have ended, with HUNGRY, or
   with REFUSED where there are no such runs. */
int rodgen_many_on(const struct rodgen_lanes *system, struct rodgen_many *many, void *memory, long long steps);

#ifdef __cplusplus
}
#endif

#endif
