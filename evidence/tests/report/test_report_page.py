"""The page of the report and the files beside it, made from rows that are made up."""

from __future__ import annotations

import csv
import json
import re
from html.parser import HTMLParser
from pathlib import Path

import pytest

from evidence.tests.report.report_rows import MADE, NASTY, SCENES, made_up
from rodgen.analyse.precision.contestant import Measurement
from rodgen_evidence.pages import report_curves
from rodgen_evidence.pages.report_guide import save_guide_figures
from rodgen_evidence.pages.report_page import made_lines, read_report, write_report
from rodgen_evidence.report.contents import failures
from rodgen_evidence.report.unit import Measured


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
    # Seven pictures of a scene; growth, savings; two costs; two dampings.
    assert len(page.alts) == 2 * 7 + 2 + 2 + 2
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

    monkeypatch.setattr(report_curves, "savings", fails)
    contents["leaving_out"][0].rows[0]["run"] = 1e-3
    with pytest.raises(RuntimeError, match="no picture"):
        write_report(tmp_path, contents, {**MADE, "seconds": 9.0})
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == before


def test_little_or_nothing_was_measured(tmp_path):
    bare: list[Measurement] = [{"scene": "s", "failed": "not <to> be had"}]
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


def test_page_of_one_section_says_nothing_of_the_others(tmp_path):
    contents = {"references": made_up()["references"], "steps": made_up()["steps"]}
    text = write_report(tmp_path, contents, {}).read_text(encoding="utf-8")
    assert "The fastest by scene" not in text
    assert "none got there" not in text


@pytest.mark.nightly
def test_scene_is_introduced_by_its_links_and_its_events(tmp_path):
    contents = made_up(("missile",))
    for events in (0, 1):
        contents["references"][0].rows[0]["events"] = events
        made = {"scenes": {"missile": "own.toml"}}
        text = write_report(tmp_path, contents, made).read_text(encoding="utf-8")
        (told,) = re.findall(r"<p>(20 links: own\.toml.*)", text)
        assert ("events" in told) is (events == 1)  # they take no part in the report


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


if __name__ == "__main__":  # to look at
    import sys

    Path(sys.argv[1]).mkdir(parents=True, exist_ok=True)
    print(write_report(Path(sys.argv[1]), made_up(tuple(SCENES)), MADE))
