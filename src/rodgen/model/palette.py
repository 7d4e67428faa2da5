"""Colours of all that is drawn, on light and on dark ground: pages, plots, pictures and films.

moments and along: stops of colour maps; series: of curves and loads that are to be told apart, also
by those who see fewer colours.
"""

from __future__ import annotations

from collections.abc import Mapping

Colours = Mapping[str, str | tuple[str, ...]]

LIGHT: Colours = {
    "background": "#ffffff",
    "ink": "#20242b",
    "faint": "#5b6470",
    "grid": "#e7eaee",
    "line": "#d5d9de",
    "behind": "#f4f6f8",
    "warn": "#a32020",
    "axis": "#b4bcc6",
    "link": "#52657d",
    "edge": "#20242b",
    "joint": "#7a8696",
    "body": "#64748b",
    "panel": "rgba(255,255,255,0.82)",
    "tail": "#c77f00",
    "centre": "#0f766e",
    "kick": "#dc2626",
    "present": "#c2410c",
    "moments": ("#08519c", "#4a90c9", "#eef0f2", "#e0705a", "#a50f15"),
    "along": ("#440154", "#3b528b", "#21918c", "#3fa34d", "#b59d00"),
    "series": (
        *("#032ca5", "#8b0400", "#197647", "#a2238b"),
        *("#9a913d", "#0393f8", "#8108ff", "#3f2f35"),
    ),
}
DARK: Colours = {
    "background": "#16191d",
    "ink": "#e8eaed",
    "faint": "#a2abb6",
    "grid": "#262b31",
    "line": "#38414d",
    "behind": "#0f1317",
    "warn": "#ff8a80",
    "axis": "#4a525c",
    "link": "#9fb3c8",
    "edge": "#0b0d0f",
    "joint": "#aab4c0",
    "body": "#94a3b8",
    "panel": "rgba(22,25,29,0.82)",
    "tail": "#f5b041",
    "centre": "#5eead4",
    "kick": "#f87171",
    "present": "#fb923c",
    "moments": ("#3b9cff", "#7cb8ee", "#f1f3f5", "#f0907a", "#ff4d4d"),
    "along": ("#8f7bff", "#5aa0ff", "#35c9c0", "#8ddf5f", "#fde725"),
    "series": (
        *("#2ab4ff", "#e97123", "#7fa669", "#b67796"),
        *("#ffea40", "#6bfaea", "#da4dc5", "#dbfec4"),
    ),
}


def colours_of(name: str, palette: Colours = LIGHT) -> tuple[str, ...]:
    """Colours of a name: the single one, or all of a list."""
    found = palette[name]
    return (found,) if isinstance(found, str) else found


def series_pair(number: int) -> tuple[str, str]:
    """A colour of the series, from 1 on, on light and on dark ground."""
    light, dark = (colours_of("series", palette)[number - 1] for palette in (LIGHT, DARK))
    return light, dark
