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
    ("text", "unit"),
    [
        ("phi_4 - phi_0", "rad"),
        ("2*tip_x + 1", "m"),
        ("tip_x/t - tip_vx", "m/s"),
        ("d/dt(omega_0)", "rad/s²"),
        ("d/dt(sin(phi_0))", "1/s"),
        ("total_energy - bending_moment_1", "J"),  # 1 J = 1 N m
        ("sqrt(tip_x**2 + tip_y**2)", "m"),
        ("tip_vx*tip_vy/2", "m²/s²"),
        ("bending_moment_1/tip_x**2", "N/m"),
        ("max(phi_0, 0) if t < 1 else phi_1", "rad"),
        ("sin(phi_0)", ""),
        ("tip_x + phi_0", ""),  # no unit
        ("d/dt(tip_x + phi_0)", ""),
        ("tip_x**t", ""),
    ],
)
def test_units_of_expressions(catalogue: Catalogue, text: str, unit: str) -> None:
    assert catalogue.quantity(text).unit == unit


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


def test_rates_are_parts_of_expressions(catalogue: Catalogue, chunk: Chunk) -> None:
    """As any quantity is, more than one of them, and where brackets follow that are not theirs."""
    text = "d/dt(phi_4)/2 - d/dt tip_x + (tip_y)"
    found, rate, speed, height = values(catalogue, chunk, text, "omega_4", "tip_vx", "tip_y")
    assert found == pytest.approx(rate / 2 - speed + height, abs=1e-8 * np.abs(rate).max())


def test_rate_of_the_energy_is_the_power(catalogue: Catalogue, chunk: Chunk) -> None:
    """All that the loads without potential do, by another function of the module."""
    powers = " + ".join(f"power_{term}" for term in catalogue.works)
    gained, done = values(catalogue, chunk, "d/dt(total_energy)", powers)
    assert gained == pytest.approx(done, abs=1e-7 * np.abs(done).max())


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("phi_4 - nothing", "nothing"),
        ("d/dt(tip_q)", "not tip_q.*did you mean tip_y"),
        ("np.sin(t)", "write sin without np"),
        ("phi_4 -", "expression"),
        ("phi(0.3) + 1", "without sensors"),
        ("d/dt(work_follower)", "the rate of work is a power"),
        ("2*d/dt(d/dt(tip_x))", "without d/dt in these"),
        ("d/dt(tip_x", "before brackets or a name"),
        ("d/dt 3", "before brackets or a name"),
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
