"""Groups of quantities at the samples of a chunk, from the functions of a generated module.

A group is made when one of its quantities is asked for, once for all of them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

import numpy as np

from rodgen.integrate.solution import principal_axes
from rodgen.integrate.stepper import Array
from rodgen.view.live.chunk import Chunk
from rodgen.view.live.quantities.source import Source

TURN = 1e-5  # rad, by which the links turn in a difference: errors are its square, and eps over it


class Groups:
    """The groups of one chunk by name, each an array (K, columns)."""

    def __init__(self, source: Source, chunk: Chunk):
        self.source, self.model, self.chunk = source, source.model, chunk
        self._made: dict[str, Array] = {}

    def __getitem__(self, name: str) -> Array:
        found = self._made.get(name)
        if found is None:
            with np.errstate(all="ignore"):  # a state may have stopped being finite
                found = self._made[name] = MAKERS[name](self)
        return found


def _links(groups: Groups, half: int, held: float) -> Array:
    """Angles or rates of all links, held ones included, (K, n)."""
    source, y = groups.source, groups.chunk.y
    moving = y.shape[1] // 2 - 2 * source.hold.translates
    begin = half * (y.shape[1] // 2) + 2 * source.hold.translates
    values = y[:, begin : begin + moving]
    if not source.hold.first:
        return values
    first = np.full((len(y), source.hold.first), held)
    return np.concatenate((first, values), axis=1)


def _clamp(groups: Groups) -> float:
    return groups.source.parameter("clamp_angle", groups.chunk.p)


def _opened(groups: Groups, name: str, held: float) -> Array:
    """What neighbouring links differ by; at a root spring, the first link from its clamp."""
    values = groups[name]
    if groups.source.hold.root_spring:
        values = np.concatenate((np.full((len(values), 1), held), values), axis=1)
    return np.diff(values, axis=1)


def _base(groups: Groups) -> Array:
    """x0, y0, vx0, vy0 of a rod that is free, (K, 4)."""
    y = groups.chunk.y
    half = y.shape[1] // 2
    return y[:, [0, 1, half, half + 1]]


def _joints(groups: Groups) -> Array:
    """x and y of joint 0, x and y of joint 1, ..., (K, 2 (n+1))."""
    chunk = groups.chunk
    found: Array = groups.model.joints(chunk.y, chunk.p)
    return found.reshape(len(chunk), -1)


def _velocity(groups: Groups, position: Callable[[Array], Array]) -> Array:
    """Velocity of a point, (K, 2): what its positions, given by the module for states (..., S),
    differ by a little before and after. Relative to joint 0, lest a rod far away lose its digits.
    """
    y, base = groups.chunk.y, 2 * groups.source.hold.translates
    half = y.shape[1] // 2
    rates = y[:, half + base :]
    fastest = np.abs(rates).max(axis=1, initial=0.0)
    h = np.where(fastest > 0, TURN / np.where(fastest > 0, fastest, 1.0), 1.0)[:, None]
    there = np.tile(y, (2, 1, 1))
    there[..., :base] = 0.0
    there[0, :, base:half] += h * rates
    there[1, :, base:half] -= h * rates
    points = position(there)
    found: Array = (points[0] - points[1]) / (2 * h)
    return found + y[:, half : half + 2] if base else found


def _tip_velocity(groups: Groups) -> Array:
    p = groups.chunk.p
    return _velocity(groups, lambda y: groups.model.joints(y, p)[..., -1, :])


def _centre_velocity(groups: Groups) -> Array:
    p = groups.chunk.p
    return _velocity(groups, lambda y: groups.model.centre_of_gravity(y, p))


def _inertia(groups: Groups) -> Array:
    return _stacked(groups.model.inertia(groups.chunk.y, groups.chunk.p), len(groups.chunk))


def _principal(groups: Groups) -> Array:
    """Angle from the x axis to the axis of the smaller moment of inertia, in (-pi/2, pi/2], the
    smaller and the larger moment, (K, 3)."""
    angle, moments = principal_axes(*groups["inertia"].T)
    return np.concatenate((angle[:, None], moments), axis=1)


def _energy(groups: Groups) -> Array:
    """Kinetic, spring, gravity, and their sum, (K, 4)."""
    parts = _stacked(groups.model.energy(groups.chunk.y, groups.chunk.p), len(groups.chunk))
    return np.concatenate((parts, parts.sum(axis=1, keepdims=True)), axis=1)


def _work(groups: Groups) -> Array:
    """Work of the loads in the order of the source."""
    chunk = groups.chunk
    found: Array = chunk.work[:, [chunk.works.index(term) for term in groups.source.works]]
    return found


def _balance(groups: Groups) -> Array:
    chunk = groups.chunk
    gained = groups["energy"][:, 3] - chunk.start
    balance: Array = gained - chunk.work.sum(axis=1) - chunk.given
    return balance[:, None]


def _power(groups: Groups) -> Array:
    chunk = groups.chunk
    powers = groups.model.power(chunk.t, chunk.y, chunk.p)
    return _stacked([powers[term] for term in groups.source.works], len(chunk))


def _moments(groups: Groups) -> Array:
    found: Array = groups.model.bending_moments(groups.chunk.y, groups.chunk.p)
    return found


def _loads(groups: Groups) -> Array:
    """Loads that may change with time, at the times of the samples."""
    source, chunk = groups.source, groups.chunk
    values = (
        source.timed[name](chunk.t) if name in source.timed else source.parameter(name, chunk.p)
        for name in source.loads
    )
    return _stacked(values, len(chunk))


def _stacked(columns: Iterable[Any], count: int) -> Array:
    """Columns, each (K,) or one number, side by side."""
    wide = [np.broadcast_to(np.asarray(column, dtype=float), count) for column in columns]
    return np.stack(wide, axis=-1) if wide else np.zeros((count, 0))


MAKERS: dict[str, Callable[[Groups], Array]] = {
    "t": lambda groups: groups.chunk.t[:, None],
    "base": _base,
    "phi": lambda groups: _links(groups, 0, _clamp(groups)),
    "omega": lambda groups: _links(groups, 1, 0.0),
    "bend": lambda groups: _opened(groups, "phi", _clamp(groups)),
    "bend_rate": lambda groups: _opened(groups, "omega", 0.0),
    "joints": _joints,
    "tip_velocity": _tip_velocity,
    "centre_velocity": _centre_velocity,
    "moments": _moments,
    "centre": lambda groups: groups.model.centre_of_gravity(groups.chunk.y, groups.chunk.p),
    "inertia": _inertia,
    "principal": _principal,
    "energy": _energy,
    "work": _work,
    "balance": _balance,
    "power": _power,
    "loads": _loads,
}
