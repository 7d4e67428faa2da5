"""
A rod that stands on its head
=============================

The pivot of a rod is shaken up and down. From a certain amplitude on the upright rod does not fall:
P. L. Kapitza (1951). The upper picture shows how fast small deviations grow, by Floquet
multipliers; the lower one two runs beside that amplitude, 1.5 degrees off the upright at the start.
"""

import matplotlib.pyplot as plt
import numpy as np

import rodgen

scene = rodgen.Scene.example("kapitza").replace({"initial.phi": np.pi / 2})
shakes = np.linspace(0.03, 0.042, 13)
growth = [rodgen.floquet(scene.replace({"parameters.shake": float(a)})).growth for a in shakes]

figure, (above, below) = plt.subplots(2, layout="constrained")
above.plot(shakes, growth, "o-")
above.set(xlabel="amplitude of the pivot [m]", ylabel="growth [1/s]")
for shake in (0.0355, 0.0369):
    leaning = {"parameters.shake": shake, "initial.phi": np.pi / 2 + np.radians(1.5)}
    sol = rodgen.simulate(scene.replace(leaning), span=(0, 6), progress=False)
    below.plot(sol.t, np.degrees(sol.phi[:, 0]) - 90, label=f"{shake} m")
below.set(xlabel="time [s]", ylabel="off the upright [deg]", ylim=(-5, 15))
below.legend()
