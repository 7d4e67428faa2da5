"""Recorded runs of the live view, which a page shows: written beside the built pages."""

from __future__ import annotations

from pathlib import Path

from sphinx.application import Sphinx

import rodgen
from rodgen_live.page.export import export

SHOWN = {
    "missile": {},
    "beck_after_flutter": {"span": [0.0, 20.0]},
    "falling_chain": {"span": [0.0, 6.0]},
}


def _write(site: Sphinx, failure: Exception | None) -> None:
    if failure is None and site.builder.format == "html":
        for name, settings in SHOWN.items():
            run = rodgen.simulate(rodgen.Scene.example(name), progress=False, **settings)
            folder = Path(site.outdir) / "replays" / name
            folder.parent.mkdir(exist_ok=True)
            export(run, folder)


def setup(site: Sphinx) -> dict[str, bool]:
    site.connect("build-finished", _write)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
