"""
How many links does a critical load need?
=========================================

The critical load of Beck's column for 10 to 160 links converges with order 2 to 20.0509 EI/L².
Richardson's extrapolation of the same numbers gives six more digits.
"""

import matplotlib.pyplot as plt
import numpy as np

import rodgen

scene = rodgen.Scene.example("becks_column")
n = np.array([10, 20, 40, 80, 160])
loads = [rodgen.critical_load(scene.with_links(int(k))).load_parameter for k in n]
limit = rodgen.richardson(n, loads)

figure, axes = plt.subplots()
axes.loglog(n, np.abs(np.array(loads) - limit.value), "o-", label="n links")
axes.loglog(n, 20.0 / n**2, "k:", label="order 2")
axes.axhline(limit.error, color="tab:red", label=f"extrapolated: {limit.value:.7f}")
axes.set(xlabel="number of links", ylabel="error of the critical load [EI/L²]")
axes.legend()
