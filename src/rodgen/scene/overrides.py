"""Values given for one run instead of those of its scene."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rodgen.model.rod import ROD, STEADY, TANK, UNEVEN
from rodgen.model.term import ANCHOR
from rodgen.model.terms import PARAMETERS, TERMS
from rodgen.scene import spring
from rodgen.scene.errors import SceneError, meant
from rodgen.scene.expression import Expression
from rodgen.scene.integration import Integrate
from rodgen.scene.keys import named_numbers
from rodgen.scene.numbers import mass_of
from rodgen.scene.plain import is_number, plain, put
from rodgen.scene.scene import Scene


def check_used(settings: Integrate, given: Mapping[str, Any], prefix: str = "") -> None:
    """Raise SceneError for a value that the method has no use for.

    settings: all that holds for the run; given: of it, what was asked for beside the scene, None
    where it was not; prefix: of the names in messages. In a scene itself both a step and
    tolerances may stand, so that its method can be changed alone.
    """
    useless = ("rtol", "atol") if settings.fixed else ("step",)
    why = "has a fixed step" if settings.fixed else "chooses its own steps"
    if given.get("t_eval") is not None and given.get("output_every") is not None:
        allowed = "absent: t_eval has the times of the samples"
        raise SceneError(f"{prefix}output_every", given["output_every"], allowed)
    for name in useless:
        if given.get(name) is not None:
            raise SceneError(f"{prefix}{name}", given[name], f"absent: {settings.method} {why}")


def with_parameters(scene: Scene, values: Mapping[str, Any]) -> Scene:
    """The scene with other values of parameters of its module and of [parameters], by name,
    checked as in its file.

    A number may take the place of a law, such as a load that was a function of time, and the
    reverse; then the scene has another module. What the scene computes from other values, such as
    the mass of every link, may be given as it is. Raises SceneError for names that the scene has
    no place for, and for another value of what is computed.
    """
    if not isinstance(values, Mapping):
        raise SceneError("parameters", values, "a dictionary of values by name")
    rod = (one.name for one in (*ROD, *scene.hold.parameters))
    names = (*rod, *scene.loads.parameters)
    own, computed = scene.parameters, _computed(scene)
    table = scene.model_dump(exclude_none=True)
    known = dict.fromkeys((*names, *named_numbers(table), *scene.structure.numbers))
    numbers: dict[str, Any] = {}
    for name, value in values.items():
        if name not in known and name not in computed:
            raise SceneError("parameters", name, f"one of {', '.join(known)}{meant(name, known)}")
        if name in own and _equal(plain(value, name), own[name]):
            continue
        if name in computed:
            allowed = f"as it is: it follows from {computed[name]}, which may be changed instead"
            raise SceneError(name, value, allowed)
        if name in names:
            put(table, scene.place(name), value)
        elif name in scene.numbers:
            put(table, ("parameters", name), value)
        else:
            numbers[name] = plain(value, name)
    for place, text in _texts(scene, numbers):
        put(table, place, text)
    return Scene.from_dict(table)


def _equal(value: Any, own: Any) -> bool:
    """Whether a value is the one that the scene has, number by number."""
    try:
        return bool(np.array_equal(np.asarray(value, dtype=float), np.asarray(own, dtype=float)))
    except (TypeError, ValueError):
        return False


def _computed(scene: Scene) -> dict[str, str]:
    """Parameters of the module that follow from other values of the scene, and from which."""
    structure = scene.structure
    masses = "rod.mass, rod.mass_per_length, rod.length and [[bodies]]"
    rows = [one for way in UNEVEN.values() for one in way.parameters]
    found = {one.name: f"rod.{one.key} and rod.length" if one.key else masses for one in rows}
    found |= dict.fromkeys((one.name for one in STEADY.values()), masses)
    for name in structure.tanks:
        found |= {f"{name}_{what}": f"bodies.{name.removeprefix('body_')}" for what in TANK}
    for term in (TERMS[name] for name in structure.loads if TERMS[name].kind == ANCHOR):
        found |= {one.name: f"{term.table} and rod.length" for one in term.parameters}
        found |= {one.name: "rod.clamp_angle" for one in term.parameters if one.angle}
    found |= dict.fromkeys(dict(structure.tables), "[tables]")
    if scene.rod.mass is None:
        found["mass"] = "rod.mass_per_length"
    return {name: source for name, source in found.items() if name in structure.parameters}


def _texts(scene: Scene, numbers: Mapping[str, Any]) -> Iterator[tuple[tuple[str, ...], str]]:
    """Keys of the expressions that have some numbers, and their texts with other values of them."""
    for name, value in numbers.items():
        if isinstance(value, bool) or not (is_number(value) and math.isfinite(value)):
            raise SceneError(name, value, "a finite number")
    texts: dict[str, tuple[tuple[str, ...], Expression]] = {
        f"{state}_rate": (("states", state, "rate"), e) for state, e in scene.rates.items()
    }
    texts |= {load: (scene.place(load), e) for load, e in scene.expressions.items()}
    if scene.spring_law is not None:
        texts[spring.NAME] = ("rod", spring.NAME), scene.spring_law
    bodies = [body.name for body in scene.bodies]
    for body, _, e in scene.distribution.changing:
        at = ("bodies", str(bodies.index(body)), "mass") if body else ("rod", mass_of(""))
        texts[mass_of(body)] = at, e
    for prefix, (place, text) in texts.items():
        here = {k: v for k, v in numbers.items() if k in text.parametrised(prefix)[1]}
        if here:
            yield place, text.with_numbers(prefix, here)


def with_masses_at(scene: Scene, t: float) -> Scene:
    """The scene whose masses stay what they are at a time [s], its damping that of the scene: what
    goes by the mass of the links does so by that at the start of the span."""
    changing = {name: e for name, _, e in scene.distribution.changing}
    if not changing:
        return scene
    table = scene.model_dump(exclude_none=True)
    if "" in changing:
        table["rod"]["mass_per_length"] = changing[""].held(t)
        ratio = scene.distribution.links_mass / scene.distribution_at(t).links_mass
        for name in filter(lambda name: PARAMETERS[name].by_mass, scene.loads.parameters):
            put(table, scene.place(name), ratio * scene.loads.value(name))
    masses = scene.distribution_at(t).body_mass
    for body, mass in zip(table["bodies"] if masses else (), masses, strict=True):
        if body["name"] in changing:
            body["mass"] = mass
    return Scene.from_dict(table)


def with_state(scene: Scene, y: Any, name: str = "y0") -> Scene:
    """The scene that starts in a state y (states,), in the order of the module's STATE; name: what
    it is called in messages. Raises SceneError for what is no such state."""
    states = len(scene.initial_state())
    state = np.asarray(plain(y, name))
    if state.dtype.kind not in "iuf" or state.shape != (states,) or not np.isfinite(state).all():
        raise SceneError(name, y, f"{states} finite numbers, as the module's STATE has them")
    table = scene.model_dump(exclude_none=True)
    return Scene.from_dict(table | initial_tables(scene, state.astype(float)))


def initial_tables(scene: Scene, y: NDArray[np.float64]) -> dict[str, Any]:
    """What tables of a scene have of a state y (states,) at the start."""
    added = {
        name: {"rate": state.rate, "initial": value}
        for (name, state), value in zip(
            scene.states.items(), y[len(y) - len(scene.states) :].tolist(), strict=True
        )
    }
    return {"initial": initial_table(scene, y)} | ({"states": added} if added else {})


def initial_table(scene: Scene, y: NDArray[np.float64]) -> dict[str, Any]:
    """The table [initial] of a state y (states,)."""
    q, v = np.split(y[: len(y) - len(scene.states)], 2)
    base = 2 * scene.hold.translates
    table = {"phi": q[base:].tolist(), "omega": v[base:].tolist()}
    return table | ({"position": q[:2].tolist(), "velocity": v[:2].tolist()} if base else {})
