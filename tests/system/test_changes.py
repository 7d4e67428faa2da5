"""What a change of a system must not do: to other systems, to numbers that it does not name."""

from __future__ import annotations

import numpy as np
import pytest

import rodgen
from rodgen.errors import InputError
from rodgen.system import System
from tests.scene.tables import scene_of
from tests.told import refused

FORCE = "loads.follower.force"
ROD = {"links": 4, "length": 2.0, "mass": 3.0, "bending_stiffness": 30.0}
CLAMPED = {**ROD, "boundary": "clamped"}


def pushed(force: str, **tables: object) -> System:
    return System(scene_of(rod=CLAMPED, loads={"follower": {"force": force}}, **tables))


def test_a_list_of_one_system_is_not_that_of_another() -> None:
    one = pushed("2").at(y0=np.zeros(8))
    other = one.at({"initial.phi.0": 0.7})
    assert refused(one.at, {"initial.phi.0": -np.inf}).field == "initial.phi.0"
    assert one.scene.initial.phi == [0.0] * 4
    assert other.scene.initial.phi == [0.7, 0.0, 0.0, 0.0] == other.y0[:4].tolist()


def test_numbers_in_one_text_are_changed_by_the_places_that_they_have() -> None:
    """An exponent that becomes whole is no number of the module any more."""
    changes = {f"{FORCE}.1": 2.0, f"{FORCE}.2": 7.0}
    system = pushed("3*t**1.5 + 4*t + 5").at(changes)
    assert system.scene.loads.follower.force == "3*t**2 + 7*t + 5"
    assert system.structure == system.scene.structure
    np.testing.assert_array_equal(system.p, System(system.scene).p)
    assert refused(pushed("3*t").at, {f"{FORCE}.0": -1.0})[:2] == (f"{FORCE}.0", -1.0)


def test_supports_without_a_place_move_with_the_start_of_a_free_rod() -> None:
    """They rest where the straight rod has their points."""
    held = [{"at": 0.4, "stiffness": [300.0, 400.0]}]
    system = System(scene_of(rod=ROD, supports=held))
    y = np.array(system.y0)
    y[:2] = 0.5, 0.2
    np.testing.assert_array_equal(system.at(y0=y).p, System(system.at(y0=y).scene).p)
    assert system.at(y0=y).parameter("support_x").max() == pytest.approx(0.5 + 0.4 * 2.0)


def test_a_number_of_a_law_along_the_rod_is_none_of_a_link() -> None:
    key = "loads.distributed_follower.force_per_length"
    loads = {"distributed_follower": {"force_per_length": "5*(1 - s)*t"}}
    frozen = System(scene_of(rod=CLAMPED, loads=loads)).at(t=0.5)
    doubled = frozen.at({f"{key}.0": 10.0})
    twice = 2 * frozen.parameter("distributed_follower")
    np.testing.assert_array_equal(doubled.parameter("distributed_follower"), twice)
    assert refused(frozen.at, {f"{key}.3": 10.0}).field == "key"


def test_another_span_leaves_numbers_of_a_time() -> None:
    """Also where the law has none in all of it: a mass that is zero at 15 s."""
    rod = {**CLAMPED, "mass": None, "mass_per_length": "3 - 0.2*t"}
    loads = {"internal_damping": {"coefficient": 0.02}}
    frozen = System(scene_of(rod=rod, loads=loads)).at(t=5.0)
    later = frozen.with_settings(span=[5.0, 20.0])
    np.testing.assert_array_equal(later.p, frozen.p)
    assert later.scene.integrate.span == [5.0, 20.0]


def test_settings_are_changed_as_a_scene_changes_them() -> None:
    timed = pushed("2", integrate={"t_eval": [0.5, 1.0], "span": [0.0, 1.0]})
    for others in ({}, {"rod.mass": 4.0}):
        changed = timed.at({"integrate.output_every": 0.1, **others})
        assert changed.settings.t_eval == [0.5, 1.0]
    stepped = pushed("2", integrate={"method": "gauss", "step": 0.01})
    for made in (stepped.at, stepped.scene.replace):
        assert refused(made, {"integrate.rtol": 1e-6}).field == "integrate.rtol"


def test_what_is_no_change_is_refused() -> None:
    system = pushed("3*t")
    wrong: object
    for wrong in ({"0": 1.0}, {1: 2}, {f"{FORCE}.0": 10**400}, {f"{FORCE}.²": 1.0}, [1], "x"):
        with pytest.raises(InputError):
            system.at(wrong)  # type: ignore[arg-type]
    fixed = System(rodgen.Scene.example("ziegler"))
    for values in (
        np.ma.masked_array([1.0, 2.0], [0, 1]),
        ["10*t"],
        [1.0, None],
        [[1.0], [1.0, 2]],
    ):
        assert refused(fixed.batch_arrays, {FORCE: values}).field == f"p.{FORCE}"


def test_a_run_up_to_a_time_is_not_for_loads_of_another() -> None:
    frozen = pushed("5*t", integrate={"span": [0.0, 1.0]}).at(t=0.25)
    assert refused(rodgen.natural_modes, frozen, after=0.75)[:2] == ("after", 0.75)


def test_many_runs_do_not_pass_over_an_event_that_ends_them() -> None:
    watched = [{"quantity": "phi_1", "value": 0.0, "name": "z", "action": "stop"}]
    scene = rodgen.Scene.example("ziegler").replace({"events": watched})
    assert refused(rodgen.simulate_many, scene)[:2] == ("events", ["z"])
