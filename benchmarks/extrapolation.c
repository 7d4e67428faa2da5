/* A free uniform rod under thrust at its tail, with internal damping, in 80-bit arithmetic.

   Reference solutions from a family that no contestant is of: the explicit midpoint rule with 2, 4,
   .., 2 K substeps, extrapolated (Gragg, Bulirsch and Stoer; Hairer, Norsett, Wanner, Solving ODEs I,
   section II.9), in equal steps. Accelerations by the elimination of yardstick.c.

   y = [x0, y0, phi (N), vx0, vy0, omega (N)]
   p = [mass, length, bending_stiffness, follower_force, internal_damping] */

#include <math.h>

typedef long double real;
enum { SIZE = 2 * N + 4 };

static void rhs(const real *y, const double *p, real *dy)
{
    const real m = (real)p[0] / N, l = (real)p[1] / N, k = p[2] / l, d = p[4] * m;
    const real *phi = y + 2, *omega = y + N + 4;
    real c[N], s[N], torque[N], e[N][3], w[N][2], G[N][4], q[N][2];
    real before = 0;
    for (int i = 0; i < N; i++) {
        const int inner = i < N - 1;
        const real after =
            inner ? k * (phi[i + 1] - phi[i]) + d * (omega[i + 1] - omega[i]) : 0;
        c[i] = cosl(phi[i]);
        s[i] = sinl(phi[i]);
        torque[i] = after - before;
        before = after;
        const real wn = 6 / l * torque[i], we = m * l / 2 * omega[i] * omega[i];
        e[i][0] = 3 * s[i] * s[i] - 1;
        e[i][1] = -3 * s[i] * c[i];
        e[i][2] = 3 * c[i] * c[i] - 1;
        w[i][0] = -wn * s[i] - we * c[i];
        w[i][1] = wn * c[i] - we * s[i];
    }
    const real fx = -p[3] * c[N - 1], fy = -p[3] * s[N - 1];
    for (int j = 1; j < N; j++) {
        const real *a = e[j - 1], *b = e[j];
        real d11 = a[0] + b[0] + 4, d12 = a[1] + b[1], d22 = a[2] + b[2] + 4;
        real rx = w[j - 1][0] + w[j][0], ry = w[j - 1][1] + w[j][1];
        if (j == N - 1) {
            rx -= fx;
            ry -= fy;
        }
        if (j > 1) {
            const real *g = G[j - 1], *f = q[j - 1];
            d11 -= a[0] * g[0] + a[1] * g[2];
            d12 -= a[0] * g[1] + a[1] * g[3];
            d22 -= a[1] * g[1] + a[2] * g[3];
            rx -= a[0] * f[0] + a[1] * f[1];
            ry -= a[1] * f[0] + a[2] * f[1];
        }
        const real over = 1 / (d11 * d22 - d12 * d12);
        G[j][0] = over * (d22 * b[0] - d12 * b[1]);
        G[j][1] = over * (d22 * b[1] - d12 * b[2]);
        G[j][2] = over * (d11 * b[1] - d12 * b[0]);
        G[j][3] = over * (d11 * b[2] - d12 * b[1]);
        q[j][0] = over * (d22 * rx - d12 * ry);
        q[j][1] = over * (d11 * ry - d12 * rx);
    }
    real lx = 0, ly = 0, *alpha = dy + N + 4;
    for (int j = N - 1; j >= 0; j--) {
        const real nx = j ? q[j][0] - (G[j][0] * lx + G[j][1] * ly) : 0;
        const real ny = j ? q[j][1] - (G[j][2] * lx + G[j][3] * ly) : 0;
        alpha[j] = 12 / (m * l * l) * (torque[j] - l / 2 * (c[j] * (ny + ly) - s[j] * (nx + lx)));
        if (j == 0) {
            dy[N + 2] = -lx / m + l / 2 * (alpha[0] * s[0] + omega[0] * omega[0] * c[0]);
            dy[N + 3] = -ly / m - l / 2 * (alpha[0] * c[0] - omega[0] * omega[0] * s[0]);
        }
        lx = nx;
        ly = ny;
    }
    for (int i = 0; i < N + 2; i++)
        dy[i] = y[N + 2 + i];
}

static void midpoint(const real *y, const real *f0, const double *p, real H, int parts, real *out)
{
    const real h = H / parts;
    real old[SIZE], f[SIZE];
    for (int i = 0; i < SIZE; i++) {
        old[i] = y[i];
        out[i] = y[i] + h * f0[i];
    }
    for (int part = 1; part < parts; part++) {
        rhs(out, p, f);
        for (int i = 0; i < SIZE; i++) {
            const real next = old[i] + 2 * h * f[i];
            old[i] = out[i];
            out[i] = next;
        }
    }
}

/* From t = 0 to the end in so many equal steps; the state is replaced. */
void extrapolated(double end, double *state, const double *p, const double *counts)
{
    const long steps = (long)counts[0];
    real y[SIZE], f0[SIZE], T[K][SIZE];
    for (int i = 0; i < SIZE; i++)
        y[i] = state[i];
    for (long step = 0; step < steps; step++) {
        rhs(y, p, f0);
        for (int j = 0; j < K; j++) {
            midpoint(y, f0, p, (real)end / steps, 2 * (j + 1), T[j]);
            for (int k = j; k > 0; k--) {
                const real r = (real)(j + 1) / k, over = 1 / (r * r - 1);
                for (int i = 0; i < SIZE; i++)
                    T[k - 1][i] = T[k][i] + (T[k][i] - T[k - 1][i]) * over;
            }
        }
        for (int i = 0; i < SIZE; i++)
            y[i] = T[0][i];
    }
    for (int i = 0; i < SIZE; i++)
        state[i] = (double)y[i];
}
