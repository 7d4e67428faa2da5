"""
A nonlinear normal mode
=======================

A rod without damping has a family of periodic motions for each of its linear modes. The frequency
of such a motion changes with its energy.
"""

import matplotlib.pyplot as plt

import rodgen

scene = rodgen.Scene.from_dict(
    {
        "name": "nonlinear_mode",
        "rod": {
            "links": 5,
            "length": 1.0,
            "mass": 1.0,
            "bending_stiffness": 1.0,
            "boundary": "clamped",
        },
    }
)
family = rodgen.continue_mode(scene, 1, 2.0)

figure, axes = plt.subplots()
axes.plot(family.energy, 1 / family.period)
axes.axhline(rodgen.natural_modes(scene, count=1).frequencies[0], color="gray", linestyle=":")
axes.set(xlabel="energy [J]", ylabel="frequency [Hz]")
