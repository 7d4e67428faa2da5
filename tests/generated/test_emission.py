"""NumPy modules: against 50-digit arithmetic, and what is in their text and what is not."""

from __future__ import annotations

import ast
from collections.abc import Callable

import numpy as np
import pytest
from sympy import Rational, symbols

from rodgen.check.module_check import LIMIT, _draw_parameters, check_module
from rodgen.emit.printer import NUMPY, Printer
from rodgen.emit.targets import FORMS
from rodgen.loading import load_text
from rodgen.model.rod import BOUNDARIES, INERTIAS
from rodgen.model.terms import TERMS
from rodgen.scene.structure import Structure
from tests.generated.conftest import Built, Written
from tests.palette import ALL, ALONG, ENDS, can_move, cases
from tests.reference import GENERATED

EPSILON = np.finfo(float).eps
PARTS = ("rhs", "jac", "mass", "power", "quantities")


@pytest.fixture
def exact(written: Written, point: type) -> Callable[[Structure, str], ast.Module]:
    """The text of a structure in a form, whose module is held against 50-digit arithmetic; nothing
    in it is unused."""

    def check(structure: Structure, form: str) -> ast.Module:
        (text,) = written(structure, "numpy", form, PARTS).values()
        module = load_text(text, structure.stem)
        deviations = list(check_module(module, states=1))
        expected = {"rhs", "mass matrix", "energy", "joints", "centre of gravity", "inertia"}
        expected |= {"bending moments", "generalised force"}
        assert {d.quantity for d in deviations} - {"power", "forces", "air"} == expected
        # Rounding of some hundred operations, amplified by the condition of M (about 20 at n=5). A
        # power is what remains of force times velocity where one is nearly normal to the other:
        # that of a distributed follower on a nearly straight rod, 1e-4 of it.
        # Likewise axial drag, by the small part along a link of a velocity across it.
        limits = dict.fromkeys(("power", "forces"), LIMIT)
        assert [d for d in deviations if d.error >= limits.get(d.quantity, 1e-12)] == []
        point(module).assert_jacobian(module.jac)
        assert "errstate" not in text
        assert "EXPRESSIONS" not in text
        tree = ast.parse(text)
        _all_used(tree)
        return tree

    return check


@cases(
    "boundary, links, inertia, terms, form",
    *(BOUNDARIES, (1, 2, 5), INERTIAS, ((), ENDS, ALONG), FORMS),
    where=can_move,
)
def test_module_equals_fifty_digit_arithmetic(
    exact: Callable[[Structure, str], ast.Module],
    boundary: str,
    links: int,
    inertia: str,
    terms: tuple[str, ...],
    form: str,
) -> None:
    exact(Structure(links, boundary, inertia, terms), form)


# Of three links, of which one is inside.
@cases("boundary, inertia, form, term", BOUNDARIES, INERTIAS, FORMS, ALL)
def test_module_of_one_load_is_right_and_holds_only_that(
    exact: Callable[[Structure, str], ast.Module], boundary: str, inertia: str, form: str, term: str
) -> None:
    tree = exact(Structure(3, boundary, inertia, (term,)), form)
    names = _names(tree)
    own = {one.name for one in TERMS[term].parameters if not one.optional}
    for parameter in (parameter for one in TERMS.values() for parameter in one.parameters):
        assert (parameter.name in names) == (parameter.name in own), parameter
    assert ("clamp_angle" in names) == BOUNDARIES[boundary].is_clamped
    assert ("vx0" in names) == (boundary == "free")
    assert ("drag_x" in names) == (term == "external_damping")
    functions = {f.name: f for f in tree.body if isinstance(f, ast.FunctionDef)}
    solved = _names(functions["rhs"])
    assert ("lambda_x" in solved) == (form == "chain" and inertia == "uniform")
    assert ("tension" in solved) == (form == "chain" and inertia == "lumped")
    assert ("dposv" in names) == (form == "dense")
    assert ("power" in functions) == (term not in ("gravity", "moment"))


def _names(tree: ast.AST) -> set[str]:
    return {node.id for node in ast.walk(tree) if isinstance(node, ast.Name)}


def _all_used(tree: ast.Module) -> None:
    functions = {f.name: f for f in tree.body if isinstance(f, ast.FunctionDef)}
    for name, function in functions.items():
        names = [node for node in ast.walk(function) if isinstance(node, ast.Name)]
        stored = {n.id for n in names if isinstance(n.ctx, ast.Store)}
        read = {n.id for n in names if isinstance(n.ctx, ast.Load)}
        assert stored - read <= {"_"}, name
    public = {"rhs", "jac", "implicit", "energy", "power", "mass_matrix", "joints", "parameters"}
    public |= {
        "__dir__",
        "centre_of_gravity",
        "inertia",
        "bending_moments",
        "forces",
        "generalised_force",
        "air",
    }
    used = _names(tree)
    assert functions.keys() - public <= used
    imported = {a.asname or a.name for node in tree.body for a in getattr(node, "names", ())}
    assert imported <= used


