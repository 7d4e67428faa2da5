"""
Error against run time
======================

The picture shows the error at the end of a run against its run time, for four methods on one
scene. Use such a picture to choose a method.
"""

import matplotlib.pyplot as plt

import rodgen

scene = rodgen.Scene.example("missile_conservative")
found = rodgen.work_precision(scene, seconds=4.0)

figure, axes = plt.subplots()
for method in ("dop853", "gauss", "radau", "rk4"):
    rows = [row for row in found.rows if row["who"] == "rodgen" and row["method"] == method]
    rows = [row for row in rows if not row.get("failed")]
    axes.loglog([r["seconds"] for r in rows], [r["error_phi"] for r in rows], "o-", label=method)
axes.set(xlabel="time of a run [s]", ylabel="error of the angles [rad]")
axes.legend()
