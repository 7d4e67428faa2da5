"""Dialog that says what to do, and lists the keys."""

from __future__ import annotations

from collections.abc import Mapping

from nicegui import ui

from rodgen_live.page.fields import dialog

SPACE = "space"
TO_DO = (
    "Drag the slider of a load past the mark at its critical value, and watch the rod.",
    "Press Flutter below the rod to plot its tail: over time, as a phase plot, as a spectrum.",
    "Choose another scene from the list, or write one under Text; ? shows this again.",
)
# What takes keys while it has the focus: static/rod.js, static/timeline.js,
# static/chart_pointer.js.
IN_FOCUS = {
    "The rod, in focus": {
        "← → ↑ ↓": "Move the picture",
        "+ −": "Zoom, as the wheel does",
        "0": "Fit the rod, as a double click does",
        "Esc": "Let go of a kick or a pull",
    },
    "The time line, in focus": {
        "← →": "A sample back or on",
        "page up, page down": "A tenth of the line",
        "Home, End": "The first sample, the present",
        "a, b": "Ends of the loop",
    },
    "A plot, in focus": {
        "+ −": "Zoom, as the wheel does",
        "← →": "Move along it",
        "0": "All of it, as a double click does",
    },
}


def show_shortcuts(everywhere: Mapping[str, str]) -> None:
    """Open a dialog of keys; everywhere: what keys do that the whole page takes, by their names."""
    with dialog("What to do, and keys"):
        for line in TO_DO:
            ui.label(line)
        for title, keys in {"The page": everywhere, **IN_FOCUS}.items():
            with ui.element("table").classes("rg-keys"):
                with ui.element("caption"):
                    ui.label(title)
                for key, does in keys.items():
                    with ui.element("tr"):
                        with ui.element("th").props("scope=row"), ui.element("kbd"):
                            ui.label(key)
                        with ui.element("td"):
                            ui.label(does)
