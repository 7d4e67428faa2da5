"""Rows of a report that are made up: runs on straight lines, costs that grow with n, failures."""

from __future__ import annotations

import math

from rodgen.analyse.precision.contestant import Measurement
from rodgen_evidence.report.unit import Measured

NASTY = "it said <script>alert('1 & 2')</script>"
MADE = {
    "quick": True,
    "seconds": 171.4,
    "machine": {"processor": "Some <Processor> at 3 GHz", "C flags": "-O3 -march=native"},
    "versions": {"rodgen": "0.1.0", "numpy": "2.1.0", "heyoka": "not installed"},
    "threads": 1,
    "scenes": {"missile": "the damped <missile>"},
}
OURS = {"gauss": 6, "radau": 5, "dop853": 8, "rk4": 4, "semi_implicit_euler": 1, "euler": 1}
THEIRS = {"SciPy": "DOP853", "heyoka": "Taylor", "MuJoCo": "RK4", "CasADi": "cvodes"}
FIXED = ("rk4", "semi_implicit_euler", "euler")
SCENES = {"free_n20": 20, "below_flutter": 50, "damped_n200": 200, "missile": 20}


def setting(scene: str, who: str, method: str, target: str, order: int, at: int) -> Measurement:
    """A point on a straight line: halving the step divides the error by 2^order."""
    fixed = method in FIXED
    value = 0.01 / 2**at if fixed else 10.0 ** -(at + 2)
    steps = 1000 * 2**at if fixed else int(300 * 10 ** (at / max(order, 2)))
    slow = {"c": 1.0, "numpy": 60.0}.get(
        target, 2.0 + 3.0 * list(THEIRS).index(who) if who in THEIRS else 1.0
    )
    error = max(3e-13, 0.2 * (2.0 ** -(order * at) if fixed else 10.0 ** -(1.1 * at)))
    return {
        "scene": scene,
        "n": SCENES[scene],
        "who": who,
        "method": method,
        "target": target,
        "kind": "step" if fixed else "rtol",
        "setting": value,
        "order": order,
        "seconds": steps * 1e-6 * slow * (1 + order / 8) * SCENES[scene] / 20,
        "rounds": 5,
        "inside": None,
        "error_phi": error,
        "error_angles": 1.1 * error,
        "error_rates": 20 * error,
        "error_tail": 1.3 * error,
        "error_modes": 0.4 * error,
        "error_energy": 0.1 * error**1.1,
        "balance": 0.1 * error if who == "rodgen" else None,
        "nsteps": steps,
        "rejected": None if fixed else steps // 20,
        "nfev": steps * max(order, 1),
        "njev": steps if method in ("gauss", "radau") else None,
        "nlu": None,
        "setup_generate": 1.5 if who == "rodgen" else None,
        "setup_compile": 80.0 / 3 if who == "heyoka" else 0.7,
        "agreed": None if who == "rodgen" else 3.1e-15,
        "failed": "",
    }


def precision(scene: str) -> list[Measurement]:
    ours = [("rodgen", m, t, o) for m, o in OURS.items() for t in ("c", "numpy")]
    theirs = [(who, m, "rodgen's c" if who == "SciPy" else who, 6) for who, m in THEIRS.items()]
    rows = [setting(scene, *who, at) for who in (*ours, *theirs) for at in range(7)]
    broken = {key: None for key in rows[0] if key.startswith("error_")}
    return [*rows, {**rows[-1], **broken, "seconds": None, "setting": 1e-15, "failed": NASTY}]


def reference(scene: str) -> Measurement:
    estimates = {f"estimate_{name}": 2e-12 for name in ("phi", "tail", "modes", "energy")}
    checked = {"checked_by": "Taylor series", "check_phi": 1.5e-12}
    made = {"method": "extrapolation", "order": 16, "tolerance": 1e-18, "nfev": 10**6}
    start: Measurement = {"scene": scene, "n": SCENES[scene], "seconds": 3.2, "failed": ""}
    return {**start, **made, **estimates, **checked}


