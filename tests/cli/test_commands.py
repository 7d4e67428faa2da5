"""The command line in processes of its own."""

from __future__ import annotations

import os
import re
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest

import rodgen as package
from rodgen.cli.errors import reported

Run = Callable[..., subprocess.CompletedProcess[str]]
ROOT = Path(__file__).parents[2]

SHORT = """
name = "short"
[rod]
links = 4
length = 1.0
bending_stiffness = 2.0
mass = 1.0
[loads.follower]
force = "5*min(t/0.1, 1)"
[loads.gravity]
[initial]
phi = "0.1*cos(pi*s)"
[integrate]
span = [0.0, 0.3]
"""


@pytest.fixture
def short(tmp_path: Path) -> Path:
    path = tmp_path / "short.toml"
    path.write_text(SHORT, encoding="utf-8")
    return path


def test_derive_proves_and_writes(rodgen: Run, tmp_path: Path) -> None:
    done = rodgen("derive", 4, "--out", tmp_path)
    assert done.returncode == 0, done.stderr
    assert "n = 4 (LagrangesMethod)" in done.stdout
    assert "any n (symbolic)" in done.stdout
    assert "proven in" in done.stdout
    (module,) = tmp_path.iterdir()
    assert module.name == "rod_free_n4.py"
    before = module.stat().st_mtime_ns
    again = rodgen("derive", 4, "--out", tmp_path)
    assert "proven earlier" in again.stdout
    assert "up to date" in again.stdout
    assert module.stat().st_mtime_ns == before


