"""The reference modules under version control are what the generator writes, byte by byte."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
import sympy

from rodgen.emit.tableaux import headers
from rodgen.loading import load_module, sources
from rodgen.native import run
from rodgen.scene.structure import Structure

GENERATED = Path(__file__).parents[2] / "generated"
# What each file stem is written from: structure, target, form.
REFERENCES = {
    "rod_free_n5": (Structure(5), "numpy", "chain"),
    "rod_free_n5_conservative": (Structure(5, terms=()), "numpy", "chain"),
    "rod_free_n5_dense": (Structure(5), "numpy", "dense"),
    "rod_free_n5_c": (Structure(5), "c", "chain"),
    "rod_cantilever_n5": (Structure(5, "cantilever"), "numpy", "chain"),
    "rod_clamped_n5_tip_load_lumped": (
        Structure(5, "clamped", "lumped", ("tip_load",)),
        "numpy",
        "chain",
    ),
}
FILES = [f"{stem}.py" for stem in REFERENCES] + ["rod_free_n5_c.c", "rod_free_n5_c.h"]


@pytest.mark.parametrize("stem", REFERENCES)
def test_reference_module_is_fresh(stem: str, pytestconfig: pytest.Config) -> None:
    texts = sources(*REFERENCES[stem])
    assert set(texts) == {name for name in FILES if Path(name).stem == stem}
    for name, text in texts.items():
        path = GENERATED / name
        if pytestconfig.getoption("update"):
            path.write_text(text, encoding="utf-8", newline="\n")
        kept = path.read_bytes().decode()
        assert _for_this_sympy(kept) == text, "run `make reference` and look at the difference"


@pytest.mark.parametrize("name", ["methods.h", "tableaux.h"])
def test_headers_of_the_step_loops_are_fresh(name: str, pytestconfig: pytest.Config) -> None:
    path = Path(run.__file__).with_name(name)
    if pytestconfig.getoption("update"):
        path.write_text(headers()[name], encoding="utf-8", newline="\n")
    assert path.read_text(encoding="utf-8") == headers()[name], "run `make reference`"


def _for_this_sympy(text: str) -> str:
    """A newer SymPy may be installed than the one that wrote the module: only its number may
    differ."""
    (written,) = set(re.findall(r"with SymPy (\S+) from", text))
    return text.replace(f"SymPy {written} ", f"SymPy {sympy.__version__} ").replace(
        f'"sympy": "{written}"', f'"sympy": "{sympy.__version__}"'
    )


@pytest.mark.parametrize("name", FILES)
def test_banner_names_what_made_the_module(name: str) -> None:
    path = GENERATED / name
    text = path.read_text(encoding="utf-8")
    banner = re.split(r'"""|/\*|\*/', text)[1]
    provenance = load_module(path.with_suffix(".py")).PROVENANCE
    for part in ("rodgen", "sympy", "template", "template_hash", "structure_hash"):
        assert str(provenance[part]) in banner
    assert f"{provenance['operations']['rhs']} operations" in banner
    guard = re.search(r"tests/\S+\.py", banner)
    assert guard
    assert (GENERATED.parent / guard[0]).samefile(__file__)


def test_nothing_else_is_under_version_control() -> None:
    listed = (GENERATED / ".gitignore").read_text(encoding="utf-8")
    assert sorted(re.findall(r"^!(rod_\w+\.\w+)$", listed, re.M)) == sorted(FILES)
