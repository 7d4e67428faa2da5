"""The compiled solve of Newton's method against (sigma I - J)^-1 with J in 50 digits.

A wrong matrix leaves results right, and takes many more steps."""

from __future__ import annotations

import ctypes
import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest
from rodgen.derive.implicit_form import ImplicitForm

from rodgen.emit import module_files
from rodgen.scene.structure import BOUNDARIES, INERTIAS, TERMS, Structure

pytestmark = pytest.mark.compiler
Built = Callable[..., ModuleType]
Written = Callable[..., dict[str, str]]

# Every boundary, inertia and load, with and without drag; written for other tests as well.
FEW = [
    Structure(3, "free", "uniform", TERMS),
    Structure(2, "free", "lumped", ()),
    Structure(2, "cantilever", "uniform", TERMS),
    Structure(1, "clamped", "lumped", TERMS),
    Structure(3, "pinned", "lumped", ("internal_damping",)),
]
# Every load with every boundary and inertia.
APART = [("follower", "internal_damping"), ("gravity", "tip_load"), ("external_damping",)]
# Of the size of the rates, so that neither sigma nor J alone decides.
REAL, PAIR = 7.5, 3.0 + 20.0j

PROGRAM = """
#include "{stem}.c"

/* Both systems at a state: real numbers, then pairs; right is overwritten. */
void solve_both(double t, const double *y, const double *p, double real, const double *pair,
    double *right)
{{
    static struct newton x;
    static struct real_cells one;
    static struct pair_cells two;
    linearise(t, y, p, &x, &one);
    real_factor(&x, real, &one);
    real_solve(&x, &one, right, right);
    pair_factor(&x, pair[0] + pair[1] * I, &two);
    pair_solve(&x, &two, (double _Complex *)(right + STATES), (double _Complex *)(right + STATES));
}}
"""


def _id(structure: Structure) -> str:
    return structure.stem.replace("_".join(TERMS), "all")


def _compiled(files: dict[str, str], folder: Path) -> ctypes.CDLL:
    """The text of a module with a way in, not optimised: a compilation of half a second."""
    for name, text in files.items():
        (folder / name).write_text(text)
    (stem,) = (Path(name).stem for name in files if name.endswith(".c"))
    (folder / "solve.c").write_text(PROGRAM.format(stem=stem))
    compiler = next(filter(None, map(shutil.which, ("cc", "gcc", "clang"))))
    options = ["-std=c99", "-O0", "-shared", "-fPIC", "-w", "-o", "solve.so", "solve.c", "-lm"]
    subprocess.run([compiler, *options], cwd=folder, check=True)
    return ctypes.CDLL(str(folder / "solve.so"))


def _holds(at: Any, files: dict[str, str], folder: Path) -> None:
    """Both solves at a state, to the digits that elimination without exchanges leaves."""
    J, size = at.exact_jacobian(), len(at.y)
    right = np.random.default_rng(2).standard_normal(3 * size)
    expected = (
        np.linalg.solve(REAL * np.eye(size) - J, right[:size]),
        np.linalg.solve(PAIR * np.eye(size) - J, right[size:].view(complex)),
    )
    shift = np.array([PAIR])
    y, p, pair, out = (x.ctypes.data_as(ctypes.c_void_p) for x in (at.y, at.p, shift, right))
    solve = _compiled(files, folder).solve_both
    solve(ctypes.c_double(at.t), y, p, ctypes.c_double(REAL), pair, out)
    for got, exact in zip((right[:size], right[size:].view(complex)), expected, strict=True):
        np.testing.assert_allclose(got, exact, rtol=0, atol=1e-11 * np.abs(exact).max())


@pytest.mark.parametrize("structure", FEW, ids=_id)
def test_solve_is_that_of_the_exact_jacobian(
    built: Built, written: Written, point: type, structure: Structure, tmp_path: Path
) -> None:
    _holds(point(built(structure)), written(structure, "c", "chain"), tmp_path)


@pytest.mark.long
@pytest.mark.parametrize("boundary", BOUNDARIES)
@pytest.mark.parametrize("inertia", INERTIAS)
@pytest.mark.parametrize("terms", APART, ids="_".join)
def test_solve_with_every_load_for_itself(
    built: Built,
    written: Written,
    point: type,
    boundary: str,
    inertia: str,
    terms: tuple[str, ...],
    tmp_path: Path,
) -> None:
    structure = Structure(3, boundary, inertia, terms)
    _holds(point(built(structure)), written(structure, "c", "chain"), tmp_path)


def test_a_wrong_sign_in_the_base_is_seen(
    built: Built, point: type, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """Joint 0 of a free rod with what link 0 does to it turned round: no result shows it."""
    structure = Structure(2, "free", "lumped", ())
    right = ImplicitForm.base
    monkeypatch.setattr(ImplicitForm, "base", lambda self, links: -right(self, links))
    files = module_files(structure, "c")
    with pytest.raises(AssertionError, match="tolerance"):
        _holds(point(built(structure)), files, tmp_path)
