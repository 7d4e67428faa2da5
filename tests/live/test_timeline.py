"""Looking back at samples of a run: what the page is shown of them, and what is marked."""

from __future__ import annotations

import time
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

pytest.importorskip("nicegui", reason="the extra view is not installed")

from rodgen.live.page.answers import take_up
from rodgen.live.run.curves import spectrum
from rodgen.live.run.live_run import LiveRun
from rodgen.live.run.marks import MOST, Mark, Marks
from rodgen.live.run.scenes import edit
from rodgen.scene import Scene
from tests.live.conftest import ROD
from tests.live.test_run import Page
from tests.live.view import expect

View = Any  # see conftest.py
SCENE = Scene.from_dict(ROD)


@pytest.fixture
def run() -> Iterator[LiveRun]:
    """Paused after samples at 0, 0.01, ..., 0.3 s, with a profile of the rates."""
    made = LiveRun(SCENE)
    made.do(lambda: made.add_plot({"kind": "profile", "y": ["omega"]})).result()
    made.do(lambda: made._took(made.live.advance(0.3, 10.0))).result()
    yield made
    made.close()


def looks(run: LiveRun, page: Page, text: str) -> dict[str, Any]:
    """What the page gets next after it has said something."""
    before = len(page.headers)
    page.acknowledge()
    assert take_up(run, text)
    page.gets(before + 1)
    return page.headers[-1]


def seen(run: LiveRun) -> Page:
    page = Page(run)
    page.gets(1)
    return page


def test_rod_profile_and_values_are_those_of_the_sample(run: LiveRun) -> None:
    page = seen(run)
    present = page.headers[-1]
    line = {"from": 0.0, "to": 0.3, "count": 31, "past": None, "keeps": False, "marks": []}
    assert present["line"] == line
    header = looks(run, page, '{"look": 0.1234}')
    sample = run.store.near(0.12)
    assert (header["t"], header["line"]["past"]) == (0.12, 0.12)
    joints = run.model.joints(sample.y[0], sample.p)
    # Single precision.
    assert header["joints"].reshape(-1, 2) == pytest.approx(joints - joints[0], abs=1e-6)
    (plot,) = run.plots
    half = sample.y.shape[1] // 2
    rates = page.rows[plot][-1].reshape(-1, 2)[:, 1]
    assert rates == pytest.approx(sample.y[0, half + 2 :])
    assert float(header["texts"]["kinetic_energy"]) == pytest.approx(  # five digits are shown
        float(run.catalogue.columns(["kinetic_energy"], sample)[0, 0]), rel=1e-4
    )


def test_steps_end_at_the_first_sample_and_in_the_present(run: LiveRun) -> None:
    page = seen(run)
    assert looks(run, page, '{"step": -1}')["line"]["past"] == pytest.approx(0.29)
    assert looks(run, page, '{"step": -100}')["line"]["past"] == 0.0
    assert looks(run, page, '{"step": 29}')["line"]["past"] == pytest.approx(0.29)
    assert looks(run, page, '{"step": 1}')["line"]["past"] is None
    looks(run, page, '{"look": 0.2}')
    assert looks(run, page, '{"look": null}')["t"] == 0.3


def test_what_moves_the_rod_is_seen_in_the_present(run: LiveRun) -> None:
    """A kick, a change, a step or a start shows what it does, wherever the page looked."""
    page = seen(run)
    heavier = edit(run.live.scene, [(("rod", "mass"), 4.0)])
    for act in (
        lambda: run.kick(4, 1.0, (0.0, 0.1)),
        lambda: run.change(heavier, "rod.mass = 4"),
        run.one_step,
        run.restart,
    ):
        looks(run, page, '{"step": -1}')
        run.do(act).result()
        assert run.past is None
        run.do(lambda: run._took(run.live.advance(run.live.t + 0.1, 10.0))).result()


def test_a_spectrum_is_of_what_leads_to_the_sample(run: LiveRun) -> None:
    page = seen(run)
    run.do(lambda: run.add_plot({"kind": "spectrum", "y": ["omega_4"], "window": 0.2})).result()
    *_, name = run.plots
    looks(run, page, '{"look": 0.25}')
    samples = [run.store.near(0.05 + 0.01 * k) for k in range(21)]
    values = [run.catalogue.columns(["omega_4"], sample)[0, 0] for sample in samples]
    wanted = spectrum(np.array([sample.t[0] for sample in samples]), np.array(values))
    for _ in range(50):  # at most four of them a second are made
        page.acknowledge()
        rows = page.rows[name][-1].reshape(-1, 2)
        if rows.shape == wanted.shape and np.allclose(rows, wanted, rtol=1e-9):
            return
        time.sleep(0.02)
    raise AssertionError("not the spectrum of the samples from 0.05 to 0.25 s")


def test_run_that_is_looked_back_at_goes_on(run: LiveRun) -> None:
    page = seen(run)
    looks(run, page, '{"look": 0.1}')
    run.do(lambda: run._took(run.live.advance(0.5, 10.0))).result()
    header = looks(run, page, '{"step": 0}')
    assert (header["t"], header["line"]["to"]) == (pytest.approx(0.1), 0.5)


