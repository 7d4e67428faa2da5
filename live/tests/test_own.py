"""Names of quantities in plots: which of a kind, and expressions of them."""

from __future__ import annotations

import numpy as np
import pytest

import rodgen
from live.tests.conftest import SCENE, SHORT
from live.tests.runs import prepared
from rodgen.errors import InputError
from rodgen.loading import build_fastest
from rodgen.scene import Scene
from rodgen_live.page.quantity_field import which
from rodgen_live.plot_quantities import MOST_OWN, Catalogue
from rodgen_live.run.plot_spec import PlotSpec, transfer
from rodgen_live.sample_store import Chunk
from rodgen_live.user_expression import LONGEST


@pytest.fixture
def catalogue() -> Catalogue:
    return prepared(SCENE)[0]


@pytest.fixture(scope="module")
def chunk() -> Chunk:
    run = rodgen.simulate(SCENE, span=[0.0, 0.5])
    return prepared(SCENE)[1](run.t, run.y)


def values(catalogue: Catalogue, chunk: Chunk, *names: str) -> list[np.ndarray]:
    for name in names:
        catalogue.quantity(name)
    return list(catalogue.columns(names, chunk).T)


def test_expression_is_made_of_quantities(catalogue: Catalogue, chunk: Chunk) -> None:
    own, last, first = values(catalogue, chunk, "2*(phi_4 - phi_0) + sin(t)", "phi_4", "phi_0")
    assert np.array_equal(own, 2 * (last - first) + np.sin(chunk.t))
    assert np.all(values(catalogue, chunk, "1 + 2")[0] == 3.0)


def test_units_of_expressions(catalogue: Catalogue) -> None:
    for text, unit in (
        ("phi_4 - phi_0", "rad"),
        ("tip_x/t - tip_vx", "m/s"),
        ("d/dt(omega_0)", "rad/s²"),
        ("d/dt(sin(phi_0))", "1/s"),
        ("total_energy - bending_moment_1", "J"),  # 1 J = 1 N m
        ("sqrt(tip_x**2 + tip_y**2)", "m"),
        ("bending_moment_1/tip_x**2", "N/m"),
        ("2*bending_moment_1", "N m"),
        ("total_energy/omega_0**2", "J s²/rad²"),
        ("min(tip_x, 3) - 0.5 + 0.1*abs(tip_y)", "m"),  # numbers may have any unit
        ("omega_0*cos(phi_0)**2", "rad/s"),
        ("tip_x*interp(t, [0, 1], [0, 1])", ""),
        ("max(phi_0, 0) if t < 1 else phi_1", "rad"),
        ("sin(phi_0)", ""),
        ("deg(5) - phi_0", "rad"),
        ("phi_0/deg(1)", ""),  # a number of degrees
        ("tip_x*deg(30*t/t)", "m rad"),
        ("tip_x + phi_0", ""),  # no unit
        ("tip_x**t", ""),
    ):
        assert catalogue.quantity(text).unit == unit, text


def test_rates_are_those_of_the_motion(catalogue: Catalogue, chunk: Chunk) -> None:
    """Alone, more than one of them in an expression, and where brackets follow that are not theirs;
    that of the energy is the power of all loads without potential, by another function of the
    module."""
    powers = " + ".join(f"power_{term}" for term in catalogue.works)
    for text, wanted in (
        ("d/dt(phi_2)", "omega_2"),
        ("d/dt tip_x", "tip_vx"),
        ("d / dt (tip_y + 0*t)", "tip_vy"),
        ("d/dt(phi_4)/2 - d/dt tip_x + (tip_y)", "omega_4/2 - tip_vx + tip_y"),
        ("d/dt(total_energy)", powers),
    ):
        found, same = values(catalogue, chunk, text, wanted)
        scale = max(np.abs(same).max(), 1.0)
        # Differences of 1e-5: their square, and rounding over it, of energies of ten joules.
        assert found == pytest.approx(same, abs=1e-7 * scale), text


def test_what_is_no_expression_is_refused(catalogue: Catalogue) -> None:
    for text, said in (
        ("phi_4 - nothing", "nothing"),
        ("d/dt(tip_q)", "tip_y"),
        ("np.sin(t)", "np"),
        ("phi(0.3) + 1", ""),
        ("d/dt(work_follower)", ""),
        ("2*d/dt(d/dt(tip_x))", "d/dt"),
        ("d/dt(tip_x", ""),
        ("__import__('os')", ""),
        ("1+" * LONGEST + "1", str(LONGEST)),
    ):
        with pytest.raises(InputError, match=said or None) as refused:
            catalogue.quantity(text, "plot.y[0]")
        assert refused.value.field.startswith("plot.y[0]")
        assert text not in catalogue.quantities


def test_expressions_are_not_kept_without_end(catalogue: Catalogue) -> None:
    for number in range(MOST_OWN):
        catalogue.quantity(f"phi_0 + {number}")
    with pytest.raises(InputError, match=str(MOST_OWN)):
        catalogue.quantity("phi_0 - 1")


def test_plot_of_an_expression_goes_over_to_another_rod(catalogue: Catalogue) -> None:
    """As far as that has its quantities; the tail's becomes the tail's there."""
    scene = Scene.from_dict(SHORT)
    after = Catalogue(scene, build_fastest(scene))
    choice = {"id": "p1", "kind": "time", "y": [f"phi_{k} - phi_0" for k in (4, 3, 1)]}
    moved = transfer(PlotSpec.from_dict(choice, catalogue), "p2", catalogue, after)
    assert moved is not None
    assert moved.y == ("phi_2 - phi_0", "phi_1 - phi_0")


TWENTY = list(range(20))
TAKEN = {"all": [], "3": [3], " 0, 5-7 ": [0, 5, 6, 7], "2,2,1": [2, 1], "19-19": [19]}
REFUSED = ("", "-1", "20", "9-5", "0-99999999", "1e3", "all, 3", "0-20", "²")


def test_numbers_and_stretches() -> None:
    for text, numbers in TAKEN.items():
        assert which(text, TWENTY, several=True) == numbers
    assert which("4", TWENTY, several=False) == [4]
    for text, several in [(text, True) for text in REFUSED] + [("all", False), ("1, 2", False)]:
        with pytest.raises(InputError, match="0 to 19"):
            which(text, TWENTY, several=several)
