/* The yardstick: accelerations of a free uniform rod from its joint forces, in O(n).

   Plain block elimination from the first joint to the last and back, sine and cosine from libm.
   With m a = sum of forces and J alpha = sum of moments of every link, the acceleration that two
   links share at their joint gives, times m, for the force lambda_j on link j from link j - 1

       E_{j-1} lambda_{j-1} + (E_{j-1} + E_j + 4 I) lambda_j + E_j lambda_{j+1}
           = f_{j-1} - f_j + w_{j-1} + w_j,
       E = 3 n n^T - I,   w = 6/l torque n - m l/2 omega^2 e,

   f the loads on a link. The number of links is given by -DN=50.

   y = [x0, y0, phi (N), vx0, vy0, omega (N)]
   p = [mass, length, bending_stiffness, follower_force, follower_angle] */

#include <math.h>

#ifndef N
#error "give the number of links: -DN=50"
#endif

void yardstick_rhs(double t, const double *y, const double *p, double *dy)
{
    const double m = p[0] / N, l = p[1] / N, k = p[2] / l;
    const double h = 0.5 * m * l, g = 6.0 / l;
    const double *phi = y + 2, *u = y + N + 2, *omega = y + N + 4;
    double c[N], s[N], torque[N];
    double G[N][4], q[N][2]; /* lambda_j = q_j - G_j lambda_{j+1} */
    (void)t;

    for (int i = 0; i < N; i++) {
        c[i] = cos(phi[i]);
        s[i] = sin(phi[i]);
    }
    double before = 0.0; /* moment of the spring at the start of the link */
    for (int i = 0; i < N - 1; i++) {
        const double after = k * (phi[i + 1] - phi[i]);
        torque[i] = after - before;
        before = after;
    }
    const double along = -p[3] * cos(p[4]), across = -p[3] * sin(p[4]);
    const double fx = along * c[N - 1] - across * s[N - 1];
    const double fy = along * s[N - 1] + across * c[N - 1];
    torque[N - 1] = 0.5 * l * across - before;

    /* From the first joint to the last. */
    double e11 = 3.0 * s[0] * s[0] - 1.0, e12 = -3.0 * s[0] * c[0], e22 = 3.0 * c[0] * c[0] - 1.0;
    double wn = g * torque[0], we = h * omega[0] * omega[0];
    double wx = -wn * s[0] - we * c[0], wy = wn * c[0] - we * s[0];
    double d11 = e11 + 4.0, d12 = e12, d22 = e22 + 4.0, rx = wx, ry = wy;
    for (int j = 1; j < N; j++) {
        e11 = 3.0 * s[j] * s[j] - 1.0;
        e12 = -3.0 * s[j] * c[j];
        e22 = 3.0 * c[j] * c[j] - 1.0;
        wn = g * torque[j];
        we = h * omega[j] * omega[j];
        wx = -wn * s[j] - we * c[j];
        wy = wn * c[j] - we * s[j];
        d11 += e11;
        d12 += e12;
        d22 += e22;
        rx += wx;
        ry += wy;
        if (j == N - 1) {
            rx -= fx;
            ry -= fy;
        }
        const double over = 1.0 / (d11 * d22 - d12 * d12);
        const double h11 = d22 * e11 - d12 * e12, h12 = d22 * e12 - d12 * e22;
        const double h21 = d11 * e12 - d12 * e11, h22 = d11 * e22 - d12 * e12;
        const double qx = over * (d22 * rx - d12 * ry), qy = over * (d11 * ry - d12 * rx);
        G[j][0] = over * h11;
        G[j][1] = over * h12;
        G[j][2] = over * h21;
        G[j][3] = over * h22;
        q[j][0] = qx;
        q[j][1] = qy;
        d11 = e11 + 4.0 - over * (e11 * h11 + e12 * h21);
        d12 = e12 - over * (e11 * h12 + e12 * h22);
        d22 = e22 + 4.0 - over * (e12 * h12 + e22 * h22);
        rx = wx - (e11 * qx + e12 * qy);
        ry = wy - (e12 * qx + e22 * qy);
    }

    /* And back, with the accelerations of the links. */
    const double per_J = 12.0 / (m * l * l);
    double *alpha = dy + N + 4;
    double lx = 0.0, ly = 0.0; /* the force in the joint after the link */
    for (int j = N - 1; j > 0; j--) {
        const double nx = q[j][0] - (G[j][0] * lx + G[j][1] * ly);
        const double ny = q[j][1] - (G[j][2] * lx + G[j][3] * ly);
        const double across_link = c[j] * (ny + ly) - s[j] * (nx + lx);
        alpha[j] = per_J * (torque[j] - 0.5 * l * across_link);
        lx = nx;
        ly = ny;
    }
    alpha[0] = per_J * (torque[0] - 0.5 * l * (c[0] * ly - s[0] * lx));

    const double ends = N == 1 ? 1.0 : 0.0; /* the only link bears the thrust itself */
    const double turn = 0.5 * l * alpha[0], swing = 0.5 * l * omega[0] * omega[0];
    dy[N + 2] = (ends * fx - lx) / m + turn * s[0] + swing * c[0];
    dy[N + 3] = (ends * fy - ly) / m - turn * c[0] + swing * s[0];
    for (int i = 0; i < N + 2; i++)
        dy[i] = u[i];
}