def test_changes_and_kicks_are_marked(run: LiveRun) -> None:
    page = seen(run)
    page.acknowledge()
    run.do(lambda: run.kick(4, 1.0, (0.0, 0.1))).result()
    page.gets(2)
    ((t, what),) = page.headers[-1]["line"]["marks"]
    assert (t, what) == (run.live.t, "kick (0, 0.1) N s upon link 4")
    assert "marks" not in looks(run, page, '{"step": -1}')["line"]  # the page has them
    assert f"upon link 4 at t = {t:.6g} s" in run.do(run.solution).result().message


def test_marks_of_a_slider_are_one_and_bounded() -> None:
    marks = Marks()
    marks.note(1.0, "mass = 2")
    marks.note(1.5, "mass = 3")
    marks.note(2.0, "kick (0, 1) N s upon link 0")
    assert marks.every == (Mark(1.5, "mass = 3"), Mark(2.0, "kick (0, 1) N s upon link 0"))
    for k in range(2 * MOST):
        marks.note(3.0 + k, f"kick {k}")
    assert len(marks.every) == MOST
    assert (marks.every[0].t, marks.every[-1].what) == (1.5, f"kick {2 * MOST - 1}")


@pytest.mark.parametrize(
    "text",
    [
        *("", "3", "[]", "{}", '{"ack": 1, "step": 1}', '{"go": 1}', '{"ack": 1.5}'),
        *(
            '{"keep": 1}',
            '{"branch": true}',
            '{"look": NaN}',
            '{"look": true}',
            '{"look": "1"}',
            '{"step": null}',
            '{"step": 1.5}',
        ),
        '{"ack": ' + "1" * 500 + "}",
        "[" * 100_000,
    ],
)
def test_other_answers_are_none(run: LiveRun, text: str) -> None:
    assert not take_up(run, text)


@pytest.mark.nightly
def test_time_line_in_the_page(view: View) -> None:
    """By keys: rod, values and cursors of the plots follow; a loop plays between its ends."""
    view.pause_after(0.5)
    line = view.page.get_by_role("slider", name="Time that is shown")
    lines = "Object.values(rodgenLive.plots).filter(({ at }) => at !== null).length"
    hints = view.page.locator(".rodgen-hint:visible")  # words are for pointers
    end = float(line.get_attribute("aria-valuemax"))
    view.sees(lines, 0, "a line in a plot")
    line.press("Home")
    view.until(lambda: view.live("t"), 0.0, "not at the first sample")
    view.until(lambda: float(view.text("t")), 0.0, "another time in the values")
    expect(line).to_have_attribute("aria-valuetext", "0 s, looking back")
    view.sees(lines, 2, "no line in the plots")
    expect(hints).to_have_count(0)
    line.press("ArrowRight")
    view.until(lambda: view.live("t"), pytest.approx(0.01), "no step on")
    line.press("a")
    for _ in range(3):
        line.press("PageUp")
    view.until(lambda: view.live("t"), lambda t: t > 0.25 * end, "no page on")
    line.press("b")
    last = float(line.get_attribute("aria-valuenow"))
    view.button("Play again").click()
    times = [view.live("t") for _ in range(50) if not view.page.wait_for_timeout(20)]
    assert len(set(times)) > 3
    assert 0.0 < min(times) < max(times) <= last + 0.011  # the sample nearest to the end
    assert view.page.evaluate("rodgenLive.state") == "paused"
    ends = [view.page.get_by_role("button", name=f"Loop {word}") for word in ("from", "up to")]
    for button in ends:  # while it plays, wherever it is
        button.click()
        expect(button).to_have_attribute("aria-pressed", "false")
    line.press("End")
    view.until(lambda: view.live("t"), pytest.approx(end), "not in the present")
    view.sees(lines, 0, "a line in a plot still")


@pytest.mark.nightly
def test_dragging_the_time_line_moves_the_rod(view: View) -> None:
    view.tab("Values").pause_after(0.5)
    line = view.page.get_by_role("slider", name="Time that is shown")
    present = view.text("kinetic_energy")
    box = line.bounding_box()
    end, y = view.live("t"), box["y"] + box["height"] / 2
    view.page.mouse.move(box["x"] + box["width"] - 12, y)
    view.page.mouse.down()
    view.page.mouse.move(box["x"] + box["width"] / 2, y, steps=10)
    view.until(lambda: view.live("t"), pytest.approx(end / 2, abs=0.02), "not in the middle")
    view.page.mouse.up()
    view.until(lambda: view.text("kinetic_energy"), lambda text: text != present, "no other values")


@pytest.mark.nightly
def test_planes_end_where_the_time_line_is(view: View) -> None:
    """A phase plot and a Poincaré section show what lies before the time that is looked at."""
    view.add_plot("phase plot", quantity="omega_0", over="phi_0")
    view.pause_after(0.5)
    plot = "Object.values(rodgenLive.plots).at(-1)"
    all_of_them = view.page.evaluate(f"{plot}.rows")
    view.sees(f"{plot}.seen", all_of_them, "not all samples at first")
    line = view.page.get_by_role("slider", name="Time that is shown")
    line.press("Home")
    view.sees(f"{plot}.seen", 1, "not the first sample alone")
    line.press("ArrowRight")
    view.sees(f"{plot}.seen", 2, "not two samples")
    line.press("End")
    view.sees(f"{plot}.seen", all_of_them, "not all samples again")
