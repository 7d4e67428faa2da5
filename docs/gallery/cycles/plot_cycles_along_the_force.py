"""
How a limit cycle grows with the force
======================================

This is the branch of limit cycles of Beck's column, from the Hopf point where flutter begins to
large amplitudes. Stable cycles are solid.
"""

import matplotlib.pyplot as plt
import numpy as np

import rodgen

scene = rodgen.Scene.example("beck_after_flutter")
branch = rodgen.continue_cycles(scene, "loads.follower.force", (8, 20), step=0.2)
stable = branch.unstable.values == 0

figure, axes = plt.subplots()
force, size = branch.value.values, branch.amplitude.values
axes.plot(np.where(stable, force, np.nan), size, color="tab:blue")
axes.plot(np.where(stable, np.nan, force), size, color="tab:blue", linestyle="--")
axes.set(xlabel="follower force [N]", ylabel="amplitude [rad]")
