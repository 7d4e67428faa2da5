"""Tables of results, for terminals and notebooks alike."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from rodgen.analyse.chaos.exponents import Exponents
from rodgen.analyse.critical import Critical
from rodgen.analyse.cycles.cycle import Cycle
from rodgen.analyse.cycles.floquet import Floquet
from rodgen.analyse.extrapolate import Extrapolation
from rodgen.analyse.family import GROUPS, factor_of, label_of
from rodgen.analyse.fourier import Spectrum
from rodgen.analyse.growth import SimulatedCritical
from rodgen.analyse.modes import Modes
from rodgen.analyse.onset import digits
from rodgen.analyse.precision.work_precision import WorkPrecision
from rodgen.analyse.statics import Equilibrium
from rodgen.integrate import Solution
from rodgen.integrate.endings import FINISHED
from rodgen.integrate.ensemble import Ensemble
from rodgen.scene import Scene
from rodgen.scene.contents import in_words
from rodgen.show.summary import along_in_words
from rodgen.studies.study import Study

STABLE = {"": "yes", None: "not known (more than 200 links, or external damping of a bent rod)"}
ROUNDING = 1e-15  # of the largest coordinate
SHOWN = 10  # multipliers of a cycle


@dataclass(frozen=True)
class ResultTable:
    """Rows of text under the names of their columns; with two that have none, names and values."""

    columns: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]

    @classmethod
    def of_values(cls, values: Mapping[str, str]) -> ResultTable:
        """A table of names and values."""
        return cls(("", ""), tuple(values.items()))

    @classmethod
    def of_rows(cls, columns: Iterable[str], rows: Iterable[Iterable[str]]) -> ResultTable:
        """A table with a heading."""
        return cls(tuple(columns), tuple(map(tuple, rows)))


def of_equilibrium(rest: Equilibrium) -> dict[str, str]:
    """Where the tail is, and how it was found."""
    largest = abs(rest.joints).max()
    x, y, x0, y0 = (0.0 if abs(c) < ROUNDING * largest else c for c in (*rest.tip, *rest.joints[0]))
    angle = float(rest.phi[-1])
    stages = len(rest.stages)
    return {
        "tip x": f"{x:.12g} m",
        "tip y": f"{y:.12g} m",
        "tip angle": f"{angle:.12g} rad = {math.degrees(angle):.6g} degrees",
        "joint 0": f"({x0:.12g}, {y0:.12g}) m",
        **{name: f"{value:.12g}" for name, value in rest.states.items()},
        "Newton iterations": f"{rest.iterations}, the last correction {rest.change:.1e} rad",
        "load stages": str(stages) if stages > 1 else "1 (the whole load at once)",
        "stable": STABLE.get(rest.instability, f"NO ({rest.instability})"),
    }


def of_cycle(found: Cycle) -> dict[str, str]:
    """Its period, its energies, and its multipliers."""
    of = ", that of the loads" if found.forced else ""
    rows = {
        "period": f"{found.period:.12g} s{of}",
        "frequency": f"{1 / found.period:.10g} Hz",
        "amplitude of the angles": f"{found.amplitude:.8g} rad",
        "energy of y0": f"{found.energy:.10g} J",
        **{f"work of {name} a period": f"{work:.8g} J" for name, work in found.work.items()},
    }
    if found.angle:
        rows["turned after a period by"] = (
            f"{found.angle:.10g} rad = {math.degrees(found.angle):.6g} degrees"
        )
    if found.drift.any():
        rows["moved after a period by"] = f"({found.drift[0]:.8g}, {found.drift[1]:.8g}) m"
    multipliers = found.nontrivial[:SHOWN].tolist()
    for at, mu in enumerate(multipliers):
        sign = f" {'+-'[mu.imag < 0]} {abs(mu.imag):.8g} i" if mu.imag else ""
        rows[f"multiplier {at + 1}"] = f"{mu.real:.8g}{sign}   (size {abs(mu):.8g})"
    left = len(found.nontrivial) - len(multipliers)
    rows["further multipliers"] = f"{left}, smaller" if left else "none"
    if found.by == "picard":
        rows["further multipliers"] = "smaller, and not computed"
    rows["multipliers that are 1"] = f"{found.trivial}, found with an error of " * bool(
        found.trivial
    ) + (f"{found.trivial_error:.1e}" if found.trivial else "none: the loads give the phase")
    rows["stable"] = "yes" if found.stable else "NO"
    way = f"after a run of {found.after:g} s, " if found.after else ""
    way += f"by {found.by}, in {found.iterations} iterations of Newton's method"
    if not found.iterations:
        way = "on the family of a linear mode"
    rows["found"] = f"{way}; closes to {found.residual:.1e} of its size"
    return rows


def of_critical(found: Critical) -> dict[str, str]:
    """The load, what becomes of the motion there, and what was searched."""
    low, high, forces = found.searched
    first, second = found.modes
    rows = {
        f"critical {label_of(found.load)}": f"{digits(found.force, found.error)} {found.unit}",
        factor_of(found.load): digits(
            found.factor, found.error * found.factor / (found.force or 1)
        ),
        **_stiffness(found),
        "load of the scene": _applied(found),
        "load ratio": "not known" if math.isnan(found.load_ratio) else f"{found.load_ratio:.6g}",
        "kind": found.kind + ", where stability is regained" * (found.end == "lower"),
        "frequency at onset": f"{digits(found.frequency, found.frequency_error)} Hz",
        "modes": f"{first} and {second}" if first != second else str(first),
        "error, estimated": f"{found.error:.1e} {found.unit}",
        "grows from the state": found.state,
        "searched": f"{low:g} to {high:g} {found.unit} at {forces} forces",
        "modes looked at": "all" if found.complete else "the lowest 16",
    }
    if found.growth:
        rows["grows already"] = f"at {low:g} {found.unit}, with {found.growth:.4g} 1/s"
    if found.stable is not None:
        ends = [f"{a:.10g} to {b:.10g} {found.unit}" for a, b in found.stable]
        rows["stable"] = ", ".join(ends) or "nowhere in the range"
    if found.turning:
        rows["apart from that"] = f"the rod turns as a whole, with {found.turning:.4g} 1/s"
    return rows


def _applied(found: Critical) -> str:
    """The size that the load has in the scene itself."""
    if math.isnan(found.applied):
        return "follows the motion"
    return f"{found.applied:.9g} {found.unit}"


def _stiffness(found: Critical) -> dict[str, str]:
    """The EI of the factor, of a rod along which it differs."""
    if found.scene.distribution.stiffness is not None or found.load in GROUPS:
        return {}
    what = "the mean of the springs of the inner joints times the length of a link"
    return {"EI in it": f"{found.stiffness:.10g} N m^2, {what}"}


def of_modes(found: Modes) -> ResultTable:
    """Frequencies, and how fast motions grow where any does or dies away."""
    damped = bool(found.growth.any())
    columns = ["mode", "frequency [Hz]", "period [s]"]
    rows = []
    for at, (f, growth) in enumerate(zip(found.frequencies, found.growth, strict=True)):
        size = float((growth**2 + (2 * math.pi * f) ** 2) ** 0.5)
        row = [str(at + 1), f"{f:.10g}", f"{1 / f:.6g}" if f else "-"]
        dies = [f"{growth:.6g}", f"{0.0 - growth / size:.6g}" if f else "-"]
        rows.append((*row, *dies * damped))
    return ResultTable.of_rows([*columns, *["growth [1/s]", "damping ratio"] * damped], rows)


def of_exponents(found: Exponents) -> ResultTable:
    """Every exponent with its error."""
    rows = []
    for at, (mean, error) in enumerate(zip(found.exponents, found.errors, strict=True)):
        said = "zero within its error" if abs(mean) <= 2 * error else ""
        rows.append((str(at + 1), f"{mean:.6g}", f"{error:.2g}", said))
    return ResultTable.of_rows(("", "exponent [1/s]", "error [1/s]", ""), rows)


def of_floquet(found: Floquet) -> dict[str, str]:
    """The period and the largest multiplier."""
    return {
        "period": f"{found.period:.12g} s",
        "largest multiplier": f"{found.modulus:.10g}, at {found.argument:.6g} rad",
        "growth": f"{found.growth:.6g} 1/s",
        "error": f"{found.error:.1e}",
        "stable": "yes" if found.stable else "NO",
    }


def of_spectrum(found: Spectrum) -> ResultTable:
    """Every peak."""
    peaks = zip(found.frequencies, found.amplitudes, strict=True)
    rows = [(f"{f:.10g}", f"{size:.6g}") for f, size in peaks]
    return ResultTable.of_rows(("frequency [Hz]", "amplitude"), rows)


def of_extrapolation(found: Extrapolation) -> dict[str, str]:
    """The limit, its error and the order."""
    orders = ", ".join(f"{order:.4g}" for order in found.orders)
    return {
        "value": digits(found.value, found.error),
        "error, estimated": f"{found.error:.1e}",
        "order": f"{found.order:.4g}",
        "orders observed": orders or "none",
    }


def of_simulated_critical(found: SimulatedCritical) -> dict[str, str]:
    """The force, between which forces it was found, and what that took."""
    return {
        "critical force": f"{found.force:.10g} N",
        "did not grow": f"{found.low:.10g} N",
        "grew": f"{found.high:.10g} N",
        "runs": f"{found.runs} of {found.span:g} s, in {found.seconds:.3g} s, {found.target}",
    }


def of_work_precision(found: WorkPrecision) -> ResultTable:
    """The settings than which none is both faster and closer."""
    rows = [
        (
            f"{row['who']} {row['method']}",
            f"{row['setting']:g}",
            f"{row['seconds']:.3g}",
            f"{row[found.measure]:.2e}",
        )
        for row in found.front()
    ]
    return ResultTable.of_rows(("method", "setting", "seconds", found.measure), rows)


def of_study(given: Study) -> ResultTable:
    """What is varied."""
    rows = [
        (
            one.name,
            f"{len(one.values)} values" if one.values else one.scale,
            *map(str, one.ends),
        )
        for one in given.axes
    ]
    return ResultTable.of_rows(("key", "", "from", "to"), rows)


def of_ensemble(found: Ensemble) -> ResultTable:
    """The least and the largest of what is kept, over the runs that did not fail."""
    rows = []
    for name, values in {"t [s]": found.t, **found.values}.items():
        fine = values[found.status == FINISHED]
        ends = (f"{fine.min():.6g}", f"{fine.max():.6g}") if len(fine) else ("-", "-")
        rows.append((name, *ends))
    return ResultTable.of_rows(("kept", "least", "largest"), rows)


def of_scene(scene: Scene) -> dict[str, str]:
    """The rod, what acts on it, and how it is integrated."""
    rod, settings = scene.rod, scene.integrate
    rows = {
        "rod": f"{rod.boundary}, {rod.links} links, {rod.inertia} inertia",
        "length": f"{rod.length:g} m",
        "mass": f"{scene.mass:g} kg",
        "EI": f"{along_in_words(rod.bending_stiffness)} N m^2",
        "bodies": ", ".join(body.name for body in scene.bodies),
        "loads": ", ".join(in_words(scene)),
        "span": f"{settings.span[0]:g} to {settings.span[1]:g} s, by {settings.method}",
        "events": ", ".join(event.name for event in scene.events),
    }
    return {name: text for name, text in rows.items() if text}


def of_solution(solution: Solution) -> dict[str, str]:
    """How the run ended, what it cost, and how well its energy balances."""
    stats, settings, t = solution.stats, solution.scene.integrate, solution.t
    rejected = f" ({stats.rejected} rejected)" if stats.rejected else ""
    rows = {
        "status": solution.status + f": {solution.message}" * bool(solution.message),
        "samples": f"{len(t)} of {solution.y.shape[-1]} states",
        "method": f"{settings.method}, {stats.steps} steps{rejected}, {stats.rhs} evaluations",
        "time taken": f"{stats.wall_seconds:.3g} s"
        + f", target {stats.target}" * bool(stats.target),
        "events": ", ".join(
            f"{event.name} at {event.t:.6g} s" for event in solution.events[:SHOWN]
        ),
    }
    if len(t):
        rows["samples"] += f", t = {t[0]:g} to {t[-1]:g} s"
        x, y = solution.tip[-1]
        rows["tail at the end"] = f"({x:.6g}, {y:.6g}) m"
        rows["energy balances to"] = f"{solution.energy_error:.2e} J"
    return {name: text for name, text in rows.items() if text}
