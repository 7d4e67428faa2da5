"""Expressions: safe and right, with their break points, poles, slopes and pulses."""

from __future__ import annotations

import math
import re
from itertools import product

import numpy as np
import pytest
import sympy

from rodgen.scene.expression import Expression, parse_expression
from rodgen.scene.zeros import SEEN, find_pulses
from tests.told import refused

VALUES = [
    ("300*min(t/0.5, 1)", 0.25, 150.0),
    ("300*min(t/0.5, 1)", 3.0, 300.0),
    ("-1.5*sin(t)**2 if t <= pi else 0", 1.0, -1.5 * math.sin(1.0) ** 2),
    ("-1.5*sin(t)**2 if t <= pi else 0", 4.0, 0.0),
    ("max(1, t, 3) - -t", 2.0, 5.0),
    ("2**-t", 3.0, 0.125),
    ("-t**2", 3.0, -9.0),
    ("t - (2 - t)/-(t - 3) - (t - 1)", 4.0, -1.0),
    ("2**-(t**2)*(1 + t)*3", 1.0, 3.0),
    ("-(t if t < 1 else 2)*(max(t, -t) if -t < 1 else 3)", 4.0, -8.0),
    ("1 if t < (2 if t < 3 else t + 1) else 0", 5.0, 1.0),
    ("1if t<1else 2", 3.0, 2.0),  # of which Python itself would warn, which is an error here
    ("+".join(["t"] * 150), 2.0, 300.0),
    ("deg(90*t) - deg(-2)/t + sin(deg(30))", 2.0, math.pi + math.pi / 180 + 0.5),
    ("tanh(t) + exp(-t)*log(t)/sqrt(t) + abs(cos(t) - tan(t))", 2.0, None),
]


def test_value_by_hand_and_by_generated_code() -> None:
    for text, at, value in VALUES:
        expression = Expression(text, "t")
        code = eval(expression.source(), {"np": np, "t": np.float64(at)})
        assert expression(at) == pytest.approx(float(code), rel=1e-15)
        if value is not None:
            assert expression(at) == pytest.approx(value, rel=1e-15)
        np.testing.assert_allclose(expression([at, at]), [expression(at)] * 2)


OTHER = [
    *("__import__('os').system('true')", "t.__class__", "open('x')", "x", "s", "lambda: 1"),
    *("[t]", "(t, t)", "{t}", "'t'", "f'{t}'", "t if t else 1", "t < 1"),
    *("1 < t < 2 if t < 1 else 0", "t == 1", "not t", "t and 1", "t // 2", "t % 2", "t @ t"),
    *("t << 1", "1j", "True", "None", "...", "min(t)", "sin(t, t)", "sin()", "sin(x=t)"),
    *("min(*t)", "sin", "pi(t)", "t := 1", "(yield)", "t; t", "t\nt", "", " ", "1e999"),
    *("deg()", "deg(1, 2)", "deg", "30*deg", "deg(x)"),
    *("9" * 400, "t" * 2000, "(" * 500 + "t" + ")" * 500, "-" * 900 + "t", "t\0"),
    *("t + 0/0", "t + log(-1)", "t*(-1)**0.5", "10**999 + t", "t if 1 < (2 < 3) else t"),
    *("1 if t > 1 if 2 < 3 else t else 0", "1if t<1else foo"),
]


def test_everything_else_is_refused() -> None:
    for text in OTHER:
        assert refused(Expression, text, "t", "force")[:2] == ("force", text)


def test_functions_of_other_programs_are_answered_with_their_like() -> None:
    at = np.array([0.5, 2.0])
    for name, function in (
        *(("step", np.heaviside(at, 0.0)), ("sgn", np.sign(at)), ("ln", np.log(at))),
        *(("radians", np.radians(at)), ("cosh", np.cosh(at)), ("sinh", np.sinh(at))),
    ):
        told = refused(Expression, f"2*{name}(t)", "t", "force").allowed
        instead = told.partition(f"{name}(x) is written ")[2].strip("`")
        written = re.sub(r"\bx\b", "t", instead)
        np.testing.assert_allclose(Expression(written, "t")(at), function, rtol=1e-15)


