"""
What a digit costs
==================

Error at the end of a run against the time that it takes, for four methods on one scene: the
picture by which a method is chosen.
"""

import matplotlib.pyplot as plt

import rodgen

scene = rodgen.Scene.example("missile_conservative")
found = rodgen.work_precision(scene, seconds=6.0)

figure, axes = plt.subplots()
for method in ("dop853", "gauss", "radau", "rk4"):
    rows = [row for row in found.rows if row["who"] == "rodgen" and row["method"] == method]
    rows = [row for row in rows if not row.get("failed")]
    axes.loglog([r["seconds"] for r in rows], [r["error_phi"] for r in rows], "o-", label=method)
axes.set(xlabel="time of a run [s]", ylabel="error of the angles [rad]")
axes.legend()
