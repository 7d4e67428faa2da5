"""The peers: their formulations against rodgen's, and their motions against a tight run of it."""

from __future__ import annotations

import math
from functools import cached_property
from importlib.util import find_spec
from itertools import islice, pairwise
from types import ModuleType
from typing import Any

import numpy as np
import pytest

import rodgen
from rodgen.analyse.precision.contestant import NotModelledError
from rodgen.analyse.precision.job import Job
from rodgen.scene import Scene
from rodgen_evidence.report.cases import cases, rod
from rodgen_evidence.report.costs.cost_rows import THRUST, built, parameter_vector
from rodgen_evidence.report.peers import (
    FAMILIES,
    LIBRARIES,
    RATES,
    chain_accelerations,
    family,
    loads,
    peer,
)
from rodgen_evidence.report.peers import prepare as prepared_rates
from rodgen_evidence.report.peers.tree import Tree

pytestmark = pytest.mark.compiler

CLAMPS = {"cantilever": 0.3, "clamped": 0.3}
# Of all kinds: two change with time, one of them and the thrust with a kink, one jumps.
LOADS: dict[str, Any] = {
    "follower": {"force": "300*min(t/0.1, 1)", "angle": 0.1},
    "gravity": {"g": 9.81},
    "internal_damping": {"coefficient": 0.3},
    "tip": {"x": "1.5*sin(t)**2 if t <= 0.06 else 0", "y": "abs(t - 0.06)*sin(1)"},
}
FINS = {"external_damping": {"coefficient": 0.5, "fin_factor": {"nose": 2.0, "tail": 20.0}}}


def needs(name: str) -> None:
    package = LIBRARIES[name.split()[0].strip(",")].package
    if find_spec(package) is None:
        pytest.skip(f"{package} is not installed: make report installs it as far as it can")


class InNumpy(Job):
    """Its module is not compiled, which takes seconds for every scene."""

    @cached_property
    def model(self) -> ModuleType:
        return rodgen.build(self.scene, target="numpy")


def job(
    boundary: str, inertia: str, tables: dict[str, Any], links: int = 4, kind: type[Job] = InNumpy
) -> Job:
    held = {"boundary": boundary, "inertia": inertia}
    if boundary in CLAMPS:
        held["clamp_angle"] = CLAMPS[boundary]
    shape = {"phi": "0.3 + 0.1*s", "omega": "0.5*(s - 0.5)"}
    table = rod("small", links, 0.2, rod=held, loads=tables, initial=shape)
    return kind.of("small", Scene.from_dict(table))


def by_hand(given: Job) -> peer.Accelerations:
    """chain_accelerations.py in numbers."""
    scene = given.scene

    def found(t: float, y: Any) -> Any:
        p = loads.parameters(scene, t, loads.PLAIN)(t)
        q, u = np.split(y, 2)
        return np.array(
            chain_accelerations.accelerations(scene.structure, p, q, u, chain_accelerations.NUMBERS)
        )

    return found


@pytest.mark.parametrize(
    ("boundary", "inertia"),
    [("free", "uniform"), ("cantilever", "lumped"), ("clamped", "lumped"), ("pinned", "uniform")],
)
def test_expressions_are_the_scene(boundary: str, inertia: str) -> None:
    """With all loads: a hundred roundings of some 1000 operations."""
    given = job(boundary, inertia, LOADS | FINS)
    assert len(given.stretches) == 3  # kinks at 0.06 and 0.1 s
    assert peer.check_accelerations(given, by_hand(given)) < 1e-13


@pytest.mark.parametrize("table", [*LOADS, "external_damping"])
def test_a_load_that_is_left_out_is_seen(table: str) -> None:
    whole, less = LOADS | FINS, {k: v for k, v in (LOADS | FINS).items() if k != table}
    with pytest.raises(ArithmeticError, match="differ"):
        peer.check_accelerations(
            job("clamped", "lumped", whole), by_hand(job("clamped", "lumped", less))
        )


def test_expressions_without_conditions() -> None:
    given = job("free", "uniform", LOADS)
    for middle in (0.03, 0.08, 0.15):
        at = loads.parameters(given.scene, middle, loads.PLAIN)
        for t in (middle, middle + 0.01):
            for name, expression in given.scene.time_dependent_loads.items():
                assert at(t)[name] == pytest.approx(float(expression(t)), rel=1e-14, abs=1e-16)


def test_stretches_hold_every_sample_once() -> None:
    given = job("free", "uniform", LOADS | {"tip": {"x": "max(t - 0.0613, 0)"}})
    found = given.stretches
    sampled = np.concatenate([one.times[: one.samples] for one in found])
    assert sampled == pytest.approx(given.sample_times[1:], abs=1e-15)
    assert [one.last for one in found] == pytest.approx([0.0613, 0.1, 0.2])
    pieces = [pair for one in found for pair in peer.runs(one)]
    for before, times in pieces:
        gaps = np.diff(times, prepend=before)
        assert gaps == pytest.approx(gaps[0], rel=1e-6)
    assert np.concatenate([times for _, times in pieces])[-1] == given.sample_times[-1]


def test_relative_angles() -> None:
    tree = Tree.of(job("free", "uniform", LOADS).scene)
    half = np.arange(7.0) ** 2
    assert tree.relative(half) == pytest.approx([0, 1, 4, 5, 7, 9, 11])
    assert tree.absolute(tree.relative(half)) == pytest.approx(half)
    many = np.stack([half, 2 * half])
    assert tree.absolute(np.stack([tree.relative(one) for one in many])) == pytest.approx(many)


