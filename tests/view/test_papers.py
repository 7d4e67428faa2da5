"""Pictures for papers: their style, formats and widths; axes that say what is so."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import matplotlib
import numpy as np
import pytest
from matplotlib.figure import Figure

import rodgen
from rodgen.analyse.statics import Equilibrium
from rodgen.errors import InputError
from rodgen.integrate import Solution
from rodgen.scene import Scene
from rodgen.show.appearance import pictures_of
from rodgen.show.critical_pictures import connect_curves
from rodgen.show.picture_files import save_figures
from rodgen.show.picture_settings import FORMATS, PictureSettings, parse_width
from rodgen.show.run_pictures import save_pictures

COLUMN = 3.3  # inches: of a paper in two columns
ROUNDING = 0.01  # inches: of letters to whole pixels


@pytest.fixture(scope="module")
def flutters() -> Solution:
    """A column that flutters, for a second."""
    return rodgen.simulate(Scene.example("flutter"), span=[0.0, 1.0], progress=False)


def axes_of(figure: Figure) -> list[str]:
    return [axes.get_xlabel() for axes in figure.axes]


@pytest.mark.parametrize(
    ("text", "inches"),
    [("3.3in", 3.3), ("84mm", 84 / 25.4), ("8.4 cm", 8.4 / 2.54), ("240pt", 240 / 72)],
)
def test_widths_have_units(text: str, inches: float) -> None:
    assert parse_width(text) == pytest.approx(inches, rel=1e-15)


def test_settings_that_are_not_allowed() -> None:
    with pytest.raises(InputError):
        PictureSettings("gif")
    for text in ("3.3", "in", "0.1in", "99in", "1e3in", "-3in"):
        with pytest.raises(InputError) as caught:
            parse_width(text)
        assert caught.value.value == text  # as it was given


@pytest.mark.parametrize("ending", FORMATS)
def test_files_of_a_width_and_a_format(flutters: Solution, tmp_path: Path, ending: str) -> None:
    """Those in vectors have text as text, and no title; sizes are those of the files."""
    draw = pictures_of(Solution)["tail"]
    settings = PictureSettings(ending, COLUMN)
    (made,) = save_figures(((one, draw(flutters)) for one in ["tail"]), tmp_path, settings)
    assert [made] == list(tmp_path.iterdir()) == [tmp_path / f"tail.{ending}"]
    content = made.read_bytes()
    if ending == "png":
        width = int.from_bytes(content[16:20])
        assert width == COLUMN * 250  # dots per inch, of the style
    elif ending == "svg":
        (points,) = re.findall(rb'<svg [^>]*width="([0-9.]+)pt"', content)
        assert float(points) == pytest.approx(72 * COLUMN)
        assert b">frequency [Hz], Hann window</text>" in content
        assert b"flutter" not in content
    else:
        (points,) = re.findall(rb"/MediaBox \[ 0 0 ([0-9.]+) ", content)
        assert float(points) == pytest.approx(72 * COLUMN)


@pytest.mark.slow
def test_the_same_picture_is_the_same_file(flutters: Solution, tmp_path: Path) -> None:
    for name in ("a", "b"):
        (tmp_path / name).mkdir()
        save_pictures(flutters, tmp_path / name, PictureSettings("svg"))
    files = sorted(file.name for file in (tmp_path / "a").iterdir())
    assert "envelope.svg" in files
    for file in files:
        assert (tmp_path / "a" / file).read_bytes() == (tmp_path / "b" / file).read_bytes(), file


def test_the_style_is_one_of_matplotlib() -> None:
    """Every setting is known to it, and the fonts are read in a column."""
    with matplotlib.rc_context(rodgen.style):
        assert matplotlib.rcParams["font.size"] == 8.0
    assert matplotlib.rcParams["font.size"] != 8.0


@pytest.mark.slow
@pytest.mark.parametrize("width", [COLUMN, None])
def test_nothing_is_written_beyond_a_picture(
    flutters: Solution, tmp_path: Path, width: float | None
) -> None:
    """In a column, and as wide as pictures are."""
    beck = Scene.example("becks_column")
    shown = [flutters, rodgen.natural_modes(beck), rodgen.critical_load(beck)]
    shown += [rodgen.static_equilibrium(Scene.example("cantilever_self_weight"))]
    beyond = []

    def drawn() -> Iterator[tuple[str, Figure]]:
        for at, one in enumerate(shown):
            for name, draw in pictures_of(type(one)).items():
                figure = draw(one)
                yield f"{name} {at}", figure
                figure.draw_without_rendering()
                taken, (wide, high) = figure.get_tightbbox(), figure.get_size_inches()
                if taken.xmin < -ROUNDING or taken.xmax > wide + ROUNDING:
                    beyond.append((name, taken.xmin, taken.xmax - wide))
                if taken.ymin < -ROUNDING or taken.ymax > high + ROUNDING:
                    beyond.append((name, taken.ymin, taken.ymax - high))

    save_figures(drawn(), tmp_path, PictureSettings("png", width))
    assert not beyond


def test_an_envelope_holds_every_moment_and_force(flutters: Solution) -> None:
    """Its limits are those of the moments at the joints; its marks are the largest of all."""
    axes = pictures_of(Solution)["envelope"](flutters).axes
    assert len(axes) == 3
    moments = flutters.bending_moments
    low, high = (line.get_ydata() for line in axes[0].lines[1:3])
    np.testing.assert_array_equal(low, moments.min(axis=0)[: len(low)])
    np.testing.assert_array_equal(high, moments.max(axis=0)[: len(high)])
    for panel, name in zip(axes, ("bending_moments", "axial_force", "shear_force"), strict=True):
        (mark,) = (line for line in panel.lines if line.get_marker() == "o")
        (place,), (value,) = mark.get_data()
        assert abs(value) == np.nanmax(np.abs(flutters.values(name)))
        assert 0.0 <= place <= 1.0


def test_a_chain_has_no_bending_moment_in_its_envelope() -> None:
    chain = Scene.example("hanging_chain").replace({"integrate.span": [0.0, 0.1]})
    figure = pictures_of(Solution)["envelope"](rodgen.simulate(chain, progress=False))
    assert len(figure.axes) == 2


@pytest.mark.parametrize(("angle", "across"), [(0.0, 1), (-np.pi / 2, 0), (0.6, None)])
def test_an_equilibrium_is_drawn_where_it_is(angle: float, across: int | None) -> None:
    """Its coordinates are its own, however little it bends; then the scale across is another."""
    table = Scene.example("cantilever_self_weight").model_dump(exclude_none=True, by_alias=True)
    table["rod"]["clamp_angle"], table["loads"] = angle, {"tip": {"x": 0.01, "y": 0.01}}
    rest = rodgen.static_equilibrium(Scene.from_dict(table))
    (axes,) = pictures_of(Equilibrium)["shape"](rest).axes
    (line,) = (line for line in axes.lines if line.get_label() == "equilibrium")
    np.testing.assert_array_equal(np.column_stack(line.get_data()), rest.joints)
    scales = axes.get_aspect()
    assert scales == 1 if across is None else (scales > 1) == (across == 1)


def test_curves_of_eigenvalues_go_on_where_they_cross() -> None:
    """Two straight lines that cross, given in rising order at each force."""
    forces = np.linspace(0.0, 1.0, 21)
    lines = np.column_stack([forces, 0.9 - forces]).astype(complex)
    np.testing.assert_array_equal(connect_curves(np.sort(lines, axis=1)), lines)


def test_the_upper_axis_of_a_critical_load_is_its_parameter() -> None:
    """P L^2/EI of Beck's column, of which the exact onset is 20.05, within a thousandth for a mesh
    of 100 links and more; its modes have their numbers."""
    found = rodgen.critical_load(Scene.example("becks_column"))
    upper = pictures_of(type(found))["curves"](found).axes[0]
    (beside,) = upper.child_axes
    rod = found.scene.rod
    low, high = np.array(upper.get_xlim()) * rod.length**2 / rod.bending_stiffness
    upper.figure.draw_without_rendering()
    assert beside.get_xlim() == pytest.approx((low, high), rel=1e-12)
    assert {text.get_text() for text in upper.texts} >= {"1", "2"}


def test_peaks_of_a_spectrum_have_numbers(flutters: Solution) -> None:
    found = rodgen.spectrum(flutters)
    (axes,) = pictures_of(type(found))["density"](found).axes
    named = {text.get_text(): text.xy[0] for text in axes.texts}
    assert named == {f"{at}": one for at, one in enumerate(found.frequencies, 1)}
