"""The printed tables, and the tables rebuilt."""

from __future__ import annotations

import csv
import math
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest
from pandas import DataFrame

from rodgen.analyse.critical import critical_load
from rodgen.analyse.references.follower_columns import thrust
from rodgen.integrate import simulate
from rodgen_evidence.pages.thesis_page import summary, write_thesis
from rodgen_evidence.thesis import (
    clamp,
    critical_forces,
    data,
    frequencies,
    largest_steps,
    mass_spring_table,
    outlook,
    rebuild,
    run_times,
    scenes,
    static_deflection,
)
from rodgen_evidence.thesis.hypotheses import numerical_frequency
from rodgen_evidence.thesis.largest_steps import rounded_down
from rodgen_evidence.thesis.percentages import ANALYTICAL, NEITHER, SIMULATED, base_of, percentages
from rodgen_evidence.thesis.special_times import times
from rodgen_evidence.thesis.table import (
    INCOMPARABLE,
    Remark,
    ThesisTable,
    by_size,
    matching_digits,
    verdict,
)


def bases(table: str) -> list[str]:
    return [row.base for row in percentages() if row.table == table]


def test_printed_deviations_against_printed_values():
    # Worked out by hand: 326.12 / 438.16 - 1 = -25.571 %, but (93.95 - 125.31) / 93.95 = -33.38 %.
    assert set(bases("3.4")) == set(bases("3.5")) == {ANALYTICAL}
    assert bases("3.3") == [SIMULATED, ANALYTICAL]
    assert bases("3.6").count(SIMULATED) == 9
    assert bases("3.1").count(NEITHER) == 5
    assert "two digits exchanged" in base_of("3.6")


def test_analytical_values_follow_from_their_formulas():
    assert float(data.THRUST_COEFFICIENT) * 100 / 25 == pytest.approx(float(data.THRUST))
    for row in data.TABLE_3_6.itertuples():
        exact = float(data.BECK_COEFFICIENT) * 100 / (5 - 5 / row.links) ** 2
        # 92.0663 N and 88.8643 N are printed as 92.06 N and 88.87 N.
        unit = data.unit(row.analytical) / (1 if row.links in (15, 20) else 2)
        assert float(row.analytical) == pytest.approx(exact, abs=unit)
    # (3.1): q l^4 / (8 EI), its whole mass on 4.9 m.
    assert pytest.approx(0.0721, abs=5e-5) == 0.05 * 9.81 / 4.9 * 4.9**4 / 800


@pytest.mark.parametrize(
    ("printed", "value", "count"),
    [
        ("411.83", 411.776430, 4),
        ("0.0198", 0.01982580, 3),
        ("0.0735", 0.07359263, 2),
        ("93.95", 81.0, 0),
        ("-1.2", 1.2, 0),
    ],
)
def test_digits_that_agree(printed: str, value: float, count: int):
    assert matching_digits(printed, value) == count


def test_verdicts_follow_from_the_numbers():
    assert verdict("0.0198", 0.0198258) == "reproduced to all 3 digits"
    assert verdict("13.3896", 13.2888, "why") == "off by +0.76 %: 2 of 6 digits, why"
    assert verdict("0.0735", 0.07359263) == "off by -0.13 %: 2 of 3 digits"
    assert verdict("93.95", 81.0) == "off by +16 %: none of 4 digits"
    assert not verdict("411.83", 411.776430).startswith("reproduced")
    assert rounded_down("0.02", 0.0233).startswith("reproduced")
    assert rounded_down("0.0006", 0.000905).startswith("not reproduced")


def test_deviations_are_counted_by_decades():
    assert by_size([0.0, 0.003, -0.01, 0.0101, -0.5, 1.0, -25.0]) == (
        "3 up to 0.01 %, 1 up to 0.1 %, 2 up to 1 %, 1 above 1 %"
    )
    assert by_size([]) == ""


@pytest.mark.parametrize(
    ("verdicts", "words"),
    [
        ([verdict("13.39", 13.29), verdict("0.0198", 0.0198258)], "1 of 2"),
        ([verdict("13.39", 13.29)], "0 of 1"),
        ([f"{INCOMPARABLE}: span not given"], "no values to reproduce"),
        ([None], "no values to reproduce"),
    ],
)
def test_rows_to_all_digits_are_counted(verdicts: list[str | None], words: str):
    assert (
        summary(ThesisTable("3.1", "", (), DataFrame({"verdict": verdicts}, dtype=object))) == words
    )


def test_steps_shift_frequencies_as_known():
    # Semi-implicit Euler: sin(pi f' h) = pi f h, to second order f' = f (1 + (2 pi f h)^2 / 24).
    assert numerical_frequency(1.0, 1e-2, "semi_implicit_euler") == pytest.approx(
        1.000164535, abs=1e-7
    )


