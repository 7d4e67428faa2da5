"""What is in a module and what is not; the same bytes from everywhere."""

from __future__ import annotations

import ast
import hashlib
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

from rodgen.check.module import LIMIT, _parameters, check_module
from rodgen.derive import inertia
from rodgen.derive.symbols import xi
from rodgen.emit import module_files, module_text
from rodgen.emit.targets import FORMS
from rodgen.loading import load_text
from rodgen.model.rod import BOUNDARIES, INERTIAS
from rodgen.model.terms import TERMS
from rodgen.scene.expression import Expression
from rodgen.scene.structure import Structure
from tests.palette import ALL, ENDS, SHORT_RODS, TIMED, can_move, cases

Built = Callable[..., ModuleType]
Written = Callable[..., dict[str, str]]
EPSILON = np.finfo(float).eps
REFERENCE = Path(__file__).parents[2] / "generated" / "rod_free_n5.py"
SUBSETS = [(), *((term,) for term in TERMS), ("follower", "external_damping"), ALL]
# Of three links, of which one is inside.
EVERY_LOAD = cases("boundary, inertia, form, terms", BOUNDARIES, INERTIAS, FORMS, SUBSETS)
PARTS = ("rhs", "jac", "mass", "power", "quantities")


def _check(module: ModuleType) -> None:
    deviations = list(check_module(module, states=2))
    expected = {"rhs", "mass matrix", "energy", "joints", "centre of gravity", "inertia"}
    expected |= {"bending moments", "generalised force"}
    assert {d.quantity for d in deviations} - {"power", "forces"} == expected
    # Rounding of some hundred operations, amplified by the condition of M (about 20 at n=5). A
    # power is what remains of force times velocity where one is nearly normal to the other: that
    # of a distributed follower on a nearly straight rod, 1e-4 of it.
    limits = {"power": LIMIT}
    assert [d for d in deviations if d.error >= limits.get(d.quantity, 1e-12)] == []


def _text(written: Written, structure: Structure, form: str) -> str:
    (text,) = written(structure, "numpy", form, PARTS).values()
    return text


@SHORT_RODS
def test_module_equals_fifty_digit_arithmetic(
    built: Built,
    written: Written,
    boundary: str,
    links: int,
    inertia: str,
    terms: tuple[str, ...],
) -> None:
    """And nothing in its text is unused."""
    structure = Structure(links, boundary, inertia, terms)
    _check(built(structure))
    _all_used(ast.parse(_text(written, structure, "chain")))


@EVERY_LOAD
def test_every_load_equals_fifty_digit_arithmetic(
    built: Built, boundary: str, inertia: str, form: str, terms: tuple[str, ...]
) -> None:
    _check(built(Structure(3, boundary, inertia, terms), "numpy", form))


@cases("boundary, links, inertia", BOUNDARIES, (1, 2, 5), INERTIAS, where=can_move)
def test_dense_form_equals_fifty_digit_arithmetic(
    built: Built, boundary: str, links: int, inertia: str
) -> None:
    _check(built(Structure(links, boundary, inertia, ALL), "numpy", "dense"))


@pytest.mark.nightly
@pytest.mark.parametrize(
    ("boundary", "inertia", "form"), [("clamped", "uniform", "chain"), ("free", "lumped", "dense")]
)
def test_longer_modules_pass_the_check(
    built: Built, boundary: str, inertia: str, form: str
) -> None:
    module = built(Structure(30, boundary, inertia, TERMS), "numpy", form)
    assert max(d.error for d in check_module(module, states=1)) < LIMIT


@pytest.mark.parametrize(("boundary", "inertia"), [("free", "uniform"), ("cantilever", "lumped")])
def test_forms_agree_however_long_the_chain(built: Built, boundary: str, inertia: str) -> None:
    links = 1000
    structure = Structure(links, boundary, inertia, TERMS)
    chain, dense = built(structure), built(structure, "numpy", "dense")
    draw = np.random.default_rng(links)
    p = chain.parameters(**_parameters(chain, 0.0, draw))
    y = draw.standard_normal(len(chain.STATE))
    one, two = chain.rhs(0.0, y, p), dense.rhs(0.0, y, p)
    # The condition of M grows as n^3, to 5e8 at n = 1000; the dense form loses that many digits.
    np.testing.assert_allclose(one, two, rtol=0, atol=5e8 * EPSILON * np.abs(two).max())


