"""The faults that are sown are those of today's sources."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.mutation.faults import FAULTS, Fault
from tests.mutation.seed import ROOT, lay, place


@pytest.fixture(scope="module")
def layout(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return lay(tmp_path_factory.mktemp("layout"))


@pytest.mark.nightly
@pytest.mark.parametrize("fault", FAULTS, ids=lambda fault: fault.right[:40])
def test_text_stands_once_and_its_tests_are_there(layout: Path, fault: Fault) -> None:
    assert place(fault, layout).is_file()
    assert fault.right != fault.wrong
    assert all((ROOT / "tests" / test).exists() for test in fault.tests.split())