def test_single_link_has_no_springs(written: Written) -> None:
    (text,) = written(Structure(1), "numpy", "chain", PARTS).values()
    assert not {"k", "joint_moment", "link_moment", "spring"} & _names(ast.parse(text))
    assert "later" not in text
    assert "lapack" not in text


def test_sums_are_written_with_the_fewest_operations() -> None:
    """A divisor stands once where all terms have it, and before one of them where one has it."""
    a, b = symbols("a b")
    write = Printer(NUMPY, str, lambda symbol: 0)
    for expression, operations in (((a + b) / 2, 1), (a / 2 + b, 1), (a - 3 * b, 1)):
        tree = ast.parse(write(expression), mode="eval")
        products = [n for n in ast.walk(tree) if isinstance(n, ast.BinOp)]
        assert sum(isinstance(n.op, ast.Mult | ast.Div) for n in products) == operations
        value = eval(compile(tree, "", "eval"), {"a": 5.0, "b": 0.25})
        assert value == float(expression.subs({a: 5, b: Rational(1, 4)}))


def test_state_of_rest_has_a_jacobian(built: Built) -> None:
    """External damping is not smooth at rest: its derivative there is taken as zero."""
    rod = built(Structure(3))
    y = np.zeros(10)
    given = {"mass": 3.0, "length": 2.0, "bending_stiffness": 30.0}
    given |= {"follower_force": 1.0, "internal_damping": 0.1}
    damped, free = (
        rod.jac(0.0, y, rod.parameters(**given, external_damping=value)) for value in (9.0, 0.0)
    )
    assert np.isfinite(damped).all()
    np.testing.assert_allclose(damped, free, atol=1e-12)


# Long chains --------------------------------------------------------------------------------------


@pytest.mark.parametrize(("boundary", "inertia"), [("free", "uniform"), ("cantilever", "lumped")])
def test_forms_agree_however_long_the_chain(built: Built, boundary: str, inertia: str) -> None:
    links = 1000
    structure = Structure(links, boundary, inertia, ENDS)
    chain, dense = built(structure), built(structure, "numpy", "dense")
    draw = np.random.default_rng(links)
    p = chain.parameters(**_draw_parameters(chain, 0.0, draw))
    y = draw.standard_normal(len(chain.STATE))
    one, two = chain.rhs(0.0, y, p), dense.rhs(0.0, y, p)
    # The condition of M grows as n^3, to 5e8 at n = 1000; the dense form loses that many digits.
    np.testing.assert_allclose(one, two, rtol=0, atol=5e8 * EPSILON * np.abs(two).max())


@pytest.mark.slow
def test_long_chain_keeps_its_digits(built: Built, point: type) -> None:
    """Sixty links: the exact solution of two hundred takes 50-digit arithmetic ten seconds."""
    at = point(built(Structure(60)))
    dense = built(Structure(60), "numpy", "dense")
    exact = np.array(at.exact_rhs(at.y), float)
    errors = [np.abs(m.rhs(at.t, at.y, at.p) - exact).max() for m in (at.module, dense)]
    assert errors[0] <= 1e-11 * np.abs(exact).max()
    assert errors[0] <= 2 * errors[1]  # no worse than the dense form; one state has some luck


@pytest.mark.parametrize("form", FORMS)
def test_loops_stay_loops(written: Written, form: str) -> None:
    parts = ("rhs", "jac", "quantities")
    made = (written(Structure(n), "numpy", form, parts).values() for n in (20, 2000))
    short, long = (len(text) for (text,) in made)
    # Only numbers get longer: by two digits at some places.
    assert short <= long < min(60_000, short + 2000)
    assert (long - short) % 2 == 0


# What is wrong is seen ----------------------------------------------------------------------------

WRONG = [
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
]


@pytest.mark.slow
def test_check_sees_a_wrong_module() -> None:
    text = (GENERATED / "rod_free_n5.py").read_text(encoding="utf-8")
    for right, wrong in WRONG:
        at = text.index("def rhs") if " = " in right else 0
        assert right in text[at:]
        module = load_text(text[:at] + text[at:].replace(right, wrong, 1), "wrong")
        assert max(d.error for d in check_module(module)) > LIMIT, wrong
