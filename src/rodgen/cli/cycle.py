"""rodgen cycle: the periodic motion that a scene settles on, its stability, and branches."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from rodgen.cli.console import out, print_json, print_values, warn, working, write_picture
from rodgen.cli.options import AsJson, OutFolder, SceneFile
from rodgen.cli.results import promised

if TYPE_CHECKING:
    import xarray
    from rich.table import Table

    from rodgen.analyse.cycles.cycle import Cycle
    from rodgen.scene import Scene

SHOWN = 10  # multipliers
# Error of the trivial multipliers, beyond which all of them are doubtful; where they are double,
# they move by the root of the rounding.
UNSURE, UNSURE_DOUBLE = 1e-6, 1e-4


def cycle(
    scene_file: SceneFile,
    segments: Annotated[
        int, typer.Option(help="How many segments of the period are shot one by one.")
    ] = 4,
    branch_file: Annotated[
        Path | None,
        typer.Option(
            "--from",
            metavar="FILE",
            help="A branch of cycles that this command has written: begin with one of its cycles, "
            "stable or not, instead of a run.",
        ),
    ] = None,
    at: Annotated[
        int | None,
        typer.Option(
            help="The number of the cycle in that file; if not given, that nearest to SCENE's own "
            "value, at which the cycle is then found."
        ),
    ] = None,
    vary: Annotated[
        str | None,
        typer.Option(metavar="KEY", help="Follow the branch of cycles along a number of SCENE."),
    ] = None,
    between: Annotated[
        str | None,
        typer.Option(
            metavar="A,B", help="Between which values; a Hopf point is looked for from A."
        ),
    ] = None,
    start: Annotated[
        str,
        typer.Option(help="Where the branch begins: hopf (a Hopf point), or run (SCENE's cycle)."),
    ] = "hopf",
    mode: Annotated[
        int | None,
        typer.Option(
            help="Of a scene without dissipation: the motion of this nonlinear mode, 1 is the "
            "slowest, and its family from small motions on."
        ),
    ] = None,
    energy: Annotated[
        float | None,
        typer.Option(metavar="JOULES", help="With --mode: the energy above that of rest."),
    ] = None,
    out_folder: OutFolder = Path("results"),
    as_json: AsJson = False,
) -> None:
    """Show the periodic motion that SCENE settles on, and its Floquet multipliers; draw both. With
    --vary, follow such motions along a number of SCENE."""
    from rodgen.scene import Scene, SceneError

    scene = Scene.from_toml(scene_file)
    if vary is None and between is not None:
        raise SceneError("--between", between, "given with --vary, the key that is varied")
    if at is not None and branch_file is None:
        raise SceneError("--at", at, "given with --from, the file of a branch")
    if (mode is None) != (energy is None):
        name, other = ("--mode", "--energy") if energy is None else ("--energy", "--mode")
        raise SceneError(name, energy if mode is None else mode, f"given with {other}")
    if mode is not None:
        for option, value in (("--vary", vary), ("--from", branch_file)):
            if value is not None:
                raise SceneError(option, str(value), "absent beside --mode")
    if vary is not None:
        _branch(scene, vary, between, start, segments, out_folder, as_json)
        return
    with promised(None if as_json else out_folder / scene.name) as folder:
        with working("looking for a cycle"):
            if mode is not None and energy is not None:
                found = _of_mode(scene, mode, energy, segments)
            else:
                found = _found(scene, segments, branch_file, at)
        if not found.stable:
            warn(f"this cycle is unstable: {found.unstable} multipliers are larger than 1")
        double = not (found.work or found.forced)  # energy is kept
        if found.trivial_error > (UNSURE_DOUBLE if double else UNSURE):
            warn(f"the multipliers are right to {found.trivial_error:.1e} only")
        if as_json:
            print_json(_object(found))
            return
        print_values(f"{scene.name}: cycle", _rows(found))
        from rodgen.show.cycle_pictures import film_strip, unit_circle

        write_picture(lambda: film_strip(found), folder, "cycle")
        write_picture(lambda: unit_circle(found), folder, "multipliers")
        if mode is not None and energy is not None:
            from rodgen.analyse.cycles.nonlinear_modes import continue_mode
            from rodgen.show.cycle_pictures import family

            data = continue_mode(scene, mode, energy, segments=segments)
            write_picture(lambda: family(data, scene), folder, "mode")


def _of_mode(scene: Scene, mode: int, energy: float, segments: int) -> Cycle:
    from rodgen.analyse.cycles.nonlinear_modes import nonlinear_mode

    return nonlinear_mode(scene, mode, energy, segments=segments)


def _found(scene: Scene, segments: int, branch_file: Path | None, at: int | None) -> Cycle:
    from rodgen.analyse.cycles.cycle import find_cycle

    if branch_file is None:
        return find_cycle(scene, segments=segments)
    from rodgen.analyse.cycles.branch_data import nearest, on_branch, read

    data = read(branch_file)
    if at is not None:
        scene, _, y0, period = on_branch(data, at)
    else:
        _, _, y0, period = on_branch(data, nearest(data, scene))
    return find_cycle(scene, y0=y0, period=period, segments=segments)


def _branch(
    scene: Scene,
    key: str,
    between: str | None,
    start: str,
    segments: int,
    out_folder: Path,
    as_json: bool,
) -> None:
    from rodgen.analyse.curves.files import save
    from rodgen.analyse.cycles.branches import continue_cycles

    ends = _ends(between)
    with promised(None if as_json else out_folder / scene.name) as folder:
        with working("following cycles"):
            data = continue_cycles(scene, key, ends, start=start, segments=segments)
        if not data.attrs["complete"]:
            warn(f"the branch stops at {float(data['value'][-1]):.9g}: {data.attrs['end']}")
        for note in filter(None, data.attrs["notes"].split("\n")):
            warn(note)
        if as_json:
            print_json(_branch_object(data))
            return
        out.print(_branch_table(data, scene.name, key))
        if "supercritical" in data.attrs:
            kind = "super" if data.attrs["supercritical"] else "sub"
            out.print(
                f"The Hopf point is {kind}critical: first Lyapunov coefficient "
                f"{data.attrs['lyapunov']:.6g} per rad^2."
            )
        file = folder / "cycles.nc"
        save(data, file)
        out.print(f"Written: {file}")
        from rodgen.show.cycle_pictures import amplitudes

        write_picture(lambda: amplitudes(data, scene), folder, "cycles")


def _ends(between: str | None) -> tuple[float, float]:
    """Two numbers from A,B. Raises SceneError."""
    from rodgen.scene import SceneError

    try:
        low, high = (float(part) for part in (between or "").split(","))
    except ValueError:
        allowed = "two numbers A,B between which the key of --vary is varied"
        raise SceneError("--between", between, allowed) from None
    return low, high


def _branch_object(data: xarray.Dataset) -> dict[str, object]:
    names = ("value", "period", "amplitude", "tip", "energy", "unstable")
    points = [
        {name: data[name].values[at].item() for name in names} for at in range(data.sizes["point"])
    ]
    special = [
        {
            name: data[f"special_{name}"].values[at].item()
            for name in ("kind", "value", "period", "frequency")
        }
        for at in range(data.sizes["special"])
    ]
    return {"points": points, "special": special}


def _branch_table(data: xarray.Dataset, name: str, key: str) -> Table:
    from rich.table import Table

    table = Table(title=f"{name}: cycles along {key}")
    for column in ("point", key, "period [s]", "amplitude [rad]", "unstable"):
        table.add_column(column, justify="right")
    special = list(
        zip(data["special_after"].values.tolist(), range(data.sizes["special"]), strict=True)
    )
    for at in range(-1, data.sizes["point"]):
        if at >= 0:
            row = [float(data[one][at]) for one in ("value", "period", "amplitude")]
            table.add_row(str(at), *(f"{one:.9g}" for one in row), str(int(data["unstable"][at])))
        for after, number in special:
            if after == at:
                kind = str(data["special_kind"].values[number])
                value, period = (
                    float(data[f"special_{one}"][number]) for one in ("value", "period")
                )
                table.add_row(kind, f"{value:.11g}", f"{period:.9g}", "", "")
    return table


def _object(found: Cycle) -> dict[str, object]:
    return {
        "period": found.period,
        "multipliers": [[mu.real, mu.imag] for mu in found.multipliers.tolist()],
        "energy": found.energy,
        "y0": found.y0.tolist(),
    }


def _rows(found: Cycle) -> dict[str, str]:
    of = ", that of the loads" if found.forced else ""
    rows = {
        "period": f"{found.period:.12g} s{of}",
        "frequency": f"{1 / found.period:.10g} Hz",
        "amplitude of the angles": f"{found.amplitude:.8g} rad",
        "energy of y0": f"{found.energy:.10g} J",
        **{f"work of {name} a period": f"{work:.8g} J" for name, work in found.work.items()},
    }
    if found.angle:
        rows["turned after a period by"] = (
            f"{found.angle:.10g} rad = {math.degrees(found.angle):.6g} degrees"
        )
    if found.drift.any():
        rows["moved after a period by"] = f"({found.drift[0]:.8g}, {found.drift[1]:.8g}) m"
    multipliers = found.nontrivial[:SHOWN].tolist()
    for at, mu in enumerate(multipliers):
        sign = f" {'+-'[mu.imag < 0]} {abs(mu.imag):.8g} i" if mu.imag else ""
        rows[f"multiplier {at + 1}"] = f"{mu.real:.8g}{sign}   (size {abs(mu):.8g})"
    left = len(found.nontrivial) - len(multipliers)
    rows["further multipliers"] = f"{left}, smaller" if left else "none"
    rows["multipliers that are 1"] = f"{found.trivial}, found with an error of " * bool(
        found.trivial
    ) + (f"{found.trivial_error:.1e}" if found.trivial else "none: the loads give the phase")
    rows["stable"] = "yes" if found.stable else "NO"
    way = f"after a run of {found.after:g} s, " if found.after else ""
    way += f"by {found.iterations} iterations of Newton's method"
    if not found.iterations:
        way = "on the family of a linear mode"
    rows["found"] = f"{way}; closes to {found.residual:.1e} of its size"
    return rows
