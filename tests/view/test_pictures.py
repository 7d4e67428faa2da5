"""Pictures and the summary of a run: what their curves are, and what they say."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

import rodgen
from rodgen.integrate import Solution
from rodgen.model.terms import TERMS, axis_label
from rodgen.scene import Scene
from rodgen.show import run_pictures
from rodgen.show.analysis_pictures import equilibrium_shape, scene_at_start
from rodgen.show.animation.motion import sample_motion
from rodgen.show.branch_pictures import bifurcation_diagram
from rodgen.show.event_marks import force_intervals
from rodgen.show.marks import LONGEST_TURN, OBSTACLE, curved_arrow, draw_by_stability
from rodgen.show.picture_files import save_figures
from rodgen.show.picture_settings import PictureSettings
from rodgen.show.run_pictures import energies, phase_plot, trajectories
from rodgen.show.summary import scene_table, summary
from rodgen.show.time_pictures import (
    moment_map,
    shapes,
    tail_history,
)
from tests.palette import ROD
from tests.told import numbers
from tests.view.marks import turned


def run(force: float | str = 0.0, g: float = 0.0, **more: Any) -> Solution:
    """A rod under these loads; more: other tables, and keys of [integrate]."""
    tables = {name: more.pop(name) for name in ("events", "initial") if name in more}
    loads = {**ROD["loads"], "follower": {"force": force}, "gravity": {"g": g}}
    table = {**ROD, **tables, "loads": loads, "integrate": {**ROD["integrate"], **more}}
    return rodgen.simulate(Scene.from_dict(table))


@pytest.fixture(scope="module")
def swinging() -> Solution:
    """A rod that is bent at first and floats, for 20 s: lines of its spectrum are 0.05 Hz apart."""
    return run(span=[0.0, 20.0], output_every=0.02)


def test_tail_swings_with_the_first_natural_frequency(swinging: Solution) -> None:
    above, below = tail_history(swinging).axes
    (curve,), (spectrum,) = above.lines, below.lines
    assert np.array_equal(curve.get_ydata(), swinging.values("tail_deflection"))
    frequencies, sizes = spectrum.get_data()
    first = rodgen.natural_modes(swinging.scene, count=1).frequencies[0]
    assert frequencies[np.argmax(sizes)] == pytest.approx(first, abs=0.05)


def test_moments_are_those_of_the_joints(swinging: Solution) -> None:
    mesh = moment_map(swinging).axes[0].collections[0]
    shown = np.reshape(mesh.get_array(), (6, -1))
    assert np.array_equal(shown, swinging.bending_moments.T)
    low, high = mesh.get_clim()
    assert -low == high == np.abs(shown).max()


def test_moments_are_drawn_where_the_joints_are() -> None:
    rod = {"links": 3, "joints": [0.0, 0.1, 0.4, 1.0], "boundary": "clamped"}
    scene = rodgen.Scene(
        name="uneven",
        rod=rod | {"length": 1.0, "mass": 1.0, "bending_stiffness": 1.0},
        loads={"gravity": {}},
        integrate={"span": [0.0, 0.1], "output_every": 0.05},
    )
    run = rodgen.simulate(scene, target="numpy", progress=False)
    mesh = moment_map(run).axes[0].collections[0]
    # Rows meet half way between joints.
    assert np.asarray(mesh.get_coordinates())[1:-1, 0, 1] == pytest.approx([0.05, 0.25, 0.7])


def test_a_curved_arrow_turns_as_its_couple_does() -> None:
    """An arc about zero, as long as its share, and a head at its end that points on."""
    for share in (1.0, 0.5, -1.0):
        *arc, first, end, last = curved_arrow(2.0, share)
        assert np.linalg.norm(arc, axis=1) == pytest.approx(np.full(len(arc), 2.0))
        angles = np.unwrap(np.arctan2(*np.transpose(arc)[::-1]))
        assert angles[-1] - angles[0] == pytest.approx(share * LONGEST_TURN)
        assert end == pytest.approx(arc[-1])
        ahead = arc[-1] - (first + last) / 2
        assert np.linalg.det([arc[-1], ahead]) * share > 0


def test_couples_are_drawn_about_their_points_and_told_of() -> None:
    loads = {"moment": [{"moment": -2.0, "at": 0.3}, {"moment": "3 if t < 0.25 else 0"}]}
    scene = Scene.from_dict({**ROD, "loads": loads, "integrate": {"span": [0.0, 0.5]}})
    axes = scene_at_start(scene).axes[0]
    drawn = [line for line in axes.lines if line.get_color() == TERMS["moment"].colours[0]]
    # The joints of the scene are those of its thumbnail; both arcs have one radius.
    for line, at, turn in zip(drawn, (0.3, 1.0), (-1.0, 1.0), strict=True):
        points = np.transpose(line.get_data())
        rod = np.transpose(axes.lines[0].get_data())
        link = min(int(at * 5), 4)
        centre = rod[link] + (at * 5 - link) * (rod[link + 1] - rod[link])
        way = points[:2] - centre
        assert np.linalg.norm(way, axis=1) == pytest.approx([0.07 * 2.0] * 2)
        assert np.linalg.det(way) * turn > 0
    solution = rodgen.simulate(scene)
    acting = {term.name: end for term, _, end in force_intervals(solution)}
    assert acting == {"moment_2": pytest.approx(0.25, abs=0.01)}
    (text,) = (t for t in scene_at_start(scene).legends[0].get_texts() if "-2" in t.get_text())
    assert text.get_text() == "couple -2\u00a0N m"


def test_stops_and_walls_are_drawn_once_and_told_of() -> None:
    """However many shapes there are, and beyond what is seen of a wall without being in the way."""
    stop = {"at": 1.0, "direction": "pi/2", "gap": 0.3, "stiffness": 10.0}
    wall = {"normal": "pi/2", "point": [0.0, -0.4], "stiffness": 10.0}
    table = {**ROD, "stops": [stop], "walls": [wall], "integrate": {"span": [0.0, 0.2]}}
    solution = rodgen.simulate(Scene.from_dict(table), progress=False)
    for figure in (shapes(solution), scene_at_start(solution.scene)):
        axes = figure.axes[0]
        lines = [one.get_xydata() for one in axes.lines if one.get_gid() == OBSTACLE]
        np.testing.assert_allclose([line[:, 1].mean() for line in lines], [0.3, -0.4], atol=1e-12)
        assert np.ptp(axes.get_xlim()) < 5.0
        assert "stops and walls" in axes.get_xlabel().replace("\n", " ")


def test_pictures_say_when_a_force_acts_and_what_happened() -> None:
    apex = {"name": "apex", "quantity": "tip_y", "value": -0.05}
    solution = run("3 if t < 0.25 else 0", 9.81, events=[apex], span=[0.0, 0.5])
    ((term, start, end),) = force_intervals(solution)
    assert term is TERMS["follower"]
    assert (start, end) == pytest.approx((0.0, 0.25), abs=0.01)  # between samples
    assert [event.name for event in solution.events] == ["apex"]
    for draw in (energies, moment_map, tail_history, trajectories):
        figure = draw(solution)
        said = [text.get_text() for text in figure.legends[0].get_texts()]
        assert any("follower force" in words for words in said)
        (apex,) = (words for words in said if words.endswith(": apex"))
        assert apex.partition(":")[0] in {text.get_text() for text in figure.axes[0].texts}


@pytest.mark.parametrize("width", [3.3, 7.0])
@pytest.mark.slow
def test_words_on_events_lie_over_nothing(tmp_path: Path, width: float) -> None:
    """Of many events with the longest names, some at almost the same times: numbers stand apart
    from each other, above time axes, and the legend inside the picture."""
    heights = [-0.1, -0.1001, -0.1002, -0.5, -1.0, -2.0, *np.linspace(-2.5, -4.5, 12)]
    events = [
        {
            "name": f"place {at} {'of the centre ' * 4}".strip(),
            "quantity": "centre_of_gravity_y",
            "value": float(one),
        }
        for at, one in enumerate(heights)
    ]
    solution = run(g=9.81, events=events, span=[0.0, 1.0])
    assert len(solution.events) == len(events)
    seen = []

    def drawn() -> Iterator[tuple[str, Figure]]:
        for draw in (energies, moment_map, tail_history, trajectories):
            figure = draw(solution)
            yield draw.__name__, figure
            seen.append(draw)
            figure.draw_without_rendering()
            boxes = [text.get_window_extent() for text in figure.axes[0].texts]
            for at, box in enumerate(boxes):
                assert not any(box.overlaps(other) for other in boxes[at + 1 :])
                assert box.y0 >= figure.axes[0].bbox.y1 or draw is trajectories
            inside = figure.legends[0].get_window_extent()
            assert inside.x0 >= 0
            assert inside.x1 <= figure.bbox.width

    save_figures(drawn(), tmp_path, PictureSettings("png", width))
    assert len(seen) == 4


@pytest.mark.parametrize("name", run_pictures.PICTURES)
def test_a_picture_of_one_sample_shows_it(swinging: Solution, name: str) -> None:
    """None has empty axes, and none a scale of times: there is one."""
    figure = run_pictures.PICTURES[name](swinging.isel(np.array([7])))
    figure.draw_without_rendering()
    for axes in figure.axes:
        assert any(map(_is_seen, axes.lines)) or axes.texts or axes.collections
        assert not axes.child_axes
    t = swinging.t[7]
    if name in ("energy", "tail"):
        (x,) = {float(x) for line in figure.axes[0].lines for x in line.get_xdata()}
        assert x == t
    if name == "moment":
        dots = figure.axes[0].collections[0]
        assert np.array_equal(dots.get_array(), swinging.bending_moments[7])
        assert {*dots.get_offsets()[:, 0]} == {t}


def _is_seen(line: Line2D) -> bool:
    """Whether a line has more than one point, or a mark."""
    return len(line.get_xdata()) > 1 or line.get_marker() not in ("None", "", None)


def test_energies_are_those_that_there_are_and_that_in_gravity_begins_at_zero() -> None:
    """A rod that falls from 4 km: what it loses in height is what it gains in speed."""
    falling = run(g=9.81, span=[0.0, 0.5], initial={"phi": 0.0, "position": [0.0, 4000.0]})
    drawn = [(line.get_label(), line.get_ydata()) for line in energies(falling).axes[0].lines]
    assert len(drawn) == 3
    fallen = 3.0 * 9.81 * 9.81 * falling.t**2 / 2  # J
    for name, due in (("gravity", -fallen), ("kinetic", fallen), ("total", 0 * fallen)):
        (line,) = (line for label, line in drawn if label.startswith(name))
        assert line == pytest.approx(due, rel=1e-6, abs=1e-6)


@pytest.mark.parametrize(("g", "named"), [(0.0, "couples"), (9.81, "gravity and couples")])
def test_energy_of_constant_couples_is_told_as_such(
    make_scene: Callable[..., Scene], g: float, named: str
) -> None:
    scene = make_scene(2, "clamped", terms=("gravity",) if g else ())
    scene = scene.replace({"loads.moment": [{"moment": 0.5}, {"moment": 0.1, "at": 0.2}]})
    lines = energies(rodgen.simulate(scene, span=(0, 0.1), target="numpy")).axes[0].lines
    labels = [line.get_label() for line in lines]
    assert f"{named} from the start" in labels
    assert f"total with {named} from the start" in labels


def test_weight_is_drawn_along_its_vector(make_scene: Callable[..., Scene]) -> None:
    """In a picture of the rest, in which the rod bends too much to be stretched, and in a film."""
    fall = {"loads.gravity": {"acceleration": ["3*cos(t)", -4.0]}}
    scene = make_scene(4, "clamped", ()).replace(fall)
    arrows = equilibrium_shape(rodgen.static_equilibrium(scene)).axes[0].texts
    assert arrows
    for arrow in arrows:
        way = np.subtract(arrow.xy, arrow.xyann)
        assert way / np.linalg.norm(way) == pytest.approx([0.6, -0.8])
    solution = rodgen.simulate(scene, span=(0, 0.5), target="numpy")
    due = scene.rod.mass * np.c_[3 * np.cos(solution.t), -4.0 + 0 * solution.t]
    force = sample_motion(solution).loads["gravity"].force
    np.testing.assert_allclose(force, due, rtol=1e-12)


def test_what_holds_a_rod_is_drawn_where_it_moves(make_scene: Callable[..., Scene]) -> None:
    """Marks go and turn as the functions of time of the base say, and the root has a path."""
    base = {"x": "0.3*sin(2*t)", "y": "0.2*cos(3*t)", "angle": "t"}
    scene = make_scene(3, "clamped", ()).replace({"base": base, "rod.clamp_angle": 0.4})
    solution = rodgen.simulate(scene, span=(0.5, 1.6), output_every=0.1, target="numpy")
    due = np.c_[0.3 * np.sin(2 * solution.t), 0.2 * np.cos(3 * solution.t)]
    start = scene_at_start(solution.scene).axes[0]
    for axes, count in ((shapes(solution).axes[0], 12), (start, 1)):
        marks = [line for line in axes.lines if line.get_marker() == "s"]
        places = np.concatenate([mark.get_xydata() for mark in marks])
        np.testing.assert_allclose(places, due[:count], atol=1e-12)  # of metres: rounding
        np.testing.assert_allclose(list(map(turned, marks)), 0.4 + solution.t[:count])
    (path,) = (line for line in trajectories(solution).axes[0].lines if line.get_label() == "root")
    np.testing.assert_allclose(path.get_xydata(), due, atol=1e-12)
    np.testing.assert_allclose(sample_motion(solution).clamp, 0.4 + solution.t)
    assert "base x 0.3*sin(2*t) m, y 0.2*cos(3*t) m, angle t rad" in " ".join(
        str(scene_table(scene)).split()
    )


def test_equilibria_are_measured_from_the_clamp_that_was_moved(
    make_scene: Callable[..., Scene],
) -> None:
    """Across its line at that time, from joint 0 on, as in the equilibrium by itself."""
    base = {"x": "0.2*sin(3*t)", "angle": "t**2"}
    scene = make_scene(2, "cantilever", ("tip_load",)).replace({"base": base})
    scene = scene.replace({"loads.tip": {"y": 1.0}, "rod.clamp_angle": 0.4})
    found = rodgen.continue_equilibria(scene, "loads.tip.y", (1.0, 1.5), t=0.5)
    (curve, *_) = bifurcation_diagram([found], scene).axes[0].lines
    joints = rodgen.static_equilibrium(scene, t=0.5).joints
    across = (joints[-1] - joints[0]) @ [-np.sin(0.65), np.cos(0.65)]
    assert curve.get_ydata()[0] == pytest.approx(across, abs=1e-9)  # of the solver's tolerance


def test_the_error_of_energy_has_numbers_at_powers_of_ten_alone(swinging: Solution) -> None:
    """Even where all of it lies between two of them; those around it are shown."""
    least = swinging.energy_error
    assert least > 0
    end = int(np.argmax(np.abs(swinging.energy_balance))) + 1
    below = energies(swinging.isel(np.array([0, end - 1]))).axes[1]
    low, high = below.get_ylim()
    assert low <= least <= high
    assert (round(np.log10(low), 9) % 1, round(np.log10(high), 9) % 1) == (0, 0)


@pytest.mark.parametrize(("most", "style"), [(1000, "-"), (0, "None")])
def test_phase_plot_follows_the_motion(
    monkeypatch: pytest.MonkeyPatch, most: int, style: str
) -> None:
    """Samples more than a period apart: states between them are computed; without, there are dots,
    as lines would show what never was."""
    monkeypatch.setattr(run_pictures, "MOST", most)
    curve = phase_plot(run(span=[0.0, 40.0], output_every=0.9)).axes[0].lines[0]
    assert curve.get_linestyle() == style


def test_axes_of_keys_have_the_units_of_quantities() -> None:
    for key, unit in (
        ("loads.follower.force", "[N]"),
        ("rod.bending_stiffness", "[N m²]"),
        ("loads.external_damping.fin_factor", ""),
        ("initial.velocity.1", "[m/s]"),
        ("rod.links", ""),
        ("parameters.P0", "P0"),
    ):
        assert axis_label(key).endswith(unit)
        assert ("[" in axis_label(key)) == ("[" in unit)


def test_a_rod_that_flew_far_is_drawn_in_its_size() -> None:
    """Shapes stand side by side: the picture is a few lengths wide, however far the rod went."""
    solution = run(g=9.81, span=[0.0, 8.0], output_every=0.5)
    fallen = np.ptp(solution.joints[..., 1])
    axes = shapes(solution).axes[0]
    assert np.ptp(axes.get_ylim()) < 25 < fallen / 10  # of 2 m, 12 of them beside one another


# The summary -------------------------------------------------------------------------------------


def told(solution: rodgen.Solution) -> tuple[list[float], list[float]]:
    """Numbers of the sentence on energy, and of that on its balance with work: the error [J], and
    its share of the largest energy or exchange."""
    lines = [line for line in summary(solution).splitlines() if line.startswith("Energy")]
    energy, balance = map(numbers, lines)
    return energy, balance


@pytest.mark.parametrize(
    ("terms", "omega", "energy"),
    [((), 3.0, 18.0), ((), 0.0, 0.0), (("gravity",), 0.0, 0.0)],
    ids=["spins", "rests", "falls"],
)
def test_energy_that_stays(
    make_scene: Callable[..., Scene], terms: tuple[str, ...], omega: float, energy: float
) -> None:
    """Of a free rod of 2 m and 3 kg; at 3 rad/s it has 1/2 m (l omega/2)^2 + m l^2 omega^2/24. At
    rest there is nothing of which an error could be a share."""
    scene = make_scene(3, terms=terms, initial={"phi": 0.0, "omega": omega})
    (stays, within), (error, *share) = told(rodgen.simulate(scene, target="numpy"))
    assert stays == energy
    assert within <= 1e-8
    assert error <= 1e-8
    assert len(share) == bool(terms or omega)
    assert all(one < 1e-9 for one in share)
    if omega:  # of the energy that there is, as none is exchanged; of two digits
        assert share[0] * energy == pytest.approx(error, rel=0.06)


def test_energy_that_went_elsewhere_shows_it(make_scene: Callable[..., Scene]) -> None:
    """Kinetic energy grows with the square of the rate; what is less than rounding stayed, and
    what overflows did not."""
    scene = make_scene(3, initial={"phi": 0.0, "omega": 3.0})
    resting = rodgen.simulate(scene, target="numpy").isel(np.array([0, 0]))
    for change, said in ((1.0, 36), (1e-6, 18.000018), (1e-8, 18.0000002), (1e-12, 1.8e-11)):
        solution = resting.isel(np.array([0, 1]))
        solution.y[1, 5:] *= np.sqrt(1 + change)
        assert told(solution)[0] == [18, said]
    solution = resting.isel(np.array([0, 1]))
    solution.y[1, 5] = 1e200  # vx0
    with np.errstate(all="ignore"):
        assert "18 J to inf J" in summary(solution)


def test_a_curve_changes_its_style_with_its_stability() -> None:
    """Each piece begins where the one before ends; a single point has none."""
    axes = Figure().add_subplot()
    x = np.arange(6.0)
    draw_by_stability(axes, x, x**2, np.array([0, 0, 1, -1, -1]))
    assert [line.get_linestyle() for line in axes.lines] == ["-", "--", ":"]
    assert [line.get_xdata().tolist() for line in axes.lines] == [[0, 1, 2], [2, 3], [3, 4, 5]]
    draw_by_stability(axes, x[:1], x[:1], np.array([], dtype=int))
    assert len(axes.lines) == 3
