"""Tables of branches, boundaries and studies, for terminals and notebooks alike."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from rodgen.analyse.branches.branch_data import UNKNOWN
from rodgen.integrate.endings import NO_RESULT
from rodgen.show.result_tables import ResultTable
from rodgen.show.study_results import Results

if TYPE_CHECKING:
    import xarray

Rows = dict[str, str]


def of_branch(data: xarray.Dataset) -> Rows:
    """How far a branch of equilibria goes, how stable its ends are, and its special points."""
    values, unstable = data["value"].values, data["unstable"].values
    rows = {
        "points": f"{len(values)}, from {values[0]:.9g} to {values[-1]:.9g}",
        "ends": data.attrs["end"],
        "unstable directions": f"{_number(unstable[0])} at its start, {_number(unstable[-1])} at "
        "its end",
    }
    if "turning" in data:
        turning = data["turning"].values
        rows["turns with"] = f"{turning[0]:.9g} rad/s at its start, {turning[-1]:.9g} at its end"
    return rows | _numbered(_on_branch(data))


def _number(unstable: int) -> str:
    return "unknown" if unstable == UNKNOWN else str(unstable)


def _on_branch(data: xarray.Dataset) -> Iterator[str]:
    parts = (data[f"special_{name}"].values for name in ("kind", "value", "frequency", "note"))
    for kind, value, frequency, note in zip(*parts, strict=True):
        words = f"{named(kind)} at {value:.12g}"
        if frequency:
            words += f", {frequency:.12g} Hz"
        yield f"{words} ({note})" if note else words


def of_cycles(data: xarray.Dataset) -> Rows:
    """How far a branch of cycles goes, how the cycles change along it, and its special points."""
    values, period, amplitude = (data[name].values for name in ("value", "period", "amplitude"))
    unstable = data["unstable"].values
    parts = (data[f"special_{name}"].values for name in ("kind", "value", "period"))
    special = (f"{named(k)} at {v:.11g}, period {p:.9g} s" for k, v, p in zip(*parts, strict=True))
    rows = {
        "points": f"{len(values)}, from {values[0]:.9g} to {values[-1]:.9g}",
        "ends": data.attrs["end"],
        "period": f"{period[0]:.9g} s at its start, {period[-1]:.9g} s at its end",
        "amplitude": f"{amplitude[0]:.6g} rad at its start, {amplitude[-1]:.6g} rad at its end",
        "stable cycles": f"{np.count_nonzero(unstable == 0)} of {len(unstable)}",
    }
    if "supercritical" in data.attrs:
        kind = "super" if data.attrs["supercritical"] else "sub"
        rows["Hopf point"] = f"{kind}critical"
    return rows | _numbered(special)


def of_boundary(data: xarray.Dataset) -> Rows:
    """What a boundary of stability divides, where it begins and ends, and its special points."""
    a, b, frequency = (data[name].values for name in ("a", "b", "frequency"))
    parts = (data[f"special_{name}"].values for name in ("kind", "a", "b", "frequency"))
    special = zip(*parts, strict=True)
    return {
        "points": f"{data.attrs['a']}, {data.attrs['b']}: {len(a)}",
        "begins there": data.attrs["kind"],
        "first": _place(a[0], b[0], frequency[0]),
        "last": _place(a[-1], b[-1], frequency[-1]),
        "ends": data.attrs["end"],
        **_numbered(f"{kind} at {_place(*where)}" for kind, *where in special),
    }


def _place(a: float, b: float, frequency: float) -> str:
    return f"{a:.10g}, {b:.10g}, at {frequency:.8g} Hz"


def of_mode(data: xarray.Dataset) -> Rows:
    """How the motions of a nonlinear mode change with their energy, and the special ones."""
    energy, frequency, amplitude = (data[n].values for n in ("energy", "frequency", "amplitude"))
    special = zip(data["special_kind"].values, data["special_energy"].values, strict=True)
    return {
        "points": f"{len(energy)}, from {energy[0]:.6g} to {energy[-1]:.6g} J above rest",
        "ends": data.attrs["end"],
        "linear mode": f"{data.attrs['linear_frequency']:.9g} Hz",
        "frequency": f"{frequency[0]:.9g} Hz at its start, {frequency[-1]:.9g} Hz at its end",
        "amplitude": f"{amplitude[0]:.6g} rad at its start, {amplitude[-1]:.6g} rad at its end",
        "stable motions": f"{np.count_nonzero(data['unstable'].values == 0)} of {len(energy)}",
        **_numbered(f"{named(kind)} at {value:.9g} J" for kind, value in special),
    }


def of_study(data: xarray.Dataset) -> ResultTable:
    """What was varied and what was kept, each with its ends, and the points that failed."""
    of = Results.thinned(data)
    rows = [(name, "varied", *_ends(*of.along(name))) for name in of.axes]
    rows += [(of.label(name), "kept", *_ends(*of.numbers(name))) for name in of.kept]
    failed = np.count_nonzero(np.isin(of.status, NO_RESULT))
    rows += [("points that failed", "", str(failed), "")] * bool(failed)
    return ResultTable.of_rows(("", "", "least", "largest"), rows)


def _ends(values: NDArray[np.float64], classes: list[str]) -> tuple[str, str]:
    """The least and the largest of numbers; of what is text or yes and no, all that is met."""
    if classes:
        return ", ".join(classes), ""
    fine = values[np.isfinite(values)]
    return (f"{fine.min():.6g}", f"{fine.max():.6g}") if fine.size else ("-", "-")


def named(kind: str) -> str:
    """A kind of special point in words."""
    points = {"hopf": "Hopf point", "branch": "branch point"}
    return points.get(str(kind), str(kind))


def _numbered(special: Iterator[str]) -> Rows:
    return {f"special {number}": words for number, words in enumerate(special, 1)}
