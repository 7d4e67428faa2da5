"""Light or dark: as the browser wants it, until it is chosen here."""

from __future__ import annotations

from nicegui import ui

COOKIE = "rodgen_dark"  # which the server sees before there is a page
TURN = f"""
    const dark = !document.body.classList.contains("body--dark");
    Quasar.Dark.set(dark);
    document.cookie = "{COOKIE}=" + (dark ? 1 : 0) + "; path=/; max-age=31536000; samesite=lax";
"""
# Until Quasar marks the body as light or dark.
BEFORE = "body:not(.body--light, .body--dark) { background: %s; }"
KEPT = {"0": BEFORE % "#f4f6f8", "1": BEFORE % "#0f1317"}
UNKNOWN = KEPT["0"] + "@media (prefers-color-scheme: dark) { " + KEPT["1"] + " }"


def as_before() -> None:
    """Give the page that is being built the shade that was chosen last, from its first moment."""
    request = ui.context.client.request
    kept = request.cookies.get(COOKIE) if request else None
    ui.add_css(KEPT.get(kept or "", UNKNOWN))
    if kept in KEPT:
        ui.dark_mode(kept == "1")
