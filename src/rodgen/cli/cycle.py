"""rodgen cycle: the periodic motion that a scene settles on, its stability, and branches."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from rodgen.cli.console import out, print_json, print_values, warn, working, write_picture
from rodgen.cli.curves import content_of, followed, going_on, numbers
from rodgen.cli.options import (
    AsJson,
    CheckMesh,
    LongestStep,
    MostPoints,
    OutFolder,
    PointNumber,
    ResumeFile,
    point_of,
)
from rodgen.cli.results import promised
from rodgen.scene import Scene
from rodgen.system import System

if TYPE_CHECKING:
    import xarray
    from matplotlib.figure import Figure
    from rich.table import Table

    from rodgen.analyse.curves.journal import Journal
    from rodgen.analyse.cycles.cycle import Cycle

CYCLES = "cycles"  # files of a branch
# Error of the trivial multipliers, beyond which all of them are doubtful; where they are double,
# they move by the root of the rounding.
UNSURE, UNSURE_DOUBLE = 1e-6, 1e-4
ROUGH = 1e-8  # likewise, of the error of collocation
SEGMENTS = 4  # that are shot, unless others are asked for


def cycle(
    scene: Scene,
    by: Annotated[
        str | None,
        typer.Option(
            help="collocation (on a mesh of the period), shooting, or picard (only the leading "
            "multipliers). Default: collocation, and picard for many links."
        ),
    ] = None,
    multipliers: Annotated[
        int | None,
        typer.Option(metavar="K", help="Number of leading multipliers of picard. Default: 10."),
    ] = None,
    segments: Annotated[
        int | None,
        typer.Option(help="Number of segments of shooting. Default: 4."),
    ] = None,
    branch_file: Annotated[
        Path | None,
        typer.Option(
            "--from",
            metavar="FILE",
            help="A branch of cycles that this command has written: begin with its cycle --at, "
            "stable or not, instead of a run. Without --at, begin with the cycle nearest to "
            "SCENE's own value, and find the cycle at this value. With --vary, a branch of "
            "equilibria that rodgen branch has written: begin in its Hopf point --at (1 is "
            "the first special point).",
        ),
    ] = None,
    at: PointNumber = None,
    vary: Annotated[
        str | None,
        typer.Option(metavar="KEY", help="Follow the branch of cycles along this number of SCENE."),
    ] = None,
    between: Annotated[
        str | None,
        typer.Option(
            metavar="A,B", help="Range of the number. The search for a Hopf point begins at A."
        ),
    ] = None,
    start: Annotated[
        str,
        typer.Option(help="Start of the branch: hopf (a Hopf point) or run (SCENE's cycle)."),
    ] = "hopf",
    switch: Annotated[
        int | None,
        typer.Option(
            metavar="NUMBER",
            help="With --vary: follow the branch that begins in the special point of this number. "
            "This is a branch point, or a period doubling, where cycles of twice the period "
            "begin.",
        ),
    ] = None,
    resume: ResumeFile = None,
    step: LongestStep = 0.1,
    most: MostPoints = 200,
    mode: Annotated[
        int | None,
        typer.Option(
            help="For a scene without dissipation: find the motion of this nonlinear mode (1 is "
            "the slowest), and its family from small motions on."
        ),
    ] = None,
    energy: Annotated[
        float | None,
        typer.Option(metavar="JOULES", help="With --mode: energy above that of rest."),
    ] = None,
    check_mesh: CheckMesh = False,
    out_folder: OutFolder = Path("results"),
    as_json: AsJson = False,
) -> None:
    """Find the periodic motion that SCENE settles on, and its Floquet multipliers, and draw both.

    With --vary, follow periodic motions along a number of SCENE.
    """
    from rodgen.errors import InputError

    if vary is None and between is not None:
        raise InputError("--between", between, "given with --vary, the key that is varied")
    if vary is None and resume is not None:
        raise InputError("--resume", str(resume), "given with --vary, the key that is varied")
    if vary is None and switch is not None:
        raise InputError("--switch", switch, "given with --vary, the key that is varied")
    point_of(branch_file or resume, at, "--from or --resume")
    if (mode is None) != (energy is None):
        name, other = ("--mode", "--energy") if energy is None else ("--energy", "--mode")
        raise InputError(name, energy if mode is None else mode, f"given with {other}")
    if mode is not None:
        others = {"--vary": vary, "--from": branch_file, "--check-mesh": check_mesh or None}
        for option, value in others.items():
            if value is not None:
                raise InputError(option, str(value), "absent beside --mode")
    if vary is not None:
        for option, asked in (("--by", by), ("--multipliers", multipliers)):
            if asked is not None:
                raise InputError(option, asked, "absent beside --vary: branches are shot")
        from rodgen.analyse.branches.branch_data import read as equilibria
        from rodgen.analyse.cycles.branch_data import read

        how: dict[str, Any] = {"switch": switch, "segments": segments or SEGMENTS}
        how |= {"step": step, "most": most, "check_mesh": check_mesh}
        name = CYCLES if switch is None else f"{CYCLES}_{switch}"
        file = None if as_json else out_folder / scene.name / f"{name}.nc"
        command: dict[str, Any] = {
            "command": "cycle",
            "scene": scene.to_dict(),
            "vary": vary,
            "between": between,
        }
        command |= {"start": content_of(branch_file) if branch_file else start, **how}
        command |= {"start_at": at} if branch_file else {}
        going = going_on(resume, None if branch_file else at, read, file, command)
        if going.curve is not None:
            how |= {"resume": going.curve, "at": going.at}
        elif branch_file:
            how |= {"start": equilibria(branch_file), "at": at}
        else:
            how["start"] = start
        _branch(scene, vary, between, file, going.journal, how)
        return
    with promised(None if as_json else out_folder / scene.name) as folder:
        with working("looking for a cycle"):
            if mode is not None and energy is not None:
                found = _of_mode(scene, mode, energy, segments or SEGMENTS)
            else:
                more: dict[str, Any] = {"by": by, "segments": segments}
                more["multipliers"] = multipliers
                found = _found(scene, branch_file, at, check_mesh=check_mesh, **more)
        for note in found.notes:
            warn(note)
        if not found.stable:
            warn(f"this cycle is unstable: {found.unstable} multipliers are larger than 1")
        double = not (found.work or found.forced)  # energy is kept
        if found.error > ROUGH:
            warn(
                f"the larger multipliers are right to about {found.error:.0e} only: drag and other "
                "loads with a kink spoil the order of collocation"
            )
        if found.trivial_error > (UNSURE_DOUBLE if double else UNSURE):
            warn(f"the multipliers are right to {found.trivial_error:.1e} only")
        if as_json:
            print_json(_object(found))
            return
        from rodgen.show.cycle_pictures import film_strip, unit_circle
        from rodgen.show.result_tables import of_cycle

        print_values(f"{scene.name}: cycle", of_cycle(found))

        write_picture(lambda: film_strip(found), folder, "cycle")
        write_picture(lambda: unit_circle(found), folder, "multipliers")
        if mode is not None and energy is not None:
            from rodgen.analyse.cycles.nonlinear_modes import continue_mode
            from rodgen.show.cycle_pictures import family

            with working("following the family of the mode"):
                data = continue_mode(scene, mode, energy, segments=segments or SEGMENTS)
            write_picture(lambda: family(data, scene), folder, "mode")


def _of_mode(scene: Scene, mode: int, energy: float, segments: int) -> Cycle:
    from rodgen.analyse.cycles.nonlinear_modes import nonlinear_mode

    return nonlinear_mode(scene, mode, energy, segments=segments)


def _found(scene: Scene, branch_file: Path | None, at: int | None, **given: Any) -> Cycle:
    """given: to `find_cycle`."""
    from rodgen.analyse.cycles.periodic_motion import find_cycle

    if branch_file is None:
        return find_cycle(scene, **given)
    from rodgen.analyse.cycles.branch_data import nearest, on_branch, read

    data = read(branch_file)
    there, known = on_branch(data, nearest(data, scene) if at is None else at)
    beside = System(scene) if at is None else there
    return find_cycle(beside, y0=known.y0, period=known.period, **given)


def _branch(
    scene: Scene,
    key: str,
    between: str | None,
    file: Path | None,
    journal: Journal | None,
    given: dict[str, Any],
) -> None:
    """Follow a branch; file: that is written, unless the curve is printed; given: to
    `continue_cycles`."""
    from rodgen.analyse.cycles.branches import continue_cycles
    from rodgen.errors import InputError

    if between is None:
        raise InputError("--between", None, "two numbers A,B between which the key of --vary goes")
    ends = numbers("--between", between, ",")
    with promised(file and file.parent) as folder:
        made = followed(
            "the branch of cycles",
            lambda said: continue_cycles(
                scene, key, ends, watch=lambda value: said(f"{key} = {value:.6g}"), **given
            ),
            journal,
        )
        data = made.data
        made.warn()
        if file is None:
            print_json(_branch_object(data))
        else:
            out.print(_branch_table(data, scene.name, key))
            if "supercritical" in data.attrs:
                kind = "super" if data.attrs["supercritical"] else "sub"
                out.print(
                    f"The Hopf point is {kind}critical: first Lyapunov coefficient "
                    f"{data.attrs['lyapunov']:.6g} per rad^2."
                )
            made.write(folder, file.stem, lambda: _amplitudes(data, scene))
        made.stop(file)


def _amplitudes(data: xarray.Dataset, scene: Scene) -> Figure:
    from rodgen.show.cycle_pictures import amplitudes

    return amplitudes(data, scene)


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
                kind = f"{number + 1}: {data['special_kind'].values[number]}"
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
        "notes": list(found.notes),
    }
