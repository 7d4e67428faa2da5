"""
A rod on an elastic foundation
==============================

A clamped rod stands on springs along its whole length. With a stiffer foundation the natural
frequencies rise, the lowest ones most.
"""

import matplotlib.pyplot as plt
import numpy as np

import rodgen

scene = rodgen.Scene.from_dict(
    {
        "name": "on_a_foundation",
        "rod": {
            "links": 30,
            "length": 1.0,
            "mass": 1.0,
            "bending_stiffness": 1.0,
            "boundary": "clamped",
        },
        "foundation": {"stiffness": 1.0},
    }
)
stiffness = np.geomspace(1, 1e5, 26)
data = rodgen.study(
    scene, {"foundation.stiffness": stiffness}, analysis="modes", keep=["frequencies(4)"], workers=1
)

figure, axes = plt.subplots()
axes.loglog(stiffness, data["frequencies(4)"])
axes.set(xlabel="stiffness of the foundation [N/m²]", ylabel="frequency [Hz]")
