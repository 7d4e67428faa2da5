"""
A hanging chain
===============

A heavy rod is held level at one end. The picture shows its equilibria from stiff to soft. The
softest rod hangs like a chain.
"""

import matplotlib.pyplot as plt

import rodgen

figure, axes = plt.subplots()
for stiffness in (10.0, 1.0, 0.1, 0.01):
    scene = rodgen.Scene.from_dict(
        {
            "name": "hanging",
            "rod": {
                "links": 40,
                "length": 1.0,
                "mass": 1.0,
                "bending_stiffness": stiffness,
                "boundary": "clamped",
            },
            "loads": {"gravity": {}},
        }
    )
    found = rodgen.static_equilibrium(scene)
    axes.plot(*found.joints.T, label=f"EI = {stiffness:g} N m²")
axes.set(aspect="equal", xlabel="x [m]", ylabel="y [m]")
axes.legend()
