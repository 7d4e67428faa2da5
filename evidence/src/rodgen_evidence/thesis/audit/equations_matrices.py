"""Equations 2.41 to 2.45, 2.51, 2.53, 2.61 and 2.65 as printed: matrices and loads in them."""

from __future__ import annotations

from collections.abc import Callable

from sympy import Expr, Integer, Rational, S, cos, sin

from rodgen.derive.symbols import k, l, m, vx0, vy0
from rodgen_evidence.thesis.audit.claim import READ, Claim, Entries
from rodgen_evidence.thesis.audit.equations_energy import (
    HALF,
    derived_rates,
    matrix_rows,
)
from rodgen_evidence.thesis.audit.truth import Column, Matrix, flat, omega, phi, product, truth

TWO_LINKS = range(2, 7)  # n for which the first and the last row of K and D_i are two
EVERY = ("internal_damping", "external_damping", "follower", "gravity")
SPREAD = range(4, 7)  # n for which columns 0, 1, 2 and n-1 of 2.44 are four


def row_name(n: int, at: int) -> str:
    """Name of a row of the equations of motion, and of the rates after them."""
    return f"row {_coordinate(at)}" if at < n + 2 else f"d{_coordinate(at - n - 2)}/dt"


def _coordinate(at: int) -> str:
    return ("x0", "y0")[at] if at < 2 else f"phi_{at - 2}"


def entry_of(columns: Callable[[int], int]) -> Callable[[int, int], str]:
    """Names of the entries of a matrix with so many columns."""

    def name(n: int, at: int) -> str:
        row, column = divmod(at, columns(n))
        return f"row {row}, column {column}"

    return name


def weight(n: int, i: int) -> int:
    return 1 + 2 * (n - i - 1)


def tridiagonal(n: int, factor: Expr) -> Matrix:
    """2.42 and 2.52: two rows of zeros, then -1, 2, -1, with 1 at both ends."""
    rows = [[S.Zero] * n for _ in range(n + 2)]
    for i in range(n):
        for j in range(max(i - 1, 0), min(i + 2, n)):
            rows[i + 2][j] = -factor if i != j else 2 * factor
    rows[2][0] = rows[n + 1][n - 1] = factor
    return rows


def mass_matrix(n: int) -> Matrix:
    """Mass matrix that 2.43 should be, by 2.24 to 2.26 put right."""
    x = [-l * sin(phi[i]) * weight(n, i) for i in range(n)]
    y = [l * cos(phi[i]) * weight(n, i) for i in range(n)]
    rows = [[Integer(2 * n), S.Zero, *x], [S.Zero, Integer(2 * n), *y]]
    for i in range(n):
        links = [l**2 * weight(n, max(i, j)) * cos(phi[i] - phi[j]) for j in range(n)]
        links[i] = 2 * l**2 * (Rational(1, 3) + n - i - 1)
        rows.append([x[i], y[i], *links])
    return [[HALF * m * entry for entry in row] for row in rows]


def quadratic(n: int, factor: Expr, last: int) -> Matrix:
    """2.44 with its factor, and its weight of the last column and row."""

    def w(i: int) -> int:
        return last if i == n - 1 else weight(n, i)

    rows = [[l * cos(phi[j]) * w(j) for j in range(n)], [l * sin(phi[j]) * w(j) for j in range(n)]]
    for i in range(n):
        rows.append([l**2 * sin(phi[j] - phi[i]) * w(max(i, j)) for j in range(n)])
    return [[factor * entry for entry in row] for row in rows]


def balance(loads: Callable[[int], Column]) -> Entries:
    """M v' - (Q omega^2 - K phi + loads), row by row, with the loads as printed."""

    def rows(n: int) -> Column:
        return [row - load for row, load in zip(matrix_rows(n), loads(n), strict=True)]

    return rows


