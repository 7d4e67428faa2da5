"""
A falling chain is chaotic
==========================

Ten links without stiffness fall from the level. Two chains differ by 1e-9 rad at the start, and
are at different places after a second. The largest Lyapunov exponent is the rate of this growth.
"""

# sphinx_gallery_thumbnail_path = "pictures/film_falling_chain_forgets.gif"

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.animation import FuncAnimation

import rodgen

scene = rodgen.Scene.example("falling_chain")
system = rodgen.System(scene)
y0 = np.array(system.y0)
one = rodgen.simulate(system, span=[0.0, 4.0], progress=False)
y0[0] += 1e-9
other = rodgen.simulate(system.at(y0=y0), span=[0.0, 4.0], progress=False)
found = rodgen.lyapunov_exponents(scene, count=1, span=50.0)

figure, axes = plt.subplots()
axes.semilogy(one.t, np.abs(one.phi - other.phi).max(axis=1) + 1e-17)
axes.semilogy(one.t, 1e-6 * np.exp(found.exponents[0] * (one.t - 2.3)), "k:", label="the exponent")
axes.set(xlabel="time [s]", ylabel="difference of angles [rad]", ylim=(1e-12, 1e2))
axes.legend(title=f"{found.exponents[0]:.1f} ± {found.errors[0]:.1f} 1/s")

# %%
# Both chains as a film, at the true speed. They part after three seconds.

figure, axes = plt.subplots(figsize=(6, 4))
axes.set(xlim=(-1.1, 1.1), ylim=(-1.15, 0.3), aspect="equal")
axes.set_axis_off()
figure.subplots_adjust(0, 0, 1, 1)
axes.plot(0, 0, "ko")
chains = [axes.plot([], [], color=color, linewidth=4)[0] for color in ("tab:orange", "tab:blue")]


def draw(t):
    """One frame: both chains at this time."""
    for chain, run in zip(chains, (one, other), strict=True):
        chain.set_data(*run.joints[np.searchsorted(run.t, t)].T)
    return chains


film = FuncAnimation(figure, draw, frames=np.arange(0, 4, 0.05), interval=50)