def test_break_points() -> None:
    for text, breaks in (
        ("300*min(t/0.5, 1)", [0.5]),
        ("-1.5*sin(t)**2 if t <= pi else 0", [math.pi]),
        ("abs(t - 2) + max(t, 3, 4)", [2.0, 3.0, 4.0]),
        ("abs(sin(t))", [math.pi]),
        ("1 if t < 1 else 2 if t < 2.5 else 3", [1.0, 2.5]),
        ("sin(t)", []),
        ("min(deg(t), deg(0.75)) + deg(abs(t - 2))", [0.75, 2.0]),
        ("t**2 + 1", []),
        ("abs(0*t)", []),
        # between two samples, and where the comparison is no number on one side
        ("1e5 if (t - 0.10001)*(0.10003 - t) > 0 else 0", [0.10001, 0.10003]),
        ("1 if sqrt((t - 1.23456789)**2 - 1e-12)*(t - 1.23456789) > 0 else 0", None),
        ("1000 if abs(t - 1.0001) < 0.0001 else 0", [1.0, 1.0001, 1.0002]),
        ("min(t, 99)", []),
    ):
        found = Expression(text, "t").breaks(0.0, 5.0)
        if breaks is None:  # both ends of what is no number
            assert found == pytest.approx([1.23456789] * len(found), abs=2e-6)
            continue
        assert found == pytest.approx(breaks, abs=1e-13)


def test_poles() -> None:
    for text, poles in (
        ("1/t", [0.0]),
        ("1/(t - 5)", [5.0]),
        ("1/(t - 0.50013)", [0.50013]),
        ("3 - 1e-3/(t - 0.50013)**2", [0.50013]),
        ("1/abs(t - 0.50013) + (t - 2)**-1", [0.50013, 2.0]),
        ("tan(t)", [math.pi / 2, 1.5 * math.pi]),
        ("tan(deg(45*t))", [2.0]),
        ("exp(1/(t - 1))", [1.0]),
        ("1/(t - 1) if t > 1 else 0", [1.0]),
        ("1/sqrt(t - 1)", [1.0]),
        # finite after all
        ("sin(t - 1)/(t - 1)", []),
        ("exp(-1/t**2)", []),
        ("min(1/(t - 1)**2, 1e9)", []),
        ("1/(t - 1) if t < 0.9 else 0", []),
        ("1/(t + 0.1)", []),
        ("log(t)", []),
        ("1e9*t**3", []),
    ):
        assert Expression(text, "t").poles(0.0, 5.0) == pytest.approx(poles, abs=1e-13)


def test_equal_trees_have_equal_source() -> None:
    one, two = Expression("t+ 1", "t"), Expression("(t + 1)", "t")
    assert one.source() == two.source()
    assert one.canonical == two.canonical


def test_slopes_are_differences() -> None:
    for text in (
        *("sin(t) * cos(2*t) - t", "tan(t/3) / (2 + t**3)", "exp(-t) - log(1 + t)"),
        *("sqrt(1 + t**2) * tanh(t)", "abs(t - 1) + abs(t)", "(1 + t) ** (2*t)"),
        *("deg(t**2) * sin(deg(90*t))", "abs(deg(t - 1))"),
        *("min(t, 1 - t, 0.45)", "max(t**2, 1 - t, 0.5)", "t if t < 0.5 else 3*t"),
        "interp(t, [0, 0.4, 1], [1, 3, 2], 'cubic')",
    ):
        law, h = parse_expression(text, "t", "mass", (), ("s",)), 2.0**-18
        for t in (0.21, 0.48, 0.77):
            ends = [float(law.evaluate(np.asarray(t + at), {"s": 0.0})) for at in (-h, h)]
            # h^2 of the third derivative, and rounding over h.
            slope = float(law.derivative(np.asarray(t), {"s": 0.0}))
            assert slope == pytest.approx((ends[1] - ends[0]) / (2 * h), rel=1e-7, abs=1e-9)


def test_second_derivatives_are_those_of_sympy() -> None:
    """Of what moves a base, whose velocity and acceleration are taken from its text."""
    t = sympy.Symbol("t")
    known = {"t": t, "abs": sympy.Abs, "tan": sympy.tan}
    for text in (
        *("sin(t)*cos(2*t) - t**3", "tan(t/3)/(2 + t**3)", "exp(-t) - log(1 + t)"),
        *("sqrt(1 + t**2)*tanh(t)", "(1 + t)**(2*t)", "2**t/(1 + sin(t)**2)"),
    ):
        law, exact = Expression(text, "t"), sympy.sympify(text, known)
        for order, at in product((1, 2), (0.21, 0.77)):
            expected = float(exact.diff(t, order).subs(t, at))
            assert float(law.derivative(at, {}, order)) == pytest.approx(expected, rel=1e-12)


