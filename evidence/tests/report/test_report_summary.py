"""What the report concludes from its rows: the fastest, growth, savings, digits, failures."""

from __future__ import annotations

import math

import pytest

from evidence.tests.report.report_rows import NASTY, SCENES, made_up, others, precision
from rodgen.analyse.precision.contestant import Measurement
from rodgen.analyse.precision.rows import format_label, format_short
from rodgen_evidence.pages import report_curves
from rodgen_evidence.report.contents import failed_of, frame, kind_of, reference_error
from rodgen_evidence.report.costs.leaving_out import savings
from rodgen_evidence.report.precision.growth import growth_line
from rodgen_evidence.report.report_summary import best_row, growth, sentences
from rodgen_evidence.report.stability.rounding import losing
from rodgen_evidence.report.unit import Measured
from tests.told import numbers


def test_summary_follows_the_numbers():
    contents = made_up()
    best = best_row(contents, "missile")
    assert best["1e-3"].startswith("dop853 in C, rtol 1e-5")
    assert numbers(best["1e-9"]) == [1.2e-8]  # no one has less
    contents["references"][1].rows[0]["estimate_phi"] = 1e-5
    assert reference_error(contents, "missile") == 1e-5
    assert "rtol" not in best_row(contents, "missile")["1e-6"]  # which cannot be told
    rows, extremes, steps, _, duels, _ = sentences(contents)
    assert numbers(rows) == [409, 13, 3, 3]
    assert numbers(extremes) == [1, 91, 45, 15, 12, 15, 3]
    assert numbers(steps) == [28, 30, 5, 50, 30]  # within 5 %; with 50 links off by 30 %
    assert numbers(duels) == [2, 0.8, 12.5, 6.65]
    assert "SciPy LSODA" in duels
    contents["extremes"][0].rows.pop()
    assert numbers(sentences(contents)[1])[:2] == [0, 90]


def test_units_that_failed_are_those_of_their_scene_alone():
    crashed = [Measured("precision", f"precision-{s}-c", "f", 0.0, [], s) for s in SCENES]
    assert list(failed_of({"precision": crashed}, "free_n20")["failed"]) == ["free_n20"]
    longer = [Measured("precision", "precision-free_n200-c", "f", 0.0, [], "crashed")]
    assert failed_of({"precision": longer}, "free_n20").empty


def test_short_numbers():
    numbers = {1e-5: "1e-5", 2.5e-12: "2.5e-12", 1e10: "1e10", 0.01: "0.01", math.inf: "inf"}
    assert {value: format_short(value) for value in numbers} == numbers


def test_what_the_report_cut_short_is_no_failure():
    reasons = {
        "not tried: would take more than 0.6 s, from rtol 1e-12 on": "not tried, as time was up",
        "stopped after 0.6 s": "stopped, as they took too long",
        "stopped after 3 s, as its step became too small": "failed",
        "not installed: make report installs it": "not installed",
        "every peer missed this error in the time of a run": "without an opponent within the error",
        NASTY: "failed",
    }
    for reason, kind in reasons.items():
        assert kind_of(reason) == kind
    rows: list[Measurement] = [{"failed": reason} for reason in reasons]
    said = sentences({"precision": [Measured("precision", "p", "f", 0.0, rows)]})[0]
    assert numbers(said)[:6] == [6, 1, 2, 2, 1, 1]


def test_growth_of_a_known_exponential():
    row = others()["growth"][0]
    line = growth_line(row)
    assert line is not None
    (first, last), (low, high) = line
    assert low == pytest.approx(1e-14 * math.exp(8 * first), rel=1e-9)
    assert high == pytest.approx(1e-14 * math.exp(8 * last), rel=1e-9)
    # ln(10)/8 = 0.288 s a digit, sixteen of them 4.6 s.
    assert numbers(growth("chain", [row])) == [8, 0.29, 1e-16, 1, 4.6]
    slow = {**row, "rate": 1.0}  # 150-fold in 5 s, which says nothing of a digit in 2.3 s
    assert growth_line(slow) is None
    for rate, told in ((1.0, [1, 1, 1]), (-0.1, [-0.1, -0.1, 1]), (None, [])):
        assert numbers(growth("chain", [{**row, "rate": rate}])) == told


def test_digits_lost_against_another_form():
    start: Measurement = {"group": "g", "case": "c", "n": 5, "kind": "free", "ulps_input": 2.0}
    made: list[Measurement] = [
        {**start, "form": f, "ulps": u} for f, u in (("c", 100.0), ("dense", 3.0))
    ]
    assert list(losing(frame(made))["form"]) == ["c"]
    assert losing(frame({**row, "ulps_input": 11.0} for row in made)).empty  # unavoidable
    assert losing(frame({**row, "ulps": 100.0} for row in made)).empty  # none keeps them


def test_savings_are_ratios():
    ratios = savings(frame(others()["leaving_out"]))
    assert list(ratios.index) == list(SCENES)
    assert ratios.loc["missile", "operations"] == pytest.approx(2.5)
    assert savings(frame(others()["leaving_out"][:1])).empty


def test_lines_of_a_picture_can_be_told_apart():
    """By colour, dashes or mark, each alone in what it is drawn with."""
    who = ("rodgen C", "rodgen C, from C", "rodgen C, of a batch", "rodgen NumPy")
    who += ("rodgen NumPy, dense", "CasADi, generated C", "MuJoCo, mj_forward", "Numba, by hand")
    who += ("PyDy, Kane to Cython", "Pinocchio, aba")
    rows = [{"who": name, "n": n, "seconds": 1e-6 * n} for name in who for n in (10, 20)]
    (drawn,) = report_curves.against_n(frame(rows)).axes
    looks = {(line.get_color(), line.get_marker()) for line in drawn.lines}
    assert len(looks) == len(who)
    assert len({line.get_marker() for line in drawn.lines}) >= len(who) - 1


@pytest.mark.parametrize("seconds", [(0.0189, 0.0209), (0.031, 0.044), (0.003, 0.02)])
def test_numbers_beside_an_axis_differ(seconds):
    rows = [{"who": "rodgen", "n": n, "seconds": t} for n, t in zip((10, 50), seconds, strict=True)]
    figure = report_curves.against_n(frame(rows))
    figure.draw_without_rendering()
    ticks = figure.axes[0].yaxis.get_ticklabels(which="both")
    low, high = figure.axes[0].get_ylim()
    shown = [tick.get_text() for tick in ticks if low <= tick.get_position()[1] <= high]
    shown = [words for words in shown if words]
    assert len(shown) == len(set(shown)) >= 2


def test_scene_without_a_reference_is_not_judged():
    contents = made_up(("missile",))
    contents["references"][0].rows[0]["failed"] = "the rates are not finite"
    for one in contents["precision"]:
        one.rows[:] = [{"scene": "missile", "n": 20, "failed": "no reference: not finite"}]
    row = best_row(contents, "missile")
    assert {value for key, value in row.items() if key != "scene"} == {"no reference"}


def test_labels():
    names = [format_label(row) for row in precision("missile")[::7]]
    ours, theirs = {"gauss in C", "gauss in NumPy"}, {"SciPy DOP853 on rodgen's C", "heyoka Taylor"}
    assert ours | theirs < {*names}
