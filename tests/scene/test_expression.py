"""The grammar of expressions: safe, right, with its break points."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rodgen.scene.errors import SceneError
from rodgen.scene.expression import Expression, parsed
from rodgen.scene.grammar import FUNCTIONS

VALUES = [
    ("300*min(t/0.5, 1)", 0.25, 150.0),
    ("300*min(t/0.5, 1)", 3.0, 300.0),
    ("-1.5*sin(t)**2 if t <= pi else 0", 1.0, -1.5 * math.sin(1.0) ** 2),
    ("-1.5*sin(t)**2 if t <= pi else 0", 4.0, 0.0),
    ("max(1, t, 3) - -t", 2.0, 5.0),
    ("2**-t", 3.0, 0.125),
    ("-t**2", 3.0, -9.0),
    ("tanh(t) + exp(-t)*log(t)/sqrt(t) + abs(cos(t) - tan(t))", 2.0, None),
    ("1 if t > 1 if 2 < 3 else t else 0", 2.0, None),
]


@pytest.mark.parametrize(("text", "at", "value"), VALUES[:8])
def test_value_by_hand_and_by_generated_code(text: str, at: float, value: float | None) -> None:
    expression = Expression(text, "t")
    code = eval(expression.source(), {"np": np, "t": np.float64(at)})
    assert expression(at) == pytest.approx(float(code), rel=1e-15)
    if value is not None:
        assert expression(at) == pytest.approx(value, rel=1e-15)
    np.testing.assert_allclose(expression([at, at]), [expression(at)] * 2)


@pytest.mark.parametrize(
    "text",
    [
        "__import__('os').system('true')",
        "t.__class__",
        "open('x')",
        "x",
        "s",
        "lambda: 1",
        "[t]",
        "(t, t)",
        "{t}",
        "'t'",
        "f'{t}'",
        "t if t else 1",
        "t < 1",
        "1 < t < 2 if t < 1 else 0",
        "t == 1",
        "not t",
        "t and 1",
        "t // 2",
        "t % 2",
        "t @ t",
        "t << 1",
        "1j",
        "True",
        "None",
        "...",
        "min(t)",
        "sin(t, t)",
        "sin()",
        "sin(x=t)",
        "min(*t)",
        "sin",
        "pi(t)",
        "t := 1",
        "(yield)",
        "t; t",
        "t\nt",
        "",
        " ",
        "1e999",
        "9" * 400,
        "t" * 2000,
        "(" * 500 + "t" + ")" * 500,
        "-" * 900 + "t",
        "t\0",
        "t + 0/0",
        "t + log(-1)",
        "t*(-1)**0.5",
        "10**999 + t",
        "t if 1 < (2 < 3) else t",
    ],
)
def test_everything_else_is_refused(text: str) -> None:
    with pytest.raises(SceneError, match="force"):
        Expression(text, "t", "force")


def test_what_is_refused_is_never_run() -> None:
    touched = []
    FUNCTIONS_BEFORE = dict(FUNCTIONS)
    with pytest.raises(SceneError):
        Expression("touched.append(1)", "t")
    assert touched == []
    assert FUNCTIONS_BEFORE == FUNCTIONS


@pytest.mark.parametrize(
    ("text", "breaks"),
    [
        ("300*min(t/0.5, 1)", [0.5]),
        ("-1.5*sin(t)**2 if t <= pi else 0", [math.pi]),
        ("abs(t - 2) + max(t, 3, 4)", [2.0, 3.0, 4.0]),
        ("abs(sin(t))", [math.pi]),
        ("1 if t < 1 else 2 if t < 2.5 else 3", [1.0, 2.5]),
        ("sin(t)", []),
        ("t**2 + 1", []),
        ("abs(0*t)", []),
        # between two samples, and where the comparison is no number on one side
        ("1e5 if (t - 0.10001)*(0.10003 - t) > 0 else 0", [0.10001, 0.10003]),
        ("1 if sqrt((t - 1.23456789)**2 - 1e-12)*(t - 1.23456789) > 0 else 0", None),
        ("1000 if abs(t - 1.0001) < 0.0001 else 0", [1.0, 1.0001, 1.0002]),
        ("min(t, 99)", []),
    ],
)
def test_break_points(text: str, breaks: list[float] | None) -> None:
    found = Expression(text, "t").breaks(0.0, 5.0)
    if breaks is None:
        assert found == pytest.approx([1.23456789] * len(found), abs=2e-6)
        return
    inside = [b for b in breaks if 0 < b < 5]
    assert found == pytest.approx(inside, abs=1e-13)


@pytest.mark.parametrize(
    ("text", "poles"),
    [
        ("1/t", [0.0]),
        ("1/(t - 5)", [5.0]),
        ("1/(t - 0.50013)", [0.50013]),
        ("3 - 1e-3/(t - 0.50013)**2", [0.50013]),
        ("1/abs(t - 0.50013) + (t - 2)**-1", [0.50013, 2.0]),
        ("tan(t)", [math.pi / 2, 1.5 * math.pi]),
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
    ],
)
def test_poles(text: str, poles: list[float]) -> None:
    assert Expression(text, "t").poles(0.0, 5.0) == pytest.approx(poles, abs=1e-13)


def test_odd_spacing_brings_no_warnings() -> None:
    """Python itself would warn of 1if; pytest turns warnings into errors."""
    assert Expression("1if t<1else 2", "t")(3.0) == 2.0
    with pytest.raises(SceneError, match="foo"):
        Expression("1if t<1else foo", "t")


def test_long_sums_are_fine() -> None:
    assert Expression("+".join(["t"] * 150), "t")(2.0) == 300.0


def test_equal_trees_have_equal_source() -> None:
    one, two = Expression("t+ 1", "t"), Expression("(t + 1)", "t")
    assert one.source() == two.source()
    assert one.canonical == two.canonical


trees = st.recursive(
    st.floats(-1e3, 1e3).map(repr) | st.just("t") | st.just("pi"),
    lambda inner: st.one_of(
        st.tuples(inner, st.sampled_from("+-*/"), inner).map(lambda p: f"({p[0]}{p[1]}{p[2]})"),
        inner.map(lambda p: f"sin({p})"),
        inner.map(lambda p: f"-{p}"),
        st.tuples(inner, inner).map(lambda p: f"max({p[0]},{p[1]})"),
        st.tuples(inner, inner, inner).map(lambda p: f"({p[0]} if t<{p[1]} else {p[2]})"),
    ),
    max_leaves=8,
)


@given(text=trees, at=st.floats(-10, 10))
def test_walked_tree_and_generated_code_agree(text: str, at: float) -> None:
    try:
        expression = Expression(text, "t")
    except SceneError as error:
        assert "not '" in str(error) or text in str(error)  # noqa: PT017 (0/0 is no number)
        return
    with np.errstate(all="ignore"):
        code = eval(expression.source(), {"np": np, "t": np.float64(at)})
    np.testing.assert_array_equal(expression(at), code)


@pytest.mark.parametrize(
    "text",
    [
        "sin(t) * cos(2*t) - t",
        "tan(t/3) / (2 + t**3)",
        "exp(-t) - log(1 + t)",
        "sqrt(1 + t**2) * tanh(t)",
        "abs(t - 1) + abs(t)",
        "(1 + t) ** (2*t)",
        "min(t, 1 - t, 0.45)",
        "max(t**2, 1 - t, 0.5)",
        "t if t < 0.5 else 3*t",
        "interp(t, [0, 0.4, 1], [1, 3, 2], 'cubic')",
    ],
)
def test_slopes_are_differences(text: str) -> None:
    law, h = parsed(text, "t", "mass", (), ("s",)), 2.0**-18
    for t in (0.21, 0.48, 0.77):
        ends = [float(law.value(np.asarray(t + at), {"s": 0.0})) for at in (-h, h)]
        # h^2 of the third derivative, and rounding over h.
        slope = float(law.slope(np.asarray(t), {"s": 0.0}))
        assert slope == pytest.approx((ends[1] - ends[0]) / (2 * h), rel=1e-7, abs=1e-9)
