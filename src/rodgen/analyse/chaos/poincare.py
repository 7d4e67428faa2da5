"""Poincaré sections: states of a motion where it crosses a surface."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from rodgen.errors import InputError
from rodgen.integrate.quantity_formulas import MotionSlice
from rodgen.integrate.simulate import simulate
from rodgen.integrate.solution import Solution
from rodgen.scene import Scene
from rodgen.scene.plain_tables import is_number, to_plain
from rodgen.system import System

if TYPE_CHECKING:
    import xarray

CROSSING = "the section"  # name of the event
WAYS = ("rising", "falling", "either")


def poincare_section(
    motion: System | Scene | Solution,
    where: str,
    *,
    rising: float | None = None,
    falling: float | None = None,
    either: float | None = None,
    transient: float = 0.0,
) -> xarray.Dataset:
    """Return the states of a motion where a quantity crosses a level.

    Crossings are found like events of a run, on its dense output. They do not depend on samples.

    Parameters
    ----------
    motion
        A scene or System, which is run over its span, or a `Solution`, whose run is repeated.
    where
        Name of the quantity, as in an event: phi_0, omega_3 or tip_y, for example.
    rising, falling, either
        One of these: the level, in the unit of the quantity, and the direction in which it is
        crossed.
    transient
        Time at the start whose crossings are left out [s].

    Returns
    -------
    xarray.Dataset
        One dimension of crossings: t [s], phi [rad], omega [rad/s], tip [m] and the whole state y.

    Raises
    ------
    InputError
        For a quantity that does not exist, or without exactly one level.
    RunError
        If the run fails.

    Examples
    --------
    A pendulum passes its lowest point once a period:

    >>> import numpy as np, rodgen
    >>> scene = rodgen.Scene.from_dict({
    ...     "name": "pendulum",
    ...     "rod": {"links": 1, "length": 1.0, "mass": 1.0, "bending_stiffness": 0.0,
    ...             "boundary": "pinned"},
    ...     "loads": {"gravity": {}},
    ...     "initial": {"phi": -1.5},
    ... })
    >>> found = rodgen.poincare_section(scene, "phi_0", rising=-np.pi / 2)
    >>> np.diff(found.t)[:3].round(3)
    array([1.638, 1.638, 1.638])
    """
    import xarray

    direction, level = _check_level(rising, falling, either)
    system = motion.system if isinstance(motion, Solution) else System.of(motion)
    events = [one.model_dump(exclude_none=True) for one in system.events]
    event = {"quantity": where, "value": level, "direction": direction, "name": CROSSING}
    watching = system.at({"events": [*events, event]})
    if isinstance(motion, Solution):
        span = [float(motion.t[0]), float(motion.t[-1])]
        run = simulate(watching.at(y0=motion.y[0]), model=motion.model, span=span)
    else:
        run = simulate(watching)
    start = float(run.t[0]) + _check_seconds(transient)
    met = [one for one in run.events if one.name == CROSSING and one.t >= start]
    t = np.array([one.t for one in met])
    y = np.array([one.y for one in met]).reshape(len(met), run.y.shape[1])
    piece = MotionSlice(run.model, run.system.p, y, t, timed=run.system.time_laws)
    data = {
        "t": ("crossing", t, {"units": "s"}),
        "phi": (("crossing", "link"), piece.values("phi"), {"units": "rad"}),
        "omega": (("crossing", "link"), piece.values("omega"), {"units": "rad/s"}),
        "tip": (("crossing", "axis"), piece.values("tip"), {"units": "m"}),
        "y": (("crossing", "state"), y),
    }
    said = {"where": where, "level": level, "direction": direction}
    return xarray.Dataset(data, {"axis": ["x", "y"]}, said)


def _check_level(*given: float | None) -> tuple[str, float]:
    """Check that one direction is given, and return it with its level."""
    levels = {
        way: to_plain(one, way) for way, one in zip(WAYS, given, strict=True) if one is not None
    }
    if len(levels) != 1:
        raise InputError(
            "section", list(levels) or None, f"one of {', '.join(WAYS)}, and its level"
        )
    ((direction, level),) = levels.items()
    if not (is_number(level) and np.isfinite(level)):
        raise InputError(direction, level, "a finite number, the level")
    return direction, float(level)


def _check_seconds(transient: float) -> float:
    made = to_plain(transient, "transient")
    if not (is_number(made) and 0 <= made < np.inf):
        raise InputError("transient", transient, "a time of at least 0 s")
    return float(made)
