"""One verdict on one answer."""

from __future__ import annotations

from typing import NamedTuple

RIGHT, CONTRADICTED, REFUSED, NONE = "right", "contradicted", "refused", "no reference"
FOLD = "refused at a fold"


class Judgement(NamedTuple):
    """function: whose answer; kind: one of the words above; size: of the load; text: what is
    wrong, or was said."""

    function: str
    kind: str
    size: float
    text: str = ""
