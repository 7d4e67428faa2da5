"""What a scene has that its author may not have meant."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from rodgen.errors import short
from rodgen.model.rod import CLAMP_ANGLE
from rodgen.model.terms import PARAMETERS
from rodgen.scene import grammar
from rodgen.scene.files import TABLES
from rodgen.scene.grammar import TABLE
from rodgen.scene.keys import NUMBERS, named_numbers, texts
from rodgen.scene.scene import Scene

TURN = 2 * math.pi


def doubts(scene: Scene) -> Iterator[str]:
    """Sentences on numbers and tables that no expression names, and on angles that look like
    degrees."""
    given = scene.model_dump(exclude_none=True)
    named = named_numbers(given)
    for name in scene.numbers:
        if name not in named:
            yield f"no expression names {NUMBERS}.{name}"
    trees = [grammar.parse(text, "") for text in texts(given) if scene.tables and TABLE in text]
    read = {name for tree in trees if tree for name in grammar.table_names(tree)}
    for name in scene.tables:
        if repr(name) not in read:
            yield f"no expression names {TABLES}.{name}"
    parameters = scene.parameters
    for name in (CLAMP_ANGLE.name, *scene.loads.parameters):
        angle = name == CLAMP_ANGLE.name or PARAMETERS[name].angle
        if angle and abs(parameters.get(name, 0.0)) > TURN:
            given = parameters[name]
            turns = f"{abs(given) / TURN:.1f} turns"
            yield f"{scene.field(name)} = {given:g} is {turns}: angles are in radians"
    if (most := _largest_angle(scene)) > TURN:
        text = short(scene.initial.phi)
        yield f"initial.phi = {text} turns a link by {most / TURN:.1f} turns: angles are in radians"


def _largest_angle(scene: Scene) -> float:
    """Of a link at the start [rad]."""
    y = scene.initial_state()
    half = (len(y) - len(scene.states)) // 2
    return float(np.abs(y[2 * scene.hold.translates : half]).max(initial=0.0))