def test_printed_steps_ask_for_one_damping():
    product, links = largest_steps.common(largest_steps.dampings())
    assert product.low <= largest_steps.DAMPING * scenes.MASS < product.high
    assert links == (10, 20, 30, 40)


def test_printed_steps_ask_for_one_mass(monkeypatch: pytest.MonkeyPatch):
    # omega = 4 sqrt(3) n^2 sqrt(EI / (M L^3)), which the fastest mode has for many links.
    monkeypatch.setattr(
        largest_steps, "fastest", lambda n: 48**0.5 * n**2 * (100 / (50 * 125)) ** 0.5
    )
    mass, links = largest_steps.common(largest_steps.masses("semi_implicit_euler"))
    assert mass.low < scenes.MASS < mass.high
    assert links == (10, 20, 30, 40)


@pytest.mark.nightly
def test_two_columns_ask_for_masses_that_overlap():
    """And the damping kept, 55 kg gives one more of the 15 printed steps than 50 kg."""
    semi, kutta = (
        largest_steps.common(largest_steps.masses(method))[0]
        for method in ("semi_implicit_euler", "thesis_runge_kutta")
    )
    assert semi.low < kutta.low < semi.high < kutta.high
    assert (largest_steps.count_matches(50.0), largest_steps.count_matches(55.0)) == (11, 12)


def _costs(euler: tuple[float, float], semi: tuple[float, float]) -> DataFrame:
    """Rows of table 4.2 in which Runge-Kutta's method costs as much as Euler's."""
    times = {"euler": euler, "semi_implicit_euler": semi, "thesis_runge_kutta": euler}
    return DataFrame(
        {"links": n, "method": method, "step": 1e-3, "thesis": c, "c": c, "cost": c}
        for method, costs in times.items()
        for n, c in zip((10, 20), costs, strict=True)
    )


def test_the_note_on_costs_says_what_the_table_says():
    (*_, note) = run_times.notes(_costs((90.0, 660.0), (1.0, 2.0)))
    assert "90, 330 times as much" in note.text
    assert "at every n in ours" in note.text
    (*_, note) = run_times.notes(_costs((90.0, 1.0), (1.0, 2.0)))
    assert "90, 0.5 times as much" in note.text
    assert "at n = 10 in ours" in note.text


def test_run_times_say_how_often_they_were_multiplied():
    assert times([4000.0]) == "4000 times"
    assert times([0.4718, 5000.0, 31.2]) == "0.47 to 5000 times"


def test_two_frequencies_that_have_not_met_beat():
    """A bend becomes a hundredfold below the critical force, and goes back: it does not grow."""
    force = 411.776430 * (1 - 9.5e-5)
    period = critical_forces.beat(10, "free", force)
    scene = scenes.thrust(
        10,
        force=force,
        initial={"phi": critical_forces.BENT["free"]},
        method="dop853",
        rtol=1e-8,
        span=[0.0, 1.2 * period],
        output_every=0.1,
    )
    run = simulate(scene)
    bend = np.abs(np.diff(run.phi, axis=1)).max(axis=1) / np.abs(np.diff(run.phi[0])).max()
    assert bend.max() > 100
    # Seen over one swing of the rod, 2.2 s, the bend is small again after a whole beat.
    assert bend[np.abs(run.t - period) < 1.1].max() < bend.max() / 4
    assert math.isnan(critical_forces.beat(10, "free", 412.0))  # beyond the onset it grows


COLUMNS = {
    "3.1": frequencies.COLUMNS_3_1,
    "3.2": frequencies.COLUMNS_3_2,
    "3.3": static_deflection.COLUMNS,
    "3.4": critical_forces.COLUMNS_3_4,
    "3.5": mass_spring_table.COLUMNS,
    "3.6": critical_forces.COLUMNS_3_6,
    "4.1": largest_steps.COLUMNS_4_1,
    "4.2": run_times.COLUMNS,
    "clamp": clamp.columns_of(clamp.LINKS),
    "outlook": outlook.COLUMNS,
}
TEXTS = {
    "name": "f1 < f2",
    "unit": "m",
    "method": "Euler",
    "verdict": "reproduced to all 2 digits",
}


def made_up(number: str) -> ThesisTable:
    """A table with all its columns and numbers of no meaning: the page is tested, not they."""
    rows = DataFrame(
        {
            c.key: TEXTS.get(c.key, 10 * k if c.key == "links" else k + 326.12)
            for c in COLUMNS[number]
        }
        for k in (1, 2, 3)
    )
    if "thesis" in rows:
        rows.loc[1, "thesis"] = math.nan
    table = ThesisTable(number, f"of {number}", COLUMNS[number], rows, ["L = 5 m"], ["m < 1 kg"])
    table.notes, table.curve = [Remark("shown", "a < b")], [(0.0, 0.0), (5.0, -0.1)]
    return table


