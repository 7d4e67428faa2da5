"""The reference modules under version control compute what the generator's modules of today do.

Their text is compared by `make check ONLY=reference`."""

from __future__ import annotations

import numpy as np
import pytest

from rodgen.check.module_check import check_module
from rodgen.loading import load_module
from tests.generated.conftest import Built
from tests.reference import GENERATED, MODULES, ROOT

OF_STATES = ("energy", "mass_matrix", "joints", "bending_moments")
OF_TIME = ("rhs", "jac")


@pytest.mark.parametrize("stem", MODULES)
def test_reference_module_computes_what_a_new_one_does(
    built: Built, point: type, stem: str
) -> None:
    """And both what 50-digit arithmetic gives, at a random state."""
    structure, target, form = MODULES[stem]
    kept, new = load_module(GENERATED / f"{stem}.py"), built(structure, target, form)
    assert (kept.STATE, kept.PARAMETERS) == (new.STATE, new.PARAMETERS)
    assert kept.PROVENANCE["structure_hash"] == new.PROVENANCE["structure_hash"]
    assert (ROOT / kept.__doc__.split("Do not edit; ")[1].split()[0]).is_file()
    at = point(kept)
    of = dict.fromkeys(OF_STATES, (at.y, at.p)) | dict.fromkeys(OF_TIME, (at.t, at.y, at.p))
    for name, given in of.items():
        one, two = (np.asarray(getattr(module, name)(*given)) for module in (kept, new))
        # Rounding, in the order of operations of another version of SymPy.
        np.testing.assert_allclose(one, two, rtol=0, atol=1e-12 * np.abs(two).max(), err_msg=name)
    # Rounding of some hundred operations, amplified by the condition of M.
    assert max(d.error for d in check_module(kept, states=1)) < 1e-12