def equilibrium(*loads: str) -> Entries:
    """d/dt dL/du - dL/dq less the generalised forces of the loads of these names, which come from
    their laws by virtual power: no sign and no vector of a printed form is in them."""

    def rows(n: int) -> Column:
        t = truth(n)
        return [
            row - sum((t.forces[name][at] for name in loads), S.Zero)
            for at, row in enumerate(t.lagrange_rows)
        ]

    return rows


def with_rates(rows: Entries) -> Entries:
    """Rows, then the lines d phi/dt = omega and d s/dt = v as printed: their right sides."""
    return lambda n: [*rows(n), vx0, vy0, *omega[:n]]


def with_derived_rates(rows: Entries) -> Entries:
    """Rows, then the time derivatives of the coordinates of the derivation."""
    return lambda n: [*rows(n), *derived_rates(n)]


def damping(n: int) -> Column:
    """- D_i omega."""
    return [-e for e in product(truth(n).D_i, list(omega[:n]))]


def medium(n: int) -> Column:
    """- D_e."""
    return [-e for e in truth(n).D_e]


def every_load(n: int) -> Column:
    """- D_i omega - D_e + F + A."""
    loads = zip(damping(n), medium(n), truth(n).F, truth(n).A, strict=True)
    return [sum(load, S.Zero) for load in loads]


def summed_rows(n: int) -> Column:
    """2.65: - D_i - D_e omega + F + A, made a sum by rows of D_i summed and D_e times (v, omega)
    row by row."""
    t = truth(n)
    inner = [sum(row, S.Zero) for row in t.D_i]
    outer = [e * u for e, u in zip(t.D_e, t.rates, strict=True)]
    return [f + a - d - e for f, a, d, e in zip(t.F, t.A, inner, outer, strict=True)]


def load_claim(
    number: str, title: str, load: str, printed: Callable[[int], Column], text: str
) -> Claim:
    """The printed term, made of the derived vector or matrix, beside the load of that name."""
    return Claim(
        number,
        f"{title} in the equations",
        {READ: balance(printed)},
        equilibrium(load),
        printed=r"\mathbf{M} \frac{d}{dt}(v + \omega) = \mathbf{Q}\omega^2 - \mathbf{K}\varphi "
        + text,
        note="The derived vector or matrix is inserted, and compared with the work of the load.",
        label=row_name,
    )


RATES = r" \quad \frac{d}{dt}\varphi = \omega, \quad \frac{d}{dt}s = v"
ROWS = (
    r"\begin{bmatrix} 0 & 0 & 0 & \dots & 0 & 0 \\ 0 & 0 & 0 & \dots & 0 & 0 \\ 1 & -1 & & & & \\ "
    r"-1 & 2 & -1 & & & \\ & \ddots & \ddots & \ddots & & \\ & & & -1 & 2 & -1 \\ "
    r"& & & & -1 & 1 \end{bmatrix}"
)

