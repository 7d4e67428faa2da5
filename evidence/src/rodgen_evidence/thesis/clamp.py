"""A better clamp: `clamped` beside the thesis's `cantilever`, which loses a link to the wall."""

from __future__ import annotations

from pandas import DataFrame

from rodgen.analyse.critical import critical_load
from rodgen.analyse.extrapolation import richardson
from rodgen.analyse.modes import natural_modes
from rodgen.analyse.references import continuum, follower_columns
from rodgen.analyse.references.elastica import own_weight
from rodgen.analyse.statics import static_equilibrium
from rodgen_evidence.page_tables import Column
from rodgen_evidence.thesis import scenes
from rodgen_evidence.thesis.static_deflection import GRAVITY, cantilever
from rodgen_evidence.thesis.table import Remark, ThesisTable, column, percent

LINKS = (5, 10, 20, 40, 80)
# With the exponents of 1/n that their errors have: all, or by the symmetry of their rule every
# second.
EXPONENTS = {"cantilever": (1, 2, 3, 4), "clamped": (2, 4, 6, 8)}
BOUNDARIES = tuple(EXPONENTS)
FREQUENCIES = 3
DEFLECTION = "deflection, nonlinear [m]"


def columns_of(links: tuple[int, ...]) -> tuple[Column, ...]:
    """The columns for these numbers of links."""
    return (
        column("quantity", "quantity"),
        column("boundary", "clamp"),
        *(column(f"n{n}", f"n = {n}", "", ".6f") for n in links),
        column("limit", "extrapolated", "", ".8f"),
        column("limit_error", "its estimated error", "", ".1g"),
        column("continuum", "continuum", "", ".8f"),
        column("order", "observed order", "", ".2f"),
        column("error", f"error at n = {links[-1]}", "%", "+.3g"),
    )


def values(boundary: str, links: int) -> dict[str, float]:
    """The quantities that are compared, of a rod of that many links."""
    # Without thrust, but with its term: one module for frequencies and load.
    modes = natural_modes(scenes.thrust(links, boundary, force=0.0), FREQUENCIES)
    tip = static_equilibrium(cantilever(links, boundary)).tip
    load = critical_load(scenes.thrust(links, boundary)).value
    frequencies = {f"f{k + 1} [Hz]": float(f) for k, f in enumerate(modes.frequencies)}
    return frequencies | {DEFLECTION: -float(tip[1]), "Beck's load [N]": float(load)}


def exact() -> dict[str, float]:
    """The quantities that are compared, of the continuum."""
    frequencies = {
        f"f{k} [Hz]": float(continuum.natural_frequency("clamped", k, **scenes.LONG))
        for k in range(1, FREQUENCIES + 1)
    }
    load = scenes.WEIGHED * GRAVITY * scenes.LENGTH**2 / scenes.STIFFNESS  # q L^3 / EI
    return frequencies | {
        DEFLECTION: float(own_weight(load).y) * scenes.LENGTH,
        "Beck's load [N]": float(follower_columns.beck().dimensional(**scenes.LONG)[0]),
    }


def table_clamp(links: tuple[int, ...] = LINKS) -> ThesisTable:
    """Table of both clamps side by side."""
    truth = exact()
    found = {boundary: [values(boundary, n) for n in links] for boundary in BOUNDARIES}
    rows = DataFrame(
        [
            _row(name, boundary, links, [v[name] for v in found[boundary]], truth[name])
            for name in truth
            for boundary in BOUNDARIES
        ]
    )
    table = ThesisTable("clamp", "Two clamps", columns_of(links), rows)
    table.conditions = ["L = 5 m, EI = 100 N m^2; g = 9.81 m/s^2 and m = 50 g for the deflection"]
    linear = continuum.linear_own_weight(
        load=scenes.WEIGHED * GRAVITY / scenes.LENGTH,
        length=scenes.LENGTH,
        bending_stiffness=scenes.STIFFNESS,
    ).deflection
    table.assumed = [
        f"m = {scenes.MASS:g} kg for the frequencies; Beck's load needs no mass.",
        "The deflection, of the links and of the continuum, is that of large rotations, "
        f"{truth[DEFLECTION]:.7f} m; linear, q L^4/(8 EI) as in table 3.3, it is {linear:.7f} m.",
    ]
    of_f1 = rows[rows["quantity"] == "f1 [Hz]"].set_index("boundary")
    orders, errors = (of_f1[key][list(BOUNDARIES)] for key in ("order", "error"))
    table.notes = [
        Remark(
            "shown",
            f"The clamp of the thesis converges with the observed order {orders.iloc[0]:.2f}, the "
            f"root spring of stiffness 2 EI n/L with {orders.iloc[1]:.2f}; with as many links its "
            f"f1 is {abs(errors.iloc[0] / errors.iloc[1]):.0f} times closer.",
        )
    ]
    return table


def _row(
    name: str, boundary: str, links: tuple[int, ...], found: list[float], truth: float
) -> dict[str, float | str]:
    limit = richardson(links, found, EXPONENTS[boundary])
    return {
        "quantity": name,
        "boundary": boundary,
        **{f"n{n}": value for n, value in zip(links, found, strict=True)},
        "limit": limit.value,
        "limit_error": limit.error,
        "continuum": truth,
        "order": limit.orders[-1],
        "error": percent(found[-1], truth),
    }
