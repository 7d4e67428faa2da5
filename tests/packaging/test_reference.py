"""The page of public names has all of them, and every public function tells what a user needs."""

from __future__ import annotations

import inspect
import re
from pathlib import Path

import rodgen

PAGE = Path(__file__).parents[2] / "docs" / "reference" / "python.md"
SECTIONS = ("Parameters", "Returns", "Examples")


def test_page_has_every_public_name() -> None:
    shown = re.findall(r"^\.\. auto\w+:: rodgen\.(\w+)$", PAGE.read_text(), re.MULTILINE)
    assert sorted(shown) == sorted(rodgen.__all__)


def test_classes_have_an_example() -> None:
    classes = [getattr(rodgen, name) for name in rodgen.__all__]
    missing = [
        one.__name__
        for one in filter(inspect.isclass, classes)
        if "\nExamples\n--------\n>>> " not in (inspect.getdoc(one) or "")
    ]
    assert not missing


def test_functions_tell_what_they_take_and_return_with_an_example() -> None:
    functions = [getattr(rodgen, name) for name in rodgen.__all__]
    for one in filter(inspect.isfunction, functions):
        text = inspect.getdoc(one) or ""
        missing = [name for name in SECTIONS if f"\n{name}\n{'-' * len(name)}\n" not in text]
        assert not missing, (one.__name__, missing)
