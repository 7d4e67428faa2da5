"""Modules of rods that differ along their length, in every target and form."""

from __future__ import annotations

from collections.abc import Callable
from types import ModuleType

from rodgen.check.module import check_module
from rodgen.model.rod import BOUNDARIES, INERTIAS
from rodgen.scene.structure import Structure
from tests.palette import ALONG, ENDS, UNEVEN, carries, cases

Built = Callable[..., ModuleType]
FORMS = ("chain", "dense")


@cases(
    "boundary, links, inertia, form, terms, uneven",
    *(BOUNDARIES, (1, 2, 3, 5, 8), INERTIAS, FORMS, (ENDS, ALONG), UNEVEN),
    where=carries,
)
def test_module_equals_fifty_digit_arithmetic(
    built: Built,
    boundary: str,
    links: int,
    inertia: str,
    form: str,
    terms: tuple[str, ...],
    uneven: tuple[str, ...],
) -> None:
    module = built(Structure(links, boundary, inertia, terms, (), uneven), "numpy", form)
    # Rounding of some hundred operations, amplified by the condition of M.
    assert max(d.error for d in check_module(module, states=2)) < 1e-12
