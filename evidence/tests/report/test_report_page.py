"""The page of the report, made from rows that are made up."""

from __future__ import annotations

import csv
import json
import math
import re
from html.parser import HTMLParser
from pathlib import Path

import pytest

from rodgen.analyse.precision.contestant import Row
from rodgen.analyse.precision.rows import label, short
from rodgen_evidence.pages import report_curves
from rodgen_evidence.pages.report_guide import save_guide_figures
from rodgen_evidence.pages.report_page import made_lines, read_report, write_report
from rodgen_evidence.report.contents import failed_of, failures, frame, kind_of, trusted
from rodgen_evidence.report.costs.leaving_out import savings
from rodgen_evidence.report.precision.growth import growth_line
from rodgen_evidence.report.stability.rounding import losing
from rodgen_evidence.report.summary import best_row, growth, sentences
from rodgen_evidence.report.unit import Measured

NASTY = "it said <script>alert('1 & 2')</script>"
MADE = {
    "quick": True,
    "seconds": 171.4,
    "machine": {"processor": "Some <Processor> at 3 GHz", "C flags": "-O3 -march=native"},
    "versions": {"rodgen": "0.1.0", "numpy": "2.1.0", "heyoka": "not installed"},
    "threads": 1,
    "scenes": {"missile": "the damped <missile>"},
}
OURS = {"gauss": 6, "radau": 5, "dop853": 8, "rk4": 4, "semi_implicit_euler": 1, "euler": 1}
THEIRS = {"SciPy": "DOP853", "heyoka": "Taylor", "MuJoCo": "RK4", "CasADi": "cvodes"}
FIXED = ("rk4", "semi_implicit_euler", "euler")
SCENES = {"free_n20": 20, "below_flutter": 50, "damped_n200": 200, "missile": 20}


def setting(scene: str, who: str, method: str, target: str, order: int, at: int) -> Row:
    """A point on a straight line: halving the step divides the error by 2^order."""
    fixed = method in FIXED
    value = 0.01 / 2**at if fixed else 10.0 ** -(at + 2)
    steps = 1000 * 2**at if fixed else int(300 * 10 ** (at / max(order, 2)))
    slow = {"c": 1.0, "numpy": 60.0}.get(
        target, 2.0 + 3.0 * list(THEIRS).index(who) if who in THEIRS else 1.0
    )
    error = max(3e-13, 0.2 * (2.0 ** -(order * at) if fixed else 10.0 ** -(1.1 * at)))
    return {
        "scene": scene,
        "n": SCENES[scene],
        "who": who,
        "method": method,
        "target": target,
        "kind": "step" if fixed else "rtol",
        "setting": value,
        "order": order,
        "seconds": steps * 1e-6 * slow * (1 + order / 8) * SCENES[scene] / 20,
        "rounds": 5,
        "inside": None,
        "error_phi": error,
        "error_tail": 1.3 * error,
        "error_modes": 0.4 * error,
        "error_energy": 0.1 * error**1.1,
        "balance": 0.1 * error if who == "rodgen" else None,
        "steps": steps,
        "rejected": None if fixed else steps // 20,
        "rhs": steps * max(order, 1),
        "jacobian": steps if method in ("gauss", "radau") else None,
        "factorisations": None,
        "setup_generate": 1.5 if who == "rodgen" else None,
        "setup_compile": 80.0 / 3 if who == "heyoka" else 0.7,
        "agreed": None if who == "rodgen" else 3.1e-15,
        "failed": "",
    }


def precision(scene: str) -> list[Row]:
    ours = [("rodgen", m, t, o) for m, o in OURS.items() for t in ("c", "numpy")]
    theirs = [(who, m, "rodgen's c" if who == "SciPy" else who, 6) for who, m in THEIRS.items()]
    rows = [setting(scene, *who, at) for who in (*ours, *theirs) for at in range(7)]
    broken = {key: None for key in rows[0] if key.startswith("error_")}
    return [*rows, {**rows[-1], **broken, "seconds": None, "setting": 1e-15, "failed": NASTY}]


