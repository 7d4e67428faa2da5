"""Results of a study as its pictures need them."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from rodgen.arrays import Array
from rodgen.dataset_result import LONG_NAME, UNITS
from rodgen.integrate.stepper import FINISHED, NO_RESULT
from rodgen.model.term import typeset
from rodgen.model.terms import axis_label
from rodgen.studies.point_arrays import ALWAYS, METHOD

EVEN_SPACING = 1e-6  # of the spacing in which an axis is linear or logarithmic
KEPT_ALWAYS = {one.name for one in (*ALWAYS, METHOD)}  # what a study keeps without being asked
MOST_SHOWN = 2 * 10**5  # points of a picture
NAMES = {"stable": {1: "stable", 0: "unstable", -1: "not known"}}


@dataclass(frozen=True)
class StudyResults:
    """Results of a study as its pictures need them. one_of: how many points there are for each that
    they have."""

    dataset: Any
    one_of: int = 1

    @classmethod
    def subsample(cls, dataset: Any) -> StudyResults:
        """Leave out every other point, or three of four, along the longest axes where there are
        more than a picture can show; `share` then says so."""
        steps = {str(dim): 1 for dim in dataset["status"].dims}
        sizes = {dim: int(dataset.sizes[dim]) for dim in steps}
        while math.prod(sizes.values()) > MOST_SHOWN:
            longest = max(sizes, key=lambda dim: sizes[dim])
            steps[longest] *= 2
            sizes[longest] = -(-int(dataset.sizes[longest]) // steps[longest])
        of = math.prod(steps.values())
        if of == 1:
            return cls(dataset)
        shown = dataset.isel({dim: slice(None, None, step) for dim, step in steps.items()})
        return cls(shown.load(), of)

    @property
    def share(self) -> str:
        """Share of the points that they have, in words; "" where that is all."""
        return f"one point of {self.one_of}" if self.one_of > 1 else ""

    @cached_property
    def is_sample(self) -> bool:
        """Whether its points are a sample."""
        return bool(self.axes != self.dataset["status"].dims)

    @cached_property
    def axes(self) -> tuple[str, ...]:
        """Names of the varied keys."""
        dims = tuple(map(str, self.dataset["status"].dims))
        coords = self.dataset.coords.items() if dims == ("point",) else ()
        return tuple(str(n) for n, c in coords if c.dims == dims != (n,)) or dims

    @cached_property
    def kept(self) -> list[str]:
        """Names of the kept quantities, without the variables that every study has."""
        return [str(name) for name in self.dataset.data_vars if name not in KEPT_ALWAYS]

    @property
    def title(self) -> str:
        """Name of the study."""
        return str(self.dataset.attrs.get("name", "study"))

    def inner_dims(self, name: str) -> tuple[str, ...]:
        """Return the dimensions of a variable beside those of the points."""
        return tuple(str(d) for d in self.dataset[name].dims[self.status.ndim :])

    def is_section(self, name: str) -> bool:
        """Whether a variable has a value for every crossing."""
        return any(dim.startswith("crossing") for dim in self.inner_dims(name))

    @cached_property
    def status(self) -> NDArray[Any]:
        """Status of every point, as text."""
        # Text of any length, as stores that are read piece by piece have it, is made plain first.
        return np.asarray(self.dataset["status"].values).astype(object).astype(str)

    @property
    def failures(self) -> NDArray[np.bool_]:
        """Whether each point has no result, though it was computed."""
        return np.isin(self.status, NO_RESULT)

    def words(self, name: str) -> str:
        """Return what a variable or an axis is, in words, its name where there are none."""
        if name in self.axes:
            return axis_label(name).partition(" [")[0]
        return str(self.dataset[name].attrs.get(LONG_NAME, "") or name)

    def label(self, name: str) -> str:
        """Return words for a variable or an axis with its unit."""
        if name in self.axes:
            return axis_label(name)
        units = self.dataset[name].attrs.get(UNITS, "")
        return f"{self.words(name)} [{typeset(units)}]" if units else self.words(name)

    def axis_values(self, name: str) -> tuple[Array, list[str]]:
        """Return the values of an axis, as numbers, and their labels where they are text."""
        values = np.asarray(self.dataset[name].values)
        if values.dtype.kind in "iuf":
            return values.astype(float), []
        return np.arange(len(values), dtype=float), [str(value) for value in values]

    def set_axis(self, axes: Axes, name: str, which: str) -> None:
        """Set scale, label and ticks of an axis of a picture; which: "x" or "y"."""
        values, texts = self.axis_values(name)
        if is_logarithmic(values):
            axes.set(**{f"{which}scale": "log"})
        axes.set(**{f"{which}label": self.label(name)})
        if texts:
            axes.set(**{f"{which}ticks": values, f"{which}ticklabels": texts})

    def values_of(self, name: str) -> tuple[Array, list[str]]:
        """Return a variable at all points, not-a-number where they did not finish; and the classes
        of text and of named whole numbers, in which case the numbers count them."""
        values = np.asarray(self.dataset[name].values)
        there = self.status == FINISHED
        there = there.reshape(there.shape + (1,) * (values.ndim - there.ndim))
        if values.dtype.kind == "f":
            return np.where(there, values, np.nan), []
        if values.dtype.kind in "iu" and name not in NAMES:
            return np.where(there, values, np.nan), []
        text = values.dtype.kind not in "iu"
        shown = [str(v) if text else NAMES[name].get(int(v), str(v)) for v in values.flat]
        classes = np.array(shown, dtype=str).reshape(values.shape)
        found = np.unique(classes[np.broadcast_to(there, values.shape)])
        return np.where(there, np.searchsorted(found, classes), np.nan), found.tolist()


def is_logarithmic(values: Array) -> bool:
    """Whether values are evenly spaced in their logarithm alone."""
    if len(values) < 3 or not (values > 0).all():
        return False
    steps, plain = np.diff(np.log(values)), np.diff(values)
    even = [np.ptp(one) <= EVEN_SPACING * np.abs(one).max() for one in (steps, plain)]
    return bool(even[0] and not even[1])
