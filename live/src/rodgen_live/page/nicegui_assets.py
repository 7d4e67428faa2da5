"""Reduced files of NiceGUI, served in place of its own, as most of these is for other pages."""

from __future__ import annotations

import re

from rodgen_live.page.elements import ICONS, LIBRARY

COMPONENTS = (
    "avatar|badge|banner|bar|breadcrumbs|carousel|circular|color|date|drawer|editor|expansion|fab"
    "|footer|img|infinite|intersection|knob|message|pagination|parallax|pull|radio|rating"
    "|scrollarea|skeleton|slide|splitter|stepper|table|time|timeline|toolbar|tree|uploader|video"
)
# What the page does not have, in the selector of a rule or in a face of a font.
ABSENT = re.compile(
    rf"\.q-(?:{COMPONENTS})(?![a-z])"
    r"|\.q-(?:col-)?gutter-|\.q-transition--(?:flip|rotate)"
    r"|\.(?:col|offset)-(?:xs|sm|md|lg|xl)|\.shadow-|\.(?:bg|text)-[a-z-]+-\d"
    r'|"Material (?:Icons |Symbols)|font-weight: (?:100|300|900)|/\* symbols'
)
RULE = re.compile(r"([^{}]+)\{[^{}]*\}")
ICON_FONT = re.compile(r'"Material Icons";[^}]*url\([\'"]?(.*?)[\'"]?\)')
# Instead of DOMPurify: the page shows no HTML of others. What is asked for is shown as text.
PURIFIER = b"""export default new Proxy({}, { get: (_, name) =>
    name === "sanitize" ? html => new Option(html).innerHTML : () => {} });
"""


def replacements() -> dict[str, bytes]:
    """Contents to serve, by the paths of files in LIBRARY."""
    sheets = {path.name: path.read_text("utf-8") for path in LIBRARY.glob("*.css")}
    found = {name: RULE.sub(_reduce_rule, sheet).encode() for name, sheet in sheets.items()}
    found["dompurify.mjs"] = PURIFIER
    if (font := icon_font()) is not None:
        found[font] = ICONS.read_bytes()
    return found


def icon_font() -> str | None:
    """Path in LIBRARY of the font of all icons that there are, or None."""
    found = ICON_FONT.search((LIBRARY / "fonts.css").read_text("utf-8"))
    return found[1] if found else None


def _reduce_rule(rule: re.Match[str]) -> str:
    """Reduce a rule to the selectors that the page may have; nothing where there are none."""
    text, selectors = rule[0], rule[1]
    if "@" in selectors:  # a face of a font
        return "" if ABSENT.search(text) else text
    kept = [selector for selector in selectors.split(",") if not ABSENT.search(selector)]
    if kept and "(" in selectors:  # with commas of its own
        return text
    return ",".join(kept) + text[len(selectors) :] if kept else ""
