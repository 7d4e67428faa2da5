"""Critical forces of random scenes against exact polynomials; windows, other loads, what is said.

The linearised straight rod is assembled by hand in whole numbers, with the angle of every link:
det(u B + p A + v M), where B are springs of one, A the follower force of one, M masses and lengths
of one, p = P L^2/(EI n^2), v a squared rate, and u = 1 + d s, since a dashpot stands beside every
spring. Its coefficients are interpolated exactly; how many of its roots lie on the right is told by
the Routh array (with damping) and by Sturm's chain (without), in 80 digits.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property, lru_cache
from itertools import pairwise
from typing import Any

import mpmath as mp
import numpy as np
import pytest
from scipy.optimize import brentq

from rodgen.analyse.critical import critical_load
from rodgen.analyse.extrapolation import richardson
from rodgen.analyse.modes import natural_modes
from rodgen.errors import AnalysisError
from rodgen.result import format_with_error
from rodgen.scene import Scene
from tests.analyse.rods import ONES, rod
from tests.told import numbers

Rows = list[list[Any]]
HIGHEST = 1000  # EI/L^2, to which a search goes
SHARES = [0.01, 0.05, *np.arange(0.1, 0.95, 0.1), 0.95, 0.98, 0.99, 0.999]  # of a force, below it
THRUST: dict[str, Any] = {"follower": {"force": 1.0}}
WEIGHT: dict[str, Any] = {"gravity": {"g": 9.0}}
UPRIGHT = ONES | {"clamp_angle": np.pi / 2}


@dataclass(frozen=True)
class Chain:
    """A straight rod under a follower force at its tail."""

    n: int
    boundary: str
    lumped: bool

    def matrices(self) -> tuple[Rows, Rows, Rows]:
        """B, A and M: angles of the moving links, before them the displacement of a free nose."""
        n, free = self.n, self.boundary == "free"
        first = self.boundary == "cantilever"
        size = n - first + free
        B, A, M = ([[Fraction(0)] * size for _ in range(size)] for _ in range(3))
        at = {link: link - first + free for link in range(first, n)}
        springs = [(i, i + 1, 1) for i in range(n - 1)]
        springs += [(-1, 0, 2)] * (self.boundary == "clamped")
        for i, j, stiffness in springs:
            for one, other, sign in ((i, i, 1), (j, j, 1), (i, j, -1), (j, i, -1)):
                if one in at and other in at:
                    B[at[one]][at[other]] += sign * stiffness
        for i, row in at.items():
            beyond = n - i - Fraction(1, 2)  # mass from the middle of the link on
            for j, column in at.items():
                M[row][column] = min(beyond, n - j - Fraction(1, 2))
            M[row][row] = beyond if self.lumped else n - i - Fraction(2, 3)
            A[row][row] -= 1
            A[row][-1] += 1
            if free:  # the rod accelerates by P over its mass
                A[row][row] += beyond / n
                M[0][row] = M[row][0] = beyond
        if free:
            M[0][0], A[0][-1] = Fraction(n), Fraction(1)
        return B, A, M

    @cached_property
    def terms(self) -> tuple[int, dict[tuple[int, int], Any]]:
        """Size, and coefficients of u^(size - j - k) p^j v^k; rigid-body motions divided out."""
        scale = 6 * self.n
        B, A, M = (np.array([[int(x * scale) for x in row] for row in m]) for m in self.matrices())
        B, A, M = (m.astype(object) for m in (B, A, M))
        size = len(B)
        whole = range(size + 1)
        by_v = [_through([_determinant(B + p * A + v * M) for v in whole]) for p in whole]
        columns = [_through([row[k] for row in by_v]) for k in whole]
        found = {(j, k): c for k, column in enumerate(columns) for j, c in enumerate(column) if c}
        rigid = min(k for _, k in found)
        exact = {key: mp.mpf(c.numerator) / c.denominator for key, c in found.items()}
        return size, {(j, k - rigid): c for (j, k), c in exact.items()} | {(-1, 0): rigid}

    def growing(self, factor: Any, d: Any) -> int:
        """How many motions grow at P L^2/EI; d: c_int sqrt(M/(EI L))."""
        size, terms = self.terms
        rigid, p = terms[-1, 0], mp.mpf(factor) / self.n**2
        polynomial = [mp.mpf(0)] * (2 * size + 1)
        for (j, k), c in terms.items():
            if j < 0:
                continue
            power = size - j - k - rigid
            for m in range(power + 1 if d else 1):
                polynomial[2 * k + m] += c * p**j * mp.binomial(power, m) * mp.mpf(d) ** m
        while polynomial[-1] == 0:
            polynomial.pop()
        return _routh(polynomial[::-1]) if d else _sturm(polynomial[::-2])


def _determinant(matrix: Any) -> Any:
    """Of whole numbers, by Bareiss's elimination, which stays among them."""
    m, sign, before = matrix.copy(), 1, 1
    for k in range(len(m) - 1):
        rows = [row for row in range(k, len(m)) if m[row, k]]
        if not rows:
            return 0
        if rows[0] != k:
            m[[k, rows[0]]], sign = m[[rows[0], k]], -sign
        rest = slice(k + 1, None)
        m[rest, rest] = (m[rest, rest] * m[k, k] - np.outer(m[rest, k], m[k, rest])) // before
        before = m[k, k]
    return sign * m[-1, -1]


