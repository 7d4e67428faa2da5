"""Judge `critical_load`: stable below, unstable above, and the motion that begins to grow."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from rodgen_evidence.verdicts.along_load import AlongLoad, KinkError
from rodgen_evidence.verdicts.exact_rest import ChainFoldError
from rodgen_evidence.verdicts.judgement import CONTRADICTED, FOLD, NONE, REFUSED, RIGHT, Judgement
from rodgen_evidence.verdicts.product_answers import Refusal
from rodgen_evidence.verdicts.spectrum50 import GROWS

NAME = "critical"
BESIDE = 1e-5, 1e-5  # of the force and of its unit, above an onset
BELOW = 1e-9  # of the force, and of its unit
BEFORE = 0.2, 0.4, 0.6, 0.8, 0.9, 0.99, 0.999  # of the way from a load to the end of the rests
RATE = 1e-3  # of the largest rate: how well the rate at an onset has to be met


def critical(reference: AlongLoad, answer: Any) -> list[Judgement]:
    """The verdict on a critical load, or on its refusal."""
    try:
        first = growth(reference, 0.0)
    except KinkError as unknown:
        return [Judgement(NAME, NONE, 0.0, str(unknown))]
    except ChainFoldError:
        return [Judgement(NAME, RIGHT if isinstance(answer, Refusal) else NONE, 0.0)]
    if isinstance(answer, Refusal):
        return [_refusal(reference, answer, first)]
    texts = list(_wrong(reference, answer))
    return [Judgement(NAME, CONTRADICTED if texts else RIGHT, answer.value, "; ".join(texts))]


def _sizes(reference: AlongLoad) -> Iterator[float]:
    """The loads of the grid, and before the first at which there is no rest some that lie close to
    the end of the way."""
    for size in map(float, reference.grid):
        try:
            reference.rest(size)
        except ChainFoldError:
            low = max(float(one) for one in reference.grid if one < reference.end)
            yield from (low + share * (reference.end - low) for share in BEFORE)
        yield size


def growth(reference: AlongLoad, size: float) -> float:
    """Growth rate of the motion that grows most [1/s]."""
    return reference.spectrum(size).growth


def _refusal(reference: AlongLoad, answer: Refusal, first: float) -> Judgement:
    """Right where the rod is unstable without the load, or bears all of it."""
    if first > GROWS:
        return Judgement(NAME, RIGHT, 0.0, answer.text)
    for size in _sizes(reference):
        try:
            if growth(reference, size) > GROWS:
                return Judgement(NAME, REFUSED, size, f"grows at {size:.6g}, but: {answer.text}")
        except ChainFoldError:
            return Judgement(
                NAME, FOLD, reference.end, f"ends at {reference.end:.9g}: {answer.text}"
            )
        except KinkError as unknown:
            return Judgement(NAME, NONE, size, str(unknown))
    return Judgement(NAME, RIGHT, 0.0, answer.text)


def _wrong(reference: AlongLoad, answer: Any) -> Any:
    """Yield the faults of a critical load."""
    force, unit = answer.value, reference.sketch.unit
    below = force - BELOW * (abs(force) + unit)
    for size in reference.grid:
        try:
            grows = growth(reference, size)
        except ChainFoldError:
            break
        except KinkError:
            return
        if size < below and grows > GROWS:
            yield f"{force:.9g}, but {grows:.3g} 1/s at {size:.6g}"
            return
    try:
        above = growth(reference, force * (1 + BESIDE[0]) + BESIDE[1] * unit)
        if above <= GROWS:
            yield f"{force:.9g}, but nothing grows above it ({above:.3g} 1/s)"
        yield from _other_rate(reference, answer)
    except ChainFoldError:
        if reference.end < force * (1 - 1e-4):
            yield f"{force:.9g}, but the rest ends at {reference.end:.9g}"


def _other_rate(reference: AlongLoad, answer: Any) -> Any:
    """Whether the motion at the onset is none of the reference."""
    spectrum = reference.spectrum(answer.value)
    s, own = np.append(spectrum.s, 0.0), 2j * np.pi * answer.frequency
    off = float(np.abs(s - own).min())
    largest = max(float(np.abs(s).min(initial=np.inf, where=np.abs(s) > 0)), abs(own))
    if off > RATE * largest:
        yield f"{answer.kind} with {own.imag:.6g} 1/s is {off:.2g} from an eigenvalue"
    if (answer.kind == "flutter") != bool(answer.frequency):
        yield f"{answer.kind} has {answer.frequency:.3g} Hz"
    beside = reference.spectrum(answer.value * (1 + BESIDE[0]) + BESIDE[1] * reference.sketch.unit)
    grown = beside.growing
    oscillates = np.abs(grown.imag) > 1e-3 * np.abs(grown)
    wanted = oscillates if answer.kind == "flutter" else ~oscillates
    if len(grown) and not wanted.any():
        yield f"{answer.kind}, but above grow {np.array2string(grown, precision=4)}"
