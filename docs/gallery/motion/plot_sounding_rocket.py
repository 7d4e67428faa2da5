"""
A sounding rocket with a steered engine
=======================================

The rocket is a tapered tube with a payload, a tank that empties, and a gimbal with a lag that a
gyro steers. A gust hits it. The picture shows the angle of the gimbal and the largest bending
moment.
"""

import matplotlib.pyplot as plt

import rodgen

sol = rodgen.simulate(rodgen.Scene.example("sounding_rocket"), rtol=1e-5, progress=False)

figure, (above, below) = plt.subplots(2, sharex=True)
above.plot(sol.t, sol.y[:, sol.model.STATE.index("gimbal")])
above.set(ylabel="gimbal [rad]")
below.plot(sol.t, abs(sol.bending_moments).max(axis=1) / 1e3)
below.set(xlabel="time [s]", ylabel="largest moment [kN m]")
figure.tight_layout()
