"""Judge answers by the reference: right, contradicted, refused, or without a reference."""

from __future__ import annotations

from collections import Counter
from typing import Any

import numpy as np

from rodgen_evidence.verdicts.along_load import HELD, AlongLoad, KinkError
from rodgen_evidence.verdicts.branch_check import branch
from rodgen_evidence.verdicts.critical_check import critical
from rodgen_evidence.verdicts.exact_rest import ChainFoldError, ExactRest
from rodgen_evidence.verdicts.judgement import CONTRADICTED, FOLD, NONE, REFUSED, RIGHT, Judgement
from rodgen_evidence.verdicts.product_answers import Answers, Refusal
from rodgen_evidence.verdicts.spectrum50 import GROWS

SAME = 1e-7  # rad, between two ways to one rest
AMONG = 1e-6  # of a rate, from an eigenvalue; its square root where two meet
MEETS = 1e-2


def judge(reference: AlongLoad, answers: Answers) -> list[Judgement]:
    """List all verdicts on a scene."""
    found = critical(reference, answers.critical())
    for size in map(float, reference.grid):
        found += static(reference, size, answers.static(size))
        found += modes(reference, size, answers.modes(size))
    return found + branch(reference, answers.branch(), answers.key[1])


def summary(verdicts: list[Judgement]) -> dict[str, dict[str, int]]:
    """Count the verdicts of each kind by function."""
    functions = dict.fromkeys(one.function for one in verdicts)
    return {f: dict(Counter(v.kind for v in verdicts if v.function == f)) for f in functions}


def static(reference: AlongLoad, size: float, answer: Any) -> list[Judgement]:
    """`static_equilibrium`: the rest that the way from the unloaded rod leads to, and stable as its
    eigenvalues are."""
    name = "static"
    try:
        rest: Any = reference.rest(size)
    except ChainFoldError:
        rest = None
    if isinstance(answer, Refusal):
        if answer.input:
            return [Judgement(name, NONE, size, answer.text)]
        held = rest is not None and rest.stiffness > HELD and reference.stays(size)
        kind = (FOLD if reference.turns_back(size) else REFUSED) if held else RIGHT
        return [Judgement(name, kind, size, answer.text)]
    table, found = reference.sketch.at(size), []
    try:
        own = reference.at_rest(table, answer.y)
    except ChainFoldError:
        return [Judgement(name, CONTRADICTED, size, "rates are not zero in its rest")]
    if not reference.hangs and (text := _other_branch(reference, size, own, rest)):
        found.append(Judgement(name, CONTRADICTED, size, text))
    try:
        growth = reference.about(table, own).growth
    except KinkError as unknown:
        return [*found, Judgement(name, NONE, size, str(unknown))]
    if answer.stable is (growth <= GROWS):
        return [*found, Judgement(name, RIGHT, size)]
    text = f"stable is {answer.stable} where a motion grows with {growth:.3g} 1/s"
    return [*found, Judgement(name, CONTRADICTED, size, text)]


def _other_branch(reference: AlongLoad, size: float, own: ExactRest, rest: ExactRest | None) -> str:
    """Describe the fault of a rest to which neither way of the loads leads."""
    apart = np.inf
    if rest is not None:
        off = np.array(own.z, dtype=float) - np.array(rest.z, dtype=float)
        apart = float(np.abs(off).max(initial=0.0))
    if apart <= SAME or reference.is_way(size, own):
        return ""
    if reference.turns_back(size):
        return "an answer where the branch of the unloaded rod turns back"
    return f"another branch, {apart:.3g} away"


def modes(reference: AlongLoad, size: float, answer: Any) -> list[Judgement]:
    """`natural_modes`: rates are eigenvalues, and one grows where one grows."""
    name = "modes"
    try:
        spectrum = reference.spectrum(size)
    except (ChainFoldError, KinkError) as unknown:
        return [Judgement(name, NONE, size, str(unknown))]
    if isinstance(answer, Refusal):
        kind = FOLD if reference.turns_back(size) else REFUSED
        return [Judgement(name, NONE if answer.input else kind, size, answer.text)]
    s, found = np.append(spectrum.s, 0.0), []
    for rate in answer.growth + 2j * np.pi * answer.frequencies:
        off = np.sort(np.abs(s - rate))
        least = AMONG * max(abs(rate), 1e-3 * np.abs(s).max())
        if off[0] > least and not (len(off) > 1 and off[1] < MEETS * abs(rate)):
            found.append(f"{rate:.8g} 1/s is {off[0]:.2g} from an eigenvalue")
    grows = bool((answer.growth > 0).any())
    if grows != (spectrum.growth > GROWS):
        found.append(f"grows is {grows} where {spectrum.growth:.3g} 1/s is the largest growth")
    return [Judgement(name, CONTRADICTED if found else RIGHT, size, "; ".join(found))]
