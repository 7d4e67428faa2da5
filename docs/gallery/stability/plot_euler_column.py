"""
Euler's column: branches of equilibria
======================================

A column under a dead load stays straight up to its first buckling load. There two bent branches
leave the straight branch, which goes on, unstable (dashed). The branch points are located to ten
digits.
"""

import matplotlib.pyplot as plt
import numpy as np

import rodgen

scene = rodgen.Scene.example("euler_column")
straight = rodgen.continue_equilibria(scene, "loads.tip.y", (0, -30))
bent = rodgen.continue_equilibria(scene, "loads.tip.y", (0, -30), branch_point=1)

figure, axes = plt.subplots()
for branch in (straight, bent):
    load, tip = -branch.value.values, branch.tip.values[:, 0]
    stable = branch.unstable.values == 0
    axes.plot(np.where(stable, load, np.nan), tip, color="tab:blue")
    axes.plot(np.where(stable, np.nan, load), tip, color="tab:blue", linestyle="--")
for value in straight.special_value.values:
    axes.plot(-value, 0, "o", color="tab:red")
axes.set(xlabel="load [EI/L²]", ylabel="deflection of the tip [L]")
