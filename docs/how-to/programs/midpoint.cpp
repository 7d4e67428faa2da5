// A free rod of ten links under thrust, stepped by a method of the program's own.
#include "rod_free_n10_follower_gravity_c.h"
#include <array>
#include <cstdio>
#include <vector>

#define ROD(name) rod_free_n10_follower_gravity_c_##name
#define AT(name) ROD_FREE_N10_FOLLOWER_GRAVITY_C_##name

int main()
{
    std::array<double, AT(PARAMETERS)> p{};
    p[AT(P_MASS)] = 50.0;
    p[AT(P_LENGTH)] = 5.0;
    p[AT(P_BENDING_STIFFNESS)] = 100.0;
    p[AT(P_FOLLOWER_FORCE)] = 30.0;

    // Memory of our own: the function then allocates nothing, and every thread has its own.
    std::vector<double> memory(ROD(work)() / sizeof(double) + 1);
    auto rates = [&](double t, const std::vector<double> &y) {
        std::vector<double> dy(y.size());
        ROD(rhs_in)(t, y.data(), p.data(), dy.data(), memory.data());
        return dy;
    };

    std::vector<double> y(AT(STATES));
    y[AT(Y_PHI_0)] = 0.05;
    const double h = 1e-3;
    for (int step = 0; step < 1000; ++step) { // the midpoint rule
        auto half = rates(step * h, y);
        for (std::size_t i = 0; i < y.size(); ++i)
            half[i] = y[i] + 0.5 * h * half[i];
        const auto slope = rates((step + 0.5) * h, half);
        for (std::size_t i = 0; i < y.size(); ++i)
            y[i] += h * slope[i];
    }
    std::printf("phi_0 after a second: %.6f rad\n", y[AT(Y_PHI_0)]);
}
