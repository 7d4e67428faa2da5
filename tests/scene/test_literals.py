"""Numbers in the text of an expression: which they are, and the text with another one."""

from __future__ import annotations

import pytest

from rodgen.scene.expression import Expression
from rodgen.scene.literals import literals, with_literal

TEXTS = (
    "300*min(t/0.5, 1)",
    "  ( 3\n  *t)**2 - 1e-3",
    "a*2*sin(t)**2 + (1 if t < 3 else 4)",
    "interp(t, [0, -1.5, 2], [1, a, -3], 'cubic')*5",
    "(-2*phi(0.3) - 0.5*omega(0.3) - gimbal)/0.05",
)


@pytest.mark.parametrize("text", TEXTS[:3] + TEXTS[4:])
def test_literals_are_the_numbers_that_a_module_has_as_parameters(text: str) -> None:
    """In that order; other values of them are those that the module is given, of equal code."""

    def read(text: str) -> tuple[str, dict[str, float]]:
        made = Expression(text, "t", numbers=(("a", 2.0),), states=("gimbal",))
        return made.parametrised("force")

    code, named = read(text)
    named.pop("a", None)
    assert [one.value for one in literals(text)] == list(named.values())
    for at in range(len(named)):
        other, values = read(with_literal(text, at, 0.125, "force"))
        assert other == code
        assert values == values | named | {f"force_{at + 1}": 0.125}


def test_numbers_of_tables_have_their_signs() -> None:
    found = literals(TEXTS[3])
    assert [one.value for one in found] == [0.0, -1.5, 2.0, 1.0, -3.0, 5.0]
    assert [one.signed for one in found] == [True] * 5 + [False]
    assert with_literal(TEXTS[3], 1, 0.5, "force").startswith("interp(t, [0, 0.5, 2], ")


@pytest.mark.parametrize(
    ("text", "leading"),
    [
        ("300*min(t/0.5, 1)", [True, False, False]),
        ("sin(2*t)*a*7", [False, True]),
        ("(1 - s)*40/3", [False, True, False]),
        ("3*t + 5", [False, False]),
        ("-300*t", [False]),  # the sign is not its own
        ("a*sin(t)", []),
    ],
)
def test_amplitude_is_what_all_that_changes_is_multiplied_by(
    text: str, leading: list[bool]
) -> None:
    assert [one.leads for one in literals(text, ("a",))] == leading


def test_places_are_told_by_the_text_around_them() -> None:
    """Which stays what it is when other numbers change."""
    before = [one.around for one in literals(TEXTS[0])]
    assert before == ["□*min(t/·, ·)", "·*min(t/□, ·)", "·*min(t/·, □)"]
    assert before == [one.around for one in literals(with_literal(TEXTS[0], 1, 2.75, ""))]
    assert literals("1 + 1 + 1 + 1 + 1 + 1 + 1 + 1 + t")[-1].around == "…· + · + · + □ + t"


def test_negative_number_stays_what_a_power_takes() -> None:
    text = with_literal("2**t", 0, -2.5, "")
    assert Expression(text, "t")(2.0) == 6.25
