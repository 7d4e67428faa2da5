"""The faults that are sown are those of today's sources."""

from __future__ import annotations

from pathlib import Path

from tests.mutation.faults import FAULTS
from tests.mutation.seed import ROOT, lay, place


def test_every_text_stands_once_and_its_tests_are_there(tmp_path: Path) -> None:
    """Whoever changes a line that a fault is about, or renames a test, changes the list as well."""
    layout, gone = lay(tmp_path), []
    for number, fault in enumerate(FAULTS, 1):
        try:
            assert place(fault, layout).is_file()
        except LookupError as error:
            gone.append(f"{number}: {error}")
        assert fault.right != fault.wrong
        tests = fault.tests.split()
        gone += [f"{number}: {test}" for test in tests if not (ROOT / "tests" / test).exists()]
        assert tests, number
    assert not gone, "\n".join(gone)
