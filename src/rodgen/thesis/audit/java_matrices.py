"""The listing's matrices, lines 235-369, loop by loop, and the claims that they make."""

from __future__ import annotations

from collections.abc import Callable

from sympy import Expr

from rodgen.derive.symbols import k, m

from .claim import Claim, Entries
from .java_members import Array, FreeRodModel, symbolic
from .truth import c_int, flat, truth


def assembleMatrixM(it: FreeRodModel) -> None:
    """Lines 236-286."""
    for r in range(it.rows):
        for c in range(it.columns):
            # filling the first symmetric half: rows of velocities[0], velocities[1]
            if r == 0:
                _velocityRow(it, 0, c)
            if r == 1:
                _velocityRow(it, 1, c)
            # generic omega rows
            if r >= 2 and r < it.rows - 1:
                _omegaRow(it, r, c)
            # last omega row, line 270
            if r == it.rows - 1 and c == r:
                it.matrixM[r][c] = 2 * it.math.one / 3 * it.elementLength * it.elementLength
    # generating the other symmetric half
    for r in range(it.rows):
        for c in range(it.columns):
            if r != c:
                it.matrixM[c][r] = it.matrixM[r][c]


def _velocityRow(it: FreeRodModel, r: int, c: int) -> None:
    """Lines 248-251 (r = 0) and 257-260 (r = 1)."""
    n, l = it.elementCount, it.elementLength
    if c == 1 - r:
        it.matrixM[r][c] = 0 * it.math.one
    if c == r:
        it.matrixM[r][c] = 2 * it.math.one * n
    if c >= 2:
        it.matrixM[r][c] = _direction(it, r, c) * (1 + 2 * (n - (c - 1))) * l
    if c == it.columns - 1:
        it.matrixM[r][c] = _direction(it, r, c) * l


def _direction(it: FreeRodModel, r: int, c: int) -> Expr:
    return -it.anglesSin[c - 2] if r == 0 else it.anglesCos[c - 2]


def _omegaRow(it: FreeRodModel, r: int, c: int) -> None:
    """Lines 265-267."""
    n, l, cos = it.elementCount, it.elementLength, it.math.cos
    if r == c:
        third = it.math.one / 3
        it.matrixM[r][r] = 2 * l * l * (third + (n + (r - (2 * r - 1))))
    if c > r and c < it.columns - 1:
        angle = it.angles[c - 2] - it.angles[r - 2]
        it.matrixM[r][c] = l * l * cos(angle) * (1 + 2 * (n - (c - 1)))
    if c > r and c == it.columns - 1:
        it.matrixM[r][c] = l * l * cos(it.angles[c - 2] - it.angles[r - 2])


def assembleMatrixQ(it: FreeRodModel) -> None:
    """Lines 289-313."""
    n, l = it.elementCount, it.elementLength
    for r in range(it.rows):
        for c in range(it.rows - 2):
            weight = 1 + 2 * (n - (c + 1))
            if r == 0:
                it.matrixQ[r][c] = l * it.anglesCos[c] * weight
            if r == 1:
                it.matrixQ[r][c] = l * it.anglesSin[c] * weight
            if r >= 2 and r < it.rows - 1 and c >= r - 2:
                angle = it.angles[c] - it.angles[r - 2]
                it.matrixQ[r][c] = l * l * it.math.sin(angle) * weight
    # generating the other antisymmetric half
    for r in range(2, it.rows):
        for c in range(it.rows - 2):
            if r - 2 != c:
                it.matrixQ[c + 2][r - 2] = -it.matrixQ[r][c]


def assembleMatrixK(it: FreeRodModel) -> None:
    """Lines 316-341."""
    _fillBand(it, it.matrixK)


def assembleMatrixC(it: FreeRodModel) -> None:
    """Lines 344-369."""
    _fillBand(it, it.matrixC)


def _fillBand(it: FreeRodModel, matrix: Array) -> None:
    """Lines 318-340 and 346-368, which differ in nothing but the name of the matrix."""
    one = it.math.one
    for r in range(2, it.rows):
        for c in range(it.elementCount):
            if r == 2:
                if c == 0:
                    matrix[r][c] = one
                if c == 1:
                    matrix[r][c] = -one
            if r > 2 and r < it.rows - 1:
                if c == r - 3:
                    matrix[r][c] = -one
                if c == r - 2:
                    matrix[r][c] = 2 * one
                if c == r - 1:
                    matrix[r][c] = -one
            if r == it.rows - 1:
                if c == r - 3:
                    matrix[r][c] = -one
                if c == r - 2:
                    matrix[r][c] = one


