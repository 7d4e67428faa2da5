"""The fixed set of `make report`: scenes that differ in what makes them hard."""

from __future__ import annotations

import tomllib
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, cast

from rodgen_evidence.thesis.scenes import LONG

Tables = dict[str, Any]
SCENES = Path(__file__).parents[4] / "scenes"
ROD = cast("dict[str, float]", LONG)  # that of the thesis, in all sections


@dataclass(frozen=True)
class Case:
    """A scene of the set, and what it is there for; quick: it is in the short report too."""

    scene: Tables
    why: str
    quick: bool = False

    @property
    def name(self) -> str:
        """The scene's."""
        return str(self.scene["name"])

    def given(self, folder: str | Path, **more: Any) -> dict[str, Any]:
        """Arguments of what measures it; folder: where its reference is kept."""
        return {"name": self.name, "table": self.scene, "folder": str(folder), **more}


def rod(name: str, links: int, span: float, **tables: Any) -> Tables:
    """ROD, free and slightly bent, if not told otherwise."""
    return {
        "name": name,
        "rod": {"links": links, **ROD, **tables.pop("rod", {})},
        "initial": {"phi": "0.01*cos(pi*s)"},
        "integrate": {"span": [0.0, span]},
        **tables,
    }


def free(links: int, span: float) -> Tables:
    """Without loads: energy, momentum and angular momentum stay what they are."""
    bent = {"phi": "0.3*cos(pi*s)", "omega": "0.5*(s - 0.5)"}
    return rod(f"free_n{links}", links, span, initial=bent)


def rod_under_thrust(name: str, force: float) -> Tables:
    """Rod under end thrust [N]; with 50 links it flutters from 437.68 N on."""
    return rod(name, 50, 2.5, loads={"follower": {"force": force}})


def damped_rod(links: int, coefficient: float, span: float) -> Tables:
    """Rod under thrust with internal damping [m^2/s] far beyond what its fast modes can bear."""
    loads = {"follower": {"force": 300.0}, "internal_damping": {"coefficient": coefficient}}
    return rod(f"damped_n{links}", links, span, loads=loads)


def of_file(name: str) -> Tables:
    """A scene of scenes/, as far as every method has it: but for how it is integrated."""
    table = tomllib.loads((SCENES / f"{name}.toml").read_text(encoding="utf-8"))
    return {**table, "integrate": {"span": table["integrate"]["span"]}}


def beck() -> Tables:
    """Beck's column, clamped upright, under 1.12 of its critical force: it flutters."""
    return rod(
        "becks_column",
        20,
        5.0,
        rod={"mass": 20.0, "boundary": "clamped", "clamp_angle": 1.5707963267948966},
        loads={"follower": {"force": 90.0}},
        initial={"phi": "pi/2 + 0.01*s"},
    )


def falling_chain() -> Tables:
    """A chain without stiffness that falls from the horizontal: motion is chaotic."""
    return rod(
        "falling_chain",
        10,
        2.5,
        rod={"length": 1.0, "bending_stiffness": 0.0, "mass": 1.0, "boundary": "pinned"},
        loads={"gravity": {"g": 9.81}},
        initial={"phi": 0.0},
    )


# Spans fall as the links grow: their fastest motion quickens with n^2.
_SET: tuple[tuple[Callable[[], Tables], str, bool], ...] = (
    (lambda: free(10, 10.0), "conservative free rod", False),
    (lambda: free(20, 10.0), "conservative free rod", True),
    (lambda: free(50, 2.5), "conservative free rod", False),
    (lambda: free(200, 0.2), "conservative free rod, many links", False),
    (lambda: free(1000, 0.01), "conservative free rod, very many links", False),
    (
        lambda: rod_under_thrust("below_flutter", 300.0),
        "thrust of 0.69 of the critical force",
        False,
    ),
    (lambda: rod_under_thrust("at_flutter", 437.68), "thrust at the critical force", False),
    (
        lambda: rod_under_thrust("above_flutter", 500.0),
        "thrust of 1.14 of the critical force",
        False,
    ),
    (lambda: of_file("missile"), "the damped missile", False),
    (beck, "Beck's column beyond its critical force", False),
    (lambda: of_file("ivp_beam"), "problem Beam of the Test Set for IVP Solvers", False),
    (falling_chain, "chaotic: errors grow until nothing is left", False),
    (lambda: damped_rod(50, 5.0, 10.0), "strong internal damping: stiff", True),
    (lambda: damped_rod(200, 5.0, 10.0), "strong internal damping: stiff, many links", False),
    (lambda: damped_rod(1000, 5.0, 1.0), "strong internal damping: stiff, very many links", False),
)


def cases(quick: bool = False) -> list[Case]:
    """The set, or its short form."""
    return [Case(make(), why, short) for make, why, short in _SET if short or not quick]
