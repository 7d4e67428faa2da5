"""
Bending moment over time and length
===================================

A missile flies under thrust. The picture shows the bending moment in every joint at every time.
"""

import matplotlib.pyplot as plt

import rodgen

sol = rodgen.simulate(rodgen.Scene.example("missile"), progress=False)
moment = sol.bending_moments

figure, axes = plt.subplots()
limit = abs(moment).max()
extent = (sol.t[0], sol.t[-1], 0, 1)
shown = axes.imshow(
    moment.T, aspect="auto", origin="lower", extent=extent, cmap="RdBu_r", vmin=-limit, vmax=limit
)
axes.set(xlabel="time [s]", ylabel="s, from the nose")
figure.colorbar(shown, label="bending moment [N m]")
