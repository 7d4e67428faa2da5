"""The list of scenes in the page, and files that are handed in."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from tests.live.conftest import varied
from tests.live.view import expect

View = Any  # see conftest.py


@pytest.mark.nightly
def test_scenes_are_listed_by_file_and_can_be_had_again(view: View, tmp_path: Path) -> None:
    """One that is refused does not stay in the list, and one from elsewhere is none of it."""
    tomli_w = pytest.importorskip("tomli_w")
    listed = view.page.locator(".rg-scenes .q-field__native")
    mass = view.field("mass M")
    expect(listed).to_have_text("dart")
    view.select("Scene", "two")
    expect(mass).to_have_value("4")
    expect(listed).to_have_text("two")
    for time in (1, 2):  # the second is a change again
        view.select("Scene", "bad")
        view.noted("name = 3", time).close_notes()
        expect(listed).to_have_text("two")
    view.fill("mass M", "7")
    view.button("Reset to").click()
    view.reload()
    expect(mass).to_have_value("7")  # as the reset leaves what was changed
    expect(listed).to_have_text("two")
    view.button("Load two again").click()
    expect(mass).to_have_value("4")
    good = tomli_w.dumps({**varied(mass=5.0), "name": "one"})
    files = {
        "evil": good.replace("0.2*cos(pi*s)", "__import__('os').system('x')"),
        "large": good + "#" * 2**20,
        "binary": "\x00\x01",
    }
    chooser = view.tab("Scene").page.locator("input[type=file]")
    for count, (name, text) in enumerate(files.items(), 1):
        (tmp_path / f"{name}.toml").write_text(text)
        chooser.set_input_files(tmp_path / f"{name}.toml")
        view.noted("", count).close_notes()
        expect(listed).to_have_text("two")
    (tmp_path / "elsewhere.toml").write_text(good)
    chooser.set_input_files(tmp_path / "elsewhere.toml")
    expect(listed).to_have_text("one (other)")  # not shown as a file of the folder
    view.tab("Parameters")
    expect(mass).to_have_value("5")
