"""The reference has all public names, and tells of each what a user needs, units included."""

from __future__ import annotations

import inspect
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from names import shown  # of docs/site, as is the next
from pydantic import BaseModel
from told import sections, told

import rodgen
from rodgen.scene.integration import IntegrationTable
from tests.view.results import made

ROOT = Path(__file__).parents[2]


def _text(folder: Path, ending: str) -> str:
    return "\n".join(one.read_text(encoding="utf-8") for one in folder.rglob(f"*.{ending}"))


TEXT = _text(ROOT / "docs" / "reference" / "python", "md")
CODE = "\n".join(  # of examples that are run: in docstrings, on pages, in the gallery
    (
        *re.findall(r"^ *(?:>>>|\.\.\.) .*$", _text(ROOT / "src" / "rodgen", "py"), re.M),
        *re.findall(r"^```python\n(.*?)^```", _text(ROOT / "docs", "md"), re.M | re.S),
        _text(ROOT / "docs" / "gallery", "py"),
    )
)
NAMES = {name: getattr(rodgen, name) for name in rodgen.__all__}
FUNCTIONS = [name for name, one in NAMES.items() if inspect.isfunction(one)]
CLASSES = [name for name, one in NAMES.items() if inspect.isclass(one)]
RESULTS = [name for name in CLASSES if not issubclass(NAMES[name], BaseException)]
INHERITED = {name for one in (BaseModel, tuple, object, rodgen.Result) for name in dir(one)}
NUMBER = re.compile(r"\b(float|complex|Array|ArrayLike|Any\]\]|float64\])")
UNIT = re.compile(
    r"\[(1/)?([km]?(g|m|s|N|J|W|Hz)|rad|pixels)\b[^]]*\]|dimensionless|SI units|\bunits? of "
)


def test_pages_have_every_public_name() -> None:
    kinds = r"(?:auto(?:function|class|exception)|py:data)"
    listed = re.findall(rf"^\.\. {kinds}:: rodgen\.(\w+)$", TEXT, re.M)
    assert sorted(listed) == sorted(NAMES)


def test_classes_have_an_example() -> None:
    example = "\nExamples\n--------\n>>> "
    assert not [name for name in CLASSES if example not in (inspect.getdoc(NAMES[name]) or "")]


def test_functions_tell_what_they_take_and_return_with_an_example() -> None:
    for name in FUNCTIONS:
        parts = sections(inspect.getdoc(NAMES[name]) or "")
        assert {"Parameters", "Returns", "Examples"} <= parts.keys(), name
        assert not [*_untold(NAMES[name], name)]


def test_classes_tell_of_their_fields_and_members() -> None:
    for name in RESULTS:
        assert not [*_holes(name)], name


def test_editors_offer_what_the_pages_show_and_not_what_extending_needs() -> None:
    for name in ("Scene", "Solution"):
        shown, parts = _entries(name)
        offered = {*dir(made(name))}
        assert shown | NAMES[name].__annotations__.keys() - {"run_notes"} <= offered
        assert not offered & parts - {"scene", "value_of"}
    module = rodgen.build(made("Scene"), "numpy")
    assert not {"np", "math", "sys", "dpbsv"} & {*dir(module)}
    assert {"rhs", "jac", "energy", "STATE"} <= {*dir(module)}
    assert not [name for name in dir(module) if name.startswith("WEIGHT")]


def _holes(name: str) -> Iterator[str]:
    """Fields and members of a class that are not told of, not shown, or in no example."""
    kind = NAMES[name]
    text, fields = told(inspect.getdoc(kind) or ""), _fields(kind)
    yield from (one for one in fields if one not in text or _bare(fields[one], text[one]))
    shown, parts = _entries(name)
    yield from (one for one in shown if not re.search(rf"\.{one}\b", CODE))
    for member in {*dir(kind)} - INHERITED - fields.keys():
        if not member.startswith("_"):
            yield from [member] * (member not in shown | parts)
            yield from _untold(inspect.getattr_static(kind, member), member)


def test_lists_of_names_are_shown_as_lists() -> None:
    text = "t: times [s], (T,); low, high (m, 2): the range; where: it is.\nBy default: all"
    assert shown(text)[:2] == ["- ``t``: times [s], (T,).", "- ``low, high (m, 2)``: the range."]
    assert shown("A sentence, which ends here: so.") == ["A sentence, which ends here: so.", ""]
    assert told(text)["high"] == "the range"


def _fields(kind: Any) -> dict[str, str]:
    """Fields of a dataclass, a named tuple, a scene or a system, with their types as text."""
    places = ("__dataclass_fields__", "model_fields", "_fields")
    listed = (getattr(kind, place) for place in places if hasattr(kind, place))
    names = next(listed, _types(kind))
    types = {name: of for one in kind.__mro__[::-1] for name, of in _types(one).items()}
    return {name: types[name] for name in names}


def _types(one: Any) -> dict[str, str]:
    return {name: str(of) for name, of in inspect.get_annotations(one).items()}


def _entries(name: str) -> tuple[set[str], set[str]]:
    """Members of a class that the reference shows with it, and those that it shows as parts, which
    no example has to use."""
    kind = NAMES[name]
    found = re.search(rf"^\.\. autoclass:: rodgen\.{name}\n(?:   :members:(.*))?", TEXT, re.M)
    assert found
    members = {*dir(kind)} - INHERITED - _fields(kind).keys()
    every = {one for one in members if not one.startswith("_")}
    with_it = every if found[1] == "" else {*(found[1] or "").replace(" ", "").split(",")} - {""}
    parts = rf"^\.\. auto(?:method|property):: rodgen\.{name}\.(\w+)$"
    return with_it, {*re.findall(parts, TEXT, re.M)}


def _untold(member: Any, name: str = "") -> Iterator[str]:
    """What a function, a method or a property says nothing of: itself, arguments, or units."""
    inside = [getattr(member, of) for of in ("fget", "func", "__func__") if hasattr(member, of)]
    function = inside[0] if inside else member
    text, types = inspect.getdoc(function) or "", _types(function)
    meanings, parts = told(text), sections(text)
    if not text:
        yield name
    for one in inspect.signature(function).parameters:
        if one in ("self", "cls") or (
            one in IntegrationTable.model_fields and "[integrate]" in text
        ):
            continue
        if one not in meanings or _bare(types.get(one, ""), meanings[one]):
            yield f"{name}({one})"
    if _bare(types.get("return", ""), parts.get("Returns", parts[""])):
        yield f"{name} returns"


def _bare(of: str, text: str) -> bool:
    """Whether a number or an array of numbers has neither a unit nor says that it needs none."""
    return bool(NUMBER.search(of)) and not UNIT.search(text)
