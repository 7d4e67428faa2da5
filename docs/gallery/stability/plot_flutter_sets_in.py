"""
Onset of flutter
================

A clamped column is pushed by a force that turns with its tip, like the thrust of an engine. The
force grows slowly. At first a small swing dies out. Beyond the critical load it grows into flutter.
Without damping it would flutter from 19.9 EI/L² on; a little internal damping takes almost half.
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
            "follower": {"force": "9 + 0.5*t", "angle": 0.01},
            "material_damping": {"time": 0.01},
        },
        "initial": {"phi": "0.1*s"},
        "integrate": {"span": [0.0, 20.0], "output_every": 0.05},
    }
)
sol = rodgen.simulate(scene, rtol=1e-6, progress=False)
critical = rodgen.critical_load(scene).value
force, joints = 9 + 0.5 * sol.t, sol.joints

figure, (column, curve) = plt.subplots(1, 2, figsize=(6.4, 2.8))
figure.subplots_adjust(0.01, 0.1, 0.98, 0.96, 0.1)
column.set(xlim=(-0.1, 1.4), ylim=(-0.8, 0.8), aspect="equal")
column.set_axis_off()
(rod,) = column.plot([], [], color="tab:blue", linewidth=5, solid_capstyle="round")
(trail,) = column.plot([], [], color="tab:blue", linewidth=1, alpha=0.4)
column.plot([0, 0], [-0.15, 0.15], color="black", linewidth=4)
arrow = column.annotate(
    "", (1, 0), (1.2, 0), arrowprops={"arrowstyle": "-|>", "color": "tab:red", "linewidth": 2}
)
curve.set(xlim=(9, 19), ylim=(-0.8, 0.8), xticks=(), yticks=())
curve.set(xlabel="force", ylabel="deflection of the tip")
curve.axvline(critical, color="tab:red", linestyle="--")
damping = scene.parameters["material_damping_time"]
curve.text(critical + 0.2, 0.65, f"critical: {critical:.1f} EI/L²", color="tab:red")
curve.text(critical + 0.2, 0.5, f"20 links, damping {damping:g} s", color="tab:red")
(swing,) = curve.plot([], [], color="tab:blue", linewidth=1)


def draw(at):
    """One frame: the rod, where its tip has been, the force, and the deflection so far."""
    rod.set_data(*joints[at].T)
    trail.set_data(*joints[max(0, at - 20) : at + 1, -1].T)
    direction = (joints[at, -1] - joints[at, -2]) * scene.rod.links
    arrow.xy = joints[at, -1]
    arrow.set_position(joints[at, -1] + 0.02 * force[at] * direction)
    swing.set_data(force[: at + 1], joints[: at + 1, -1, 1])
    return rod, trail, arrow, swing


film = FuncAnimation(figure, draw, frames=range(0, len(sol.t), 3), interval=60)
