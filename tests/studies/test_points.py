"""Points of a study from their numbers."""

from __future__ import annotations

import pickle
from itertools import product
from typing import Any

import numpy as np
import pytest
from scipy.stats import qmc

from rodgen import Study
from rodgen.studies.axis import read_axis
from rodgen.studies.sampling import Layout, points_at
from tests.studies.conftest import BECK, scene

VARY: dict[str, Any] = {
    "loads.follower.force": {"bounds": [5, 60]},
    "loads.material_damping.time": {"bounds": [1e-5, 1], "scale": "log"},
    "rod.links": {"bounds": [4, 6]},
    "rod.boundary": {"values": ["clamped", "cantilever"]},
}


def sampled(method: str, count: int, seed: int = 3) -> Study:
    sample = {"method": method, "count": count, "seed": seed}
    return Study.of(scene(BECK), VARY, analysis="critical", sample=sample)


@pytest.mark.parametrize("method", ["sobol", "latin_hypercube", "random"])
def test_points_do_not_depend_on_what_they_are_computed_with(method: str) -> None:
    """More points begin with the fewer, but those of a hypercube, which is another study then."""
    study = sampled(method, 200)
    whole = points_at(study, range(200))
    for block in ([7], [150, 3, 4, 5], range(90, 200), [199, 0]):
        assert points_at(study, list(block)) == [whole[index] for index in block]
    assert points_at(sampled(method, 200, seed=4), range(200)) != whole
    more = sampled(method, 230)
    if method == "latin_hypercube":
        assert more.contents != study.contents
        forces = np.array([point["loads.follower.force"] for point in whole])
        assert np.unique(np.floor((forces - 5) / 55 * 200)).size == 200  # one in every stratum
    else:
        assert more.contents == study.contents
        assert points_at(more, range(200)) == whole


def test_a_sobol_sequence_is_that_of_scipy() -> None:
    force, time, *_ = qmc.Sobol(4, bits=32, seed=np.random.default_rng(3)).random(64).T
    found = points_at(sampled("sobol", 64), range(64))
    forces, times = ([point[key] for point in found] for key in (*VARY,)[:2])
    np.testing.assert_allclose(forces, 5 + 55 * force, rtol=1e-14)
    np.testing.assert_allclose(np.log10(times), -5 + 5 * time, atol=1e-13)


def test_a_random_point_is_that_of_its_seed() -> None:
    share = np.random.default_rng(np.random.SeedSequence(3, spawn_key=(17,))).random(4)
    (point,) = points_at(sampled("random", 100), [17])
    assert point["loads.follower.force"] == 5 + share[0] * 55
    assert point["rod.links"] == 4 + int(share[2] * 3)
    assert point["rod.boundary"] == ("clamped", "cantilever")[int(share[3] * 2)]


def test_a_grid_counts_its_last_axis_fastest() -> None:
    vary = {"rod.mass": [1.0, 2.0], "rod.length": [3.0, 4.0, 5.0]}
    study = Study.of(scene(BECK), vary, analysis="critical")
    found = [(point["rod.mass"], point["rod.length"]) for point in points_at(study, range(6))]
    assert found == [(1, 3), (1, 4), (1, 5), (2, 3), (2, 4), (2, 5)]
    with pytest.raises(IndexError):
        points_at(study, [6])


def test_blocks_have_every_point_once() -> None:
    for shape, wanted in product([(7,), (5, 3), (4, 3, 5), (1, 1), (100, 1, 2)], [1, 4, 10, 1000]):
        layout = Layout.of(shape, wanted)
        blocks = [layout.indices(block) for block in range(layout.count)]
        assert sorted(np.concatenate(blocks)) == list(range(int(np.prod(shape))))
        sizes = [layout.size(block) for block in range(layout.count)]
        assert max(sizes) <= wanted
        assert sizes == [*map(len, blocks)]


def test_what_an_axis_consists_of_is_short_and_tells_its_values_apart() -> None:
    """A million values are neither written into the store nor sent about as text."""
    values = np.linspace(1, 2, 10**5)
    long = read_axis("rod.mass", values.tolist(), drawn=False)
    assert list(long.values) == values.tolist()
    assert len(str(long.contents)) < 200
    assert len(pickle.dumps(long)) < 1.01 * values.nbytes + 1000
    assert pickle.loads(pickle.dumps(long)).contents == long.contents
    values[777] = np.nextafter(values[777], 2)
    assert read_axis("rod.mass", values.tolist(), drawn=False).contents != long.contents
