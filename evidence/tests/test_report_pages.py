"""What the documents show of a report is what the committed report has."""

from __future__ import annotations

import re
from collections import Counter
from pathlib import Path

import pytest

from rodgen.analyse.precision.rows import has_result
from rodgen_evidence.pages.report_guide import (
    renew_guide,
    renew_speed,
    save_guide_figures,
    speed,
)
from rodgen_evidence.pages.report_page import read_report
from rodgen_evidence.report.contents import of

ROOT = Path(__file__).parents[2]
REPORT = ROOT / "docs" / "report" / "report.json"


def test_speeds_are_those_of_the_report() -> None:
    contents, _ = read_report(REPORT)
    page = (ROOT / "docs" / "speed.md").read_text(encoding="utf-8")
    assert renew_speed(page, contents) == page
    duels = [row for row in of(contents, "equal_error", asked=1e-6) if has_result(row)]
    assert duels
    runs = of(contents, "precision", method="dop853", target="c", setting=1e-5)
    counts = {run["scene"]: run["nfev"] for run in runs}
    for row in duels:  # by another route than the table's own
        assert re.search(rf"`{row['scene']}` .*\| {row['ratio']:.2g} \|", page)
        if row["ours"] == "dop853 (c), rtol 1e-05":
            assert f"rtol 1e-05 | {counts[row['scene']]} |" in page


def test_speeds_are_taken_between_the_marks_alone() -> None:
    contents, _ = read_report(REPORT)
    text = "before\n<!-- speed: from report/report.json -->\nold\n<!-- /speed -->\nafter\n"
    made = renew_speed(text, contents)
    assert made.startswith("before\n")
    assert made.endswith("\nafter\n")
    assert "\n".join(speed(contents)) in made
    assert "old" not in made
    with pytest.raises(ValueError, match="unpack"):
        renew_speed("no marks", contents)


def test_tables_of_the_guide_are_those_of_the_report() -> None:
    contents, _ = read_report(REPORT)
    guide = (ROOT / "docs" / "which-method.md").read_text(encoding="utf-8")
    assert renew_guide(guide, contents) == guide
    counts = Counter(row["outcome"] for row in of(contents, "extremes"))
    for outcome, count in counts.items():  # by another route than the table's own
        assert f"\n| {outcome} | {count} |" in guide
    by = {(r["who"], r["n"]): r["seconds"] for r in of(contents, "costs", what="rhs")}
    ratio = by["rodgen NumPy", 20] / by["rodgen C, from C", 20]
    assert re.search(rf"\| NumPy \| \d+ \| {ratio:.0f} \|", guide)
    with pytest.raises(ValueError, match="unpack"):
        renew_guide("no marks", contents)


@pytest.mark.nightly
def test_guide_has_the_pictures_of_the_report(tmp_path: Path) -> None:
    guide = (ROOT / "docs" / "which-method.md").read_text(encoding="utf-8")
    shown = set(re.findall(r"pictures/(which_\w+\.svg)", guide))
    drawn = {file.name for file in save_guide_figures(REPORT, tmp_path)}
    assert shown
    assert shown <= drawn
    for name in shown:
        assert (ROOT / "docs" / "pictures" / name).is_file()
