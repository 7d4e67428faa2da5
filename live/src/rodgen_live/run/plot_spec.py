"""Specification of a plot, checked, and its transfer to another rod."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

from pydantic import BaseModel, Field, ValidationError

from rodgen.errors import InputError
from rodgen.model.quantities import OWN
from rodgen.scene.tables import LARGEST
from rodgen.scene.term_texts import check_choice
from rodgen.scene.validation import to_input_error
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
LINE = r"^[^\p{C}\p{Zl}\p{Zp}]{0,80}$"  # of what is printed


class PlotSpec(BaseModel, extra="forbid", frozen=True, strict=True):
    """Specification of a plot. y: names of quantities or of kinds, which stand for all of their
    quantities (profile: one kind that goes along the rod; phase, poincare and spectrum: one
    quantity); x: of phase and poincare; window: seconds that are shown, or that a spectrum is of;
    poincare: points where ``when`` reaches ``value`` (plus whole numbers of ``every``, if not 0),
    ``direction`` rising, falling or either; wrapped: angles are shown without the whole turns of
    their mean, points of a section each without its own; axes: of a spectrum (AXES).
    title: made where it is empty."""

    id: str = Field(pattern="^[A-Za-z0-9_-]{1,32}$", description="1 to 32 letters, digits, - and _")
    kind: str
    y: tuple[str, ...] = Field(min_length=1, max_length=200)
    x: str = "t"
    title: str = Field("", pattern=LINE, description="one line, of 80 letters at most")
    window: float = Field(20.0, ge=1e-6, le=LONGEST)
    when: str = ""
    value: float = Field(0.0, ge=-LARGEST, le=LARGEST)
    direction: str = "rising"
    every: float = Field(0.0, ge=0.0, le=LARGEST)
    wrapped: bool = True
    axes: str = "linear"

    @classmethod
    def from_dict(cls, choice: Mapping[str, Any], catalogue: Catalogue) -> PlotSpec:
        """Make a specification from a user's choices. Raises InputError that names field, value and
        what is allowed, also for a quantity that this rod does not have."""
        y = choice.get("y")
        names = {"y": (y,) if isinstance(y, str) else tuple(y)} if isinstance(y, str | list) else {}
        try:
            spec = cls(**{**choice, **names})
        except ValidationError as error:
            found = to_input_error(error, cls)
            raise InputError(f"plot.{found.field}", found.value, found.allowed) from None
        check_choice("plot.kind", spec.kind, PLOT_KINDS)
        check_choice("plot.direction", spec.direction, DIRECTIONS)
        check_choice("plot.axes", spec.axes, AXES)
        _check_names(spec, catalogue)
        return spec


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
    moved = {"id": name, "y": y, "x": x, "when": when}
    try:
        return PlotSpec.from_dict({**dict(spec), **moved}, after)
    except InputError:  # a kind that does not go along this rod
        return None