def truth(given: Job) -> Any:
    tight = {"method": "dop853", "rtol": 1e-12, "atol": 1e-13}
    return rodgen.simulate(given.scene, model=given.model, **tight).y


# Settings that are tried, from loose on, and the error that the last may have. Adaptive methods: of
# 1e-8 and a hundred times it, since errors of many steps add up; steps: 1/16 of the longest, and
# the order of the method (rates of up to 100 rad/s in steps of 1/8000 s).
TRIED: dict[str, tuple[int, float]] = {
    "SciPy": (13, 1e-6),
    "CVODE": (13, 1e-5),
    "CasADi": (13, 1e-5),
    "heyoka": (1, 1e-4),
    "CasADi collocation": (1, 1e-8),
    "MuJoCo Euler": (5, 3e-2),
    "MuJoCo implicitfast": (5, 3e-2),
    "MuJoCo RK4": (3, 1e-6),
    "Exudyn generalized-alpha": (3, 1e-3),
    "Exudyn RK44": (3, 1e-6),
}


@pytest.mark.parametrize("name", FAMILIES)
def test_motion(name: str) -> None:
    """All loads that it knows, which kink twice."""
    needs(name)
    given = job("clamped", "lumped", LOADS, kind=Job)
    count, limit = TRIED[name] if name in TRIED else TRIED[name.split()[0]]
    exact, errors = truth(given), []
    tried = list(islice(family(name, given), count))
    assert all(a.setting > b.setting for a, b in pairwise(tried))
    for who in (tried[0], tried[-1]):
        finish = who.integrate()
        assert finish.y.shape == (len(given.sample_times), len(given.initial_state))
        assert finish.y[0] == pytest.approx(given.initial_state)
        errors.append(float(np.abs(finish.y - exact).max()))
        assert all(type(number) is int for number in finish.counts.values())
    assert errors[-1] < limit
    assert count == 1 or errors[-1] < 0.5 * errors[0]  # tighter is better
    assert tried[0].agreed is None if name.startswith(("SciPy", "CVODE")) else True


@pytest.mark.parametrize("name", [n for n in FAMILIES if n.split()[0] in ("MuJoCo", "Exudyn")])
def test_free_and_pinned_motion(name: str) -> None:
    """Coordinates of joint 0, thrust that does not change, no springs."""
    needs(name)
    for boundary in ("free", "pinned"):
        tables = {"follower": {"force": 20.0}, "gravity": {"g": 9.81}}
        given = job(boundary, "uniform", tables)
        count, limit = TRIED[name]
        *_, last = islice(family(name, given), count)
        assert np.abs(last.integrate().y - truth(given)).max() < limit
        assert last.agreed is not None
        assert last.agreed < 1e-10


@pytest.mark.parametrize(
    "name", ["MuJoCo Euler", "MuJoCo implicitfast", "MuJoCo RK4", "Exudyn RK44"]
)
def test_chain_at_rest_has_steps(name: str) -> None:
    """Horizontal, without stiffness: nothing has a frequency at the start."""
    needs(name)
    table = next(case.scene for case in cases() if case.name == "falling_chain")
    given = InNumpy.of("falling_chain", table)
    first = next(family(name, given))
    assert first.setting == pytest.approx(2.5 / 100)  # that of a sample


def test_steps_without_a_limit_are_samples() -> None:
    given = job("free", "uniform", {})
    assert peer.stable(2.0, 0.0) == math.inf
    assert peer.stable(2.0, 4.0) == 0.5
    assert list(islice(peer.steps(given, math.inf, False), 2)) == [0.2 / 100, 0.1 / 100]
    assert next(peer.steps(given, 0.2 / 150, False)) == 0.1 / 100


@pytest.mark.parametrize("who", ["heyoka", "MuJoCo", "Exudyn"])
def test_what_cannot_be_modelled_is_refused(who: str) -> None:
    needs(who)
    name = next(n for n in FAMILIES if n.startswith(who))
    with pytest.raises(NotModelledError, match=rf"\b{who}\b.* external damping"):
        family(name, job("free", "uniform", LOADS | FINS))


def test_too_many_links_are_refused() -> None:
    many = Job.of("many", Scene.from_dict(rod("many", 1000, 0.01)))
    names = [
        "SciPy Radau",
        *(
            f"{who} {LIBRARIES[who].methods[0]}"
            for who in LIBRARIES
            if LIBRARIES[who].methods and who != "SciPy"
        ),
    ]
    for name in names:
        if find_spec(LIBRARIES[name.split()[0]].package):
            with pytest.raises(NotModelledError, match=r"1000 links|than \d+ links"):
                family(name, many)


def test_casadi_knows_external_damping() -> None:
    needs("CasADi")
    given = job("free", "uniform", LOADS | FINS)
    who = next(family("CasADi CVODES Adams", given))
    assert who.agreed is not None
    assert who.agreed < 1e-13


@pytest.mark.parametrize("name", RATES)
def test_rates(name: str) -> None:
    """Against rodgen's, at a random state; PyDy and Numba take ten seconds to compile."""
    needs(name)
    if name.startswith(("PyDy", "Numba")):
        pytest.skip("takes ten seconds to compile; its rates are checked in the report")
    prepared = prepared_rates(name, 5)
    y = np.random.default_rng(3).normal(scale=0.3, size=14)
    ours = built(5, THRUST)
    exact = ours.rhs(0.0, y, parameter_vector(ours))
    assert peer.difference(prepared.rhs(y), exact) < 1e-12
    assert prepared.batch(3) > 0
