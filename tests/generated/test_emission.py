"""What is in a module and what is not; the same bytes from everywhere."""

from __future__ import annotations

import ast
import hashlib
import os
import subprocess
import sys
from collections.abc import Callable
from types import ModuleType

import numpy as np
import pytest
from rodgen.derive import inertia
from rodgen.derive.symbols import xi

from rodgen.emit import module_files, module_text
from rodgen.emit.check import LIMIT, check_module
from rodgen.loading import load_text
from rodgen.scene.expression import Expression
from rodgen.scene.structure import (
    BOUNDARIES,
    BOUNDARY_PARAMETERS,
    INERTIAS,
    TERM_PARAMETERS,
    TERMS,
    Structure,
)

Built = Callable[..., ModuleType]
Written = Callable[..., dict[str, str]]
EVERY = pytest.mark.parametrize("inertia", INERTIAS)


def _chains(*links: int) -> list[tuple[str, int]]:
    """Every boundary with every number of links of which one moves."""
    return [(b, n) for b in BOUNDARIES for n in links if n >= BOUNDARIES[b].least_links]


SUBSETS = [(), *((term,) for term in TERMS), ("follower", "external_damping"), TERMS]


def _check(module: ModuleType) -> None:
    deviations = list(check_module(module, states=2))
    expected = {"rhs", "mass matrix", "energy", "joints", "centre of gravity", "inertia"}
    expected |= {"bending moments", "generalised force"}
    assert {d.quantity for d in deviations} - {"power", "forces"} == expected
    # Rounding of some hundred operations, amplified by the condition of M (about 20 at n=5).
    assert max(d.error for d in deviations) < 1e-13


# Loads alone with three links, of which one is inside; all of them with few and with more.
SMALL = [
    *((b, n, terms) for b, n in _chains(3) for terms in SUBSETS),
    *((b, n, terms) for b, n in _chains(1, 2, 5) for terms in ((), TERMS)),
]
SMALL_CHAINS = pytest.mark.parametrize(
    ("boundary", "links", "terms"),
    SMALL,
    ids=lambda x: ("+".join(x) or "none") if isinstance(x, tuple) else str(x),
)


@EVERY
@SMALL_CHAINS
def test_module_equals_fifty_digit_arithmetic(
    built: Built, boundary: str, links: int, inertia: str, terms: tuple[str, ...]
) -> None:
    _check(built(Structure(links, boundary, inertia, terms)))


@EVERY
@pytest.mark.parametrize(("boundary", "links"), _chains(1, 2, 3, 5))
def test_dense_form_equals_fifty_digit_arithmetic(
    built: Built, boundary: str, links: int, inertia: str
) -> None:
    _check(built(Structure(links, boundary, inertia, TERMS), "numpy", "dense"))


@pytest.mark.parametrize("boundary", ["free", "clamped"])
@pytest.mark.parametrize("terms", SUBSETS[:-1], ids=lambda terms: "+".join(terms) or "none")
def test_dense_form_of_every_load(built: Built, boundary: str, terms: tuple[str, ...]) -> None:
    _check(built(Structure(3, boundary, terms=terms), "numpy", "dense"))


@EVERY
@pytest.mark.parametrize("form", ["chain", "dense"])
@pytest.mark.parametrize("boundary", BOUNDARIES)
def test_longer_modules_pass_the_check(
    built: Built, boundary: str, inertia: str, form: str
) -> None:
    module = built(Structure(50, boundary, inertia, TERMS), "numpy", form)
    assert max(d.error for d in check_module(module, states=1)) < LIMIT


@EVERY
@pytest.mark.parametrize("links", [1000])
@pytest.mark.parametrize("boundary", BOUNDARIES)
def test_forms_agree_however_long_the_chain(
    built: Built, boundary: str, inertia: str, links: int
) -> None:
    structure = Structure(links, boundary, inertia, TERMS)
    chain, dense = built(structure), built(structure, "numpy", "dense")
    draw = np.random.default_rng(links)
    names = [name for name in chain.PARAMETERS if not name.startswith("fin_factor")]
    p = chain.parameters(**{name: draw.uniform(0.5, 5.0) for name in names})
    y = draw.standard_normal(len(chain.STATE))
    one, two = chain.rhs(0.0, y, p), dense.rhs(0.0, y, p)
    # The condition of M grows as n^3, to 5e8 at n = 1000; the dense form loses that many digits.
    limit = 5e8 * (links / 1000) ** 3 * np.finfo(float).eps
    np.testing.assert_allclose(one, two, rtol=0, atol=limit * np.abs(two).max())


def test_long_chain_keeps_its_digits(built: Built, point: type) -> None:
    """A hundred links: the exact solution of two hundred takes 50-digit arithmetic ten seconds."""
    at = point(built(Structure(100)))
    dense = built(Structure(100), "numpy", "dense")
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
        ('acting["follower"][..., 4, 0] = ', 'acting["follower"][..., 3, 0] = '),
        ("Q[2:] = on_links", "Q[2:] = 1.001*on_links"),
    ],
)
def test_check_sees_a_wrong_module(written: Written, right: str, wrong: str) -> None:
    (text,) = written(Structure(4)).values()
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


