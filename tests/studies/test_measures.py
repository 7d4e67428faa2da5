"""Measures of runs between two times: those of the whole run, of which some are left out."""

from __future__ import annotations

import numpy as np
import pytest

from rodgen.studies.specification import Study
from tests.studies.scenes import PENDULUM, scene
from tests.studies.test_block import computed
from tests.studies.test_crossings import one_by_one

pytestmark = pytest.mark.compiler
WHERE = "where='omega_0', either=0"


def test_a_section_between_two_times_is_a_part_of_the_whole() -> None:
    """By both ways, side by side in C and run by run."""
    whole, part = f"section(t, {WHERE})", f"section(t, {WHERE}, from=1, to=2)"
    integrate = {"span": [0.0, 3.0], "rtol": 1e-9}
    table = scene(PENDULUM, integrate=integrate)
    study = Study.of(table, {"initial.phi": [-0.5, 1.3]}, keep=[whole, part])
    for found in (computed(study), one_by_one(study)):
        for every, some in zip(found[whole], found[part], strict=True):
            expected = every[(every >= 1) & (every <= 2)]
            assert 0 < len(expected) < np.isfinite(every).sum()
            np.testing.assert_array_equal(some[np.isfinite(some)], expected)
