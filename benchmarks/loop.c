/* Seconds that count calls of a right-hand side take. */

#define _POSIX_C_SOURCE 199309L
#include <time.h>

typedef void rhs_function(double t, const double *y, const double *p, double *dy);

double loop(rhs_function *rhs, const double *y, const double *p, double *dy, long count)
{
    struct timespec start, end;
    clock_gettime(CLOCK_MONOTONIC, &start);
    for (long i = 0; i < count; i++)
        rhs(0.0, y, p, dy);
    clock_gettime(CLOCK_MONOTONIC, &end);
    return (double)(end.tv_sec - start.tv_sec) + 1e-9 * (double)(end.tv_nsec - start.tv_nsec);
}
