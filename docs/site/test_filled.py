"""Pages that the package itself fills: every mark gives way to tables, whether the site is built or
not.
"""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import commands  # these lie beside this file
import names
import pytest
import quantities
import rows

SITE = SimpleNamespace(srcdir=str(Path(__file__).parents[1]))


@pytest.mark.parametrize("module", [commands, names, quantities, rows], ids=lambda one: one.PAGE)
def test_pages_are_filled(module: Any) -> None:
    page = Path(SITE.srcdir, f"{module.PAGE}.md").read_text(encoding="utf-8")
    assert module.MARK in page
    site: Any = SITE
    source = [page]
    module._fill(site, module.PAGE, source)
    assert module.MARK not in source[0]
    assert len(source[0].splitlines()) > len(page.splitlines()) + 10
