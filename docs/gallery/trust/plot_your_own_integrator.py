"""
The right-hand side in your own program
=======================================

A generated module computes the rates of a state, with NumPy or compiled. Any integrator can use
it. Here it is SciPy's, with the exact Jacobian.
"""

import matplotlib.pyplot as plt
from scipy.integrate import solve_ivp

import rodgen

rod = rodgen.build(rodgen.Structure(10, "pinned", terms=("gravity",)), parts=("rhs", "jac"))
p = rod.parameters(mass=1.0, length=1.0, bending_stiffness=0.02, gravity=9.81)
y0 = [0.0] * len(rod.STATE)
motion = solve_ivp(rod.rhs, (0, 2), y0, method="Radau", jac=rod.jac, args=(p,), rtol=1e-6)

figure, axes = plt.subplots()
axes.plot(motion.t, motion.y[: rod.N].T)
axes.set(xlabel="time [s]", ylabel="angles of the links [rad]")