def test_long_chain_keeps_its_digits(built: Built, point: type) -> None:
    """Sixty links: the exact solution of two hundred takes 50-digit arithmetic ten seconds."""
    at = point(built(Structure(60)))
    dense = built(Structure(60), "numpy", "dense")
    exact = np.array(at.exact_rhs(at.y), float)
    errors = [np.abs(m.rhs(at.t, at.y, at.p) - exact).max() for m in (at.module, dense)]
    assert errors[0] <= 1e-11 * np.abs(exact).max()
    assert errors[0] <= 2 * errors[1]  # no worse than the dense form; one state has some luck


@pytest.mark.parametrize(
    ("right", "wrong"),
    [
        ("pull_x = ", "pull_x = 1e-8 + "),
        ("base_ay = ", "base_ay = 1e-8 + "),
        ("return np.stack((joint_x, joint_y)", "return np.stack((1.00001*joint_x, joint_y)"),
        ("return np.stack((centre_x, centre_y)", "return np.stack((centre_x, 1.1*centre_y)"),
        ("return inertia_x,", "return 1.001*inertia_x,"),
        ("    return M\n", "    return 1.001*M\n"),
        ('"follower": power_follower', '"follower": 1.001*power_follower'),
        ("return kinetic,", "return 1.001*kinetic,"),
        ("return bending\n", "return -bending\n"),
        ('acting["follower"][..., 5, 0] = ', 'acting["follower"][..., 4, 0] = '),
        ("Q[2:] = on_links", "Q[2:] = 1.001*on_links"),
    ],
)
def test_check_sees_a_wrong_module(right: str, wrong: str) -> None:
    text = REFERENCE.read_text(encoding="utf-8")
    at = text.index("def rhs") if " = " in right else 0
    assert right in text[at:]
    module = load_text(text[:at] + text[at:].replace(right, wrong, 1), "wrong")
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


@EVERY_LOAD
def test_module_holds_only_what_the_scene_has(
    written: Written, boundary: str, inertia: str, form: str, terms: tuple[str, ...]
) -> None:
    text = _text(written, Structure(3, boundary, inertia, terms), form)
    tree = ast.parse(text)
    names = {node.id for node in ast.walk(tree) if isinstance(node, ast.Name)}
    for term in TERMS.values():
        for parameter in term.parameters:
            assert (parameter.name in names) == (term.name in terms), parameter
    assert ("clamp_angle" in names) == BOUNDARIES[boundary].clamped
    assert ("vx0" in names) == (boundary == "free")
    assert ("drag_x" in names) == ("external_damping" in terms)
    (rhs,) = (f for f in tree.body if isinstance(f, ast.FunctionDef) and f.name == "rhs")
    solved = {node.id for node in ast.walk(rhs) if isinstance(node, ast.Name)}
    assert ("lambda_x" in solved) == (form == "chain" and inertia == "uniform")
    assert ("tension" in solved) == (form == "chain" and inertia == "lumped")
    assert ("dposv" in names) == (form == "dense")
    assert "errstate" not in text
    assert "EXPRESSIONS" not in text
    assert ("def power" in text) == bool(set(terms) - {"gravity"})
    _all_used(tree)


def _all_used(tree: ast.Module) -> None:
    assert not _unused_locals(tree)
    public = {"rhs", "jac", "implicit", "energy", "power", "mass_matrix", "joints", "parameters"}
    public |= {"centre_of_gravity", "inertia", "bending_moments", "forces", "generalised_force"}
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


def test_single_link_has_no_springs(written: Written) -> None:
    (text,) = written(Structure(1), "numpy", "chain", PARTS).values()
    names = {node.id for node in ast.walk(ast.parse(text)) if isinstance(node, ast.Name)}
    assert not {"k", "joint_moment", "link_moment", "spring"} & names
    assert "later" not in text
    assert "lapack" not in text


