"""
Parametric resonance
====================

A column under a pulsating load shakes if the load has twice the frequency of a mode. In this
region, called a tongue, the periodic motion has a multiplier beyond 1.
"""

import matplotlib.pyplot as plt
import numpy as np

import rodgen

scene = rodgen.Scene.from_dict(
    {
        "name": "pulsating",
        "rod": {
            "links": 3,
            "length": 1.0,
            "mass": 1.0,
            "bending_stiffness": 1.0,
            "boundary": "clamped",
        },
        "parameters": {"amplitude": 0.5, "frequency": 7.0},
        "loads": {"tip": {"x": "-0.5 - amplitude*cos(frequency*t)"}},
        "integrate": {"span": [0.0, 1.0]},
    }
)
still = scene.replace({"parameters.amplitude": 0.0})
first = 2 * np.pi * rodgen.natural_modes(still, count=1).frequencies[0]
data = rodgen.study(
    scene,
    {
        "parameters.frequency": np.linspace(0.6, 2.4, 25) * first,
        "parameters.amplitude": np.linspace(0.02, 1.0, 8),
    },
    analysis="floquet",
    keep=["growth"],
    workers=1,
)

figure, axes = plt.subplots()
growth = data["growth"].transpose("parameters.amplitude", "parameters.frequency")
shown = axes.pcolormesh(
    data["parameters.frequency"] / first, data["parameters.amplitude"], growth, cmap="Reds"
)
axes.set(xlabel="frequency of the load / first frequency", ylabel="amplitude [N]")
figure.colorbar(shown, label="growth [1/s]")
