"""Specification of a plot, checked, and its transfer to another rod."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass, fields, replace
from typing import Any

from rodgen.errors import InputError
from rodgen.model.quantities import OWN
from rodgen.scene.plain_tables import is_number
from rodgen.scene.structure import check_choice
from rodgen.scene.tables import LARGEST
from rodgen_live.plot_quantities import KINDS, Catalogue
from rodgen_live.run.sample_curves import DIRECTIONS
from rodgen_live.user_expression import NAME

PLOT_KINDS = {
    "time": "over time",
    "difference": "over time, less the run that is kept",
    "phase": "one over another (phase plot)",
    "poincare": "Poincaré section",
    "profile": "all of a kind along the rod",
    "spectrum": "spectrum",
}
AXES = {"linear": "linear", "log y": "amplitudes logarithmic", "log": "both logarithmic"}
LONGEST = 1e6  # seconds of a window
BOUNDS = {"window": (1e-6, LONGEST), "value": (-LARGEST, LARGEST), "every": (0.0, LARGEST)}
MOST_NAMES = 200


@dataclass(frozen=True)
class PlotSpec:
    """Specification of a plot. y: names of quantities or of kinds, which stand for all of their
    quantities (profile: one kind that goes along the rod; phase, poincare and spectrum: one
    quantity); x: of phase and poincare; window: seconds that are shown, or that a spectrum is of;
    poincare: points where ``when`` reaches ``value`` (plus whole numbers of ``every``, if not 0),
    ``direction`` rising, falling or either; wrapped: angles are shown without the whole turns of
    their mean, points of a section each without its own; axes: of a spectrum (AXES).
    title: made where it is empty."""

    id: str
    kind: str
    y: tuple[str, ...]
    x: str = "t"
    title: str = ""
    window: float = 20.0
    when: str = ""
    value: float = 0.0
    direction: str = "rising"
    every: float = 0.0
    wrapped: bool = True
    axes: str = "linear"

    @classmethod
    def from_dict(cls, choice: Mapping[str, Any], catalogue: Catalogue) -> PlotSpec:
        """Make a specification from a user's choices. Raises InputError that names field, value and
        what is allowed, also for a quantity that this rod does not have."""
        known = [field.name for field in fields(cls)]
        for name in choice:
            if name not in known:
                raise InputError("plot", name, f"absent: not a known key (known: {known})")
        for name in ("id", "kind", "y"):
            if name not in choice:
                raise InputError(f"plot.{name}", None, "given")
        y = (choice["y"],) if isinstance(choice["y"], str) else choice["y"]
        if not (isinstance(y, list | tuple) and 0 < len(y) <= MOST_NAMES):
            raise InputError("plot.y", y, f"1 to {MOST_NAMES} names of quantities")
        spec = cls(**{**choice, "y": tuple(y)})
        for name, fits, allowed in _checks(spec):
            if not fits:
                raise InputError(f"plot.{name}", choice[name], allowed)
        check_choice("plot.kind", spec.kind, PLOT_KINDS)
        check_choice("plot.direction", spec.direction, DIRECTIONS)
        check_choice("plot.axes", spec.axes, AXES)
        _check_names(spec, catalogue)
        return spec

    def to_dict(self) -> dict[str, Any]:
        """Convert the specification to a table for `from_dict`, as JSON has it."""
        return {**asdict(self), "y": list(self.y)}


def _checks(spec: PlotSpec) -> Iterator[tuple[str, Any, str]]:
    """Names of fields, whether their values are what they may be, and what that is."""
    id_fits = isinstance(spec.id, str) and re.fullmatch(r"[A-Za-z0-9_-]{1,32}", spec.id)
    yield "id", id_fits, "1 to 32 letters, digits, - and _"
    title = isinstance(spec.title, str) and len(spec.title) <= 80 and f" {spec.title}".isprintable()
    yield "title", title, "at most 80 printable characters"
    yield "wrapped", isinstance(spec.wrapped, bool), "true or false"
    for name, (low, high) in BOUNDS.items():
        number = getattr(spec, name)
        yield (
            name,
            is_number(number) and low <= number <= high,
            f"a number from {low:g} to {high:g}",
        )


def _check_names(spec: PlotSpec, catalogue: Catalogue) -> None:
    match spec.kind:
        case "time" | "difference":
            for at, name in enumerate(spec.y):
                catalogue.expand(name, f"plot.y[{at}]")
            return
        case "profile":
            check_choice("plot.y[0]", spec.y[0], catalogue.along)
        case _:
            catalogue.quantity(spec.y[0], "plot.y[0]")
    if len(spec.y) > 1:
        raise InputError("plot.y", list(spec.y), f"one name in a plot of kind {spec.kind}")
    if spec.kind in ("phase", "poincare"):
        catalogue.quantity(spec.x, "plot.x")
    if spec.kind == "poincare":
        catalogue.quantity(spec.when, "plot.when")


def title_of(spec: PlotSpec, catalogue: Catalogue) -> str:
    """Title that was chosen, or one that says what is shown."""
    if spec.title:
        return spec.title
    labels = [_label(name, catalogue) for name in spec.y]
    shown = ", ".join(labels[:4]) + (", ..." if len(labels) > 4 else "")
    match spec.kind:
        case "phase":
            return f"{shown} over {_label(spec.x, catalogue)}"
        case "poincare":
            value = f"{spec.value:g}" + (f" + k {spec.every:g}" if spec.every else "")
            return f"{shown} over {_label(spec.x, catalogue)} where " + (
                f"{_label(spec.when, catalogue)} = {value}, {spec.direction}"
            )
        case "profile":
            return f"{shown} along the rod"
        case "spectrum":
            return f"spectrum of {shown}"
        case "difference":
            return f"{shown}, less the run that is kept"
    return shown


def _label(name: str, catalogue: Catalogue) -> str:
    if name in catalogue.quantities:
        return catalogue.quantities[name].label
    return KINDS[name].title


def _matching_expression(text: str, before: Catalogue, after: Catalogue) -> str | None:
    """Look up an expression of one rod in the catalogue of another, its names as `counterpart` has
    them; None where that cannot have it."""

    def matching_name(found: re.Match[str]) -> str:
        return counterpart(found[0], before, after) or found[0]

    try:
        return after.quantity(NAME.sub(matching_name, text)).name
    except InputError:
        return None


def counterpart(name: str, before: Catalogue, after: Catalogue) -> str | None:
    """Name of a quantity or kind of one rod in another, or None where that has none. The last of
    its kind (the tail's) becomes the last one there."""
    if name in before.quantities:
        kind = before.quantities[name].kind
        known, now = before.kinds.get(kind, []), after.kinds.get(kind, [])
        if len(known) > 1 and name == known[-1] and now:
            return now[-1]
        if kind == OWN:
            return _matching_expression(name, before, after)
    return name if name in after.quantities or name in after.kinds else None


def missing_labels(spec: PlotSpec, before: Catalogue, after: Catalogue) -> list[str]:
    """Labels of the quantities of a plot that another rod does not have."""
    names = dict.fromkeys(filter(None, (*spec.y, spec.x, spec.when)))
    return [_label(name, before) for name in names if counterpart(name, before, after) is None]


def transfer(spec: PlotSpec, name: str, before: Catalogue, after: Catalogue) -> PlotSpec | None:
    """Convert a plot of one rod to a plot of another, under another name; None where nothing of it
    is left."""

    def new_quantity(quantity: str) -> str | None:
        return counterpart(quantity, before, after)

    y = tuple(dict.fromkeys(new for old in spec.y if (new := new_quantity(old)) is not None))
    x, when = new_quantity(spec.x), new_quantity(spec.when) if spec.when else ""
    if not y or x is None or when is None:
        return None
    try:
        return PlotSpec.from_dict(replace(spec, id=name, y=y, x=x, when=when).to_dict(), after)
    except InputError:  # a kind that does not go along this rod
        return None
