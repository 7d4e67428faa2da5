"""Doubts about a rod in the air, beyond what its forces know."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from rodgen.errors import shorten
from rodgen.integrate.quantity_formulas import Motion
from rodgen.model.terms import TERMS, describe
from rodgen.result import Note, doubt
from rodgen.scene import Scene
from rodgen.scene.air_table import DENSITY, STALL_ANGLE
from rodgen.scene.standard_atmosphere import HIGHEST

FAST = 0.8  # Mach number from which the air is compressed by more than its forces know
SLOW = 0.1  # of the largest airspeed: slower, the air pushes too little to be looked at


def air_doubts(scene: Scene, motion: Motion) -> Iterator[Note]:
    """Yield the doubts about the states of a motion: about the speed of sound, and angles at which
    the flow stalls."""
    table, places = scene.air, scene.loads.air_places
    if table is None or not places or not motion.t.size:
        return
    speeds = {name: motion.values(f"airspeed_{name}") for name in places}
    heights = motion.values("joints")[..., 0, 1]
    above = float(heights.max()) + (table.height or 0.0)
    if table.is_standard and above > HIGHEST:
        text = f"it rises to {above:.6g} m above the sea, and the standard atmosphere here reaches "
        yield doubt(f"{text}{HIGHEST:g} m: its density is a guess beyond", height=above)
    yield from _density_doubts(scene, motion)
    mach = float(np.max(np.max([*speeds.values()], axis=0) / table.sound_speed(heights)))
    if mach > FAST:
        text = f"the rod flies at up to Mach {mach:.3g}: beyond {FAST:g} the air is compressed, "
        yield doubt(f"{text}which its forces leave out", mach=mach)
    beyond = {
        name: float(np.abs(attack[speeds[name] >= SLOW * speeds[name].max()]).max())
        for name in places
        if any(one.key == STALL_ANGLE.key for one in TERMS[name].parameters)
        for attack in [motion.values(f"attack_{name}")]
        if speeds[name].max() > 0
    }
    most = max(beyond, key=lambda name: beyond[name], default="")
    if most and beyond[most] > table.stall_angle:
        largest, stall = np.degrees((beyond[most], table.stall_angle))
        text = (
            f"angles of attack of up to {largest:.3g} degrees, at the {describe(most)}, beyond the "
        )
        text += f"stall angle of {stall:.3g} degrees: forces are a guess there"
        yield doubt(text, degrees=float(largest), stall=float(stall))


def _density_doubts(scene: Scene, motion: Motion) -> Iterator[Note]:
    """Yield the doubt about a density below zero."""
    paths = scene.airflow.key_paths.items()
    names = [name for name, path in paths if path[-1] == DENSITY.key]
    least = min(float(np.min(motion.values(name))) for name in names)
    if least < 0:
        given = shorten(scene.given_value(names[0]))
        text = f"air.density = {given}: it falls to {least:.3g} kg/m^3, where the air pushes back"
        yield doubt(text, density=least)
