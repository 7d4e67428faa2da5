"""
Flutter sets in
===============

A clamped column is pushed by a force that turns with its tip, as an engine does. The force grows
slowly from nothing. At first the column swings to rest; beyond the critical load, near 11 EI/L²
with this material damping, the same small disturbance grows into a flutter.
"""

# sphinx_gallery_thumbnail_path = "pictures/film_flutter_sets_in.gif"

import matplotlib.pyplot as plt
from matplotlib.animation import FuncAnimation

import rodgen

scene = rodgen.Scene.from_dict(
    {
        "name": "flutter_sets_in",
        "rod": {
            "links": 20,
            "length": 1.0,
            "mass": 1.0,
            "bending_stiffness": 1.0,
            "boundary": "clamped",
        },
        "loads": {
            "follower": {"force": "20*min(t/20, 1)", "angle": 0.01},
            "material_damping": {"time": 0.01},
        },
        "initial": {"phi": "0.1*s"},
        "integrate": {"span": [0.0, 25.0], "output_every": 0.05},
    }
)
sol = rodgen.simulate(scene, rtol=1e-6, progress=False)

figure, axes = plt.subplots(figsize=(6, 3.6))
axes.set(xlim=(-0.2, 1.3), ylim=(-0.8, 0.8), aspect="equal")
axes.set_axis_off()
figure.subplots_adjust(0, 0, 1, 1)
(rod,) = axes.plot([], [], color="tab:blue", linewidth=4, solid_capstyle="round")
(trail,) = axes.plot([], [], color="tab:blue", linewidth=0.8, alpha=0.4)
force = axes.annotate("", (1, 0), (1.2, 0), arrowprops={"arrowstyle": "-|>", "color": "tab:red"})
text = axes.text(0.0, 0.65, "")
joints = sol.joints


def draw(at):
    """One frame: the rod, where its tip has been, and the force."""
    x, y = joints[at].T
    rod.set_data(x, y)
    trail.set_data(*joints[max(0, at - 20) : at + 1, -1].T)
    size = min(sol.t[at], 20.0)
    direction = (joints[at, -1] - joints[at, -2]) * scene.rod.links
    force.xy = joints[at, -1]
    force.set_position(joints[at, -1] + 0.02 * size * direction)
    text.set_text(f"force {size:.1f} EI/L²")
    return rod, trail, force, text


film = FuncAnimation(figure, draw, frames=range(0, len(sol.t), 2), interval=50)