def test_kept_proof_does_not_import_sympy(rodgen: Run, tmp_path: Path) -> None:
    first = rodgen("derive", 3, "--terms", "none", "--out", tmp_path)
    assert first.returncode == 0
    program = (
        "import sys\nfrom rodgen.cli import main\n"
        f"sys.argv[1:] = ['derive', '3', '--terms', 'none', '--out', {str(tmp_path)!r}]\n"
        "try:\n    main()\nexcept SystemExit as end:\n    assert not end.code\n"
        "assert 'sympy' not in sys.modules"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


def test_derive_beyond_sixty_links_says_how_it_was_proven(rodgen: Run, tmp_path: Path) -> None:
    wide = {"COLUMNS": "200"}  # headings in one line
    done = rodgen("derive", 200, "--boundary", "cantilever", "--out", tmp_path, env=wide)
    assert done.returncode == 0, done.stderr
    assert "random rational" in done.stdout
    assert "not by LagrangesMethod" in done.stdout
    assert (tmp_path / "rod_cantilever_n200.py").stat().st_size < 60_000


WRONG = """
from rodgen.derive.closed_form import ClosedForm
right = ClosedForm.M_link
ClosedForm.M_link = lambda self, i: right(self, i) * 2
from rodgen.cli import main
import sys
sys.argv[1:] = ["derive", "3", "--out", sys.argv[1], "--terms", "gravity"]
main()
"""


def test_derive_stops_at_an_entry_that_differs(tmp_path: Path) -> None:
    """With a wrong closed form: exit status 1, the entry, and no module."""
    done = subprocess.run(
        [sys.executable, "-c", WRONG, str(tmp_path)], capture_output=True, text=True, check=False
    )
    assert done.returncode == 1
    assert "not proven: M" in done.stderr
    assert "derived" in done.stderr
    assert list(tmp_path.iterdir()) == []


def test_run_writes_everything_and_says_so(rodgen: Run, short: Path, tmp_path: Path) -> None:
    done = rodgen("run", short, "--out", tmp_path / "results")
    assert done.returncode == 0, done.stderr
    folder = tmp_path / "results" / "short"
    names = {_without_hash(path) for path in folder.iterdir()}
    pictures = {"shape.png", "trajectory.png", "energy.png", "phase.png"}
    module = {f"rod_free_n4_follower_gravity_c.{ending}" for ending in ("py", "c", "h")}
    assert names == {"solution.nc", "summary.txt", *module, *pictures}
    for picture in pictures:
        assert (folder / picture).read_bytes().startswith(b"\x89PNG")
    words = (folder / "summary.txt").read_text(encoding="utf-8")
    assert words in done.stdout
    for part in ("Finished: 0.3 s", "centre of gravity", "Energy and work balance"):
        assert part in words
    sol = package.load(folder / "solution.nc")
    assert sol.t[-1] == 0.3
    assert np.abs(sol.energy_balance).max() < 1e-6


PYTHON_ONLY = {"rod_free_n4_follower_gravity.py"}


def _without_hash(path: Path) -> str:
    """Name of a file; of a module with expressions without the letters of its hash."""
    return re.sub(r"^(rod_.*)_[0-9a-f]{6}\.", r"\1.", path.name)


NO_COMPILER = [{"CC": "/nonexistent"}, {"PATH": "/nonexistent"}]


@pytest.mark.parametrize("target", ["numpy", "c"])
def test_run_takes_the_target_that_is_asked_for(
    rodgen: Run, short: Path, tmp_path: Path, target: str
) -> None:
    done = rodgen("run", short, "--target", target, "--out", tmp_path)
    assert done.returncode == 0, done.stderr
    written = {_without_hash(path) for path in (tmp_path / "short").glob("rod_*")}
    assert (written == PYTHON_ONLY) == (target == "numpy")
    assert len(written) == (1 if target == "numpy" else 3)


@pytest.mark.parametrize("env", NO_COMPILER, ids=lambda env: next(iter(env)))
def test_run_without_a_compiler_is_run_by_numpy(
    rodgen: Run, short: Path, tmp_path: Path, env: dict[str, str]
) -> None:
    env = {**env, "RODGEN_CACHE": str(tmp_path / "cache")}
    done = rodgen("run", short, "--out", tmp_path, env=env)
    assert done.returncode == 0, done.stderr
    assert done.stderr == ""
    assert {_without_hash(path) for path in (tmp_path / "short").glob("rod_*")} == PYTHON_ONLY


@pytest.mark.parametrize("env", NO_COMPILER, ids=lambda env: next(iter(env)))
def test_run_that_wants_c_without_a_compiler_says_what_else_there_is(
    rodgen: Run, short: Path, tmp_path: Path, env: dict[str, str]
) -> None:
    env = {**env, "RODGEN_CACHE": str(tmp_path / "cache")}
    done = rodgen("run", short, "--target", "c", "--out", tmp_path, env=env)
    assert done.returncode == 2
    assert "Traceback" not in done.stderr
    assert done.stderr.startswith("rodgen: ")
    assert "/nonexistent" in done.stderr or "cc, gcc, clang" in done.stderr
    assert "target numpy" in done.stderr
    assert not (tmp_path / "short").exists()


@pytest.mark.parametrize(
    ("options", "names"),
    [
        (("--target", "c"), {"rod_pinned_n2_c.py", "rod_pinned_n2_c.c", "rod_pinned_n2_c.h"}),
        (
            ("--target", "both"),
            {"rod_pinned_n2.py", "rod_pinned_n2_c.py", "rod_pinned_n2_c.c", "rod_pinned_n2_c.h"},
        ),
        (("--form", "dense"), {"rod_pinned_n2_dense.py"}),
        (
            ("--inertia", "lumped", "--terms", "tip_load"),
            {"rod_pinned_n2_tip_load_lumped.py"},
        ),
    ],
    ids=lambda x: " ".join(x) if isinstance(x, tuple) else "",
)
def test_derive_writes_what_is_asked_for(
    rodgen: Run, tmp_path: Path, options: tuple[str, ...], names: set[str]
) -> None:
    """Without a compiler too: none is needed to write C."""
    env = {"CC": "/nonexistent", "COLUMNS": "200"}
    done = rodgen("derive", 2, "--boundary", "pinned", *options, "--out", tmp_path, env=env)
    assert done.returncode == 0, done.stderr
    assert {path.name for path in tmp_path.iterdir()} == names
    assert "from the joint forces, exact" in done.stdout
    assert all(name in done.stdout.replace("\n", "") for name in names)


def test_check_takes_c_modules(rodgen: Run) -> None:
    done = rodgen("check", ROOT / "generated" / "rod_free_n5_c.py")
    assert done.returncode == 0, done.stderr
    done = rodgen("check", ROOT / "generated" / "rod_free_n5_c.py", env={"CC": "/nonexistent"})
    assert (done.returncode, "Traceback" in done.stderr) in ((0, False), (2, False))


@pytest.mark.parametrize("method", ["lsoda", "bdf", "rk23"])
def test_every_kind_of_method_can_be_saved(
    rodgen: Run, short: Path, tmp_path: Path, method: str
) -> None:
    done = rodgen("run", short, "--method", method, "--out", tmp_path)
    assert done.returncode == 0, done.stderr
    assert package.load(tmp_path / "short" / "solution.nc").stats.steps > 0


def test_run_takes_other_methods(rodgen: Run, short: Path, tmp_path: Path) -> None:
    done = rodgen("run", short, "--method", "rk4", "--step", "0.0005", "--out", tmp_path)
    assert done.returncode == 0, done.stderr
    assert "by rk4 (step 0.0005 s)" in done.stdout
    done = rodgen("run", short, "--method", "radau", "--rtol", "1e-5", "--out", tmp_path)
    assert "by radau (rtol 1e-05" in done.stdout


def test_blow_up_exits_3_with_the_time_and_keeps_samples(
    rodgen: Run, short: Path, tmp_path: Path
) -> None:
    options = ("--method", "euler", "--step", "0.02")
    long = short.read_text(encoding="utf-8").replace("0.3]", "50.0]")
    short.write_text(long, encoding="utf-8")
    done = rodgen("run", short, *options, "--out", tmp_path)
    assert done.returncode == 3, done.stderr
    assert "stopped at t = " in done.stderr
    assert "finite" in done.stderr
    assert "Traceback" not in done.stderr
    sol = package.load(tmp_path / "short" / "solution.nc")
    assert sol.status == "failed"
    assert 0 < sol.t[-1] < 50.0
    assert np.isfinite(sol.y).all()


def test_ctrl_c_keeps_what_was_computed(short: Path, tmp_path: Path) -> None:
    text = short.read_text(encoding="utf-8").replace("0.3]", "1e7]")
    short.write_text(text.replace("span", "output_every = 50.0\nspan"), encoding="utf-8")
    folder = tmp_path / "short"
    with _started("run", short, "--out", tmp_path) as process:
        while not folder.is_dir():
            assert process.poll() is None
            time.sleep(0.05)
        time.sleep(4.0)
        process.send_signal(signal.SIGINT)
        _, errors = process.communicate(timeout=60)
    assert process.returncode == 130, errors
    assert "interrupted at t = " in errors
    assert "Traceback" not in errors
    sol = package.load(folder / "solution.nc")
    assert sol.t[-1] > 0.05
    # It falls and turns for hours; the error of the balance is a share of what it gains.
    assert sol.energy_error < 1e-6 * np.abs(sol.energy.total).max()


def test_impatient_ctrl_c_loses_no_states(short: Path, tmp_path: Path) -> None:
    text = short.read_text(encoding="utf-8").replace("0.3]", "1e7]")
    short.write_text(text.replace("span", "output_every = 50.0\nspan"), encoding="utf-8")
    folder = tmp_path / "short"
    with _started("run", short, "--out", tmp_path) as process:
        while not folder.is_dir():
            time.sleep(0.05)
        time.sleep(2.0)
        process.send_signal(signal.SIGINT)
        assert process.stderr is not None
        assert "writing what was computed" in process.stderr.readline()
        time.sleep(0.2)
        process.send_signal(signal.SIGINT)
        process.communicate(timeout=60)
    assert process.returncode == 130
    assert len(package.load(folder / "solution.nc").t) > 1


@pytest.mark.parametrize("after", [0.05, 0.4, 1.5])
def test_ctrl_c_at_any_time_ends_in_one_line(tmp_path: Path, after: float) -> None:
    """While Python starts, while commands are imported, while equations are derived."""
    program = "import sys, rodgen.cli; print('up', flush=True); rodgen.cli.main()"
    with _started("derive", 40, "--out", tmp_path, program=program) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == "up\n"
        time.sleep(after)
        process.send_signal(signal.SIGINT)
        _, errors = process.communicate(timeout=60)
    assert process.returncode == 130, errors
    assert errors.strip() == "rodgen: interrupted"
    assert list(tmp_path.glob("*.py")) == []


@contextmanager
def _started(
    *arguments: object, program: str = "from rodgen.cli import main; main()"
) -> Iterator[subprocess.Popen[str]]:
    """A command that runs on, with Ctrl-C as in a terminal, and that does not outlive the test."""
    process = subprocess.Popen(
        [sys.executable, "-c", program, *map(str, arguments)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        # A test runner in the background ignores SIGINT, and its children would too.
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
    )
    try:
        yield process
    finally:
        process.kill()
        process.communicate()


def test_check_passes_and_fails(rodgen: Run, tmp_path: Path) -> None:
    good = ROOT / "generated" / "rod_cantilever_n5.py"
    done = rodgen("check", good)
    assert done.returncode == 0, done.stderr
    assert "far from straight" in done.stdout
    wrong = tmp_path / "wrong.py"
    text = good.read_text(encoding="utf-8").replace("    alpha = ", "    alpha = 1.001*", 1)
    wrong.write_text(text, encoding="utf-8")
    done = rodgen("check", wrong)
    assert done.returncode == 1
    assert "above 1e-10" in done.stderr


@pytest.mark.parametrize(
    "name", ["marker.toml", "marker.py", "rod_free_n5_c.c", "rod_free_n5_c.h", "rod_free_n5.txt"]
)
def test_check_runs_nothing_but_generated_python(rodgen: Run, tmp_path: Path, name: str) -> None:
    marker = tmp_path / "was run"
    made = ROOT / "generated" / name
    source = made.with_name("rod_free_n5.py") if name.endswith(".txt") else made
    text = source.read_text(encoding="utf-8") if source.is_file() else ""
    touch = f"open({str(marker)!r}, 'w')\n"
    (tmp_path / name).write_text(text + touch, encoding="utf-8")
    done = rodgen("check", name, cwd=tmp_path)
    assert done.returncode == 2
    assert "a .py that rodgen derive wrote (of a C module, the .py beside the .c)" in done.stderr
    assert len(done.stderr.splitlines()) == 1
    assert not marker.exists()


@pytest.mark.parametrize("lines", [5, 40, 150, 200])
def test_check_refuses_a_module_that_was_cut_off(rodgen: Run, tmp_path: Path, lines: int) -> None:
    whole = (ROOT / "generated" / "rod_free_n5.py").read_text(encoding="utf-8")
    cut = tmp_path / "cut.py"
    cut.write_text("\n".join(whole.splitlines()[:lines]) + "\n", encoding="utf-8")
    done = rodgen("check", cut)
    assert done.returncode == 2
    assert "module" in done.stderr
    assert len(done.stderr.splitlines()) == 1


def test_show_says_what_is_left_out_and_why(rodgen: Run, short: Path) -> None:
    done = rodgen("show", short)
    assert done.returncode == 0, done.stderr
    lines = {line.split("│")[1].strip(): line for line in done.stdout.splitlines() if "│" in line}
    assert "yes" in lines["gravity"]
    assert "part of the code" in lines["follower"]
    assert "no table [loads.internal_damping]" in lines["internal damping"]
    assert "break points: 0.1" in done.stdout
    assert "note:" not in done.stdout


def test_show_lists_the_first_of_many_break_points(rodgen: Run, short: Path) -> None:
    """The force is switched 100 times a second for 0.3 s."""
    text, often = short.read_text(encoding="utf-8"), "1 if sin(2*pi*50*t) > 0 else 0"
    force = next(line for line in text.splitlines() if line.startswith("force"))
    short.write_text(text.replace(force, f'force = "{often}"'), encoding="utf-8")
    done = rodgen("show", short)
    assert done.returncode == 0, done.stderr
    assert "0.01, 0.02, 0.03" in done.stdout
    assert "(29 in all)" in done.stdout


def test_show_warns_of_a_method_that_keeps_no_energy(rodgen: Run, short: Path) -> None:
    method = '[integrate]\nmethod = "semi_implicit_euler"\nstep = 1e-5'
    text = short.read_text(encoding="utf-8").replace("[integrate]", method)
    short.write_text(text, encoding="utf-8")
    done = rodgen("show", short)
    assert done.returncode == 0, done.stderr
    assert "does not keep its energy" in done.stderr


def test_numbers_at_the_limit_are_no_traceback(rodgen: Run, short: Path, tmp_path: Path) -> None:
    text = short.read_text(encoding="utf-8")
    for change in (
        ("length = 1.0", "length = 1e60"),
        ("length = 1.0", "length = 1e-59"),
        ("mass = 1.0", "mass = 1e60"),
        ("[initial]", "[initial]\nposition = [1e60, -1e60]"),
    ):
        short.write_text(text.replace(*change), encoding="utf-8")
        done = rodgen("run", short, "--out", tmp_path / change[1][:12])
        assert "Traceback" not in done.stderr, done.stderr
        assert done.returncode in (0, 3)
        assert (tmp_path / change[1][:12] / "short" / "solution.nc").is_file()


BAD = [
    (("derive", "0"), "links"),
    (("derive", "2.5"), "links"),
    (("derive", "many"), "links"),
    (("derive", "1000001"), "links"),
    (("derive", "1", "--boundary", "cantilever"), "links"),
    (("derive", "3", "--boundary", "glued"), "boundary"),
    (("derive", "3", "--inertia", "heavy"), "inertia"),
    (("derive", "3", "--terms", "wind"), "terms"),
    (("derive", "3", "--terms", "gravity,gravity"), "terms"),
    (("derive", "3", "--terms", "all,none"), "terms"),
    (("derive", "1_0"), "links"),
    (("derive", "3", "--target", "fortran"), "target"),
    (("derive", "3", "--form", "sparse"), "form"),
    (("derive", "3", "--target", "c", "--form", "dense"), "form = 'dense'"),
    (("derive", "3", "--target", "both", "--form", "dense"), "form = 'dense'"),
    (("derive", "0", "--boundary", "pinned"), "links"),
    (("derive", "3", "--terms", "tip"), "terms"),
    (("run", str(ROOT / "scenes" / "missile.toml"), "--target", "fortran"), "target"),
    (("derive", "-1"), "links = -1"),
    (("derive", "3", "--out", "/proc/no/such/folder"), "--out"),
    (("derive", "3", "--colour", "red"), "--colour"),
    (("run", "missing.toml", "--step", "abc"), "--step"),
    (("check", "missing.py", "--seed", "-1"), "--seed"),
    (("run", str(ROOT / "scenes" / "missile.toml"), "--step", "0.1"), "--step = 0.1"),
    (("run", "missing.toml"), "scene"),
    (("show", "missing.toml"), "scene"),
    (("check", "missing.py"), "module"),
    (("check", str(ROOT / "tests" / "conftest.py")), "module"),
    (("run", str(ROOT / "scenes" / "missile.toml"), "--method", "magic"), "integrate.method"),
    (("run", str(ROOT / "scenes" / "missile.toml"), "--step", "-1", "--method", "rk4"), "step"),
    (("run", str(ROOT / "scenes" / "missile.toml"), "--rtol", "nan"), "rtol"),
    *(
        (("run", str(ROOT / "scenes" / "missile.toml"), "--checkpoint", given), "--checkpoint")
        for given in ("nan", "inf", "-1", "0")
    ),
    (("derive", "3", "--out", "/dev/null/folder"), "--out"),
    (("thesis", "--out", "/dev/null/folder"), "--out"),
    (("run", "/dev/zero"), "this is a device"),
    (("fly",), "fly"),
    (("run",), "SCENE"),
    (("derive",), "links"),
]


@pytest.mark.parametrize(("arguments", "field"), BAD, ids=lambda x: " ".join(x[:6])[:40])
def test_bad_input_exits_2_in_one_line(
    rodgen: Run, tmp_path: Path, arguments: tuple[str, ...], field: str
) -> None:
    done = rodgen(*arguments, cwd=tmp_path)
    assert done.returncode == 2, done.stdout + done.stderr
    assert field.lower() in done.stderr.lower()  # typer's versions differ in case
    assert len(done.stderr.splitlines()) == 1
    assert done.stdout == ""
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("obstacle", ["file", "read-only"])
def test_results_folder_that_cannot_be_written(
    rodgen: Run, short: Path, tmp_path: Path, obstacle: str
) -> None:
    blocked = tmp_path / "blocked"
    if obstacle == "file":
        blocked.write_text("in the way", encoding="utf-8")
        folder = blocked
    else:
        folder = Path("/proc/rodgen")  # cannot be written by anyone, root included
        if not Path("/proc").is_dir():
            pytest.skip("no /proc on this system, and root may write anywhere else")
    done = rodgen("run", short, "--out", folder)
    assert done.returncode == 2
    assert "--out" in done.stderr
    assert len(done.stderr.splitlines()) == 1


def test_version_and_help(rodgen: Run) -> None:
    assert rodgen("--version").stdout.strip() == package.__version__
    for command in ("derive", "run", "check", "show"):
        done = rodgen(command, "--help")
        assert done.returncode == 0
        assert "Usage: rodgen" in done.stdout


def test_without_arguments_it_prints_its_help(rodgen: Run) -> None:
    done = rodgen()
    assert done.stdout == rodgen("--help").stdout
    assert len(done.stdout.splitlines()) > 10
    assert (done.returncode, done.stderr) == (0, "")


def test_file_that_cannot_be_read_is_named(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    missing = tmp_path / "none" / "file.txt"
    with pytest.raises(SystemExit) as ended, reported():
        missing.read_text(encoding="utf-8")
    assert ended.value.code == 2
    said = capsys.readouterr().err
    assert said == f"rodgen: cannot read or write {str(missing)!r}: No such file or directory\n"


def test_cache_that_cannot_be_written_only_costs_time(
    rodgen: Run, short: Path, tmp_path: Path
) -> None:
    blocked = tmp_path / "cache"
    blocked.write_text("in the way", encoding="utf-8")
    done = rodgen("run", short, "--out", tmp_path, env={"RODGEN_CACHE": str(blocked)})
    assert done.returncode == 0, done.stderr


def test_damaged_cache_is_made_again(rodgen: Run, short: Path, tmp_path: Path) -> None:
    """Cut short, or with a digit changed: neither is what was stored."""
    cache = tmp_path / "cache"
    env = {"RODGEN_CACHE": str(cache)}
    assert rodgen("run", short, "--out", tmp_path, env=env).returncode == 0
    assert rodgen("derive", 3, "--out", tmp_path, env=env).returncode == 0
    damaged = [path for path in cache.rglob("*") if path.is_file()]
    assert {path.suffix for path in damaged} == {".json", ".so", ".sha256"}
    for at, path in enumerate(damaged):
        content = path.read_bytes()
        changed = content.replace(b"= 4*", b"= 5*").replace(b'": 3', b'": 4')
        path.write_bytes(content[:40] if at % 2 or changed == content else changed)
    (module,) = (path.relative_to(tmp_path) for path in tmp_path.glob("short/rod_*_c_*.py"))
    before = (tmp_path / module).read_text(encoding="utf-8")
    shutil.rmtree(tmp_path / "short")
    assert rodgen("run", short, "--out", tmp_path, env=env).returncode == 0
    assert (tmp_path / module).read_text(encoding="utf-8") == before
    done = rodgen("derive", 3, "--out", tmp_path, env=env)
    assert done.returncode == 0
    assert "proven in" in done.stdout


def test_no_traces_outside_the_results(rodgen: Run, short: Path, tmp_path: Path) -> None:
    """No temporary files stay behind, and nothing is written where the command was called."""
    work = tmp_path / "work"
    work.mkdir()
    done = rodgen("run", short, "--out", tmp_path / "results", cwd=work)
    assert done.returncode == 0
    assert list(work.iterdir()) == []
    hidden = [name for name in os.listdir(tmp_path / "results" / "short") if name[0] == "."]
    assert hidden == []