def reference(scene: str) -> Row:
    estimates = {f"estimate_{name}": 2e-12 for name in ("phi", "tail", "modes", "energy")}
    checked = {"checked_by": "Taylor series", "check_phi": 1.5e-12}
    made = {"method": "extrapolation", "order": 16, "tolerance": 1e-18, "rhs": 10**6}
    start: Row = {"scene": scene, "n": SCENES[scene], "seconds": 3.2, "failed": ""}
    return {**start, **made, **estimates, **checked}


def others() -> dict[str, list[Row]]:
    t = [0.05 * k for k in range(101)]
    chaos = [min(1e-14 * math.exp(8 * x), 2.0) for x in t]
    chaos[0] = 0.0
    grow: Row = {"scene": "falling_chain", "n": 10, "method": "dop853", "setting": 1e-12}
    sizes = (10, 20, 50, 200, 1000)
    costs: list[Row] = [
        {"what": what, "who": who, "n": n, "seconds": a * n**b, "rounds": 5, "failed": ""}
        for what in ("rhs", "implicit step")
        for who, a, b in (("rodgen, C", 1e-8, 1), ("rodgen, NumPy", 1e-6, 0.6), ("CasADi", 1e-7, 2))
        for n in sizes
    ]
    left: list[Row] = [
        {"scene": s, "n": n, "variant": v, "operations": 900 * n * f, "source_bytes": 40000 * f}
        | {"object_bytes": 9000 * f, "generate": 1.2 * f, "compile": 0.8 * f, "failed": ""}
        | {"rhs": 2e-8 * n * f, "run": 0.01 * n * f}
        for s, n in SCENES.items()
        for v, f in (("as the scene", 1.0), ("every term, at zero", 2.5))
    ]
    steps: list[Row] = [
        {"method": m, "n": n, "damping": d, "damping_ratio": r, "rate": 40.0 * n**2}
        | {"found": c / (40.0 * n**2) * (1.3 if (m, n) == ("rk4", 50) else 1.0005)}
        | {"theory": c / (40.0 * n**2), "how": "bisection", "failed": ""}
        | {"off": 0.3 if (m, n) == ("rk4", 50) else 0.0005}
        for d, r in (("none", 0.0), ("strong", 3.0))
        for m, c in (("rk4", 2.83), ("semi_implicit_euler", 2.0), ("dop853", 5.96))
        for n in sizes
    ]
    outcomes = ("right", "right", "stopped", "refused", "warned", "lost")
    methods = ("gauss", "radau", "dop853", "rk4", "euler", "auto")
    extremes: list[Row] = [
        {"group": g, "case": f"{g} {10.0**e:g}", "n": 20, "target": "c", "method": m}
        | {"outcome": o, "digits": 9.3 if o == "right" else None, "condition": 1e3}
        | {"seconds": 0.1, "said": "" if o == "right" else f"{o}: the step became too small"}
        for g in ("bending stiffness", "mass", "follower force")
        for k, e in enumerate((-12, -6, 0, 6, 12))
        for i, m in enumerate(methods)
        for o in (outcomes[(i * k) % len(outcomes)],)
    ]
    extremes.append({**extremes[0], "case": "folded back", "outcome": "wrong", "said": NASTY})
    rounding: list[Row] = [
        {
            "group": "length",
            "case": f"L = {10.0**e:g} m",
            "n": n,
            "form": f,
            "ulps": 2.0 * 4 ** (e % 7),
        }
        | {"ulps_input": 1.5 if f != "numpy dense" else 0.7, "condition": 10.0 ** (e % 9)}
        | {"failed": ""}
        for e in (-6, 0, 6)
        for n in (3, 1000)
        for f in ("c", "numpy chain", "numpy dense")
    ]
    duel: Row = {"scene": "free_n20", "n": 20, "asked": 1e-6, "ours": "dop853 in C"}
    duel |= {"ours_error": 8e-7, "ours_seconds": 0.02, "theirs": "heyoka Taylor"}
    duel |= {"theirs_error": 5e-7, "theirs_seconds": 0.25, "ratio": 12.5, "rounds": 9, "failed": ""}
    lost = {**duel, "scene": "missile", "theirs": "SciPy LSODA", "ratio": 0.8}
    return {
        "growth": [{**grow, "t": t, "error": chaos, "rate": 8.0, "failed": ""}],
        "equal_error": [duel, lost],
        "costs": costs,
        "leaving_out": left,
        "install": [{"what": "plain", "seconds": 0.1, "bytes": 3 * 10**6, "failed": ""}],
        "steps": steps,
        "extremes": extremes,
        "rounding": rounding,
    }