@pytest.mark.parametrize("form", FORMS)
def test_loops_stay_loops(written: Written, form: str) -> None:
    parts = ("rhs", "jac", "quantities")
    made = (written(Structure(n), "numpy", form, parts).values() for n in (20, 2000))
    short, long = (len(text) for (text,) in made)
    # Only numbers get longer: by two digits at some places.
    assert short <= long < min(60_000, short + 2000)
    assert (long - short) % 2 == 0


TARGETS = [("numpy", "chain"), ("numpy", "dense"), ("c", "chain")]


@pytest.mark.parametrize("target", TARGETS, ids="-".join)
def test_expressions_in_time_are_part_of_the_code(built: Built, target: tuple[str, str]) -> None:
    module = built(TIMED, *target)
    read = {name: Expression(text, "t") for name, text in TIMED.expressions}
    assert not read.keys() & {*module.PARAMETERS}
    assert {name: e.canonical for name, e in read.items()} == module.EXPRESSIONS
    assert max(d.error for d in check_module(module, states=2)) < 1e-13
    plain = built(Structure(4, "clamped", terms=ENDS), *target)
    given = {"mass": 2.0, "length": 1.0, "bending_stiffness": 5.0, "internal_damping": 0.1}
    given |= {"external_damping": 0.3}
    y = np.random.default_rng(1).normal(size=8)
    p = module.parameters(**given)
    times = [-0.3, 0.0, 0.25, 0.7, np.nextafter(0.7, 1), 1.9, 3.0]
    for t in times:
        q = plain.parameters(**given, **{name: e(t) for name, e in read.items()})
        one, two = module.rhs(t, y, p), plain.rhs(t, y, q)
        # libm's functions and NumPy's may differ by a unit in the last place.
        np.testing.assert_allclose(one, two, rtol=0, atol=1e-13 * np.abs(two).max())
        one, two = module.jac(t, y, p), plain.jac(t, y, q)
        np.testing.assert_allclose(one, two, rtol=0, atol=1e-13 * np.abs(two).max())
    both = module.power(np.array(times), np.stack([y] * len(times)), p)
    for term in ("follower", "tip_load"):
        one = [module.power(t, y, p)[term] for t in times]
        np.testing.assert_allclose(both[term], one, rtol=1e-14)


@pytest.mark.parametrize("target", TARGETS, ids="-".join)
def test_force_that_is_no_number_is_seen_in_the_rates(
    built: Built, target: tuple[str, str]
) -> None:
    text = "max(sqrt(0.5 - t), min(1/(t - 0.25), 3))"
    structure = Structure(3, "pinned", "lumped", ("tip_load",), (("tip_force_y", text),))
    module = built(structure, *target)
    p = module.parameters(mass=1.0, length=1.0, bending_stiffness=1.0)
    with np.errstate(all="ignore"):
        assert np.isfinite(module.rhs(0.4, np.zeros(6), p)).all()
        assert np.isnan(module.rhs(0.6, np.zeros(6), p)).any()


def digests() -> list[str]:
    """Of all texts of a NumPy module and of a C module."""
    timed = (("tip_force_x", "sin(t)*min(t, 1, 2)"),)
    one = Structure(7, "clamped", "lumped", ("internal_damping", "tip_load"), timed)
    two = Structure(12, "free", "uniform", ("follower", "external_damping"))
    made = module_files(one) | module_files(two, "c", parts=("rhs", "jac", "newton"))
    return [hashlib.sha256(text.encode()).hexdigest() for text in made.values()]


@pytest.mark.nightly  # as reference modules are compared in processes of any seed
def test_same_bytes_under_any_hash_seed() -> None:
    here = os.environ.get("PYTHONHASHSEED", "random")
    program = f"from {__name__} import digests; print(*digests())"
    done = subprocess.run(
        [sys.executable, "-c", program],
        cwd=Path(__file__).parents[2],
        env={**os.environ, "PYTHONHASHSEED": "1" if here == "0" else "0"},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.split() == digests()
