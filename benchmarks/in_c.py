"""The C target in a C loop: against the plain elimination with the same flags, and its growth."""

from __future__ import annotations

import native
from problem import ALL, FOLLOWER, built, disagreement, packed, state
from report import Report, duration

from rodgen.judge.timing import interleaved

RATIO, ASKED = 0.65, (50, 200, 1000)  # to the yardstick, at so many links
GROWTH = 11.0


def in_c(report: Report) -> None:
    """The rod of the yardstick, rods that have no yardstick of their own, and growth."""
    for links in (5, 20, 50, 200, 1000):
        _against_yardstick(report, links)
    for kind, terms, name in (
        (("free", "uniform"), ALL, "all loads"),
        (("clamped", "lumped"), FOLLOWER, "clamped, lumped"),
        (("clamped", "lumped"), ALL, "clamped, lumped, all loads"),
    ):
        for links in ASKED:
            _other(report, links, kind, terms, f"{name}, n={links}")
    _growth(report)


def _against_yardstick(report: Report, links: int) -> None:
    what = f"free, uniform, follower, n={links}"
    module = report.module(what, built, links, target="c")
    if module is None:
        return
    ours, plain = native.of_module(module), native.yardstick(links)
    y, p = state(links), packed(module)
    if not report.agree(
        what, disagreement(ours(0.0, y, p), plain(0.0, y, p)), 1e-9, "the yardstick"
    ):
        return
    times = interleaved({"ours": ours.batch(y, p), "plain": plain.batch(y, p)})
    ratio, beside = times.ratio("ours", "plain"), f"the yardstick's {_us(times.median('plain'))}"
    shown = f"{_us(times.median('ours'))}, {ratio:.2f} of"
    if links in ASKED:
        report.row(what, ratio, RATIO, shown, f"{RATIO} of {beside}")
    else:
        report.note(what, shown, beside)


def _other(
    report: Report, links: int, kind: tuple[str, str], terms: tuple[str, ...], what: str
) -> None:
    """Checked against the dense form, shown beside the yardstick, which computes less."""
    module = report.module(what, built, links, terms, "c", kind=kind)
    if module is None:
        return
    ours, plain = native.of_module(module), native.yardstick(links)
    y, p = state(links, base=2 if kind[0] == "free" else 0), packed(module)
    dense = built(links, terms, form="dense", kind=kind).rhs(0.0, y, p)
    if not report.agree(what, disagreement(ours(0.0, y, p), dense), 1e-8, "the dense form"):
        return
    free, its = state(links), packed(built(links))
    times = interleaved({"ours": ours.batch(y, p), "plain": plain.batch(free, its)})
    shown = f"{_us(times.median('ours'))}, {times.ratio('ours', 'plain'):.2f} of"
    report.note(what, shown, f"the yardstick's {_us(times.median('plain'))} for less")


def _growth(report: Report) -> None:
    """From n=2000 to n=20000."""
    what, ours, plain = "growth, follower, n=20000 over n=2000", {}, {}
    for links in (2000, 20000):
        module = report.module(what, built, links, target="c")
        if module is None:
            return
        y, p = state(links), packed(module)
        ours[str(links)] = native.of_module(module).batch(y, p)
        plain[str(links)] = native.yardstick(links).batch(y, p)
    times = interleaved(ours, rounds=31, seconds=0.02)
    ratio, few, many = times.ratio("20000", "2000"), times.median("2000"), times.median("20000")
    shown = f"{ratio:.2f} times, {duration(few)} to {duration(many)}"
    report.row(what, ratio, GROWTH, shown, f"at most {GROWTH:g} times")
    beside = interleaved(plain, rounds=31, seconds=0.02).ratio("20000", "2000")
    report.note("the yardstick's", f"{beside:.2f} times")


def _us(seconds: float) -> str:
    return f"{seconds * 1e6:.3g} us"
