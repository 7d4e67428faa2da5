"""Static equilibrium by Newton's method on the generated derivatives, with load stepping."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from rodgen.analyse.analysis_guard import STATIC, check_analysis_memory, guard_analysis
from rodgen.analyse.equilibrium_equations import free_directions
from rodgen.analyse.equilibrium_search import check_imperfection, find_equilibrium
from rodgen.analyse.modal import DIVERGENCE
from rodgen.analyse.small_motions import instability
from rodgen.analyse.steady_rod import TIME, StateResult, SteadyRod
from rodgen.analyse.steady_state import SteadyState
from rodgen.arrays import Array
from rodgen.display import Plottable
from rodgen.errors import InputError
from rodgen.result import (
    FLAG,
    USUAL,
    WORD,
    Note,
    Row,
    StudyStorage,
    doubt,
    format_angle,
    omit_from_tables,
)
from rodgen.scene import Scene
from rodgen.system import System

ROUNDING = 1e-15  # of the largest coordinate
NOT_KNOWN = "not known (more than 200 links, or external damping of a bent rod)"


@dataclass(frozen=True, repr=False)
class Equilibrium(StateResult, Plottable):
    """An equilibrium: the rod at rest under loads that do not change.

    y: the state (states,), in SI units; phi: angles of all n links [rad]; joints: (n+1, 2) [m];
    tip: the tail (2,) [m]; force: (n_moving, 2), in the joints before moving links, over the mass
    of a link [m/s^2]; change: last correction of Newton's method [rad] (of joint 0, over the
    length); iterations: number of Newton's corrections, for all steps of the load; stages:
    fractions of the load through which it stepped, dimensionless; instability: "divergence" if a
    small motion grows without oscillating, "flutter" if one oscillates with growing amplitude, ""
    if none grows with all damping, None where this is not known (of more than 200 links; of a bent
    rod, what external damping does beside loads that follow it); stable: the same as yes or no;
    states: added states by name, in the units of the scene; imperfection: by which it was found
    [rad], 0 without, None where all equilibria were looked for; system: the rod, with the
    loads of one time.

    Examples
    --------
    >>> import rodgen
    >>> rest = rodgen.static_equilibrium(rodgen.Scene.example("cantilever_self_weight"))
    >>> rest.stable, bool(rest.tip[1] < 0)
    (True, True)
    """

    y: Array
    phi: Array
    joints: Array
    force: Array
    tip: Array = field(init=False)
    change: float
    iterations: int
    stages: tuple[float, ...]
    stable: bool | None = field(init=False)
    instability: str | None
    states: dict[str, float] = field(default_factory=dict)
    imperfection: float | None = 0.0
    system: System = field(kw_only=True, compare=False)

    ROWS = (
        Row("tip_x", "tip x", "m", ".12g", of=lambda rest: rest._round(rest.tip[0]), kept=USUAL),
        Row("tip_y", "tip y", "m", ".12g", of=lambda rest: rest._round(rest.tip[1]), kept=USUAL),
        Row(
            "tip_angle",
            "tip angle",
            "rad",
            of=lambda rest: float(rest.phi[-1]),
            text=lambda rest: format_angle(float(rest.phi[-1])),
            kept=USUAL,
        ),
        Row(
            "start",
            "joint 0",
            "m",
            ".12g",
            of=lambda rest: [rest._round(one) for one in rest.joints[0]],
        ),
        Row(
            "phi", "angles of the links", "rad", text=omit_from_tables, kept=StudyStorage(several=4)
        ),
        Row("states", "{}", format=".12g"),
        Row(
            "iterations",
            "Newton iterations",
            text=lambda rest: f"{rest.iterations}, the last correction {rest.change:.1e} rad",
        ),
        Row("stages", "load stages", text=lambda rest: rest._stages),
        Row("stable", "stable", text=lambda rest: rest._stable, kept=FLAG),
        Row("instability", "instability", text=omit_from_tables, kept=replace(WORD, usual=False)),
        *TIME,
    )

    def __post_init__(self) -> None:
        object.__setattr__(self, "tip", self.joints[-1])
        stable = None if self.instability is None else not self.instability
        object.__setattr__(self, "stable", stable)

    def _round(self, value: float) -> float:
        """Round a coordinate [m] to zero where it is rounding."""
        return float(value) if abs(value) >= ROUNDING * np.abs(self.joints).max() else 0.0

    @property
    def notes(self) -> tuple[Note, ...]:  # type: ignore[override]  # a field of other results
        """Doubt about an unstable equilibrium, and how a stable one beside it is found."""
        if not self.instability or self.imperfection is None:
            return ()
        words = f"this equilibrium is unstable ({self.instability}): small motions about it grow"
        if self.instability == DIVERGENCE:
            larger = "a larger imperfection" if self.imperfection else "imperfection 0.01"
            words += f"; {larger} looks for a stable one beside it"
        return (doubt(words),)

    @property
    def _stages(self) -> str:
        count = len(self.stages)
        return str(count) if count > 1 else "1 (the whole load at once)"

    @property
    def _stable(self) -> str:
        if self.instability:
            return f"NO ({self.instability})"
        return NOT_KNOWN if self.stable is None else "yes"

    def __repr__(self) -> str:
        x, y = self.tip
        known = "stability not known" if self.stable is None else "stable"
        how = f"unstable ({self.instability})" if self.instability else known
        return f"<Equilibrium of {self.scene.name}: tail at ({x:.6g}, {y:.6g}) m; {how}>"


@guard_analysis
def static_equilibrium(
    system: System | Scene, *, t: float | None = None, imperfection: float | None = None
) -> Equilibrium:
    """Return the equilibrium that a rod reaches as its loads grow from zero: from straight, or from
    the shape of `rest_curvature`.

    A pinned rod hangs from its pivot. A free rod rests where [[supports]], a [foundation] or loads
    that follow its place hold it. In a direction in which nothing holds it, it stays at its start.
    Loads that follow the motion, and added states, are at rest with the rod. The tip is right to
    about 1e-10 of the length at a few hundred links.

    Parameters
    ----------
    system
        The scene, or a System.
    t
        Time whose loads are taken [s]; by default the start of the scene's span.
    imperfection
        An angle [rad], above 0 and at most 1. The unloaded rod is bent evenly, so that its tail
        turns by this angle. Then the loads grow, and in the end the bend is removed. The result is
        an equilibrium of the scene's own rod: beyond a buckling load the bent and stable one (to
        the left). Without imperfection it is the straight and unstable one.

    Returns
    -------
    Equilibrium
        The state, the places of the joints (n + 1, 2) [m], and whether it is stable.

    Raises
    ------
    InputError
        For a free rod that nothing holds, and an imperfection out of range.
    AnalysisError
        If no equilibrium is found, with the reason.

    Examples
    --------
    >>> import rodgen
    >>> found = rodgen.static_equilibrium(rodgen.Scene.example("cantilever_self_weight"))
    >>> found.stable, found.joints.shape[1]
    (True, 2)
    """
    bend = 0.0 if imperfection is None else check_imperfection(imperfection)
    system = System.of(system)
    check_analysis_memory(STATIC, system)
    rod = SteadyRod.of(system, t)
    p = rod.system.p
    if rod.n_base:
        _check_support(rod, p)
    rest, stages = find_equilibrium(rod, p, bend=bend)
    state = SteadyState(rod, rest.at, p)
    return equilibrium_of(state, rest.iterations, rest.change, stages, bend)


def equilibrium_of(
    state: SteadyState,
    iterations: int,
    change: float = 0.0,
    stages: tuple[float, ...] = (1.0,),
    imperfection: float | None = None,
) -> Equilibrium:
    """Convert a steady state to an Equilibrium, with what is known of Newton's method."""
    rod, y = state.rod, state.y
    return Equilibrium(
        y=y,
        phi=rod.all_angles(state.phi),
        joints=rod.model.joints(y, state.p),
        force=state.joint_forces,
        change=change,
        iterations=iterations,
        stages=stages,
        instability=instability(state),
        states=dict(zip(rod.system.structure.state_names, state.at.added.tolist(), strict=True)),
        imperfection=imperfection,
        system=rod.system,
    )


def _check_support(rod: SteadyRod, p: Array) -> None:
    """Raise InputError for a free rod that nothing holds in place."""
    follows = rod.has_supports or rod.has_feedback  # else it need not be found out
    start = rod.unknowns_at_rest(rod.unloaded_angles, strict=False)
    if not follows or len(free_directions(rod, start, p)) == rod.n_base:
        allowed = "clamped, cantilever or pinned: nothing holds a free rod in place without "
        allowed += "[[supports]], [foundation] or loads that follow its place; of [[stops]] and "
        allowed += "[[walls]] those that it presses where it begins (`initial`)"
        raise InputError("rod.boundary", rod.system.structure.boundary, allowed)