@pytest.mark.parametrize(
    ("form", "inertia"), [("chain", "uniform"), ("chain", "lumped"), ("dense", "uniform")]
)
@pytest.mark.parametrize("boundary", BOUNDARIES)
@pytest.mark.parametrize("terms", SUBSETS, ids=lambda terms: "+".join(terms) or "none")
def test_module_holds_only_what_the_scene_has(
    written: Written, boundary: str, inertia: str, form: str, terms: tuple[str, ...]
) -> None:
    (text,) = written(Structure(3, boundary, inertia, terms), "numpy", form).values()
    tree = ast.parse(text)
    names = {node.id for node in ast.walk(tree) if isinstance(node, ast.Name)}
    for term in TERMS:
        for parameter in TERM_PARAMETERS[term]:
            assert (parameter in names) == (term in terms), parameter
    assert ("clamp_angle" in names) == ("clamp_angle" in BOUNDARY_PARAMETERS[boundary])
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


@EVERY
@SMALL_CHAINS
def test_nothing_in_a_module_is_unused(
    written: Written, boundary: str, links: int, inertia: str, terms: tuple[str, ...]
) -> None:
    (text,) = written(Structure(links, boundary, inertia, terms)).values()
    _all_used(text)


@pytest.mark.parametrize("boundary", ["free", "clamped"])
@pytest.mark.parametrize("terms", SUBSETS, ids=lambda terms: "+".join(terms) or "none")
def test_nothing_in_a_dense_module_is_unused(
    written: Written, boundary: str, terms: tuple[str, ...]
) -> None:
    (text,) = written(Structure(3, boundary, terms=terms), "numpy", "dense").values()
    _all_used(text)


def _all_used(text: str) -> None:
    tree = ast.parse(text)
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
    (text,) = written(Structure(1)).values()
    names = {node.id for node in ast.walk(ast.parse(text)) if isinstance(node, ast.Name)}
    assert not {"k", "joint_moment", "link_moment", "spring"} & names
    assert "later" not in text
    assert "lapack" not in text


@pytest.mark.parametrize("form", ["chain", "dense"])
def test_loops_stay_loops(written: Written, form: str) -> None:
    sizes = [
        len("".join(written(Structure(n), "numpy", form).values()).encode())
        for n in (20, 200, 2000)
    ]
    assert sizes[-1] < 60_000
    # Only numbers get longer: by one digit at each of the same places.
    assert sizes[2] - sizes[1] == sizes[1] - sizes[0] < 1000


EXPRESSIONS = {
    "follower_force": "300 * min(t / 0.5, 1, 2 - t) + tan(t) ** 2",
    "tip_force_x": "-1.5 * sin(t) ** 2 if t <= 0.7 else max(t, 0.5) ** -1.5",
    "tip_force_y": "exp(-t) * log(2 + t) / sqrt(1 + t) + tanh(t) * abs(cos(5 * t)) - pi",
}
TARGETS = [("numpy", "chain"), ("numpy", "dense"), ("c", "chain")]


@pytest.mark.parametrize("target", TARGETS, ids="-".join)
def test_expressions_in_time_are_part_of_the_code(built: Built, target: tuple[str, str]) -> None:
    structure = Structure(4, "clamped", terms=TERMS, expressions=tuple(EXPRESSIONS.items()))
    module = built(structure, *target)
    assert not {*EXPRESSIONS} & {*module.PARAMETERS}
    read = {name: Expression(text, "t") for name, text in EXPRESSIONS.items()}
    assert {name: e.canonical for name, e in read.items()} == module.EXPRESSIONS
    assert max(d.error for d in check_module(module, states=2)) < 1e-13
    plain = built(Structure(4, "clamped", terms=TERMS), *target)
    given = {"mass": 2.0, "length": 1.0, "bending_stiffness": 5.0, "internal_damping": 0.1}
    given["external_damping"] = 0.3
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


SEED_PROGRAM = """
import hashlib
from rodgen.emit import module_files
from rodgen.scene.structure import Structure
timed = (("tip_force_x", "sin(t)*min(t, 1, 2)"),)
one = Structure(7, "clamped", "lumped", ("internal_damping", "tip_load"), timed)
two = Structure(12, "free", "uniform", ("follower", "external_damping"))
made = ((one, "numpy", "chain"), (one, "numpy", "dense"), (two, "c", "chain"))
for structure, target, form in made:
    for name, text in module_files(structure, target, form).items():
        print(name, hashlib.sha256(text.encode()).hexdigest())
"""


def test_same_bytes_under_any_hash_seed() -> None:
    command = [sys.executable, "-c", SEED_PROGRAM]
    running = [
        subprocess.Popen(
            command,
            env={**os.environ, "PYTHONHASHSEED": seed},
            stdout=subprocess.PIPE,
            text=True,
        )
        for seed in ("0", "1", "random")
    ]
    outputs = {process.communicate()[0] for process in running}
    assert [process.returncode for process in running] == [0, 0, 0]
    (printed,) = outputs
    assert len(printed.splitlines()) == 1 + 1 + 3
    structure = Structure(12, terms=("follower", "external_damping"))
    for text in module_files(structure, "c").values():
        assert hashlib.sha256(text.encode()).hexdigest() in printed
