"""
Natural frequencies from a run
==============================

The spectrum of a motion shows the natural frequencies. Lines are the frequencies of the linearised
equations.
"""

import matplotlib.pyplot as plt

import rodgen

scene = rodgen.Scene.from_dict(
    {
        "name": "ringing",
        "rod": {"links": 20, "length": 1.0, "mass": 1.0, "bending_stiffness": 1.0},
        "initial": {"phi": "1e-3*s**3"},
        "integrate": {"span": [0.0, 30.0], "output_every": 0.002},
    }
)
found = rodgen.spectrum(rodgen.simulate(scene, progress=False))

figure, axes = plt.subplots()
axes.semilogy(found.bins, found.density)
for frequency in rodgen.natural_modes(scene, count=4).frequencies:
    axes.axvline(frequency, color="tab:red", linewidth=0.8, linestyle=":")
axes.set(xlim=(0, 40), ylim=(1e-22, None), xlabel="frequency [Hz]", ylabel="density [m²/Hz]")
