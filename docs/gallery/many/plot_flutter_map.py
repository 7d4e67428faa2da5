"""
A map of flutter
================

Where does Beck's column flutter, in the plane of force and damping? A study computes 576 points in
seconds. The boundary of stability, followed as a curve, lies on the border of the map.
"""

import matplotlib.pyplot as plt
import numpy as np

import rodgen

scene = rodgen.Scene.example("becks_column").with_links(20)
scene = scene.replace({"loads.material_damping.time": 0.01})
force, time = "loads.follower.force", "loads.material_damping.time"
data = rodgen.study(
    scene,
    {force: np.linspace(30, 130, 24), time: np.geomspace(1e-3, 3, 24)},
    analysis="modes",
    keep=["stable"],
    workers=1,
)

figure, axes = plt.subplots()
stable = data["stable"].transpose(force, time)
axes.pcolormesh(data[time], data[force], stable, cmap="RdYlBu", vmin=-0.5, vmax=1.5)
boundary = rodgen.stability_boundary(scene, (force, time), bounds=((30, 130), (1e-3, 3)))
axes.plot(boundary.b, boundary.a, "k")
axes.set(xscale="log", xlabel="time of material damping [s]", ylabel="follower force [N]")
axes.text(2e-3, 100, "flutter")
axes.text(2e-3, 33, "stable")
