"""The critical follower force, by the eigenvalues of the linearised scene."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rodgen.analyse.errors import AnalysisError
from rodgen.analyse.family import BASIS, GROWS, MOST_DENSE, Family
from rodgen.analyse.guarded import guarded
from rodgen.analyse.onset import At, Onset, onset, turning_onset
from rodgen.analyse.pencil import Pencil
from rodgen.analyse.system import System
from rodgen.integrate.stepper import Array
from rodgen.scene import Scene, SceneError
from rodgen.scene.mesh import mesh_notes
from rodgen.scene.scene import check_scene

HIGHEST = 1000.0  # EI/L^2: ten times what a free rod bears
FINE, COARSE = 0.5, 0.01  # step of the search: EI/L^2, and of the force
LEAST = 200  # forces at which a range is searched
GROWS_DAMPED = 1e-11  # of the lowest frequency: less is rounding
NEAR = 1e-3  # of a force, within which a search in a few modes has found it
SLOW = 0.01  # of the lowest frequency
CHECKED = (0.4, 0.7, 0.9, 0.99)  # of the force, where all modes are looked at
FLUTTER, DIVERGENCE = "flutter", "divergence"


@dataclass(frozen=True)
class Critical:
    """Where the steady state loses its stability as the follower force grows.

    force [N]; factor: force L^2/EI; kind: "flutter", frequency [Hz] at onset, or "divergence",
    frequency zero; modes: the two whose frequencies meet, or, with damping, the one that grows and
    the one next to it in frequency, counted from 1 by frequency just below the force, rigid-body
    motions apart; a mode that diverges, or that alone oscillates, is named
    twice. error: of the force, rounding apart [N];
    searched: range of forces that was looked at [N], up to the onset, and at how many of them;
    state: what grows unstable; complete: whether all modes were looked at below the force (at four
    forces), or the lowest 16 alone; t: the time at which the other loads are taken [s]; notes: on
    damping that belongs to the number of links.
    """

    force: float
    factor: float
    kind: str
    frequency: float
    modes: tuple[int, int]
    turning: float
    error: float
    searched: tuple[float, float, int]
    state: str
    complete: bool
    t: float
    notes: tuple[str, ...] = ()


@guarded
def critical_force(
    scene: Scene,
    *,
    lowest: float = 0.0,
    highest: float | None = None,
    t: float | None = None,
) -> Critical:
    """The smallest follower force above ``lowest`` [N] at which small motions begin to grow.

    highest: where the search ends [N], by default 1000 EI/L^2; t: time whose other loads are taken
    [s], by default the end of the span. The force of the scene itself is not used. A range of
    forces is searched in the lowest 16 modes, in steps of EI/(2 L^2) or 1 %; what is found there
    is solved for with all links, to about ten digits. Internal damping counts as the scene has it
    (a little of it can lower the force much), external damping as for motions across a rod that
    does not move along itself. Raises SceneError for a scene without a follower force,
    AnalysisError where no steady state exists or none loses its stability in the range.
    """
    family = family_of(scene, t)
    unit = family.unit
    highest = HIGHEST * unit if highest is None else highest
    if not family.whole:
        raise AnalysisError("no mode can become unstable: all motions move the rod as a whole")
    if not np.isfinite(lowest):
        raise SceneError("lowest", lowest, "a finite force")
    if not (np.isfinite(highest) and lowest < highest):
        raise SceneError("highest", highest, f"a force above lowest = {lowest:g} N")
    forces = grid(lowest, highest, unit)
    complete = family.system.cells <= MOST_DENSE
    found = _refined(family, forces, complete)
    looked = forces[: int(np.searchsorted(forces, found.force)) + 1]
    rod = family.system.scene.rod
    return Critical(
        force=found.force,
        factor=found.force * rod.length**2 / rod.bending_stiffness,
        kind=FLUTTER if found.s else DIVERGENCE,
        frequency=found.s.imag / (2 * np.pi),
        modes=_pair(family, found, family.whole if complete else BASIS),
        turning=family.turning(found.force),
        error=found.error,
        searched=(float(lowest), float(looked[-1]), len(looked)),
        state=family.state(found.force).words,
        complete=complete,
        t=family.system.t,
        notes=mesh_notes(scene),
    )


def family_of(scene: Scene, t: float | None = None) -> Family:
    """The linearised scene for every follower force. Raises SceneError, AnalysisError."""
    check_scene(scene)
    if scene.loads.follower is None:
        allowed = "a table with a force (which is itself not used): its critical value is asked for"
        raise SceneError("loads.follower", None, allowed)
    if scene.rod.bending_stiffness == 0:
        raise SceneError("rod.bending_stiffness", 0.0, "positive: a chain bears no thrust")
    given = scene.model_dump(exclude_none=True)
    given["loads"]["follower"]["force"] = 0.0
    system = System.of(Scene.from_dict(given), t)
    return Family(system, scene.rod.bending_stiffness / scene.rod.length**2)


def grid(lowest: float, highest: float, unit: float) -> Array:
    """Forces from lowest to highest, closer together where they are small."""
    most = (highest - lowest) / LEAST
    forces = [lowest]
    while forces[-1] < highest:
        forces.append(forces[-1] + min(most, max(FINE * unit, COARSE * abs(forces[-1]))))
    return np.array([*forces[:-1], highest])


def _growth(family: Family, forces: Array, modes: int) -> Array:
    """The largest growth [1/s] under every force, motions of the rod as a whole apart."""
    growth = family.elastic(forces, modes).real
    return np.asarray(np.nan_to_num(growth, nan=-np.inf).max(axis=-1))


def _unstable(family: Family, forces: Array, modes: int) -> Array:
    limit = (GROWS_DAMPED if family.damped else GROWS) * family.lowest
    return np.asarray(_growth(family, forces, modes) > limit)


def _search(family: Family, forces: Array, modes: int) -> Onset:
    """The first force of a range from which a motion grows, roughly."""
    low = float(forces[0])
    if _unstable(family, forces[:1], modes)[0]:
        raise AnalysisError(
            f"unstable already at the lowest force of the search, {low:g} N: a motion grows with "
            f"{_growth(family, forces[:1], modes)[0]:.3g} 1/s"
        )
    for block in np.array_split(forces[1:], max(1, len(forces) // 64)):
        unstable = _unstable(family, block, modes)
        if unstable.any():
            at = int(np.argmax(unstable))
            before = low if at == 0 else float(block[at - 1])
            return _between(family, before, float(block[at]), modes)
        low = float(block[-1])
    raise AnalysisError(
        f"neither flutter nor divergence between {forces[0]:g} and {forces[-1]:g} N "
        f"({len(forces)} forces, the lowest {min(modes, family.whole)} modes)"
    )


def _between(family: Family, low: float, high: float, modes: int) -> Onset:
    """Bisection to a part in a million, in the basis."""
    while high - low > 1e-6 * max(abs(high), abs(low)):
        middle = (low + high) / 2
        if _unstable(family, np.array([middle]), modes)[0]:
            high = middle
        else:
            low = middle
    s = family.elastic(np.array([high]), modes)[0]
    grown = s[np.nanargmax(s.real)]
    # Just beyond divergence a rate is real; with damping flutter has an imaginary part.
    return Onset(high, 0j if abs(grown.imag) <= abs(grown.real) else 1j * abs(grown.imag))


def _refined(family: Family, forces: Array, complete: bool) -> Onset:
    """With all links, from a search in a few modes; with all modes where those did not do, or
    where the others show an onset at a lower force."""
    near = _search(family, forces, BASIS)
    if not complete:
        return _onset(family, near)
    try:
        found = _onset(family, near)
    except AnalysisError:
        return _onset(family, _search(family, forces, family.whole))
    below = forces[0] + np.array(CHECKED) * (found.force - forces[0])
    unstable = _unstable(family, below, family.whole)
    if not unstable.any():
        return found
    until = below[int(np.argmax(unstable))]
    every = np.append(forces[forces < until], until)
    return _onset(family, _search(family, every, family.whole))


def _onset(family: Family, near: Onset) -> Onset:
    """Of a pinned rod whose turning is damped from outside, a real eigenvalue reaches zero beside
    the one that is zero always: a matter of damping, not of stiffness alone."""
    turns = family.bare is not None and not family.system.base
    if near.s == 0 and turns and not family.diverges(near.force * (1 + NEAR)):
        return turning_onset(family.at, near)
    return onset(_equations(family, near), near)


def _equations(family: Family, near: Onset) -> At:
    """Where almost nothing oscillates, turning the whole rod would be next to singular too."""
    slow = abs(near.s) < SLOW * family.lowest and isinstance(family.at(near.force), Pencil)
    return family.held if near.s == 0 or slow else family.at


def _pair(family: Family, found: Onset, modes: int) -> tuple[int, int]:
    """Numbers of the modes, by frequency just below the force."""
    s = family.rates(np.array([found.force * (1 - 1e-5)]), modes)[0]
    rates = np.sort(s.imag[s.imag > family.rigid])
    if not found.s or len(rates) < 2:
        return 1, 1
    nearest = np.argsort(np.abs(rates - found.s.imag))[:2] + 1
    first, second = sorted(int(at) for at in nearest)
    return first, second
