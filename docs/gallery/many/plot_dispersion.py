"""
Where do two hundred launches end?
==================================

The thrust of every launch is a little misaligned, and its rod is a little heavier or lighter than
planned. A Sobol sequence gives the points. They are integrated side by side in the lanes of the
processor's vectors.
"""

import matplotlib.pyplot as plt

import rodgen

scene = rodgen.Scene.example("missile")
data = rodgen.study(
    scene,
    {
        "loads.follower.angle": {"bounds": (-0.01, 0.01)},
        "rod.mass": {"bounds": (0.95 * scene.rod.mass, 1.05 * scene.rod.mass)},
    },
    sample={"method": "sobol", "count": 256, "seed": 1},
    keep=["last(tip_x)", "last(tip_y)"],
    workers=1,
)

figure, axes = plt.subplots()
shown = axes.scatter(
    data["last(tip_x)"], data["last(tip_y)"], c=data["loads.follower.angle"], s=9, cmap="coolwarm"
)
axes.set(xlabel="x of the tail at the end [m]", ylabel="y [m]")
figure.colorbar(shown, label="angle of the thrust [rad]")
