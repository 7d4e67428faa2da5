"""What is in a module and what is not; the same bytes from everywhere."""

from __future__ import annotations

import ast
import hashlib
import os
import subprocess
import sys

import numpy as np
import pytest

from rodgen.derive import inertia
from rodgen.derive.symbols import xi
from rodgen.emit import module_text
from rodgen.emit.check import LIMIT, check_module
from rodgen.loading import load_text
from rodgen.scene.structure import BOUNDARIES, TERM_PARAMETERS, TERMS, Structure


def _chains(*links: int) -> list[tuple[str, int]]:
    """Every boundary with every number of links of which one moves."""
    return [(b, n) for b in BOUNDARIES for n in links if n >= BOUNDARIES[b].least_links]


SUBSETS = [(), *((term,) for term in TERMS), ("follower", "external_damping"), TERMS]


@pytest.mark.parametrize(("boundary", "links"), _chains(1, 2, 3, 5))
@pytest.mark.parametrize("terms", SUBSETS, ids=lambda terms: "+".join(terms) or "none")
def test_module_equals_fifty_digit_arithmetic(
    boundary: str, links: int, terms: tuple[str, ...]
) -> None:
    structure = Structure(links, boundary, terms=terms)
    module = load_text(module_text(structure), structure.stem)
    deviations = list(check_module(module, states=2))
    expected = {"rhs", "mass matrix", "energy", "joints", "centre of gravity", "inertia"}
    assert {d.quantity for d in deviations} - {"power"} == expected
    # Rounding of some hundred operations, amplified by the condition of M (about 20 at n=5).
    assert max(d.error for d in deviations) < 1e-13


@pytest.mark.parametrize("boundary", BOUNDARIES)
@pytest.mark.parametrize("links", [20, 50])
def test_longer_modules_pass_the_check(boundary: str, links: int) -> None:
    structure = Structure(links, boundary)
    module = load_text(module_text(structure), structure.stem)
    assert max(d.error for d in check_module(module, states=1)) < LIMIT


@pytest.mark.parametrize(
    ("right", "wrong"),
    [
        ("force_y = ", "force_y = 1e-8 + "),
        ("return np.stack((joint_x, joint_y)", "return np.stack((1.00001*joint_x, joint_y)"),
        ("return np.stack((centre_x, centre_y)", "return np.stack((centre_x, 1.1*centre_y)"),
        ("return inertia_x,", "return 1.001*inertia_x,"),
        ("    return M\n", "    return 1.001*M\n"),
        ('"follower": power_follower', '"follower": 1.001*power_follower'),
        ("return kinetic,", "return 1.001*kinetic,"),
    ],
)
def test_check_sees_a_wrong_module(right: str, wrong: str) -> None:
    text = module_text(Structure(4))
    assert text.count(right) == 1
    module = load_text(text.replace(right, wrong), "wrong")
    assert max(d.error for d in check_module(module)) > LIMIT


def test_change_of_inertia_reaches_the_module(monkeypatch: pytest.MonkeyPatch) -> None:
    """Point masses at the ends of the links instead of spread mass, in derive/ alone."""
    structure = Structure(3, terms=())
    before = load_text(module_text(structure), "before")
    monkeypatch.setitem(inertia.INERTIAS, "uniform", lambda f: (f.subs(xi, 0) + f.subs(xi, 1)) / 2)
    after = load_text(module_text(structure), "after")
    p = before.parameters(mass=3.0, length=3.0, bending_stiffness=1.0)
    y = np.zeros(10)
    # m l^2 (1/3 + n - i - 1) with m = l = 1 becomes m l^2 (1/2 + n - i - 1)
    difference = after.mass_matrix(y, p) - before.mass_matrix(y, p)
    np.testing.assert_allclose(difference, np.diag([0, 0, 1 / 6, 1 / 6, 1 / 6]), atol=1e-15)
    y[5:] = 1.0
    assert after.energy(y, p)[0] > before.energy(y, p)[0]


