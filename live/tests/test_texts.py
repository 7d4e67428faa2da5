"""The text panel: rows that the scene has, numbers that are known, a width that stays."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import rodgen
from live.tests.view import DIGITS
from rodgen.arrays import Array
from rodgen.integrate.stepper import Counts
from rodgen.model.rod import BOUNDARIES
from rodgen.model.terms import THESIS_TERMS
from rodgen.scene import Scene
from rodgen_live.page.elements import LAYERS
from rodgen_live.panel_rows import (
    WIDTH,
    CriticalForce,
    RunStatus,
    TextRow,
    format_decimals,
    format_integer,
    format_significant,
    row_groups,
)
from rodgen_live.sample_store import Chunk
from tests.palette import ALL, ENDS

Make = Callable[..., Scene]
NAMES = "follower_force", "follower_angle"


def groups_of(
    scene: Scene, y: Array | None = None, t: float = 0.0, **present: Any
) -> dict[str, list[TextRow]]:
    """The panel for a state (states,), by default the initial one."""
    model = rodgen.build(scene)
    y = scene.initial_state() if y is None else y
    p = model.parameters(**scene.parameters)
    works = tuple(model.power(0.0, y, p)) if hasattr(model, "power") else ()
    work = np.arange(1.0, len(works) + 1)[None]
    chunk = Chunk(np.array([t]), y[None], work, works, p, given=present.pop("given", 0.0))
    cost = {"counts": Counts(), "seconds": 0.0, "settings": scene.integrate, **present}
    return row_groups(RunStatus(scene, model, chunk, **cost))


def shown(*state: Any, **present: Any) -> dict[str, str]:
    """Texts of the panel."""
    rows = (row for rows in groups_of(*state, **present).values() for row in rows)
    return {row.key: row.text.strip() for row in rows if row.text is not None}


def numbers(text: str) -> Any:
    """Of a text such as 0.5 to 2.0, to five digits."""
    return pytest.approx([float(part) for part in text.split(" to ")], rel=DIGITS)


def test_a_link_and_a_spring_have_their_share(make_scene: Make) -> None:
    """m = M/n, l = L/n, k = EI/l, and 2 EI/l at the root of a clamped rod."""
    for boundary in BOUNDARIES:
        clamp = {"clamp_angle": 0.4} if boundary in ("cantilever", "clamped") else {}
        found = shown(make_scene(4, boundary, rod=clamp))
        wanted = {"link_mass": 0.75, "link_length": 0.5, "spring_stiffness": 60.0, **clamp}
        wanted |= {"root_stiffness": 120.0} if boundary == "clamped" else {}
        assert {key: float(found[key]) for key in wanted} == wanted
        assert ("root_stiffness" in found) == (boundary == "clamped")


def test_what_differs_along_a_rod_is_shown_as_such(make_scene: Make) -> None:
    table = make_scene(4).model_dump(exclude_none=True)
    table["rod"] |= {"bending_stiffness": "30*(2 - s)", "mass_per_length": "1.5"}
    del table["rod"]["mass"]
    table["bodies"] = [{"name": "tank", "at": 0.0, "mass": 2.0}]
    found = shown(Scene.from_dict(table))
    assert "30*(2 - s)" in found["bending_stiffness_law"]
    assert "mass_per_length_law" not in found
    assert float(found["body_mass_0"]) == 2.0
    assert numbers(found["link_mass"]) == [0.75, 2.75]
    # 1/k = integral of ds/EI over a quarter of 2 m about the joint.
    first, last = (15 / np.log((2.125 - s) / (1.875 - s)) for s in (0.25, 0.75))
    assert numbers(found["spring_stiffness"]) == [last, first]
    table = make_scene(3, terms=("external_damping",)).model_dump(exclude_none=True)
    table["loads"]["external_damping"]["fin_factor"] = [1.0, 2.0, 0.5, 7.0]
    found = shown(Scene.from_dict(table))
    assert numbers(found["fin_factor_body"]) == [0.5, 2.0]
    assert float(found["fin_factor_tail"]) == 7.0


def test_loads_that_are_zero_are_shown_if_they_change(make_scene: Make) -> None:
    scene = make_scene(2, terms=("follower", "gravity"))
    for force, angle, wanted in ((40.0, 0.0, {"follower_force"}), ("min(t, 1)", 0.1, set(NAMES))):
        changed = {"loads.follower.force": force, "loads.follower.angle": angle}
        found = shown(scene.replace(changed | {"loads.gravity.g": 0.0}))
        assert {name for name in (*NAMES, "gravity") if found[name]} == wanted


def test_masses_of_links_follow_what_empties(make_scene: Make) -> None:
    """The rod, and a tank on its last link, which has nothing left in the end."""
    table = make_scene(4).model_dump(exclude_none=True)
    del table["rod"]["mass"]
    table["rod"]["mass_per_length"] = "1.5 - 0.1*t"
    table["bodies"] = [{"name": "tank", "at": 1.0, "mass": "max(2 - t, 0)", "inertia": 0.1}]
    scene = Scene.from_dict(table)
    for t, wanted in ((0.0, [0.75, 2.75]), (1.0, [0.7, 1.7]), (5.0, [0.5])):
        assert numbers(shown(scene, t=t)["link_mass"]) == wanted


def test_a_straight_rod_has_the_inertia_of_a_bar(make_scene: Make) -> None:
    """2 m and 3 kg, turning about its start at 2 rad/s: M L^2/12 = 1 kg m^2 across it, M L^2/3
    about its start. At 30 degrees, and at 90, where rounding is no product of inertia."""
    for degrees in (30.0, 90.0):
        phi = np.radians(degrees)
        scene = make_scene(3, "clamped", ENDS, initial={"phi": phi}, rod={"clamp_angle": phi})
        y = scene.initial_state()
        y[3:] = 2.0
        found = shown(scene, y)
        high = 3.0 * 9.81 * np.sin(phi)
        for key, value in {
            "length": 2.0,
            "mass": 3.0,
            "bending_stiffness": 30.0,
            "gravity": 9.81,
            "links": 3,
            "centre_of_gravity_x": np.cos(phi),
            "centre_of_gravity_y": np.sin(phi),
            "principal_direction_1": degrees,
            "principal_direction_2": degrees - 90.0,
            "principal_moment_1": 0.0,
            "principal_moment_2": 1.0,
            "inertia_x": np.sin(phi) ** 2,
            "inertia_y": np.cos(phi) ** 2,
            "kinetic_energy": 0.5 * 4.0 * 2.0**2,
            "gravity_energy": high,
            "total_energy": 8.0 + high,
            "product_xy": np.sin(phi) * np.cos(phi),
        }.items():
            assert float(found[key]) == pytest.approx(value, rel=DIGITS, abs=1e-14), key


@pytest.mark.parametrize(
    ("links", "terms"), [(1, ()), (5, THESIS_TERMS), (1, ALL)], ids=["bare", "usual", "all"]
)
def test_rows_are_those_of_the_scene(make_scene: Make, links: int, terms: tuple[str, ...]) -> None:
    scene = make_scene(links, terms=terms)
    titles = {title: [row.key for row in rows] for title, rows in groups_of(scene).items()}
    rows = [key for found in titles.values() for key in found]
    assert set(shown(scene)) == set(rows) - {"t"}  # which comes with every picture
    assert ("Loads and damping" in titles) == bool(terms)
    assert ("Critical force" in titles) == ("follower" in terms)
    potentials = {"gravity", "moment"}  # of a couple that is a number
    assert ("gravity_energy" in rows) == bool(potentials & {*terms})
    assert ("spring_stiffness" in rows) == (links > 1)
    assert ("fin_factor_body" in rows) == ("external_damping" in terms and links > 1)
    for term in ALL:
        assert (f"work_{term}" in rows) == (term in terms and term not in potentials)
    for name in scene.structure.parameters:
        other = name in ("fin_factor", *scene.structure.numbers)
        assert name in rows or other or name.startswith(("foundation_", "support_"))


def test_bending_moment_and_couples_have_switches_of_their_own() -> None:
    """The colours of the rod are there in every scene, the arrows where there is a couple."""
    needed = {layer.label: layer.term for layer in LAYERS.values()}
    assert needed["bending moment, as colour"] is None
    assert needed["couple"] == "moment"


def test_loads_and_works_are_those_of_the_present(make_scene: Make) -> None:
    """And the energy that was given is in the balance."""
    scene = make_scene(3, "clamped", ENDS, rod={"clamp_angle": 0.0})
    found = shown(scene, t=0.7, given=2.0)
    values = {key: float(text) for key, text in found.items() if key.startswith(("tip", "fin"))}
    assert values["tip_force_y"] == pytest.approx(-4 * np.cos(2.1), rel=DIGITS)
    assert values["tip_force_x"] == 6.0
    assert [values[f"fin_factor_{at}"] for at in ("nose", "body", "tail")] == [1, 1, 5]
    rows = {row.key: row for row in groups_of(scene)["Loads and damping"]}
    assert rows["tip_force_y"].label != "tip force y"  # which changes with time
    assert rows["tip_force_x"].label == "tip force x"
    assert rows["internal_damping"].unit == "m²/s"
    assert shown(scene, t=0.7, given=0.0)["given"] == ""  # nothing was done
    works = [float(text) for key, text in found.items() if key.startswith("work_") and text]
    assert works[:4] == [1.0, 2.0, 3.0, 4.0]
    balance = float(found["total_energy"]) - sum(works) - float(found["given"])
    # What is shown has five digits, of some tens of joules.
    assert float(found["energy_balance"]) == pytest.approx(balance, abs=5e-3)


def test_the_distance_to_the_critical_force(make_scene: Make) -> None:
    """Of 40 N. Why there is none has a row of its own."""
    scene, words = make_scene(5, terms=THESIS_TERMS), "no mode can become unstable"
    none = ("–", "–", "–", "")
    for critical, expected in (
        (160.0, ("160.00", "25.00", "120.00", "")),
        (32.0, ("32.000", "125.00", "-8.0000", "")),
        ("computing", ("computing", "–", "–", "")),
        (None, none),
        (0.0, ("0.0000", "–", "-40.000", "")),
        (words, (*none[:3], words)),
    ):
        found = shown(scene, critical=CriticalForce(critical))
        names = ("load", "ratio", "distance", "why")
        assert tuple(found[f"critical_{name}"] for name in names) == expected


def test_how_the_run_goes(make_scene: Make) -> None:
    counts = Counts(nsteps=1234567, rejected=89, nfev=12)
    scene = make_scene(5, terms=THESIS_TERMS, output_every=0.02)
    used = scene.integrate.model_copy(update={"method": "radau"})
    found = shown(scene, t=12.3, counts=counts, seconds=7.126, ratio=1.7264, settings=used)
    wanted = {"seconds": "7.13", "ratio": "1.73", "steps": "1\u202f234\u202f567"}
    wanted |= {"rejected": "89", "rhs": "12"}
    assert {key: found[key] for key in wanted} == wanted
    assert (found["method"].split()[0], float(found["rtol"])) == ("radau", 1e-10)
    found = shown(make_scene(5, terms=THESIS_TERMS, method="rk4", step=0.001))
    assert (found["method"], float(found["step"])) == ("rk4", 0.001)
    assert "rtol" not in found
    assert found["rejected"] == found["ratio"] == "–"


def test_numbers_have_five_digits_and_do_not_jitter() -> None:
    for value, text in (
        (0.0, "0.0000"),
        (1.0, "1.0000"),
        (-123.456789, "-123.46"),
        (99999.6, "1.0000e+05"),
        (12345.4, "12345"),
        (-1.23456e-5, "-1.2346e-05"),
        (0.00012345678, "0.00012346"),
        (float("nan"), "nan"),
        (float("-inf"), "-inf"),
        (-1e300, "-1.0000e+300"),
    ):
        assert format_significant(value).strip() == text
        assert len(format_significant(value)) == WIDTH
    rng = np.random.default_rng(2)
    for value in (rng.normal(size=500) * 10.0 ** rng.integers(-99, 100, 500)).tolist():
        for text in (
            format_significant(value),
            format_decimals(value, 3),
            format_significant(value, 3),
        ):
            assert len(text) == WIDTH
        assert float(format_significant(value)) == pytest.approx(value, rel=5.01e-5)
    assert format_decimals(-0.0001, 2).strip() == "0.00"
    assert len(format_integer(10**8)) == WIDTH
