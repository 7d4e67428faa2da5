"""The rods of the thesis as scenes, with what it leaves open named as assumptions."""

from __future__ import annotations

from typing import Any, TypedDict

from rodgen.scene import Scene


class Beam(TypedDict):
    """Length [m], bending stiffness EI [N m^2] and mass [kg] of a rod."""

    length: float
    bending_stiffness: float
    mass: float


# 3.1: the steel rod of tables 3.1 and 3.2.
AREA, SECOND_MOMENT, MODULUS = 0.001, 8.33e-9, 210e9  # m^2, m^4, Pa
STEEL = Beam(length=2.0, bending_stiffness=MODULUS * SECOND_MOMENT, mass=15.7)
STEP, SPAN = 8e-4, 50.0  # s

# 3.2 and 3.3: the long rod.
LENGTH, STIFFNESS = 5.0, 100.0  # m, N m^2
WEIGHED = 0.05  # kg, 3.2
WATCHED = 200.0  # s, 3.3.1

# Assumed. 3.2's "50 g" taken as 50 kg is the one round mass with which four of the five largest
# steps of the semi-implicit Euler method in table 4.1 come out as they are printed.
MASS = 50.0  # kg
LONG = Beam(length=LENGTH, bending_stiffness=STIFFNESS, mass=MASS)
# Assumed: the section of 3.1 for the rod of 3.3, EA = EI A/I.
AXIAL_STIFFNESS = STIFFNESS * AREA / SECOND_MOMENT  # N


def steel_rod(links: int, boundary: str, phi: str | None = None, **integrate: Any) -> Scene:
    """The rod of 3.1, bent at the start by phi, an expression in s."""
    return Scene.from_dict(
        {
            "name": f"steel_{boundary}_{links}",
            "rod": {**STEEL, "links": links, "boundary": boundary},
            "initial": {} if phi is None else {"phi": phi},
            "integrate": integrate,
        }
    )


def long_rod(
    links: int,
    boundary: str = "free",
    inertia: str = "uniform",
    mass: float = MASS,
    loads: dict[str, Any] | None = None,
    initial: dict[str, Any] | None = None,
    **integrate: Any,
) -> Scene:
    """The rod of 3.2 and 3.3."""
    return Scene.from_dict(
        {
            "name": f"rod_{boundary}_{links}",
            "rod": {**LONG, "links": links, "mass": mass, "inertia": inertia, "boundary": boundary},
            "loads": loads or {},
            "initial": initial or {},
            "integrate": integrate,
        }
    )


def thrust(links: int, boundary: str = "free", inertia: str = "uniform", **more: Any) -> Scene:
    """The rod of 3.3 under a follower force; more: as of `long_rod`, and force [N]."""
    force = more.pop("force", 1.0)
    return long_rod(links, boundary, inertia, loads={"follower": {"force": force}}, **more)