def others() -> dict[str, list[Measurement]]:
    t = [0.05 * k for k in range(101)]
    chaos = [min(1e-14 * math.exp(8 * x), 2.0) for x in t]
    chaos[0] = 0.0
    grow: Measurement = {"scene": "falling_chain", "n": 10, "method": "dop853", "setting": 1e-12}
    sizes = (10, 20, 50, 200, 1000)
    costs: list[Measurement] = [
        {"what": what, "who": who, "n": n, "seconds": a * n**b, "rounds": 5, "failed": ""}
        for what in ("rhs", "implicit step")
        for who, a, b in (("rodgen, C", 1e-8, 1), ("rodgen, NumPy", 1e-6, 0.6), ("CasADi", 1e-7, 2))
        for n in sizes
    ]
    left: list[Measurement] = [
        {"scene": s, "n": n, "variant": v, "operations": 900 * n * f, "source_bytes": 40000 * f}
        | {"object_bytes": 9000 * f, "generate": 1.2 * f, "compile": 0.8 * f, "failed": ""}
        | {"rhs": 2e-8 * n * f, "run": 0.01 * n * f}
        for s, n in SCENES.items()
        for v, f in (("as the scene", 1.0), ("every term, at zero", 2.5))
    ]
    steps: list[Measurement] = [
        {"method": m, "n": n, "damping": d, "damping_ratio": r, "rate": 40.0 * n**2}
        | {"found": c / (40.0 * n**2) * (1.3 if (m, n) == ("rk4", 50) else 1.0005)}
        | {"theory": c / (40.0 * n**2), "how": "bisection", "failed": ""}
        | {"off": 0.3 if (m, n) == ("rk4", 50) else 0.0005}
        for d, r in (("none", 0.0), ("strong", 3.0))
        for m, c in (("rk4", 2.83), ("semi_implicit_euler", 2.0), ("dop853", 5.96))
        for n in sizes
    ]
    outcomes = ("right", "right", "stopped", "refused", "warned", "lost")
    methods = ("gauss", "radau", "dop853", "rk4", "euler", "auto")
    extremes: list[Measurement] = [
        {"group": g, "case": f"{g} {10.0**e:g}", "n": 20, "target": "c", "method": m}
        | {"outcome": o, "digits": 9.3 if o == "right" else None, "condition": 1e3}
        | {"seconds": 0.1, "said": "" if o == "right" else f"{o}: the step became too small"}
        for g in ("bending stiffness", "mass", "follower force")
        for k, e in enumerate((-12, -6, 0, 6, 12))
        for i, m in enumerate(methods)
        for o in (outcomes[(i * k) % len(outcomes)],)
    ]
    extremes.append({**extremes[0], "case": "folded back", "outcome": "wrong", "said": NASTY})
    rounding: list[Measurement] = [
        {
            "group": "length",
            "case": f"L = {10.0**e:g} m",
            "n": n,
            "form": f,
            "ulps": 2.0 * 4 ** (e % 7),
        }
        | {"ulps_input": 1.5 if f != "numpy dense" else 0.7, "condition": 10.0 ** (e % 9)}
        | {"failed": ""}
        for e in (-6, 0, 6)
        for n in (3, 1000)
        for f in ("c", "numpy chain", "numpy dense")
    ]
    duel: Measurement = {"scene": "free_n20", "n": 20, "asked": 1e-6, "ours": "dop853 in C"}
    duel |= {"ours_error": 8e-7, "ours_seconds": 0.02, "theirs": "heyoka Taylor"}
    duel |= {"theirs_error": 5e-7, "theirs_seconds": 0.25, "ratio": 12.5, "rounds": 9, "failed": ""}
    lost = {**duel, "scene": "missile", "theirs": "SciPy LSODA", "ratio": 0.8}
    return {
        "growth": [{**grow, "t": t, "error": chaos, "rate": 8.0, "failed": ""}],
        "equal_error": [duel, lost],
        "costs": costs,
        "leaving_out": left,
        "install": [{"what": "plain", "seconds": 0.1, "bytes": 3 * 10**6, "failed": ""}],
        "steps": steps,
        "extremes": extremes,
        "rounding": rounding,
    }


def made_up(scenes: tuple[str, ...] = ("free_n20", "missile")) -> dict[str, list[Measured]]:
    def unit(section: str, name: str, rows: list[Measurement], failed: str = "") -> Measured:
        return Measured(section, f"{section}-{name}", "f", 1.25, rows, failed)

    contents = {
        "references": [unit("references", s, [reference(s)]) for s in scenes],
        "precision": [unit("precision", s, precision(s)) for s in scenes],
    }
    contents["precision"].append(unit("precision", "missile-exudyn", [], "crashed <b>SIGSEGV</b>"))
    for section, rows in others().items():
        contents[section] = [unit(section, "all", rows)]
    return contents
