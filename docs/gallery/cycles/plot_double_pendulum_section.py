"""
Poincaré section of a double pendulum
=====================================

Two rigid links swing under gravity. They are let go at rest in many ways that have the same
energy. Each time the first link hangs straight down, the second link gives a point in this
picture. Regular motions leave closed curves, and chaotic motions fill an area.
"""

import matplotlib.pyplot as plt
import numpy as np

import rodgen

down = -np.pi / 2
scene = rodgen.Scene.from_dict(
    {
        "name": "double_pendulum",
        "rod": {
            "links": 2,
            "length": 2.0,
            "mass": 2.0,
            "bending_stiffness": 0.0,
            "boundary": "pinned",
        },
        "loads": {"gravity": {}},
        "initial": {"phi": [0.0, 0.0]},
        "integrate": {"span": [0.0, 300.0], "rtol": 1e-9, "output_every": 1.0},
    }
)

figure, axes = plt.subplots()
for second in np.linspace(-2.0, 2.0, 15):
    # At rest all energy is that of height: with angles from below, 3 cos a + cos b is the same.
    first = np.arccos((3 * np.cos(1.25) + 1 - np.cos(second)) / 3)
    start = scene.replace({"initial.phi": [down + first, down + second]})
    found = rodgen.poincare_section(start, "phi_0", rising=down)
    angle = (found.phi[:, 1] - down + np.pi) % (2 * np.pi) - np.pi
    axes.plot(angle, found.omega[:, 1], ".", markersize=2)
axes.set(xlabel="angle of the second link from below [rad]", ylabel="its rate [rad/s]")
