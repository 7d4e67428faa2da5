"""
A whip
======

A rod is held at one end and gets thinner towards the other. It is let go while it turns. A wave
runs to the tip, and the tip moves faster than any other part.
"""

# sphinx_gallery_thumbnail_path = "pictures/film_whip.gif"

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.animation import FuncAnimation

import rodgen

scene = rodgen.Scene.from_dict(
    {
        "name": "whip",
        "rod": {
            "links": 30,
            "length": 1.0,
            "mass_per_length": "0.5*(1 - 0.95*s)**2",
            "bending_stiffness": "2e-3*(1 - 0.95*s)**4",
            "boundary": "pinned",
        },
        "initial": {"phi": "3*s*s", "omega": "30*(1 - s)**4"},
        "integrate": {"span": [0.0, 0.24], "output_every": 0.0005},
    }
)
sol = rodgen.simulate(scene, rtol=1e-6, progress=False)
speed = np.linalg.norm(np.gradient(sol.joints[:, -1], sol.t, axis=0), axis=1)

figure, (shapes, speeds) = plt.subplots(2, figsize=(6, 7))
for at in range(0, len(sol.t), 24):
    shapes.plot(*sol.joints[at].T, color=plt.cm.viridis(at / len(sol.t)))
shapes.set(aspect="equal")
speeds.plot(sol.t, speed)
speeds.set(xlabel="time [s]", ylabel="speed of the tip [m/s]")

# %%
# The same motion as a film, twenty times slower.

figure, axes = plt.subplots(figsize=(6, 4))
axes.set(xlim=(-1, 1), ylim=(-0.5, 1), aspect="equal")
axes.set_axis_off()
figure.subplots_adjust(0, 0, 1, 1)
(rod,) = axes.plot([], [], color="tab:blue", linewidth=3, solid_capstyle="round")


def draw(at):
    """One frame: the rod."""
    rod.set_data(*sol.joints[at].T)
    return (rod,)


film = FuncAnimation(figure, draw, frames=range(0, len(sol.t), 5), interval=50)