def made_up(scenes: tuple[str, ...] = ("free_n20", "missile")) -> dict[str, list[Measured]]:
    def unit(section: str, name: str, rows: list[Row], failed: str = "") -> Measured:
        return Measured(section, f"{section}-{name}", "f", 1.25, rows, failed)

    contents = {
        "references": [unit("references", s, [reference(s)]) for s in scenes],
        "precision": [unit("precision", s, precision(s)) for s in scenes],
    }
    contents["precision"].append(unit("precision", "missile-exudyn", [], "crashed <b>SIGSEGV</b>"))
    for section, rows in others().items():
        contents[section] = [unit(section, "all", rows)]
    return contents


class _Page(HTMLParser):
    """What a page asks for, its text, anchors, tables and scripts."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.asked: list[str] = []
        self.anchors: list[str] = []
        self.alts: list[str] = []
        self.tags: set[str] = set()
        self.words = ""
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        of_tag = dict(attrs)
        self.tags.add(tag)
        self.asked += [of_tag[name] for name in ("src", "href", "srcset", "data") if name in of_tag]
        self.anchors += [of_tag["id"]] if "id" in of_tag else []
        self.alts += [of_tag.get("alt", "")] if tag == "img" else []
        self.words += " "

    def handle_data(self, data):
        self.words += data


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    folder = tmp_path_factory.mktemp("report")
    contents = made_up()
    page = write_report(folder, contents, MADE)
    text = page.read_text(encoding="utf-8")
    return folder, contents, text, _Page(text)


def test_page_has_all_parts_and_needs_no_network(written):
    folder, _, text, page = written
    assert [name for name in page.anchors if name.startswith("scene-")] == [
        "scene-free-n20",
        "scene-missile",
    ]
    parts = ("equal-error", "how-errors-grow-in-time", "costs-against-n", "what-leaving-out-saves")
    more = ("import-time-and-sizes", "largest-stable-steps", "extreme-cases", "rounding-of-rhs")
    assert {*parts, *more, "summary", "failures", "made"} <= set(page.anchors)
    assert len(set(page.anchors)) == len(page.anchors)
    for name in page.asked:
        assert name.removeprefix("#") in page.anchors or (folder / name).is_file(), name
    assert page.tags & {"script", "link", "iframe", "object", "embed"} == set()
    assert "@import" not in text
    assert "url(" not in text
    # Five pictures of a scene; growth, savings; two costs; two dampings.
    assert len(page.alts) == 2 * 5 + 2 + 2 + 2
    assert all(page.alts)
    assert {path.name for path in folder.glob("*.svg")} <= set(page.asked)
    for svg in folder.glob("*.svg"):
        drawn = svg.read_text(encoding="utf-8")
        assert "prefers-color-scheme: dark" in drawn
        assert not re.search(r'(href|src)="(?!#)', drawn)
    assert not list(folder.glob(".*"))


def test_failures_are_shown_and_escaped(written):
    _, contents, text, page = written
    assert "<script>" not in text
    assert "<b>SIGSEGV" not in text
    assert page.words.count(NASTY) >= 2 * 2 + 2  # twice a scene; the wrong one, on top and below
    assert "crashed <b>SIGSEGV</b>" in page.words
    assert "Some <Processor> at 3 GHz" in page.words
    assert "heyoka not installed" in page.words
    assert "20 links: the damped <missile>." in page.words
    assert made_lines(MADE)[0] == ("quick", "yes")
    assert made_lines(MADE)[2:4] == [*MADE["machine"].items()]
    assert len(failures(contents)) == 3
    assert page.words.index("Wrong without warning") < page.words.index("Contents")
    assert "WRONG" in page.words


def test_json_has_everything(written):
    folder, contents, _, _ = written
    assert read_report(folder / "report.json") == (contents, MADE)


def test_csv_keeps_all_digits(written):
    folder, contents, _, _ = written
    for section, several in contents.items():
        expected = [(one.name, row) for one in several for row in one.rows]
        with (folder / f"{section}.csv").open(encoding="utf-8", newline="") as file:
            lines = list(csv.DictReader(file))
        units = [one for one in several if one.failed]
        assert len(lines) == len(expected) + len(units)
        for line, (unit, row) in zip(lines, expected, strict=False):
            assert line["unit"] == unit
            assert {key: _read(line[key], value) for key, value in row.items()} == row
        for line, one in zip(lines[len(expected) :], units, strict=True):
            assert (line["unit"], line["failed"]) == (one.name, one.failed)


def _read(cell: str, value: object) -> object:
    if isinstance(value, list):
        return json.loads(cell)
    return None if value is None and not cell else type(value)(cell)


def test_nothing_is_half_written(tmp_path, monkeypatch):
    contents = {"leaving_out": made_up()["leaving_out"]}
    page = write_report(tmp_path, contents, MADE)
    before = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
    assert page.name in before

    def fails(_):
        raise RuntimeError("no picture")

    monkeypatch.setattr(report_curves, "saved", fails)
    contents["leaving_out"][0].rows[0]["run"] = 1e-3
    with pytest.raises(RuntimeError, match="no picture"):
        write_report(tmp_path, contents, {**MADE, "seconds": 9.0})
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == before


def test_little_or_nothing_was_measured(tmp_path):
    bare: list[Row] = [{"scene": "s", "failed": "not <to> be had"}]
    empty = {name: [Measured(name, f"{name}-s", "f", 0.0)] for name in made_up()}
    for at, contents in enumerate(
        (
            {},
            empty,
            {name: [Measured(name, f"{name}-s", "f", 0.0, bare)] for name in empty},
            {name: [Measured(name, f"{name}-s", "f", 0.0, [], "crashed")] for name in empty},
        )
    ):
        folder = tmp_path / str(at)
        folder.mkdir()
        text = write_report(folder, contents, {}).read_text(encoding="utf-8")
        assert ("not &lt;to&gt; be had" in text) == (at == 2)
        assert text.count("crashed") >= len(empty) * (at == 3)
        assert save_guide_figures(folder / "report.json", folder) == []


@pytest.mark.nightly
def test_guide_has_its_pictures(written, tmp_path):
    folder, _, _, _ = written
    names = {path.name for path in save_guide_figures(folder / "report.json", tmp_path)}
    drawn = {"missile", "orders", "growth", "steps", "rhs", "implicit_step", "extremes"}
    assert names == {f"which_{name}.svg" for name in drawn}  # the other scenes are not there
    assert names == {path.name for path in tmp_path.iterdir()}


def test_summary_follows_the_numbers():
    contents = made_up()
    best = best_row(contents, "missile")
    assert best["1e-3"].startswith("dop853 in C, rtol 1e-5")
    assert best["1e-9"].startswith("none; rk4 in C has 1.2e-8")
    contents["references"][1].rows[0]["estimate_phi"] = 1e-5
    assert trusted(contents, "missile") == 1e-5
    assert best_row(contents, "missile")["1e-6"].startswith("cannot be told")
    said = " ".join(sentences(contents))
    assert "Of 409 rows in 13 units, 3 failed (3 in precision)." in said
    assert "1 of 91 wrong without warning" in said
    assert (
        "28 of 30 are within 5% of theory; farthest off is rk4, n = 50, damping none: +30.00%"
        in said
    )
    assert "in 2 duels theirs takes 0.8 to 12.5 times" in said
    assert "faster than ours: SciPy LSODA on missile" in said
    contents["extremes"][0].rows.pop()
    assert "0 of 90 wrong without warning" in " ".join(sentences(contents))


def test_units_that_failed_are_those_of_their_scene_alone():
    crashed = [Measured("precision", f"precision-{s}-c", "f", 0.0, [], s) for s in SCENES]
    assert list(failed_of({"precision": crashed}, "free_n20")["failed"]) == ["free_n20"]
    longer = [Measured("precision", "precision-free_n200-c", "f", 0.0, [], "crashed")]
    assert failed_of({"precision": longer}, "free_n20").empty


def test_short_numbers():
    numbers = {1e-5: "1e-5", 2.5e-12: "2.5e-12", 1e10: "1e10", 0.01: "0.01", math.inf: "inf"}
    assert {value: short(value) for value in numbers} == numbers


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
    rows: list[Row] = [{"failed": reason} for reason in reasons]
    said = sentences({"precision": [Measured("precision", "p", "f", 0.0, rows)]})[0]
    assert "2 failed (2 in precision); 1 not tried, as time was up; 1 stopped" in said


def test_growth_of_a_known_exponential():
    row = others()["growth"][0]
    line = growth_line(row)
    assert line is not None
    (first, last), (low, high) = line
    assert low == pytest.approx(1e-14 * math.exp(8 * first), rel=1e-9)
    assert high == pytest.approx(1e-14 * math.exp(8 * last), rel=1e-9)
    # ln(10)/8 = 0.288 s a digit, sixteen of them 4.6 s.
    said = growth("chain", [row])
    assert "every 0.29 s" in said
    assert "4.6 s" in said
    assert "do not grow" in growth("chain", [{**row, "rate": -0.1}])
    slow = {**row, "rate": 1.0}  # 150-fold in 5 s
    assert "do not grow" in growth("chain", [slow])
    assert growth_line(slow) is None
    assert "no rate" in growth("chain", [{**row, "rate": None}])


def test_digits_lost_against_another_form():
    start: Row = {"group": "g", "case": "c", "n": 5, "kind": "free", "ulps_input": 2.0}
    made: list[Row] = [{**start, "form": f, "ulps": u} for f, u in (("c", 100.0), ("dense", 3.0))]
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


def test_page_of_one_section_says_nothing_of_the_others(tmp_path):
    contents = {"references": made_up()["references"], "steps": made_up()["steps"]}
    text = write_report(tmp_path, contents, {}).read_text(encoding="utf-8")
    assert "The fastest by scene" not in text
    assert "none got there" not in text


@pytest.mark.nightly
def test_scene_is_introduced_by_its_links_and_its_events(tmp_path):
    contents = made_up(("missile",))
    contents["references"][0].rows[0]["events"] = 1
    made = {"scenes": {"missile": "own_event.toml"}}
    text = write_report(tmp_path, contents, made).read_text(encoding="utf-8")
    assert "<p>20 links: own_event.toml. The scene&#39;s events take no part here" in text


@pytest.mark.nightly
def test_unseen_errors_are_counted_and_listed(tmp_path):
    contents = made_up()
    row = {**contents["extremes"][0].rows[0], "outcome": "unseen", "case": "a step too large"}
    contents["extremes"][0].rows.append({**row, "said": "off by half"})
    text = write_report(tmp_path, contents, {}).read_text(encoding="utf-8")
    _, listed = text.split("<caption>Errors of fixed steps that nothing tells</caption>")
    listed = listed.split("</table>")[0]
    assert "a step too large" in listed
    assert "off by half" in listed
    assert '<span class="unseen">unseen</span> 1:' in text


def test_labels():
    names = [label(row) for row in precision("missile")[::7]]
    ours, theirs = {"gauss in C", "gauss in NumPy"}, {"SciPy DOP853 on rodgen's C", "heyoka Taylor"}
    assert ours | theirs < {*names}


if __name__ == "__main__":  # to look at
    import sys

    Path(sys.argv[1]).mkdir(parents=True, exist_ok=True)
    print(write_report(Path(sys.argv[1]), made_up(tuple(SCENES)), MADE))