CLAIMS: tuple[Claim, ...] = (
    Claim(
        "2.41",
        "equations of motion with matrices",
        {READ: with_rates(matrix_rows)},
        with_derived_rates(equilibrium()),
        printed=r"\mathbf{M} \frac{d}{dt}(v + \omega) = \mathbf{Q}\omega^2 - \mathbf{K}\varphi, "
        + RATES,
        note=(
            "Compared with the derived M, Q and K. The form of the equation is right, "
            "independent of 2.43 and 2.44. v + omega means one vector after the other, s means "
            "x0, y0."
        ),
        label=row_name,
    ),
    Claim(
        "2.42",
        "stiffness matrix",
        {READ: lambda n: flat(tridiagonal(n, k))},
        lambda n: flat(truth(n).K),
        links=TWO_LINKS,
        printed=r"\mathbf{K} = k " + ROWS,
        note="A single link has no spring.",
        label=entry_of(lambda n: n),
    ),
    Claim(
        "2.43",
        "mass matrix",
        {},
        lambda n: flat(truth(n).M),
        corrected=lambda n: flat(mass_matrix(n)),
        correction=r"\mathbf{M} = \frac{m}{2} [M_{ij}], \quad w_i = 1 + 2(n-i-1), \quad "
        r"M_{00} = M_{11} = 2n, \quad M_{0i} = -l \sin(\varphi_i) w_i, \quad "
        r"M_{1i} = l \cos(\varphi_i) w_i, \quad M_{ii} = 2 l^2 (\frac{1}{3} + n-i-1), \quad "
        r"M_{ij} = l^2 \cos(\varphi_i - \varphi_j) w_{\max(i,j)}",
        note=(
            "The number 2.43 and the matrix M, which belong between 2.42 and 2.44, are not in "
            "the available text. M is described in words before 2.42. Hypothesis: lost in "
            "scanning."
        ),
        label=entry_of(lambda n: n + 2),
    ),
    Claim(
        "2.44",
        "matrix of the squared angular velocities",
        {
            "factor 1/2 as printed": lambda n: flat(quadratic(n, HALF, weight(n, 0))),
            "factor m/2": lambda n: flat(quadratic(n, HALF * m, weight(n, 0))),
        },
        lambda n: flat(truth(n).Q),
        corrected=lambda n: flat(quadratic(n, HALF * m, 1)),
        links=SPREAD,
        repairs=(
            "Every entry stands on two lines, with its weight below it. It was probably typeset "
            "so. The lines are joined.",
            "The zeros of the diagonal have a weight below them too, probably typeset so. They "
            "are still zeros.",
            "Dots are filled by the pattern of row and column i. The matrix is written here in "
            "the same way.",
        ),
        printed=r"\mathbf{Q} = \frac{1}{2} [Q_{ij}], \quad Q_{0j} = l \cos\varphi_j w_j, \quad "
        r"Q_{1j} = l \sin\varphi_j w_j, \quad Q_{ij} = l^2 \sin(\varphi_j - \varphi_i) "
        r"w_{\max(i,j)}, \quad w_i = (1 + 2(n-i-1)) \text{ for } i < n-1, \quad "
        r"w_{n-1} = (1 + 2(n-1))",
        correction=r"\mathbf{Q} = \frac{m}{2} [Q_{ij}], \quad w_{n-1} = 1",
        note=(
            "The weight of the last column and row is that of the first link. It must be 1 + "
            "2(n-(n-1)-1) = 1. The factor lacks the mass m, without which Q omega^2 is not a "
            "force. Compared from n = 4 on, because for smaller n columns 0, 1, 2 and n-1 of the"
            " print coincide."
        ),
        label=entry_of(lambda n: n),
    ),
    load_claim("2.45", "follower force", "follower", lambda n: truth(n).F, r"+ \mathbf{F}"),
    load_claim("2.51", "internal damping", "internal_damping", damping, r"- \mathbf{D}_i \omega"),
    load_claim("2.53", "external damping", "external_damping", medium, r"- \mathbf{D}_e"),
    load_claim("2.61", "gravity", "gravity", lambda n: truth(n).A, r"+ \mathbf{A}"),
    Claim(
        "2.65",
        "equations of motion with all loads",
        {"rows of D_i summed, D_e times (v, omega) row by row": with_rates(balance(summed_rows))},
        with_derived_rates(equilibrium(*EVERY)),
        corrected=with_rates(balance(every_load)),
        printed=r"\mathbf{M} \frac{d}{dt}(v + \omega) = \mathbf{Q}\omega^2 - \mathbf{K}\varphi "
        r"- \mathbf{D}_i - \mathbf{D}_e\omega + \mathbf{F} + \mathbf{A}, " + RATES,
        correction=r"- \mathbf{D}_i \omega - \mathbf{D}_e \text{ in place of } "
        r"- \mathbf{D}_i - \mathbf{D}_e \omega",
        note=(
            "The factor omega stands at D_e instead of D_i. As printed, the sum is not defined: "
            "D_i is a matrix of n+2 rows and n columns, D_e is a vector. The reading that is "
            "compared is an assumption of this audit, made to show a difference. 2.51 and 2.53, "
            "of which 2.65 is composed, are right. Its lines for the rates are compared too, and"
            " are right."
        ),
        label=row_name,
    ),
)
