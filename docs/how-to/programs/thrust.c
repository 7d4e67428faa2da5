/* A free rod of ten links under thrust, integrated over ten seconds by dop853. */
#include "rod_free_n10_follower_gravity_c.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

/* Names of the header are long, so that a program can hold many rods. */
#define ROD(name) rod_free_n10_follower_gravity_c_##name
#define AT(name) ROD_FREE_N10_FOLLOWER_GRAVITY_C_##name

int main(void)
{
    enum { SAMPLES = 11 };
    double p[AT(PARAMETERS)] = {0}, times[SAMPLES], samples[SAMPLES * (AT(STATES) + AT(WORKS))];
    size_t sampled = 0;
    int status;
    ROD(run) *const run = calloc(1, ROD(run_size)());

    if (run == NULL)
        return 1;
    p[AT(P_MASS)] = 50.0;
    p[AT(P_LENGTH)] = 5.0;
    p[AT(P_BENDING_STIFFNESS)] = 100.0;
    p[AT(P_FOLLOWER_FORCE)] = 30.0;
    ROD(run_state)(run)[AT(Y_PHI_0)] = 0.05; /* the first link is bent a little */
    for (int i = 0; i < SAMPLES; ++i)
        times[i] = i;

    run->method = AT(DOP853);
    run->end = 10.0;
    run->low = -INFINITY; /* no load of this rod breaks off */
    run->high = INFINITY;
    run->rtol = 1e-8; /* of one step: errors of many add up */
    run->atol = 1e-10;
    status = ROD(run_start)(run, p);
    while (status == AT(PAUSED)) /* a thousand steps at a time: here a program looks at its clock */
        status = ROD(run_on)(run, p, 1000, SAMPLES, times, samples, &sampled, NULL);
    for (size_t i = 0; i < sampled; ++i) {
        const double *const y = samples + i * (AT(STATES) + AT(WORKS));
        printf("%4.1f s  phi_0 = %.12f rad\n", times[i], y[AT(Y_PHI_0)]);
    }
    free(run);
    return status < 0; /* below 0 stand the ways to fail */
}
