"""Table 3.3: a cantilever under its own weight."""

from __future__ import annotations

from pandas import DataFrame

from rodgen.analyse.references import continuum
from rodgen.analyse.statics import static_equilibrium
from rodgen.integrate import simulate
from rodgen.scene import Scene
from rodgen_evidence.thesis import data, scenes
from rodgen_evidence.thesis.percentages import base_of
from rodgen_evidence.thesis.table import VERDICT, Remark, ThesisTable, beside, column

LINKS = 50
GRAVITY = 9.81  # m/s^2
SETTLING = 40.0  # s
DAMPING = 6.0  # 1/s: near critical for the first mode, so that it comes to rest soon
STEP = 2e-5  # s, of the semi-implicit Euler method; its limit is 2.9e-5 s

COLUMNS = (
    column("name", "tip"),
    column("unit", "unit"),
    column("thesis_analytical", "thesis: analytical", "", ".4f"),
    column("thesis", "thesis: simulated", "", ".4f"),
    column("simulated", "ours: simulated to rest", "", ".6f"),
    column("discrete", "ours: static equilibrium, n = 50", "", ".8f"),
    column("model_continuum", "continuum, linear: q = m g/L, length L - L/n", "", ".6f"),
    column("continuum", "continuum, linear: q = m g/L, length L", "", ".6f"),
    column("deviation", "thesis against equilibrium", "%", "+.3f"),
    VERDICT,
)


def cantilever(links: int, boundary: str = "cantilever", settling: bool = False) -> Scene:
    """The rod of 3.2; settling: with external damping that brings it to rest."""
    loads: dict[str, dict[str, float]] = {"gravity": {"g": GRAVITY}}
    if settling:
        loads["external_damping"] = {"coefficient": DAMPING}
    return scenes.long_rod(
        links,
        boundary,
        mass=scenes.WEIGHED,
        loads=loads,
        method="semi_implicit_euler",
        step=STEP * (LINKS / links) ** 2,
        span=[0.0, SETTLING],
        output_every=SETTLING / 10,
    )


def table_3_3() -> ThesisTable:
    """Deflection [m] and rotation [rad] of the tip, simulated and in equilibrium."""
    exact = static_equilibrium(cantilever(LINKS))
    motion = simulate(cantilever(LINKS, settling=True))
    length = scenes.LENGTH * (1 - 1 / LINKS)
    q = scenes.WEIGHED * GRAVITY / scenes.LENGTH
    whole, short = (
        continuum.linear_own_weight(load=q, length=L, bending_stiffness=scenes.STIFFNESS)
        for L in (scenes.LENGTH, length)
    )
    rows = DataFrame(
        {
            "unit": ["m", "rad"],
            "simulated": [-motion.tip[-1, 1], -motion.phi[-1, -1]],
            "discrete": [-exact.tip[1], -exact.phi[-1]],
            "model_continuum": [short.deflection, short.slope],
            "continuum": [whole.deflection, whole.slope],
            "name": data.TABLE_3_3["name"],
            "thesis_analytical": data.TABLE_3_3["analytical"].astype(float),
        }
    )
    rows = beside(rows, data.TABLE_3_3["simulated"])
    table = ThesisTable("3.3", "Cantilever under its own weight", COLUMNS, rows)
    table.conditions = ["L = 5 m, EI = 100 N m^2, m = 50 g, 50 links, g = 9.81 m/s^2"]
    table.assumed = [
        f"External damping of {DAMPING:g} 1/s, {SETTLING:g} s, semi-implicit Euler steps of "
        f"{STEP:g} s: the thesis does not say how its rod came to rest."
    ]
    table.curve = [(float(x), float(y)) for x, y in exact.joints]
    table.notes = _notes(float(exact.tip[1]), short.deflection, length, q)
    return table


def _notes(tip: float, short: float, length: float, q: float) -> list[Remark]:
    # All curvature of the half link before the first spring is taken by that spring as well.
    link = scenes.LENGTH - length
    softer = q * length**2 / 2 * link / 2 / scenes.STIFFNESS * length
    return [
        Remark(
            "shown",
            "(3.1) and (3.2) spread the whole mass over L - L/n and so take q too large by "
            f"n/(n-1), {100 / (LINKS - 1):.1f} %; the links that move weigh m g/L per metre.",
        ),
        Remark(
            "shown",
            f"The simulated deflection is larger than that of the clamped rod of the same length, "
            f"{short:.5f} m, because the first spring, one link from the wall, turns for a whole "
            f"link instead of half a one: by q l^2/2 (L/2n)/EI l = {softer:.5f} m, in sum "
            f"{short + softer:.5f} m against {-tip:.5f} m of the model.",
        ),
        Remark(
            "consistent",
            f"The deflection is {-tip:.5f} m, which rounds to 0.0736. The printed 0.0735 would be "
            f"cut off, or made with g = 9.8 m/s^2 ({-tip * 9.8 / GRAVITY:.5f} m), or read before "
            "the rod had come to rest.",
        ),
        Remark("found", base_of("3.3")),
    ]