def _through(values: list[Any]) -> list[Fraction]:
    """Coefficients, ascending, of the polynomial with these values at 0, 1, 2, ..."""
    total, basis = [Fraction(0)] * len(values), [Fraction(1)]
    for k in range(len(values)):
        for i, part in enumerate(basis):
            total[i] += values[0] * part
        values = [after - before for before, after in pairwise(values)]
        up = [Fraction(0), *basis]
        basis = [(a - k * b) / (k + 1) for a, b in zip(up, [*basis, Fraction(0)], strict=True)]
    return total


def _routh(polynomial: list[Any]) -> int:
    """Roots with a positive real part."""
    a, b = polynomial[0::2], polynomial[1::2]
    first = [a[0]]
    while b:
        first.append(b[0])
        quotient = a[0] / b[0]
        a, b = b, [x - quotient * (b[i] if i < len(b) else 0) for i, x in enumerate(a[1:], 1)]
    return _changes(first)


def _sturm(polynomial: list[Any]) -> int:
    """Roots that are not real and negative."""
    degree = len(polynomial) - 1
    chain = [polynomial, [c * (degree - i) for i, c in enumerate(polynomial[:-1])]]
    while len(chain[-1]) > 1:
        rest, by = list(chain[-2]), chain[-1]
        while len(rest) >= len(by):
            quotient = rest[0] / by[0]
            rest = [x - quotient * (by[i] if i < len(by) else 0) for i, x in enumerate(rest)][1:]
        chain.append([-x for x in rest])
    low = [one[0] * (-1) ** (len(one) - 1) for one in chain]
    return degree - _changes(low) + _changes([one[-1] for one in chain])


def _changes(values: list[Any]) -> int:
    return sum((a > 0) != (b > 0) for a, b in pairwise(values))


chain = lru_cache(Chain)


def _judge(seed: int, n: int, boundary: str, inertia: str, share: float = 0.25) -> None:
    """A random rod of this kind: right to 1e-9 and to the estimated error, or rightly refused."""
    random = np.random.default_rng(seed)
    stiffness, length, mass = (float(x) for x in 10 ** random.uniform(-3, 4, 3))
    c = 0.0 if random.random() < share else float(10 ** random.uniform(-14, 8))
    keys = {"inertia": inertia, "mass": mass, "length": length, "bending_stiffness": stiffness}
    scene = rod(n, boundary, THRUST | {"internal_damping": {"coefficient": c}}, **keys)
    model = chain(n, boundary, inertia == "lumped")
    with mp.workdps(80):
        unit = mp.mpf(stiffness) / mp.mpf(length) ** 2
        d = mp.mpf(c) * mp.sqrt(mp.mpf(mass) / (mp.mpf(stiffness) * mp.mpf(length)))
        try:
            found = critical_load(scene)
        except AnalysisError:
            if d > 100 and n > 5:
                return  # the onset is lost in rounding
            force, errors = HIGHEST * unit, []
        else:
            force, errors = mp.mpf(found.value), [1e-9, found.error / found.value]
        words = f"seed {seed}, n = {n}, {boundary}, {inertia}, d = {mp.nstr(d, 3)}"
        if model.n > 1 or boundary == "clamped":
            assert not any(model.growing(x * force / unit, d) for x in SHARES), words
        for error in errors:
            assert not model.growing(force * (1 - mp.mpf(error)) / unit, d), words
            assert model.growing(force * (1 + mp.mpf(error)) / unit, d), words


