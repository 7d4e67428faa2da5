"""
A limit cycle, as a strip of shapes
===================================

Beyond flutter Beck's column swings on a limit cycle. Here is the rod at twelve times of one
period, and the multipliers that say that the cycle is stable: all lie in the unit circle, but for
the one that belongs to a shift in time.
"""

import matplotlib.pyplot as plt
import numpy as np

import rodgen

cycle = rodgen.find_cycle(rodgen.Scene.example("beck_after_flutter"))
joints = cycle.motion.joints

figure, (strip, circle) = plt.subplots(2, figsize=(8, 6), height_ratios=(1, 2))
for number, at in enumerate(np.linspace(0, len(joints) - 1, 9).astype(int)):
    x, y = joints[at].T
    strip.plot(x + 1.6 * number, y, color="tab:blue", linewidth=2)
strip.set(aspect="equal", xlabel="time", xticks=[], title=f"one period: {cycle.period:.4f} s")
angle = np.linspace(0, 2 * np.pi, 200)
circle.plot(np.cos(angle), np.sin(angle), color="gray", linewidth=0.8)
circle.plot(cycle.multipliers.real, cycle.multipliers.imag, "o")
circle.set(aspect="equal", xlabel="real part", ylabel="imaginary part", title="multipliers")
figure.tight_layout()
