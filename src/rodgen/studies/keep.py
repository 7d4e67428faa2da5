"""What is kept of every point: its name, dimensions and type, known before anything is computed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from rodgen.studies.specification import Study


@dataclass(frozen=True)
class Variable:
    """A kept quantity: dims and shape are those of one point, () for a number."""

    name: str
    dims: tuple[str, ...] = ()
    shape: tuple[int, ...] = ()
    dtype: str = "f8"
    units: str = ""
    fill: Any = float("nan")


def variables(study: Study) -> list[Variable]:
    """All that is kept of a study; the last four are there in every study."""
    kept = [Variable(one if isinstance(one, str) else one.__name__) for one in study.keep]
    return [
        *kept,
        Variable("status", dtype="U8", fill=""),
        Variable("message", dtype="U200", fill=""),
        Variable("energy_error", units="J"),
        Variable("seconds", units="s"),
    ]