@pytest.mark.nightly
def test_free_rod_end_to_end():
    # 109.68919 EI/L^2: the root of the characteristic equation, which the discrete model tends to.
    (row,) = critical_forces.table_3_4([10], span=100.0).rows.to_dict("records")
    assert row["discrete"] == pytest.approx(411.776, abs=1e-3)
    assert row["simulated"] == pytest.approx(row["discrete"], rel=5e-4)
    assert row["continuum"] == pytest.approx(4 * float(thrust().load))
    assert str(row["verdict"]).startswith("off by +0.013 %: 4 of 5 digits")


@pytest.mark.nightly
def test_clamps_converge_with_their_orders():
    for row in clamp.table_clamp((10, 20, 40)).rows.to_dict("records"):
        expected = 1 if row["boundary"] == "cantilever" else 2
        # The next term of the clamp's error is a quarter of the first for f3 at these n.
        assert row["order"] == pytest.approx(expected, abs=0.25)
        # Ten times the estimate, which is one.
        assert row["limit"] == pytest.approx(row["continuum"], abs=10 * row["limit_error"])


@pytest.mark.nightly
def test_the_outlook_is_answered():
    """With figures of other routes: critical_load has the Hopf point, a run the amplitude; small
    modes have the shapes of the continuum but for 1/n^2, 6e-4 times some ten for the third."""
    rows = outlook.table_outlook().rows
    value = dict(zip(rows["quantity"], rows["value"], strict=True))
    force = critical_load(outlook.cantilever(outlook.FORCE)).value
    assert value[outlook.BEGIN] == pytest.approx(force, rel=1e-9)
    assert value["first Lyapunov coefficient (below 0: supercritical)"] < 0
    assert (rows[rows["question"] == outlook.SHAPES]["value"] < 0.01).all()
    assert (rows[rows["question"] == outlook.FREQUENCIES]["value"].abs() < 1).all()
    medium = rows[rows["question"] == outlook.MEDIUM]
    swings = medium["value"][medium["quantity"].str.startswith(outlook.SWING)].to_numpy()
    assert (np.diff(swings) < 0).all()
    late = simulate(outlook.cantilever(outlook.FORCE, outlook.EXTERNAL[-1]))
    tail = np.abs(late.phi[late.t > 0.8 * outlook.SPAN]).max()
    assert tail == pytest.approx(swings[-1], rel=0.01)  # samples miss the crest by a little
    assert value["first exponent at 200 N [1/s]"] > 2 * value["its error at 200 N [1/s]"]
    regular = value["first exponent at 140 N [1/s]"]
    assert abs(regular) < 2 * value["its error at 140 N [1/s]"]


class _Page(HTMLParser):
    """Headings and the files that a page asks for."""

    def __init__(self) -> None:
        super().__init__()
        self.asked: list[str] = []
        self.anchors: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        given = dict(attrs)
        self.asked += [str(given[k]) for k in ("src", "href") if given.get(k)]
        if given.get("id"):
            self.anchors.append(str(given["id"]))


def test_page_names_every_table_and_needs_no_network(tmp_path: Path):
    assert sorted(rebuild.TABLES) == [
        "3.1",
        "3.2",
        "3.3",
        "3.4",
        "3.5",
        "3.6",
        "4.1",
        "4.2",
        "clamp",
        "outlook",
    ]
    tables = [made_up(number) for number in sorted(rebuild.TABLES)]
    page = write_thesis(tmp_path, tables, 1.0)
    text = page.read_text(encoding="utf-8")
    assert text.count("rounded to the printed digits") == 6  # 3.1 to 3.6
    parsed = _Page()
    parsed.feed(text)
    assert parsed.anchors == [f"table-{name.replace('.', '-')}" for name in sorted(rebuild.TABLES)]
    for name in parsed.asked:
        assert name.removeprefix("#") in parsed.anchors or (tmp_path / name).is_file(), name
    pictures = {path.name for path in tmp_path.glob("*.png")}
    assert pictures == {
        f"figure_{name}.png" for name in ("3_1", "3_2", "3_3", "3_4", "3_5", "3_6", "4_1", "4_2")
    }
    assert not list(tmp_path.glob(".*"))
    with (tmp_path / "table_3_4.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert float(rows[0]["thesis: simulated [N]"]) == 327.12
    assert rows[1]["thesis: simulated [N]"] == ""
