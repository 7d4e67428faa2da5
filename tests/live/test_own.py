"""Expressions of quantities in plots."""

from __future__ import annotations

import numpy as np
import pytest

import rodgen
from rodgen.live.catalogue import MOST_OWN, Catalogue
from rodgen.live.own import LONGEST
from rodgen.live.run.plot_spec import PlotSpec, transfer
from rodgen.live.samples import Chunk
from rodgen.loading import build_fastest
from rodgen.scene import Scene, SceneError
from tests.live.conftest import ROD, varied


@pytest.fixture(scope="module")
def run() -> rodgen.Solution:
    return rodgen.simulate(Scene.from_dict({**ROD, "integrate": {"span": [0.0, 0.5]}}))


@pytest.fixture
def catalogue(run: rodgen.Solution) -> Catalogue:
    return Catalogue(run.scene, run.model)


@pytest.fixture
def chunk(run: rodgen.Solution) -> Chunk:
    works = tuple(run.work)
    work = np.stack([run.work[term] for term in works], axis=-1)
    return Chunk(run.t, run.y, work, works, run.model.parameters(**run.scene.parameters))


def values(catalogue: Catalogue, chunk: Chunk, *names: str) -> list[np.ndarray]:
    for name in names:
        catalogue.quantity(name)
    return list(catalogue.columns(names, chunk).T)


def test_expression_is_made_of_quantities(catalogue: Catalogue, chunk: Chunk) -> None:
    own, last, first = values(catalogue, chunk, "2*(phi_4 - phi_0) + sin(t)", "phi_4", "phi_0")
    assert np.array_equal(own, 2 * (last - first) + np.sin(chunk.t))
    assert np.all(values(catalogue, chunk, "1 + 2")[0] == 3.0)


@pytest.mark.parametrize(
    ("text", "name"),
    [("d/dt(phi_2)", "omega_2"), ("d/dt tip_x", "tip_vx"), ("d / dt (tip_y + 0*t)", "tip_vy")],
)
def test_rates_are_those_of_the_motion(
    catalogue: Catalogue, chunk: Chunk, text: str, name: str
) -> None:
    found, wanted = values(catalogue, chunk, text, name)
    scale = np.abs(wanted).max()
    # Differences of 1e-5: their square, and rounding over it.
    assert found == pytest.approx(wanted, abs=1e-8 * scale)


def test_rate_of_the_energy_is_the_power(catalogue: Catalogue, chunk: Chunk) -> None:
    """All that the loads without potential do, by another function of the module."""
    powers = " + ".join(f"power_{term}" for term in catalogue.works)
    gained, done = values(catalogue, chunk, "d/dt(total_energy)", powers)
    assert gained == pytest.approx(done, abs=1e-7 * np.abs(done).max())


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("phi_4 - nothing", "nothing"),
        ("phi_4 -", "expression"),
        ("phi(0.3) + 1", "without sensors"),
        ("d/dt(work_follower)", "the rate of work is a power"),
        ("__import__('os')", "expression"),
        ("1+" * LONGEST + "1", f"at most {LONGEST}"),
    ],
)
def test_what_is_no_expression_is_refused(catalogue: Catalogue, text: str, said: str) -> None:
    with pytest.raises(SceneError, match=said) as refused:
        catalogue.quantity(text, "plot.y[0]")
    assert refused.value.field.startswith("plot.y[0]")
    assert text not in catalogue.quantities


def test_expressions_are_not_kept_without_end(catalogue: Catalogue) -> None:
    for number in range(MOST_OWN):
        catalogue.quantity(f"phi_0 + {number}")
    with pytest.raises(SceneError, match=f"{MOST_OWN} expressions"):
        catalogue.quantity("phi_0 - 1")


def test_plot_of_an_expression_goes_over_to_another_rod(catalogue: Catalogue) -> None:
    """As far as that has its quantities."""
    scene = Scene.from_dict(varied(links=2))
    after = Catalogue(scene, build_fastest(scene))
    choice = {"id": "p1", "kind": "time", "y": ["phi_4 - phi_0", "phi_1 - phi_0", "phi_0"]}
    spec = PlotSpec.from_dict(choice, catalogue)
    moved = transfer(spec, "p2", catalogue, after)
    assert moved is not None
    assert moved.y == ("phi_1 - phi_0", "phi_0")