SOME = [
    *((2, boundary, "lumped") for boundary in ("clamped", "free")),
    *((3, "clamped", "uniform"), (4, "cantilever", "uniform"), (4, "free", "uniform")),
]
# Every number of links with every boundary once, the inertias in turn, and no rigid rod.
ALL = [
    (n, boundary, ("lumped", "uniform")[(n + k) % 2])
    for n in range(1, 11)
    for k, boundary in enumerate(("clamped", "cantilever", "free"))
    if n > 1 or boundary != "cantilever"
]


@pytest.mark.parametrize(
    ("kind", "seeds"),
    [
        *((kind, range(3)) for kind in SOME),
        *(pytest.param(kind, range(3, 5), marks=pytest.mark.slow) for kind in SOME),
        *(pytest.param(kind, range(100, 107), marks=pytest.mark.nightly) for kind in ALL),
    ],
    ids=str,
)
def test_random_rods(kind: tuple[int, str, str], seeds: range) -> None:
    """From a damping of 1e-14 m^2/s, lost in the rounding of a frequency, to 1e8, and without."""
    for seed in seeds:
        _judge(seed, *kind)


def test_exact_forces() -> None:
    """8 EI/L^2 of two lumped links that are clamped, where the matrix is singular to the last bit;
    32 of two that are free, a force of the grid, and 54 of three: determinants by hand."""
    clamped = rod(2, "clamped", THRUST, inertia="lumped", **ONES)
    two, three = (rod(n, "free", THRUST, inertia="uniform", **ONES) for n in (2, 3))
    assert critical_load(clamped).value == pytest.approx(8.0, rel=1e-14)
    assert critical_load(two, bounds=(31.0, 33.0)).value == pytest.approx(32.0, rel=1e-14)
    for scene, force in ((two, 32.0), (three, 54.0)):
        found = critical_load(scene)
        assert (found.kind, found.frequency, found.modes) == ("divergence", 0.0, (1, 1))
        assert (found.value, found.load_parameter) == pytest.approx((force, force), rel=1e-12)


def test_a_heavy_column_that_thrust_holds_up() -> None:
    """Too weak a thrust lets it buckle, too strong a one lets it flutter."""
    column = rod(5, "clamped", THRUST | WEIGHT, **UPRIGHT)
    lower, upper = (
        critical_load(column, bounds=(0.0, None), end=end) for end in ("lower", "upper")
    )
    assert (lower.kind, upper.kind) == ("divergence", "flutter")
    assert lower.growth == upper.growth > 0
    window = critical_load(column, windows=True).windows
    assert window is not None
    assert np.array(window) == pytest.approx(np.array([(lower.value, upper.value)]))
    # By the eigenvalues of `natural_modes`, which know nothing of the search.
    for force, inside in ((lower.value, 1 + 1e-6), (upper.value, 1 - 1e-6)):
        for factor, grows in ((inside, False), (2 - inside, True)):
            at = {"follower": {"force": force * factor}} | WEIGHT
            growth = natural_modes(rod(5, "clamped", at, **UPRIGHT), 5).growth.max(initial=0.0)
            assert bool(growth > 0) is grows
    with pytest.raises(AnalysisError) as error:
        critical_load(column)
    assert {float(f"{force:.6g}") for force in window[0]} <= {*numbers(error.value)}
    with pytest.raises(AnalysisError):
        critical_load(column, bounds=(10.0, None), end="lower")


def test_the_next_motion_that_grows() -> None:
    """Of a search that begins above the onset: a second pair of frequencies meets."""
    scene = rod(5, "clamped", THRUST | {"internal_damping": {"coefficient": 0.0}}, **ONES)
    found = critical_load(scene, bounds=(25.0, 200.0))
    assert found.growth > 0
    model = chain(5, "clamped", lumped=False)
    with mp.workdps(80):
        counts = [model.growing(found.value * (1 + x), 0) for x in (-1e-9, 1e-9)]
        assert [model.growing(P, 0) for P in (25, 50, 70)] == [counts[0]] * 3
    assert counts[1] > counts[0] > 0
    with pytest.raises(AnalysisError, match=r"\b25\b.*\b60 N"):
        critical_load(scene, bounds=(25.0, 60.0))


GREENHILL = float(9 / 4 * mp.findroot(lambda x: mp.besselj(-1 / mp.mpf(3), x), 1.87) ** 2)


