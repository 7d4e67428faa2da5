"""Semi-implicit Euler: velocities first, positions with the new ones.

    v(t + h) = v + h a(t, q, v),    q(t + h) = q + h v(t + h)

Symplectic for a force that depends on the position alone and a constant mass matrix.
"""

from rodgen.model.method import Method, Tableau

METHOD = Method(
    place=2,
    order=1,
    steps="fixed",
    about="velocities first, positions with the new ones; [its energy grows](#what-keeps-energy)",
    citation="thesis 1.83",
    tableau=Tableau(A=((),), b=(1,), follow=True),
)
