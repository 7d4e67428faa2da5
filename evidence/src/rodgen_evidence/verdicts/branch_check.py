"""Judge `continue_equilibria`: what its points count as unstable, and its special points."""

from __future__ import annotations

from typing import Any

import numpy as np

from rodgen_evidence.verdicts.along_load import AlongLoad, KinkError
from rodgen_evidence.verdicts.exact_rest import ChainFoldError
from rodgen_evidence.verdicts.judgement import CONTRADICTED, NONE, REFUSED, RIGHT, Judgement
from rodgen_evidence.verdicts.product_answers import Refusal

NAME = "branch"
AT = 1e-4  # of the frequency, or of the largest rate: the eigenvalue that crosses
NEAR = 0.05  # rad or m, from the rest of the reference to be on its way


def branch(reference: AlongLoad, answer: Any, one: float) -> list[Judgement]:
    """The verdicts on a branch; one: its value for a load of size one."""
    if answer is None:
        return []
    try:
        reference.rest(0.0)
    except ChainFoldError as folded:
        return [Judgement(NAME, NONE, 0.0, str(folded))]
    if isinstance(answer, Refusal):
        kind = NONE if answer.input else REFUSED
        return [Judgement(NAME, kind, 0.0, answer.text)]
    values = answer["value"].values / one
    turned = np.flatnonzero(np.diff(values) <= 0)
    until = int(turned[0]) + 1 if len(turned) else len(values)
    found = [*_counts(reference, answer, values[:until]), *_specials(reference, answer, one, until)]
    if (end := values[:until][-1]) < min(reference.end, reference.sketch.highest) * (1 - 1e-3):
        found.append(Judgement(NAME, CONTRADICTED, end, f"ends at {end:.6g}: {_why(answer)}"))
    return found or [Judgement(NAME, RIGHT, 0.0)]


def _why(answer: Any) -> str:
    return "; ".join(f"{k}: {v}" for k, v in answer.attrs.items() if k in ("ended", "end", "notes"))


def _counts(reference: AlongLoad, answer: Any, values: Any) -> Any:
    """Count the motions that grow at every load that lies between points that agree."""
    unstable, first = answer["unstable"].values, reference.sketch.table["rod"]["boundary"]
    for size in reference.grid:
        at = int(np.searchsorted(values, size))
        if not 0 < at < len(values) or unstable[at - 1] != unstable[at]:
            continue
        try:
            grown = len(reference.spectrum(float(size)).growing)
        except ChainFoldError:
            return
        except KinkError as unknown:
            yield Judgement(NAME, NONE, size, str(unknown))
            return
        own = int(unstable[at])
        if own == grown:
            yield Judgement(NAME, RIGHT, size)
        else:
            where = f"{own} unstable, {grown} in the reference ({first})"
            yield Judgement(NAME, CONTRADICTED, size, where)


def _specials(reference: AlongLoad, answer: Any, one: float, until: int) -> Any:
    """Special points before the branch turns back: an eigenvalue crosses there."""
    rows = zip(
        answer["special_kind"].values,
        answer["special_value"].values / one,
        answer["special_frequency"].values,
        answer["special_after"].values,
        strict=True,
    )
    for kind, size, frequency, after in rows:
        if after >= until:
            return
        if kind == "fold":
            if not abs(reference.end - size) < 1e-3 * size:
                text = f"fold at {size:.6g}, the rest ends at {reference.end:.6g}"
                yield Judgement(NAME, CONTRADICTED, size, text)
            return
        try:
            s = np.append(reference.spectrum(float(size)).s, [])
        except (ChainFoldError, KinkError):
            return
        own = 2j * np.pi * frequency
        off = float(np.abs(s - own).min(initial=np.inf))
        scale = max(abs(own), float(np.abs(reference.spectrum(0.0).s).max(initial=0.0)))
        right = off < AT * scale if kind != "hopf" else off < 10 * AT * abs(own)
        text = "" if right else f"{kind} at {size:.9g}: {own.imag:.6g} 1/s is off by {off:.2g}"
        if kind == "hopf" and own.imag < AT**2 * scale:
            right, text = False, f"hopf at {size:.9g} with a frequency of {frequency:.2g} Hz"
        yield Judgement(NAME, RIGHT if right else CONTRADICTED, size, text)
