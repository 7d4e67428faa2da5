"""Largest steps by trying, and errors in units of the last place."""

from __future__ import annotations

import math
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import mpmath
import numpy as np
import pytest

from rodgen.check.reference_equations import ReferenceEquations
from rodgen.loading import load_module
from rodgen.model.terms import THESIS_TERMS
from rodgen_evidence.report.contents import frame
from rodgen_evidence.report.stability import rounding, steps
from rodgen_evidence.report.stability.rounding import constraints, exact_rates
from rodgen_evidence.report.stability.rounding_states import ExtremeState, extremes
from rodgen_evidence.report.stability.steps import (
    Trial,
    grows,
    largest,
    own_step,
    radius,
    straight,
)

GENERATED = Path(__file__).parents[3] / "generated"
# Two uniform links joined by a spring k turn oppositely: T = m l^2/12 a'^2, V = k (2 a)^2/2.
TWO_LINKS = math.sqrt(24 * (100 / 2.5) / (25 * 2.5**2))
# Textbook limits of h omega without damping; that of the thesis's method is the root of its
# growth, see tests/physics/test_thesis_runge_kutta.py.
UNDAMPED = {"euler": 0.0, "semi_implicit_euler": 2.0, "rk4": math.sqrt(8), "dop853": 5.96}


@pytest.fixture(scope="module")
def two_links() -> Trial:
    return straight(2, steps.ROD)


@pytest.mark.compiler
def test_mode_is_that_of_two_links(two_links: Trial) -> None:
    assert two_links.mode.omega == pytest.approx(TWO_LINKS, rel=1e-12)  # rounding


@pytest.mark.compiler
@pytest.mark.parametrize("method", UNDAMPED)
def test_largest_step_is_the_textbook_limit(two_links: Trial, method: str) -> None:
    found = largest(lambda step: grows(two_links, method, step), TWO_LINKS)
    # The interval is halved to 1e-3; 5.96 is known to three digits.
    assert found * TWO_LINKS == pytest.approx(UNDAMPED[method], rel=2e-3)


@pytest.mark.compiler
def test_overdamped_limits_are_those_of_real_eigenvalues() -> None:
    rows = steps.against_links(2, [10.0])
    found = {str(row["method"]): float(row["found"]) * float(row["rate"]) for row in rows}
    assert found["euler"] == pytest.approx(2.0, rel=2e-3)
    assert found["rk4"] == pytest.approx(2.785, rel=2e-3)  # E. Hairer, G. Wanner 1996, IV.2
    ratio = 10.0  # |lambda| = omega (zeta + sqrt(zeta^2 - 1))
    rate = TWO_LINKS * (ratio + math.sqrt(ratio**2 - 1))
    assert rows[0]["rate"] == pytest.approx(rate, rel=1e-9)


@pytest.mark.compiler
def test_amplitude_grows_beyond_the_step_found_and_not_below(two_links: Trial) -> None:
    """By the motion itself over many steps, without a fit."""
    h = largest(lambda step: grows(two_links, "rk4", step), TWO_LINKS)
    for factor, growing in ((1.01, True), (0.99, False)):
        run = two_links.run("rk4", step=factor * h)
        run.begin(1e9)
        start = float(np.abs(run.state).max())
        run.advance(500, np.empty(0), np.empty((0, len(run.state))))
        assert (float(np.abs(run.state).max()) > 10 * start) == growing


@pytest.mark.compiler
def test_dop853_takes_nearly_its_largest_step(two_links: Trial) -> None:
    step, growth = own_step(two_links)
    assert step * TWO_LINKS == pytest.approx(UNDAMPED["dop853"], rel=5e-3)
    assert growth < 1.1


@pytest.mark.parametrize("ratio", [0.0, 0.1, 1.0, 10.0])
def test_eigenvalues_are_the_roots(ratio: float) -> None:
    value, partner = steps.eigenvalues(3.0, ratio)
    assert value + partner == pytest.approx(-6.0 * ratio, abs=1e-13)  # of Vieta, to rounding
    assert value * partner == pytest.approx(9.0, rel=1e-12)
    assert value.imag >= 0
    assert abs(value) >= abs(partner) * (1 - 1e-12)


def test_largest_finds_a_threshold_wherever_it_is() -> None:
    for threshold in (0.02, 1.0, 50.0):
        assert largest(lambda h, at=threshold: h > at, 1.0) == pytest.approx(threshold, rel=1e-3)
    assert largest(lambda _: True, 1.0) == 0.0


@pytest.mark.parametrize("growth", [1 - 1e-8, 1 + 1e-8, 1.2, 0.3])
def test_radius_is_that_of_the_matrix(growth: float) -> None:
    turn = np.array([[math.cos(0.3), -math.sin(0.3)], [math.sin(0.3), math.cos(0.3)]])
    skew = np.array([[1.0, 5.0], [0.0, 0.2]])  # beats, as of vectors far from orthogonal
    matrix = growth * skew @ turn @ np.linalg.inv(skew)
    z = [np.array([1.0, 0.3])]
    for _ in range(100):
        z.append(matrix @ z[-1])
    assert radius(np.array(z)) == pytest.approx(growth, abs=1e-10)  # rounding, a hundred times


# Rounding ------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def five() -> ModuleType:
    return load_module(GENERATED / "rod_free_n5.py")


def _ordinary(links: int) -> ExtremeState:
    return next(extremes(links))