@pytest.mark.parametrize(
    ("load", "push", "g", "factor"),
    [
        ("tip", -3.0, 0.0, np.pi**2 / 4),  # Euler
        ("gravity", 0.0, 9.0, GREENHILL),
        ("all", -3.0, 0.0, np.pi**2 / 12),  # 3 EI/L^2 times it
        ("all", 0.0, 2.0, GREENHILL * 4 / (3 * 4 * 2)),  # EI over M g L^2
    ],
)
def test_dead_loads(load: str, push: float, g: float, factor: float) -> None:
    n = [5, 10, 20]
    given = UPRIGHT | {"length": 2.0, "mass": 3.0, "bending_stiffness": 4.0}
    loads: dict[str, Any] = {"tip": {"y": push}, "gravity": {"g": g}}
    found = [critical_load(rod(k, "clamped", loads, **given), load=load) for k in n]
    assert {one.kind for one in found} == {"divergence"}
    # The error falls with n^2: extrapolated twice, at n = 20 what is left is of order n^-6.
    limit = richardson(n, [one.load_parameter for one in found], order=[2, 4])
    assert limit.value == pytest.approx(factor, rel=1e-6)


@pytest.mark.slow
def test_turning_counts() -> None:
    """A free rod at rest with fins turns at any thrust; a flag leaves that out."""
    fins = {"external_damping": {"coefficient": 0.5, "fin_factor": {"tail": 20.0}}}
    scene = rod(6, "free", THRUST | fins)
    found, bent = critical_load(scene), critical_load(scene, elastic=True)
    assert (found.kind, found.frequency) == ("turning", 0.0)
    assert found.value + found.error < 0.1 * bent.value
    assert bent.kind != "turning"
    assert bent.elastic


def test_error_of_a_frequency_is_a_share_of_it() -> None:
    """A rod that is 1e8 times as stiff is the same one in other units of time."""
    stiff = ONES | {"bending_stiffness": 1e8}
    found = [critical_load(rod(6, "clamped", THRUST, **given)) for given in (ONES, stiff)]
    shares = [one.frequency_error / one.frequency for one in found]
    assert found[1].frequency == pytest.approx(1e4 * found[0].frequency, rel=1e-6)
    # Roundings are others; of an error of the squared frequency the shares would be as 1 to 1e4.
    assert 0.01 < shares[1] / shares[0] < 100


def test_only_digits_that_hold_are_printed() -> None:
    assert format_with_error(8.094074512345678, 1e-9) == "8.09407451"
    assert format_with_error(8.094074512345678, 1e-15) == "8.09407451235"
    assert format_with_error(8.094074512345678, 1.0) == "8.09"
    assert format_with_error(0.0, 0.1) == "0"


def _flutter_of_two_bodies(n: int) -> float:
    """Thrust [N] at which a clamped rod of n massless links, EI = L = 1, with bodies of 0.1 and
    1 kg at its middle and its tail flutters: where both rates by its flexibility meet."""
    l, ends = 1.0 / n, np.array([n // 2, n])
    joints = np.arange(n)
    # Moment about joint s of a lateral force at joint j, and of the places behind it.
    B = np.maximum(ends - joints[:, None], 0.0) * l
    places = (joints[None, :] < ends[:, None]) * l
    springs = np.diag(np.full(n, 1.0 / l)) - np.diag(np.full(n - 1, 1.0 / l), -1)
    springs[0, 0] *= 2

    def discriminant(thrust: float) -> float:
        # The thrust pushes forward along the last link: its place turns, its direction turns back.
        behind = (joints[None, :] >= joints[:, None]) * l
        pushed = thrust * behind
        pushed[:, -1] -= thrust * (n - joints) * l
        G = places @ np.linalg.solve(springs - pushed, B) * [0.1, 1.0]
        return float(np.trace(G) ** 2 - 4 * np.linalg.det(G))

    return float(brentq(discriminant, 10.0, 20.0, xtol=1e-13))


@pytest.mark.slow
@pytest.mark.parametrize("n", [40, 60])
def test_flutter_of_bodies_on_a_rod_without_weight(n: int) -> None:
    """Rounding leaves six digits of a rate there, and Newton's method goes to and fro within it."""
    bodies = [{"name": "a", "at": 0.5, "mass": 0.1}, {"name": "b", "at": 1.0, "mass": 1.0}]
    table = {"links": n, "length": 1.0, "mass": 1e-6, "bending_stiffness": 1.0}
    scene = Scene.from_dict(
        {"name": "light", "rod": table | {"boundary": "clamped"}, "bodies": bodies}
        | {"loads": THRUST, "integrate": {"span": [0.0, 1.0]}}
    )
    # The mass of the rod is a hundred-thousandth of the lighter body's.
    assert critical_load(scene).value == pytest.approx(_flutter_of_two_bodies(n), rel=1e-5)
