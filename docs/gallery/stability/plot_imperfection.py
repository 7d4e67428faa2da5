"""
What an imperfection does to buckling
=====================================

A perfect column buckles at a branch point. A small force across turns this point into one smooth
curve, and another curve that begins in a fold. A real column therefore never has the sharp load of
the textbook.
"""

import matplotlib.pyplot as plt

import rodgen

figure, axes = plt.subplots()
for across in (0.0, 0.01, 0.05, 0.2):
    scene = rodgen.Scene.example("euler_column").replace({"loads.tip.x": across})
    switch = 1 if across == 0 else None
    branch = rodgen.continue_equilibria(scene, "loads.tip.y", (0, -5), branch_point=switch)
    axes.plot(-branch.value, abs(branch.tip[:, 0]), label=f"{across:g} N across")
axes.set(xlabel="load [N]", ylabel="deflection of the tip [m]")
axes.legend()
