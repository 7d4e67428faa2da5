"""What a user would evaluate the rates with instead: the free uniform rod under thrust.

Every function of RATES makes a Prepared for a number of links; it raises ImportError where its
library is not installed, ValueError where so many links are too many.
"""

from __future__ import annotations

_HERE = "rodgen.judge.peers.rates."

# Name -> module and function(links).
RATES: dict[str, tuple[str, str]] = {
    "CasADi, generated C": (_HERE + "casadi_c", "prepare"),
    "Numba, by hand": (_HERE + "numba_chain", "prepare"),
    "MuJoCo, mj_forward": (_HERE + "mujoco_forward", "prepare"),
    "Pinocchio, aba": (_HERE + "pinocchio_aba", "prepare"),
    "PyDy, Kane to Cython": (_HERE + "pydy_kane", "prepare"),
}
