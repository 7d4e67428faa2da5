"""The Runge-Kutta method as the thesis's Java has it.

With q positions, v velocities, a(q, v) accelerations at the time t at which the step starts:

    a1 = a(q, v)
    a2 = a(q + h v2, v2),  v2 = v + h/2 a1
    a3 = a(q + h v3, v3),  v3 = v + h/2 a2
    a4 = a(q + h v4, v4),  v4 = v + h a3
    v(t + h) = v + h/6 (a1 + 2 a2 + 2 a3 + a4),    q(t + h) = q + h v(t + h)

Halved accelerations are carried over the whole step, positions by velocities that are updated
already: no stage is at a midpoint, and (1.84), of order 4, is another method (see rk4). A free
oscillation of frequency omega is damped as by the ratio 5/12 h omega.
"""

from dataclasses import replace

from rodgen.model.method import Method
from rodgen.model.methods.rk4 import TABLEAU

METHOD = Method(
    place=4,
    order=1,
    steps="fixed",
    about="as the listing of the thesis advances the state",
    citation="thesis 4.1.3, appendix A",
    tableau=replace(TABLEAU, c=(0, 0, 0, 0), follow=True),
)
