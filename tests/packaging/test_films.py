"""Films and pictures of the site that are drawn by hand show the code and the scenes of today."""

from __future__ import annotations

import json

from films import DRAWN, sources  # of docs/site


def test_no_film_is_older_than_its_example() -> None:
    """`python docs/site/films.py` draws them anew."""
    assert json.loads(DRAWN.read_text(encoding="utf-8")) == sources()
