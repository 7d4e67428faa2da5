"""
A chain that falls forgets
==========================

Ten links without stiffness fall from the level. Two chains that differ by 1e-9 rad at the start
are at different places after a second; the largest Lyapunov exponent says how fast.
"""

import matplotlib.pyplot as plt
import numpy as np

import rodgen

scene = rodgen.Scene.example("falling_chain")
model = rodgen.build(scene, target="c")
y0 = np.array(scene.initial_state())
one = rodgen.simulate(scene, model=model, span=[0.0, 4.0], progress=False)
y0[0] += 1e-9
other = rodgen.simulate(scene, model=model, y0=y0, span=[0.0, 4.0], progress=False)
found = rodgen.lyapunov_exponents(scene, count=1, span=50.0)

figure, axes = plt.subplots()
axes.semilogy(one.t, np.abs(one.phi - other.phi).max(axis=1) + 1e-17)
axes.semilogy(one.t, 1e-6 * np.exp(found.exponents[0] * (one.t - 2.3)), "k:", label="the exponent")
axes.set(xlabel="time [s]", ylabel="difference of angles [rad]", ylim=(1e-12, 1e2))
axes.legend(title=f"{found.exponents[0]:.1f} ± {found.errors[0]:.1f} 1/s")
