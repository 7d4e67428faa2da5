"""
Shapes and multipliers of a limit cycle
=======================================

Beyond flutter Beck's column swings on a limit cycle. The picture shows the rod at nine times of
one period, and the Floquet multipliers. All multipliers but one lie in the unit circle, so the
cycle is stable. One multiplier is 1: it belongs to a shift in time.
"""

# sphinx_gallery_thumbnail_path = "pictures/film_limit_cycle.gif"

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.animation import FuncAnimation

import rodgen

cycle = rodgen.find_cycle(rodgen.Scene.example("beck_after_flutter"))
joints = cycle.motion.joints

figure, (strip, circle) = plt.subplots(2, figsize=(5.5, 4.5), height_ratios=(1, 2))
for number, at in enumerate(np.linspace(0, len(joints) - 1, 9).astype(int)):
    x, y = joints[at].T
    strip.plot(x + 1.6 * number, y, color="tab:blue", linewidth=2)
strip.set(aspect="equal", xlabel="time", xticks=[], title=f"one period: {cycle.period:.4f} s")
angle = np.linspace(0, 2 * np.pi, 200)
circle.plot(np.cos(angle), np.sin(angle), color="gray", linewidth=0.8)
circle.plot(cycle.multipliers.real, cycle.multipliers.imag, "o")
circle.set(aspect="equal", xlabel="real part", ylabel="imaginary part", title="multipliers")
figure.tight_layout()

# %%
# One period of the limit cycle as a film, with the path of the tip.

figure, axes = plt.subplots(figsize=(6, 4))
axes.set(xlim=(-1, 1), ylim=(-0.15, 1.15), aspect="equal")
axes.set_axis_off()
figure.subplots_adjust(0, 0, 1, 1)
axes.plot([-0.15, 0.15], [0, 0], color="black", linewidth=4)
axes.plot(*joints[:, -1].T, color="tab:orange", linewidth=1.5)
(rod,) = axes.plot([], [], color="tab:blue", linewidth=5, solid_capstyle="round")


def draw(at):
    """One frame: the rod."""
    rod.set_data(*joints[at].T)
    return (rod,)


frames = np.linspace(0, len(joints) - 1, 31).astype(int)[:-1]
film = FuncAnimation(figure, draw, frames=frames, interval=50)