@pytest.mark.parametrize("boundary", BOUNDARIES)
@pytest.mark.parametrize("terms", SUBSETS, ids=lambda terms: "+".join(terms) or "none")
def test_module_holds_only_what_the_scene_has(boundary: str, terms: tuple[str, ...]) -> None:
    text = module_text(Structure(4, boundary, terms=terms))
    names = {node.id for node in ast.walk(ast.parse(text)) if isinstance(node, ast.Name)}
    for term in TERMS:
        for parameter in TERM_PARAMETERS[term]:
            assert (parameter in names) == (term in terms), parameter
    assert ("clamp_angle" in names) == (boundary == "cantilever")
    assert ("vx0" in names) == (boundary == "free")
    assert ("drag_x" in names) == ("external_damping" in terms)
    assert "errstate" not in text
    assert "EXPRESSIONS" not in text
    assert ("def power" in text) == bool(set(terms) - {"gravity"})


@pytest.mark.parametrize(("boundary", "links"), _chains(1, 2, 6))
@pytest.mark.parametrize("terms", SUBSETS, ids=lambda terms: "+".join(terms) or "none")
def test_nothing_in_a_module_is_unused(boundary: str, links: int, terms: tuple[str, ...]) -> None:
    tree = ast.parse(module_text(Structure(links, boundary, terms=terms)))
    assert not _unused_locals(tree)
    public = {"rhs", "energy", "power", "mass_matrix", "joints", "parameters"}
    public |= {"centre_of_gravity", "inertia"}
    functions = {f.name for f in tree.body if isinstance(f, ast.FunctionDef)}
    used = {node.id for node in ast.walk(tree) if isinstance(node, ast.Name)}
    assert functions - public <= used
    imported = {a.asname or a.name for node in tree.body for a in getattr(node, "names", ())}
    assert imported <= used


def _unused_locals(tree: ast.Module) -> set[str]:
    unused = set()
    for function in (f for f in tree.body if isinstance(f, ast.FunctionDef)):
        names = [node for node in ast.walk(function) if isinstance(node, ast.Name)]
        written = {n.id for n in names if isinstance(n.ctx, ast.Store)}
        read = {n.id for n in names if isinstance(n.ctx, ast.Load)}
        unused |= {f"{function.name}: {name}" for name in written - read - {"_"}}
    return unused


def test_single_link_has_no_springs() -> None:
    text = module_text(Structure(1))
    assert "moment_" not in text
    assert "later" not in text


def test_loops_stay_loops() -> None:
    small, large = (len(module_text(Structure(n)).encode()) for n in (20, 200))
    assert large < 60_000
    assert large - small < 200  # only the numbers get longer


def test_expression_in_time_is_part_of_the_code() -> None:
    expressions = (("follower_force", "300 * min(t / 0.5, 1)"),)
    structure = Structure(4, expressions=expressions)
    module = load_text(module_text(structure), "timed")
    assert "follower_force" not in module.PARAMETERS
    assert dict(expressions) == module.EXPRESSIONS
    assert max(d.error for d in check_module(module, states=2)) < 1e-13
    plain = load_text(module_text(Structure(4)), "plain")
    given = {"mass": 2.0, "length": 1.0, "bending_stiffness": 5.0, "internal_damping": 0.1}
    given["external_damping"] = 0.3
    y = np.random.default_rng(1).normal(size=12)
    p = module.parameters(**given)
    for t, force in ((0.0, 0.0), (0.25, 150.0), (2.0, 300.0)):
        q = plain.parameters(**given, follower_force=force)
        np.testing.assert_array_equal(module.rhs(t, y, p), plain.rhs(t, y, q))
    times = np.array([0.25, 2.0])
    both = module.power(times, np.stack((y, y)), p)["follower"]
    one = [module.power(t, y, p)["follower"] for t in times]
    np.testing.assert_allclose(both, one, rtol=1e-14)


SEED_PROGRAM = """
import hashlib
from rodgen.emit import module_text
from rodgen.scene.structure import Structure
for boundary in ("free", "cantilever"):
    print(hashlib.sha256(module_text(Structure(7, boundary)).encode()).hexdigest())
"""


def test_same_bytes_under_any_hash_seed() -> None:
    outputs = set()
    for seed in ("0", "1", "4242", "random"):
        env = {**os.environ, "PYTHONHASHSEED": seed}
        command = [sys.executable, "-c", SEED_PROGRAM]
        done = subprocess.run(command, env=env, capture_output=True, text=True, check=True)
        outputs.add(done.stdout)
    assert len(outputs) == 1
    here = hashlib.sha256(module_text(Structure(7)).encode()).hexdigest()
    assert here in outputs.pop()
