"""
Ziegler's paradox
=================

A little damping lowers the flutter load of Beck's column to nearly half. The boundary is followed
through the limit of vanishing damping, which is not the value without damping.
"""

import matplotlib.pyplot as plt

import rodgen

scene = rodgen.Scene.example("becks_column").replace({"loads.material_damping.time": 0.01})
boundary = rodgen.stability_boundary(
    scene,
    ("loads.follower.force", "loads.material_damping.time"),
    bounds=(None, (0.0, 1.0)),
)

figure, axes = plt.subplots()
axes.plot(boundary.b, boundary.a)
undamped = rodgen.critical_load(rodgen.Scene.example("becks_column"))
axes.axhline(undamped.value, color="tab:red", linestyle=":", label="without damping")
axes.set(xlabel="time of material damping [s]", ylabel="critical force [N]", xlim=(0, 1))
axes.set_xscale("symlog", linthresh=1e-3)
axes.legend()
