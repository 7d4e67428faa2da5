"""
Natural modes of a free rod
===========================

The four lowest bending modes of a free, uniform rod, and their frequencies beside those of the
continuous beam.
"""

# sphinx_gallery_thumbnail_path = "pictures/film_modes_of_a_rocket.gif"

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.animation import FuncAnimation

import rodgen

scene = rodgen.Scene.from_dict(
    {
        "name": "free_modes",
        "rod": {"links": 40, "length": 1.0, "mass": 1.0, "bending_stiffness": 1.0},
    }
)
modes = rodgen.natural_modes(scene, count=4)
exact = np.array([4.730040744862704, 7.853204624095838, 10.99560783800167, 14.13716549125746]) ** 2

figure, axes = plt.subplots()
s = np.linspace(0, 1, scene.rod.links + 1)
for number, shape in enumerate(modes.displacements):
    across = shape[:, 1].real / abs(shape[:, 1]).max()
    frequency = modes.frequencies[number]
    error = frequency * 2 * np.pi / exact[number] - 1
    axes.plot(s, across - 2.4 * number)
    axes.text(1.03, across[-1] - 2.4 * number, f"{frequency:.3f} Hz\noff by {error:.0e}")
axes.set(xlabel="s", yticks=[], xlim=(0, 1.3))

# %%
# The modes as a film. In truth the higher ones are faster.

figure, axes = plt.subplots(figsize=(6, 4))
axes.set(xlim=(-0.05, 1.05), ylim=(-8.6, 1.4))
axes.set_axis_off()
figure.subplots_adjust(0, 0, 1, 1)
shapes = [shape[:, 1].real / abs(shape[:, 1]).max() for shape in modes.displacements]
rods = [axes.plot(s, 0 * s, linewidth=4, solid_capstyle="round")[0] for _ in shapes]


def draw(phase):
    """One frame: every mode at this phase of its period."""
    for number, (rod, shape) in enumerate(zip(rods, shapes, strict=True)):
        rod.set_ydata(shape * np.cos(phase) - 2.4 * number)
    return rods


film = FuncAnimation(figure, draw, frames=np.linspace(0, 2 * np.pi, 41)[:-1], interval=50)
