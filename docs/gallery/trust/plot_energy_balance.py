"""
Does the energy balance?
========================

The work of every load is integrated beside the state, and the energy follows from the state by
another route. Their difference is a check of the run that costs nothing. It falls with the
tolerance.
"""

import matplotlib.pyplot as plt
import numpy as np

import rodgen

scene = rodgen.Scene.example("missile")
tolerances = np.logspace(-3, -11, 9)
errors = [
    rodgen.simulate(scene, method="dop853", rtol=rtol, progress=False).energy_error
    for rtol in tolerances
]

figure, axes = plt.subplots()
axes.loglog(tolerances, errors, "o-")
axes.set(xlabel="rtol", ylabel="error of the energy balance [J]")
