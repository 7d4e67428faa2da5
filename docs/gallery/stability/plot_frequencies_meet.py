"""
Two frequencies meet
====================

This is flutter without damping. As the follower force grows, the first two frequencies of Beck's
column approach each other, meet, and become a pair of which one grows and one decays.
"""

import matplotlib.pyplot as plt
import numpy as np

import rodgen

scene = rodgen.Scene.example("becks_column")
forces = np.linspace(0, 1.2, 61) * rodgen.critical_load(scene).value
data = rodgen.study(
    scene,
    {"loads.follower.force": forces},
    analysis="modes",
    keep=["frequencies(2)", "growth(2)"],
    workers=1,
)

figure, (above, below) = plt.subplots(2, sharex=True)
for number in (1, 2):
    above.plot(forces, data[f"frequencies({2})"].isel(mode=number - 1), ".-")
    below.plot(forces, data[f"growth({2})"].isel(mode=number - 1), ".-")
above.set(ylabel="frequency [Hz]")
below.set(xlabel="follower force [N]", ylabel="growth [1/s]")
