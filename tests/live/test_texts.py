"""The text panel: rows that the scene has, numbers that are known, a width that stays."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import rodgen
from rodgen.integrate.live import FOR_LOOKING
from rodgen.integrate.stepper import Array, Counts
from rodgen.live.samples import Chunk
from rodgen.live.texts import WIDTH, Present, digits, fixed, groups, texts, whole
from rodgen.model.rod import BOUNDARIES, INERTIAS
from rodgen.model.terms import TERMS
from rodgen.scene import Scene
from tests.live.conftest import ROD

Make = Callable[..., Scene]


def shown(scene: Scene, y: Array | None = None, t: float = 0.0, **present: Any) -> dict[str, str]:
    """The panel for a state (states,), by default the initial one."""
    model = rodgen.build(scene)
    y = scene.initial_state() if y is None else y
    p = model.parameters(**scene.parameters)
    works = tuple(model.power(0.0, y, p)) if hasattr(model, "power") else ()
    work = np.arange(1.0, len(works) + 1)[None]
    chunk = Chunk(np.array([t]), y[None], work, works, p, given=present.pop("given", 0.0))
    cost = {"counts": Counts(), "seconds": 0.0, **present}
    return texts(scene, model, Present(chunk, **cost))


def keys(scene: Scene) -> dict[str, list[str]]:
    return {title: [row.key for row in rows] for title, rows in groups(scene).items()}


@pytest.mark.parametrize("inertia", INERTIAS)
@pytest.mark.parametrize("boundary", BOUNDARIES)
def test_a_link_and_a_spring_have_their_share(
    make_scene: Make, boundary: str, inertia: str
) -> None:
    """m = M/n, l = L/n, k = EI/l, and 2 EI/l at the root of a clamped rod."""
    clamp = {"clamp_angle": 0.4} if boundary in ("cantilever", "clamped") else {}
    found = shown(make_scene(4, boundary, rod={"inertia": inertia, **clamp}))
    assert float(found["link_mass"]) == 0.75
    assert float(found["link_length"]) == 0.5
    assert float(found["spring_stiffness"]) == 60.0
    assert ("root_stiffness" in found) == (boundary == "clamped")
    if boundary == "clamped":
        assert float(found["root_stiffness"]) == 120.0
    if clamp:
        assert float(found["clamp_angle"]) == 0.4


def test_what_differs_along_a_rod_is_shown_as_such(make_scene: Make) -> None:
    table = make_scene(4).model_dump(exclude_none=True)
    table["rod"] |= {"bending_stiffness": "30*(2 - s)", "mass_per_length": "1.5"}
    del table["rod"]["mass"]
    table["bodies"] = [{"name": "tank", "at": 0.0, "mass": 2.0}]
    found = shown(Scene.from_dict(table))
    assert "30*(2 - s) N m²" in found["bending_stiffness_law"]
    assert "mass_per_length_law" not in found
    assert float(found["body_mass_0"]) == 2.0
    assert found["link_mass"] == "0.75000 to 2.7500"
    # 1/k = integral of ds/EI over a quarter of 2 m about the joint.
    first, last = (15 / np.log((2.125 - s) / (1.875 - s)) for s in (0.25, 0.75))
    assert found["spring_stiffness"] == f"{last:.3f} to {first:.2f}"


def test_a_straight_rod_has_the_inertia_of_a_bar(make_scene: Make) -> None:
    """2 m and 3 kg at 30 degrees, turning about its start at 2 rad/s: M L^2/12 = 1 kg m^2 across
    it, M L^2/3 about its start."""
    scene = make_scene(4, "pinned", ("gravity",), initial={"phi": np.pi / 6, "omega": 2.0})
    found = {key: float(text) for key, text in shown(scene).items() if key in NUMBERS}
    expected = {
        "length": 2.0,
        "mass": 3.0,
        "bending_stiffness": 30.0,
        "gravity": 9.81,
        "links": 4,
        "centre_of_gravity_x": np.cos(np.pi / 6),
        "centre_of_gravity_y": 0.5,
        "principal_direction_1": 30.0,
        "principal_direction_2": -60.0,
        "principal_moment_1": 0.0,
        "principal_moment_2": 1.0,
        "inertia_x": 0.25,
        "inertia_y": 0.75,
        "product_xy": np.sqrt(3) / 4,
        "kinetic_energy": 0.5 * 4.0 * 2.0**2,
        "gravity_energy": 3.0 * 9.81 * 0.5,
        "total_energy": 8.0 + 3.0 * 9.81 * 0.5,
    }
    assert set(expected) == set(NUMBERS)
    for key, value in expected.items():  # of five digits the last is rounded
        assert found[key] == pytest.approx(value, rel=5e-5, abs=1e-14), key


NUMBERS = (
    *("length", "mass", "bending_stiffness", "gravity", "links"),
    *("centre_of_gravity_x", "centre_of_gravity_y"),
    *("principal_direction_1", "principal_direction_2"),
    *("principal_moment_1", "principal_moment_2", "inertia_x", "inertia_y", "product_xy"),
    *("kinetic_energy", "gravity_energy", "total_energy"),
)


@pytest.mark.parametrize(
    ("links", "terms"),
    [(1, ()), (3, ("gravity",)), (3, ("follower", "external_damping")), (1, TERMS)],
)
def test_rows_are_those_of_the_scene(make_scene: Make, links: int, terms: tuple[str, ...]) -> None:
    scene = make_scene(links, terms=terms)
    titles = keys(scene)
    rows = [key for found in titles.values() for key in found]
    assert set(shown(scene)) == set(rows) - {"t"}  # which comes with every picture
    assert ("Loads and damping" in titles) == bool(terms)
    assert ("Critical force" in titles) == ("follower" in terms)
    assert ("gravity_energy" in rows) == ("gravity" in terms)
    assert ("spring_stiffness" in rows) == (links > 1)
    assert ("fin_factor_body" in rows) == ("external_damping" in terms and links > 1)
    for term in TERMS:
        assert (f"work_{term}" in rows) == (term in terms and term != "gravity")
    for name in scene.structure.parameters:
        other = name in ("fin_factor", *scene.structure.numbers)
        assert name in rows or other or name.startswith(("foundation_", "support_"))


def test_loads_that_change_with_time_are_those_of_the_present(make_scene: Make) -> None:
    scene = make_scene(2, "pinned", TERMS)
    found = shown(scene, t=0.7)
    assert float(found["tip_force_y"]) == pytest.approx(-4 * np.cos(2.1), rel=5e-5)
    assert float(found["tip_force_x"]) == 6.0
    assert [float(found[f"fin_factor_{at}"]) for at in ("nose", "body", "tail")] == [1, 1, 5]
    rows = {row.key: row for row in groups(scene)["Loads and damping"]}
    assert rows["tip_force_y"].label == "tip force y, at present"
    assert rows["tip_force_x"].label == "tip force x"
    assert rows["internal_damping"].unit == "m²/s"


def test_fin_factors_that_differ_are_shown_as_a_range(make_scene: Make) -> None:
    scene = make_scene(3, terms=("external_damping",))
    table = scene.model_dump(exclude_none=True)
    table["loads"]["external_damping"]["fin_factor"] = [1.0, 2.0, 0.5, 7.0]
    found = shown(Scene.from_dict(table))
    assert found["fin_factor_body"] == "0.50000 to 2.0000"
    assert float(found["fin_factor_tail"]) == 7.0


def test_work_and_given_energy_are_in_the_balance(make_scene: Make) -> None:
    scene = make_scene(2, "pinned", ("follower", "tip_load"))
    found = shown(scene, given=2.0)
    assert float(found["work_follower"]) == 1.0
    assert float(found["work_tip_load"]) == 2.0
    assert float(found["given"]) == 2.0
    total = float(found["total_energy"])
    assert float(found["energy_balance"]) == pytest.approx(total - 1.0 - 2.0 - 2.0, abs=1e-4)


@pytest.mark.parametrize(
    ("critical", "expected"),
    [
        (160.0, ("160.00", "25.00", "120.00")),
        (32.0, ("32.000", "125.00", "-8.0000")),
        ("computing", ("computing", "–", "–")),
        (None, ("–", "–", "–")),
        (0.0, ("0.0000", "–", "-40.000")),
    ],
)
def test_the_distance_to_the_critical_force(
    make_scene: Make, critical: Any, expected: tuple[str, ...]
) -> None:
    found = shown(make_scene(2, terms=("follower",)), critical=critical)  # of 40 N
    names = ("critical_force", "critical_ratio", "critical_distance")
    assert tuple(found[name].strip() for name in names) == expected


def test_why_there_is_no_critical_force_has_a_row_of_its_own(make_scene: Make) -> None:
    scene, words = make_scene(2, terms=("follower",)), "no mode can become unstable"
    found = shown(scene, critical=words)
    assert (found["critical_force"].strip(), found["critical_why"]) == ("–", words)
    for other in ("computing", 160.0, None):
        assert shown(scene, critical=other)["critical_why"] == ""


def test_rounding_is_no_product_of_inertia(make_scene: Make) -> None:
    """A straight rod at 90 degrees, the cosine of which is 6e-17 in doubles: 1 kg m^2 about x,
    nothing about y, and no product."""
    found = shown(make_scene(4, "pinned", initial={"phi": np.pi / 2}))
    assert float(found["inertia_x"]) == 1.0
    for key in ("principal_moment_1", "inertia_y", "product_xy"):
        assert float(found[key]) == 0.0, key


def test_how_the_run_goes(make_scene: Make) -> None:
    counts = Counts(steps=1234567, rejected=89, rhs=12)
    scene = make_scene(2, output_every=0.02)
    used = scene.integrate.model_copy(update={"method": "radau"})
    found = shown(scene, t=12.3, counts=counts, seconds=7.126, ratio=1.7264, settings=used)
    stripped = {key: text.strip() for key, text in found.items()}
    assert stripped["method"] == "radau (auto)"
    assert stripped["seconds"] == "7.13"
    assert stripped["ratio"] == "1.73"
    assert stripped["steps"] == "1\u202f234\u202f567"
    assert stripped["rejected"] == "89"
    assert stripped["rhs"] == "12"
    assert float(stripped["rtol"]) == 1e-10
    rough = scene.integrate.model_copy(update=FOR_LOOKING[-1])
    found = shown(scene, settings=rough)
    assert found["method"] == f"{FOR_LOOKING[-1]['method']} (for looking)"
    assert (float(found["rtol"]), float(found["atol"])) == (1e-3, 1e-6)
    fixed_step = make_scene(2, method="rk4", step=0.001)
    found = shown(fixed_step)
    assert (found["method"].strip(), float(found["step"])) == ("rk4", 0.001)
    assert "rtol" not in found
    assert found["rejected"].strip() == found["ratio"].strip() == "–"


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (0.0, "0.0000"),
        (1.0, "1.0000"),
        (-123.456789, "-123.46"),
        (99999.6, "1.0000e+05"),
        (12345.4, "12345"),
        (-1.23456e-5, "-1.2346e-05"),
        (0.00012345678, "0.00012346"),
        (float("nan"), "nan"),
        (float("-inf"), "-inf"),
    ],
)
def test_five_digits(value: float, text: str) -> None:
    assert digits(value).strip() == text
    assert len(digits(value)) == WIDTH


def test_numbers_do_not_jitter() -> None:
    rng = np.random.default_rng(2)
    values = rng.normal(size=3000) * 10.0 ** rng.integers(-99, 100, 3000)
    for value in values.tolist():
        for text in (digits(value), fixed(value, 3), digits(value, 3)):
            assert len(text) == WIDTH
        assert float(digits(value)) == pytest.approx(value, rel=5.01e-5)
    assert fixed(-0.0001, 2).strip() == "0.00"
    assert len(whole(10**8)) == WIDTH
    assert len({len(digits(v)) for v in (1e-300, -1e300)}) == 1


def test_tank_that_is_empty_has_no_mass() -> None:
    """A live run comes to it behind the span, stops there, and its page shows the values."""
    table = {**ROD, "bodies": [{"name": "tank", "at": 0.5, "mass": "6 - t", "inertia": 0.1}]}
    scene = Scene.from_dict(table)
    links = scene.distribution_at(6.0).of_links()["link_mass"]
    assert sum(links) == pytest.approx(ROD["rod"]["mass"], rel=1e-15)