@pytest.mark.parametrize(
    ("links", "boundary", "inertia"),
    [
        (1, "free", "uniform"),
        (2, "pinned", "lumped"),
        (6, "free", "uniform"),
        (3, "clamped", "lumped"),
    ],
)
def test_two_routes_in_sixty_digits_agree(links: int, boundary: str, inertia: str) -> None:
    """The elimination along the chain, and the hand-assembled closed form with a dense solve."""
    described = {"N": links, "BOUNDARY": boundary, "INERTIA": inertia, "TERMS": THESIS_TERMS}
    names = ("clamp_angle",) if boundary == "clamped" else ()
    model: Any = SimpleNamespace(**described, PARAMETERS=names)
    for extreme in extremes(links):
        values, y = rounding.parameters(model, extreme), rounding.state(model, extreme)
        ours = exact_rates(model, values, y)
        with mpmath.workdps(60):
            dense = ReferenceEquations(model, values, y).rhs()[len(y) // 2 :]
            off = max(abs(a - b) for a, b in zip(ours, dense, strict=True))
            # Cancellation may leave less than a quarter of the digits of the terms.
            assert off <= mpmath.mpf("1e-45") * max(1, *(abs(a) for a in dense)), extreme.case


def test_a_perturbed_rhs_is_found(five: ModuleType) -> None:
    extreme = _ordinary(5)
    y, values = rounding.state(five, extreme), rounding.parameters(five, extreme)
    unit = rounding.Units(five, values, exact_rates(five, values, y))
    right = five.rhs(0.0, y, five.parameters(**values))
    assert unit.off(right) < 20  # a few roundings of five links
    wrong = right.copy()
    scaled = right[len(y) // 2 :] * np.array([float(scale) for scale in unit.scale])
    largest_at = len(y) // 2 + int(np.argmax(np.abs(scaled)))
    wrong[largest_at] *= 1 + 1e-12
    # 1e-12 of a number is 4500 to 9007 units of its last place.
    assert 4400 < unit.off(wrong) < 9100
    wrong[largest_at] = np.nan
    assert unit.off(wrong) == math.inf


def test_chain_form_that_loses_digits_is_named() -> None:
    made, dense = (load_module(GENERATED / f"rod_free_n5{form}.py") for form in ("", "_dense"))
    rough: Any = SimpleNamespace(**vars(made))
    rough.rhs = lambda t, y, p: made.rhs(t, y, p).astype(np.float32).astype(float)
    for chain, some in ((made, False), (rough, True)):
        forms = {"numpy chain": chain, "numpy dense": dense}
        rows = rounding._rounding_rows(forms, _ordinary(5), 2)
        assert len(rounding.losing(frame(rows))) == some


def test_inputs_are_moved_by_one_unit() -> None:
    values = np.array([1.0, -3.0, 1e300, 0.0])
    moved = rounding._neighbours(values, np.random.default_rng(1))
    assert (np.abs(moved - values) <= np.spacing(np.abs(values))).all()
    assert (moved != values).all()


def test_input_error_is_that_of_the_jacobian(five: ModuleType) -> None:
    """Angles about 1e9 rad are known to 6e-8 rad: the rates change by the Jacobian times that."""
    far = next(e for e in extremes(5) if "1e+09" in e.case)
    y, values = rounding.state(five, far), rounding.parameters(five, far)
    p = five.parameters(**values)
    unit = rounding.Units(five, values, exact_rates(five, values, y))
    link = values["length"] / 5
    by_angles = five.jac(0.0, y, p)[7:, 2:7] / np.array([link, link, *[1] * 5])[:, None]
    most = np.abs(by_angles).sum(axis=1).max() * np.spacing(1e9) / float(unit.one)
    # Draws of signs find the worst ones or nearly: of five angles one in 32 is the worst.
    assert most / 4 < unit.off_inputs(y, 4) <= 1.01 * most


@pytest.mark.parametrize("held", [False, True])
def test_systems_are_those_of_the_constraints(held: bool) -> None:
    """G W G^T with the Jacobian G of the constraints, written out link by link."""
    phi = np.array([0.3, 1.9, -0.7, 2.5])
    n, first = len(phi), 0 if held else 1
    uniform, lumped = np.zeros((2 * (n + 1), 3 * n)), np.zeros((n, 2 * (n + 1)))
    for i, angle in enumerate(phi):
        e, across = (
            np.array([np.cos(angle), np.sin(angle)]),
            np.array([-np.sin(angle), np.cos(angle)]),
        )
        for joint, end in ((i, -1), (i + 1, 1)):
            rows = slice(2 * joint, 2 * joint + 2)
            sign = end  # what the end of a link does, less what the start of the next does
            uniform[rows, 3 * i : 3 * i + 2] = sign * np.eye(2)
            uniform[rows, 3 * i + 2] = sign * end * 0.5 * across
            lumped[i, 2 * joint : 2 * joint + 2] = end * e
    uniform = uniform[2 * first : 2 * n]
    system = uniform @ np.diag([1.0, 1.0, 12.0] * n) @ uniform.T
    found = constraints(phi, held, lumped=False).toarray()
    np.testing.assert_allclose(found, system, atol=1e-13)
    masses = np.repeat([0.0 if held else 2.0, *[1.0] * (n - 1), 2.0], 2)
    system = lumped @ np.diag(masses) @ lumped.T
    found = constraints(phi, held, lumped=True).toarray()
    np.testing.assert_allclose(found, system, atol=1e-13)
    model: Any = SimpleNamespace(N=n, BOUNDARY="pinned" if held else "free", INERTIA="lumped")
    y = np.concatenate(([0.0] * (2 * (not held)), phi, np.zeros(n + 2 * (not held))))
    assert rounding.chain_condition(model, y) == pytest.approx(np.linalg.cond(system), rel=1e-9)