# Claims --------------------------------------------------------------------------------------


def _assembled(
    method: Callable[[FreeRodModel], None], name: str, factor: Expr, times: int = 1
) -> Entries:
    """Entries of a matrix with the factor that createEquation gives it (lines 375-403)."""

    def entries(n: int) -> list[Expr]:
        it = symbolic(n)
        for _ in range(times):
            method(it)
        return [factor * e for e in flat(getattr(it, name))]

    return entries


def _mended_band(name: str, factor: Expr) -> Entries:
    """The band filled only where there is a joint (elementCount > 1)."""

    def entries(n: int) -> list[Expr]:
        it = symbolic(n)
        if it.elementCount > 1:
            _fillBand(it, getattr(it, name))
        return [factor * e for e in flat(getattr(it, name))]

    return entries


def _entry(columns: int) -> Callable[[int, int], str]:
    """Java's name of an entry of a matrix with this many columns more than links."""
    return lambda n, at: f"[{at // (n + columns)}][{at % (n + columns)}]"


_ONE_LINK = (
    "The branches for the first and for the last link both apply to the only link, and the last "
    "leaves a 1 where there is no joint: a single free link is turned back towards the x axis."
)
_BAND = "if (r==2) {1, -1}; if (r>2 && r<rows-1) {-1, 2, -1}; if (r==rows-1) {-1, 1}"
_HALF_M, _DAMPER = m / 2, c_int * m

CLAIMS = (
    Claim(
        "Java 235-286, 375-382",
        "mass matrix",
        {"as printed": _assembled(assembleMatrixM, "matrixM", _HALF_M)},
        lambda n: flat(truth(n).M),
        label=_entry(2),
        note="Rows are completed in order, so every entry below the diagonal is written before it "
        "is read. The thesis prints no M: this is its only statement of it.",
        printed="matrixM[r][r] = 2d*l*l*(1/3d+(n+(r-(2*r-1)))); ... matrixM[c][r]=matrixM[r][c];",
    ),
    Claim(
        "Java 288-313, 385-389",
        "velocity matrix",
        {"as printed": _assembled(assembleMatrixQ, "matrixQ", _HALF_M)},
        lambda n: flat(truth(n).Q),
        label=_entry(0),
        note="The loop that completes the lower half also runs over the entries it has written: "
        "they are negated twice. The last row is filled by it alone.",
        printed="if (r-2!=c) matrixQ[c+2][r-2]=-matrixQ[r][c];",
    ),
    Claim(
        "Java 288-313, again",
        "velocity matrix, assembled a second time over the first",
        {"as printed": _assembled(assembleMatrixQ, "matrixQ", _HALF_M, times=2)},
        lambda n: flat(truth(n).Q),
        label=_entry(0),
        note="The members are kept from step to step: nothing of the last assembly is left over.",
        printed="if (r-2!=c) matrixQ[c+2][r-2]=-matrixQ[r][c];",
    ),
    Claim(
        "Java 315-341, 392-396",
        "stiffness matrix, two links or more",
        {"as printed": _assembled(assembleMatrixK, "matrixK", k)},
        lambda n: flat(truth(n).K),
        label=_entry(0),
        links=range(2, 7),
        printed=_BAND,
    ),
    Claim(
        "Java 315-341, n=1",
        "stiffness matrix, one link",
        {"as printed": _assembled(assembleMatrixK, "matrixK", k)},
        lambda n: flat(truth(n).K),
        label=_entry(0),
        corrected=_mended_band("matrixK", k),
        links=(1,),
        note=_ONE_LINK,
        printed=_BAND,
        correction="if (elementCount>1) { ... }",
    ),
    Claim(
        "Java 343-369, 399-403",
        "internal damping matrix, two links or more",
        {"as printed": _assembled(assembleMatrixC, "matrixC", _DAMPER)},
        lambda n: flat(truth(n).D_i),
        label=_entry(0),
        links=range(2, 7),
        note="Called assembleMatrixD and D_i in section 4.1.",
        printed=_BAND,
    ),
    Claim(
        "Java 343-369, n=1",
        "internal damping matrix, one link",
        {"as printed": _assembled(assembleMatrixC, "matrixC", _DAMPER)},
        lambda n: flat(truth(n).D_i),
        label=_entry(0),
        corrected=_mended_band("matrixC", _DAMPER),
        links=(1,),
        note=_ONE_LINK,
        printed=_BAND,
        correction="if (elementCount>1) { ... }",
    ),
)
