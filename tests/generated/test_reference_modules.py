"""The reference modules under version control are what the generator writes, byte by byte."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
import sympy

from rodgen.emit import module_text
from rodgen.loading import load_module
from rodgen.scene.structure import Structure

GENERATED = Path(__file__).parents[2] / "generated"
REFERENCES = {
    "rod_free_n5": Structure(5),
    "rod_free_n5_conservative": Structure(5, terms=()),
    "rod_cantilever_n5": Structure(5, "cantilever"),
}


@pytest.mark.parametrize("stem", REFERENCES)
def test_reference_module_is_fresh(stem: str, pytestconfig: pytest.Config) -> None:
    structure = REFERENCES[stem]
    assert structure.stem == stem
    path, text = GENERATED / f"{stem}.py", module_text(structure)
    if pytestconfig.getoption("update"):
        path.write_text(text, encoding="utf-8", newline="\n")
    kept = path.read_bytes().decode()
    assert _for_this_sympy(kept) == text, "run `make reference` and look at the difference"


def _for_this_sympy(text: str) -> str:
    """A newer SymPy may be installed than the one that wrote the module: only its number may
    differ."""
    (written,) = re.findall(r'"sympy": "([^"]+)"', text)
    return text.replace(f"SymPy {written} ", f"SymPy {sympy.__version__} ").replace(
        f'"sympy": "{written}"', f'"sympy": "{sympy.__version__}"'
    )


@pytest.mark.parametrize("stem", REFERENCES)
def test_banner_names_what_made_the_module(stem: str) -> None:
    path = GENERATED / f"{stem}.py"
    banner = path.read_text(encoding="utf-8").split('"""')[1]
    provenance = load_module(path).PROVENANCE
    for part in ("rodgen", "sympy", "template", "template_hash", "structure_hash"):
        assert str(provenance[part]) in banner
    assert f"{provenance['operations']['rhs']} operations" in banner
    guard = re.search(r"tests/\S+\.py", banner)
    assert guard and (GENERATED.parent / guard[0]).samefile(__file__)


def test_nothing_else_is_under_version_control() -> None:
    listed = (GENERATED / ".gitignore").read_text(encoding="utf-8")
    assert set(re.findall(r"^!(rod_\w+)\.py$", listed, re.M)) == set(REFERENCES)
