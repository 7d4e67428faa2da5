"""The dialog that adds a plot, in a real browser: what it asks, and what it says of it."""

from __future__ import annotations

import csv
import io
from pathlib import Path
from typing import Any

import numpy as np
import pytest

View = Any  # see conftest.py


def dialog_of(view: View, kind: str) -> Any:
    """The dialog, for a kind of plot."""
    view.button("Add plot").click()
    dialog = view.page.get_by_role("dialog")
    dialog.get_by_role("combobox", name="kind of plot").click()
    view.page.get_by_role("option").filter(has_text=kind).click()
    return dialog


def choose(view: View, label: str, quantity: str) -> None:
    """Type the name of a quantity and take the one that is offered."""
    dialog = view.page.get_by_role("dialog")
    dialog.get_by_role("combobox", name=label, exact=True).fill(quantity)
    view.page.get_by_role("option").filter(has_text=f"({quantity})").click()
    view.until(lambda: view.page.get_by_role("option").count() == 0, "the names stay")


def said(view: View, label: str) -> str:
    """What stands below a field."""
    field = view.page.get_by_role("dialog").locator(".q-field", has_text=label)
    return "".join(field.locator(".q-field__messages").all_text_contents()).strip()


def add(view: View) -> None:
    view.page.get_by_role("dialog").get_by_role("button", name="Add").click()


def test_what_is_not_chosen_is_said_beside_its_field(view: View) -> None:
    dialog_of(view, "Poincaré")
    choose(view, "over", "phi_3")
    add(view)
    view.until(lambda: said(view, "points where") == "not chosen", "nothing is said")
    assert said(view, "quantity") == "not chosen"
    assert [said(view, label) for label in ("over", "while it is", "title")] == [""] * 3
    choose(view, "quantity", "omega_3")
    view.until(lambda: said(view, "quantity") == "", "it still stands there")


@pytest.mark.parametrize(
    ("label", "text", "expected"),
    [
        ("reaches the value", "abc", "must be a number"),
        ("reaches the value", "1e999", "must be a number"),
        ("and again", "-1", "must be a number from 0"),
        ("title", "x" * 81, "must be at most 80"),
    ],
)
def test_what_is_refused_is_said_beside_its_field(
    view: View, label: str, text: str, expected: str
) -> None:
    dialog = dialog_of(view, "Poincaré")
    for name, quantity in (("quantity", "omega_3"), ("over", "phi_3"), ("points where", "tip_x")):
        choose(view, name, quantity)
    dialog.get_by_role("textbox", name=label).fill(text)
    add(view)
    view.until(lambda: said(view, label).startswith(expected), "nothing is said")
    assert dialog.locator(".q-field--error").count() == 1
    assert dialog.locator(".rg-failed").text_content() == ""


def test_a_stroboscope_with_a_title(view: View) -> None:
    """Points at t = 0.105, 0.305, 0.505, ... s."""
    dialog = dialog_of(view, "Poincaré")
    for name, quantity in (("quantity", "omega_3"), ("over", "t"), ("points where", "t")):
        choose(view, name, quantity)
    dialog.get_by_role("textbox", name="reaches the value").fill("0.105")
    dialog.get_by_role("textbox", name="and again").fill("0.2")
    units = dialog.locator(".q-field__suffix")
    view.until(lambda: units.all_text_contents() == ["s", "s"], "not the unit of t")
    dialog.get_by_role("textbox", name="title").fill("stroboscope")
    add(view)
    card = view.page.locator(".rodgen-plot", has_text="stroboscope")
    card.wait_for()
    view.run()
    view.until(lambda: view.live("t") > 0.8, "time does not pass")
    view.pause()
    with view.page.expect_download() as waiting:
        card.get_by_role("button", name="Save stroboscope as CSV").click()
    rows = list(csv.reader(io.StringIO(Path(waiting.value.path()).read_text())))
    t = np.array(rows[1:], dtype=float)[:, 0]
    assert len(t) >= 3  # the last is known two samples late
    # Rounding alone: t is a straight line through the samples.
    np.testing.assert_allclose(t, 0.105 + 0.2 * np.arange(len(t)), atol=1e-12)


def test_only_what_this_kind_of_plot_has_is_in_the_page(view: View) -> None:
    """Of a long rod thousands of names go into every field that offers quantities."""
    dialog = dialog_of(view, "spectrum")
    dialog.get_by_role("combobox", name="quantity", exact=True).wait_for()
    labels = [label.text_content() for label in dialog.locator(".q-field__label").all()]
    assert labels[:3] == ["kind of plot", "quantity", "window"]
    assert len(labels) == 4
    dialog.get_by_role("textbox", name="window").fill("7")
    dialog.get_by_role("combobox", name="kind of plot").click()
    view.page.get_by_role("option").filter(has_text="phase plot").click()
    dialog.get_by_role("combobox", name="over").wait_for()
    assert dialog.get_by_role("textbox", name="window").input_value() == "7"