# Where a load wakes up after a rest: begin, peak and end by hand ----------------------------------

CELL = 10.0 / (SEEN - 1)


def test_pulse_after_a_rest() -> None:
    """exp(-x^2) is above a thousandth within |x| < sqrt(ln 1000) = 2.63; slow tails may be cut."""
    for middle, width in ((7.3, 0.01), (2.0, 1e-3), (0.05, 1e-3)):
        pulse = Expression(f"-3*exp(-((t - {middle})/{width})**2)", "t")
        ((begin, peak, end),) = find_pulses(pulse, 0.0, 10.0)
        assert middle - 3 * width < begin < middle - width
        assert middle + width < end < middle + 3 * width
        assert peak == pytest.approx(middle, abs=2 * CELL + width / 10)


def test_what_moves_all_the_time_has_none() -> None:
    for load in ("7", "sin(t)", "sin(200*t)", "300*min(t/0.5, 1)", "t**2", "1.5*sin(t)**2", "1/t"):
        assert find_pulses(Expression(load, "t"), 0.0, 10.0) == ()


def test_two_pulses_and_a_switch() -> None:
    load = Expression("exp(-((t - 3)*100)**2) + exp(-((t - 6)*100)**2) + tanh((t - 8)*1e9)", "t")
    peaks = [peak for _, peak, _ in find_pulses(load, 0.0, 10.0)]
    np.testing.assert_allclose(peaks, [3.0, 6.0, 8.0], rtol=0, atol=2e-3)


BUMP = "exp(-((t - 3)*100)**2)"


def test_pulses_are_a_matter_of_what_changes() -> None:
    """By hand, what it is multiplied by and what is added; where it is multiplied by zero it is
    not taken apart, and has no pulse."""
    alone = Expression(BUMP, "t").pulses(0.0, 10.0)
    assert len(alone) == 1
    for text, a, b in (
        (f"-(2*{BUMP}/5 - 7)", -0.4, 7.0),
        (f"g*(1 + {BUMP}*g)", 9.0, 3.0),
        (f"4 - +{BUMP}", -1.0, 4.0),
        (f"0*{BUMP} + 1", 1.0, 0.0),
        (f"{BUMP}/(g - 3)**2 if t < 0 else {BUMP}", 1.0, 0.0),
    ):
        whole = Expression(text, "t", numbers=(("g", 3.0),))
        core, *found = whole.split_affine()
        assert found == pytest.approx([a, b], abs=1e-15)
        times = np.linspace(0.0, 10.0, 101)
        np.testing.assert_allclose(a * core(times) + b, whole(times), rtol=1e-15, atol=1e-15)
        assert whole.pulses(0.0, 10.0) == (() if text.startswith("0") else alone)


def test_a_swing_is_one_beside_the_whole_load() -> None:
    """A ripple that is smaller than a millionth of the load from sample to sample is none."""
    assert Expression("2*sin(50*t)", "t").half_period(0.0, 10.0) == pytest.approx(
        np.pi / 50, rel=0.1
    )
    assert Expression("300 + 1e-5*sin(50*t)", "t").half_period(0.0, 10.0) == np.inf


def test_other_values_of_the_numbers_are_checked_and_leave_the_first_alone() -> None:
    first = Expression("a*t + 1/a", "t", numbers=(("a", 2.0), ("b", 1.0)))
    assert first.with_parameters("f")[1] == {"a": 2.0, "f_1": 1.0}
    other = first.with_values({"a": 4.0, "b": 7.0})
    assert other.with_parameters("f")[1] == {"a": 4.0, "f_1": 1.0}
    assert (float(first(1.0)), float(other(1.0))) == (2.5, 4.25)
    assert other == Expression("a*t + 1/a", "t", numbers=(("a", 4.0),))
    assert refused(first.with_values, {"a": 0.0}).value == "a*t + 1/a"
