"""
Whitney's umbrella
==================

Ziegler's pendulum has internal and external damping. Each curve shows where it begins to flutter,
for one force. Below the load without damping, 18.77 N, the curves run into the origin. Above it
they pass by. The curves are sections of a surface. Where both dampings vanish, this surface has
the singular point that H. Whitney described in 1944.
"""

import matplotlib.pyplot as plt

import rodgen

internal, external = "loads.internal_damping.coefficient", "loads.external_damping.coefficient"
scene = rodgen.Scene.example("ziegler").replace(
    {"rod.length": 1.0, "rod.mass": 1.0, internal: 0.0, external: 0.0}
)

figure, axes = plt.subplots()
for force in (15.0, 16.0, 17.0, 18.0, 18.5, 18.77, 19.5, 20.5):
    pushed = scene.replace({"loads.follower.force": force})
    line = rodgen.stability_boundary(pushed, (internal, external))
    axes.plot(line.a, line.b, label=f"{force:g} N")
axes.set(xlim=(0, 1), ylim=(0, 3.5), xlabel="internal damping [m²/s]", ylabel="external [1/s]")
axes.legend()
