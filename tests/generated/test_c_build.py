"""A generated C file ends as a loaded library or as one BuildError, whatever happens."""

from __future__ import annotations

import ast
import math
import os
import shutil
import signal
import subprocess
import sys
import sysconfig
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import jinja2
import pytest
from rodgen.templates import c_build
from rodgen.templates.c_build import BuildError, load_library

REAL = next(filter(None, map(shutil.which, ("cc", "gcc", "clang"))), "")
pytestmark = pytest.mark.skipif(not REAL, reason="no C compiler on PATH")

DECLARATIONS = "double twice(double); int is_nan(double); double inverse(double, double);"
HEADER = DECLARATIONS.replace("; ", ";\n") + "\n"
SOURCE = """
#include "rod.h"
double twice(double x) { return 2.0*x; }
int is_nan(double x) { return x != x; }
double inverse(double x, double y) { return 1.0/(x + y); }
"""
LOAD = f"""
import signal, sys
from pathlib import Path
from rodgen.templates.c_build import load_library
signal.signal(signal.SIGINT, signal.default_int_handler)  # a background shell has it ignored
_, lib = load_library("rod", Path(sys.argv[1]), {DECLARATIONS!r})
print(lib.twice(21.0))
"""
# What a compiler has to answer before it is asked to build anything.
ANSWERS = '[ "$1" = --version ] && { echo fake 1.0; exit 0; }\n'
Fake = Callable[..., Path]


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    folder = tmp_path / "modules"
    folder.mkdir()
    (folder / "rod.c").write_text(SOURCE)
    (folder / "rod.h").write_text(HEADER)
    return folder


@pytest.fixture(autouse=True)
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The folder of C libraries in an empty cache; temporary files have a directory too."""
    for variable in ("CC", "RODGEN_CFLAGS", "XDG_CACHE_HOME"):
        monkeypatch.delenv(variable, raising=False)
    monkeypatch.setenv("RODGEN_CACHE", str(tmp_path / "cache"))
    (tmp_path / "temporary").mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path / "temporary"))
    return tmp_path / "cache" / "c"


@pytest.fixture
def fake(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Fake:
    """Set CC to a shell script; what it builds with is written to the log that is returned."""

    def make(body: str = f'exec {REAL} "$@"', answers: str = ANSWERS) -> Path:
        log, program = tmp_path / "log", tmp_path / "fakecc"
        program.write_text(f'#!/bin/sh\n{answers}echo "$@" >> "{log}"\n{body}\n')
        program.chmod(0o755)
        monkeypatch.setenv("CC", f"'{program}'")
        log.write_text("")
        return log

    return make


def _twice(folder: Path, stem: str = "rod") -> float:
    _, lib = load_library(stem, folder, DECLARATIONS)
    value: float = lib.twice(21.0)
    return value


def _fails(folder: Path, stem: str = "rod", declarations: str = DECLARATIONS) -> str:
    with pytest.raises(BuildError) as caught:
        load_library(stem, folder, declarations)
    message = str(caught.value)
    assert "--target numpy" in message
    return message


def _lines(log: Path) -> list[str]:
    return log.read_text().splitlines()


def _names(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.rglob("*") if not path.is_dir())


def _until(done: Callable[[], Any], seconds: float = 30.0) -> None:
    end = time.monotonic() + seconds
    while not done():
        assert time.monotonic() < end, "waited in vain"
        time.sleep(0.01)


def _alive(pid: int) -> bool:
    """Whether a process runs; one that has ended but that nobody has waited for does not."""
    done = subprocess.run(["ps", "-o", "stat=", "-p", str(pid)], capture_output=True, text=True)
    return done.stdout.strip()[:1] not in ("", "Z")


def _start(folder: Path, **environment: str) -> subprocess.Popen[str]:
    return subprocess.Popen(
        [sys.executable, "-c", LOAD, str(folder)],
        env={**os.environ, **environment},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


# The text


def test_text_can_be_pasted_into_a_module(folder: Path) -> None:
    text = Path(c_build.__file__).read_text(encoding="utf-8")
    loader = jinja2.DictLoader({"c_build.py": text, "module": "X = 1\n{% include 'c_build.py' %}"})
    pasted = jinja2.Environment(loader=loader, keep_trailing_newline=True)
    module = pasted.get_template("module").render()
    assert module == "X = 1\n" + text
    names: dict[str, Any] = {"__name__": "rod"}
    exec(compile(module, "<rod>", "exec"), names)
    assert names["load_library"]("rod", folder, DECLARATIONS)[1].twice(21.0) == 42.0


def test_text_needs_python_and_cffi_only() -> None:
    tree = ast.parse(Path(c_build.__file__).read_text(encoding="utf-8"))
    imported = {
        name.split(".")[0]
        for node in ast.walk(tree)
        for name in (
            [alias.name for alias in node.names]
            if isinstance(node, ast.Import)
            else [node.module or ""]
            if isinstance(node, ast.ImportFrom)
            else []
        )
    }
    assert imported <= sys.stdlib_module_names


# The cache


def test_library_is_built_once(folder: Path, cache: Path, tmp_path: Path, fake: Fake) -> None:
    log = fake()
    assert [_twice(folder) for _ in range(3)] == [42.0] * 3
    assert len(_lines(log)) == 1
    assert _names(cache) == ["rod.sha256", "rod.so"]
    assert not any((tmp_path / "temporary").iterdir())
    assert cache.stat().st_mode & 0o777 == 0o700


def test_default_flags_keep_nan_infinity_and_signed_zeros(folder: Path) -> None:
    _, lib = load_library("rod", folder, DECLARATIONS)
    assert [lib.is_nan(x) for x in (math.nan, math.inf, 0.0)] == [1, 0, 0]
    assert [lib.inverse(-0.0, y) for y in (0.0, -0.0)] == [math.inf, -math.inf]
    assert lib.inverse(math.inf, 1.0) == 0.0


def _other_source(folder: Path, _: Fake, __: pytest.MonkeyPatch) -> None:
    (folder / "rod.c").write_text(SOURCE.replace("2.0*x", "x + x"))


def _other_header(folder: Path, _: Fake, __: pytest.MonkeyPatch) -> None:
    (folder / "rod.h").write_text(HEADER + "\n")


def _other_flags(_: Path, __: Fake, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("RODGEN_CFLAGS", "-O1")


def _other_version(_: Path, fake: Fake, __: pytest.MonkeyPatch) -> None:
    fake(answers=ANSWERS.replace("1.0", "1.1"))


def _other_processor(_: Path, __: Fake, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(c_build, "_processor", lambda: "flags: none")


def _other_python(_: Path, __: Fake, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sysconfig, "get_config_var", lambda name: "cpython-399")


def _other_format(_: Path, __: Fake, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(c_build, "_FORMAT", "another")


CHANGES = [
    *(_other_source, _other_header, _other_flags, _other_version),
    *(_other_processor, _other_python, _other_format),
]


@pytest.mark.parametrize("change", CHANGES, ids=lambda change: change.__name__[1:])
def test_change_is_built_anew(
    change: Callable[..., None],
    folder: Path,
    cache: Path,
    fake: Fake,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    fake()
    assert _twice(folder) == 42.0
    change(folder, fake, monkeypatch)
    assert _twice(folder) == 42.0
    assert len(list(cache.glob("*/rod.so"))) == 2


DAMAGES: dict[str, Callable[[bytes, str], tuple[bytes | None, str | None]]] = {
    "truncated": lambda so, sums: (so[: len(so) // 2], sums),
    "empty": lambda so, sums: (b"", sums),
    "garbage": lambda so, sums: (b"\0garbage" * 500, sums),
    "wrong digest": lambda so, sums: (so, "0" * 64 + sums[64:]),
    "no digest": lambda so, sums: (so, None),
    "no library": lambda so, sums: (None, sums),
    "unreadable digest": lambda so, sums: (so, "\0\udcff"),
    # As another architecture's library would be: whole, but nothing to load.
    "foreign": lambda so, sums: (
        b"",
        "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855  rod.so\n",
    ),
}


@pytest.mark.parametrize("damage", DAMAGES)
def test_damaged_entry_is_built_anew(damage: str, folder: Path, cache: Path, fake: Fake) -> None:
    log = fake()
    _twice(folder)
    (library,) = cache.glob("*/rod.so")
    sums = library.with_suffix(".sha256")
    content, text = DAMAGES[damage](library.read_bytes(), sums.read_text())
    # New files: this process runs the library that it has loaded from the old one.
    library.unlink()
    sums.unlink()
    if content is not None:
        library.write_bytes(content)
    if text is not None:
        sums.write_bytes(text.encode(errors="surrogateescape"))
    assert [_twice(folder), _twice(folder)] == [42.0] * 2
    assert len(_lines(log)) == 2


def test_entry_is_a_file(folder: Path, cache: Path) -> None:
    _twice(folder)
    (entry,) = cache.iterdir()
    shutil.rmtree(entry)
    entry.write_text("not a directory")
    assert _twice(folder) == 42.0


def _root_is_a_file(cache: Path) -> None:
    cache.parent.write_text("not a directory")


def _folder_is_a_file(cache: Path) -> None:
    cache.parent.mkdir()
    cache.write_text("not a directory")


def _others_may_write(cache: Path) -> None:
    cache.mkdir(parents=True)
    cache.chmod(0o777)


def _group_may_write(cache: Path) -> None:
    cache.mkdir(parents=True)
    cache.chmod(0o770)


def _root_of_all(cache: Path) -> None:
    cache.mkdir(parents=True)
    cache.chmod(0o700)
    cache.parent.chmod(0o777)


UNUSABLE = [_root_is_a_file, _folder_is_a_file, _others_may_write, _group_may_write, _root_of_all]


@pytest.mark.parametrize("spoil", UNUSABLE, ids=lambda spoil: spoil.__name__[1:])
def test_unusable_cache_costs_only_time(
    spoil: Callable[[Path], None], folder: Path, cache: Path, tmp_path: Path, fake: Fake
) -> None:
    log = fake()
    spoil(cache)
    assert [_twice(folder), _twice(folder)] == [42.0] * 2
    assert len(_lines(log)) == 2
    assert not any((tmp_path / "temporary").iterdir())
    assert not cache.is_dir() or not any(cache.iterdir())


def test_library_of_another_user_is_not_loaded(
    folder: Path, cache: Path, fake: Fake, monkeypatch: pytest.MonkeyPatch
) -> None:
    log = fake()
    _twice(folder)
    me = os.getuid()
    monkeypatch.setattr(os, "getuid", lambda: me + 1)
    assert _twice(folder) == 42.0
    assert len(_lines(log)) == 2


def test_library_in_an_entry_open_to_others_is_not_loaded(
    folder: Path, cache: Path, fake: Fake
) -> None:
    log = fake()
    _twice(folder)
    next(cache.iterdir()).chmod(0o777)
    assert _twice(folder) == 42.0
    assert len(_lines(log)) == 2


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write anywhere")
def test_read_only_cache(folder: Path, cache: Path) -> None:
    cache.mkdir(parents=True)
    cache.chmod(0o500)
    assert _twice(folder) == 42.0
    assert not any(cache.iterdir())


def test_cache_that_refuses_new_files(
    folder: Path, cache: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As a read-only file system does, to root too."""
    usual = tempfile.mkdtemp

    def refuse(suffix: str | None = None, prefix: str | None = None, dir: Any = None) -> str:
        if dir is not None and Path(dir) == cache:
            raise OSError(30, "Read-only file system", str(dir))
        return usual(suffix, prefix, dir)

    monkeypatch.setattr(tempfile, "mkdtemp", refuse)
    assert _twice(folder) == 42.0
    assert not any(cache.iterdir())


def test_cache_from_which_nothing_may_be_run(folder: Path, cache: Path, fake: Fake) -> None:
    """A library that loads only where it is built outside the cache."""
    fake(f'case "$PWD" in */cache/*) echo no > rod.so;; *) exec {REAL} "$@";; esac')
    assert _twice(folder) == 42.0
    assert not any(cache.iterdir())


def test_user_without_a_home(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def home() -> Path:
        raise RuntimeError("Could not determine home directory.")

    monkeypatch.setattr(Path, "home", home)
    monkeypatch.delenv("RODGEN_CACHE")
    assert _twice(folder) == 42.0


def test_cache_root(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The rules of loading.cache, of which this file must hold a copy."""
    from rodgen.loading.cache import cache_root

    for override in (str(tmp_path), "relative", "", None):
        for base in (str(tmp_path / "xdg"), "relative", "", None):
            for variable, value in (("RODGEN_CACHE", override), ("XDG_CACHE_HOME", base)):
                if value is None:
                    monkeypatch.delenv(variable, raising=False)
                else:
                    monkeypatch.setenv(variable, value)
            assert c_build._root() == cache_root()


def test_nowhere_to_build(folder: Path, cache: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    _root_is_a_file(cache)
    monkeypatch.setattr(tempfile, "tempdir", str(folder / "rod.c"))
    assert "RODGEN_CACHE and TMPDIR" in _fails(folder)


@pytest.mark.parametrize("name", ["with some spaces", "Prüfkörper-棒", "quote's $HOME; *"])
def test_names_of_folders(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder = tmp_path / name / "modules"
    folder.mkdir(parents=True)
    (folder / "rod.c").write_text(SOURCE)
    (folder / "rod.h").write_text(HEADER)
    monkeypatch.setenv("RODGEN_CACHE", str(tmp_path / name / "cache"))
    assert [_twice(folder), _twice(folder)] == [42.0] * 2
    assert _names(tmp_path / name / "cache") == ["rod.sha256", "rod.so"]


# The compiler


def test_compiler_with_arguments(folder: Path, fake: Fake, monkeypatch: pytest.MonkeyPatch) -> None:
    """As `ccache gcc` is: a program that is told the compiler."""
    log = fake('exec "$@"', answers="")
    monkeypatch.setenv("CC", f"{os.environ['CC']} {REAL} -DWITH='\"a b\"'")
    (folder / "rod.c").write_text(SOURCE + "const char *with = WITH;\n")
    assert _twice(folder) == 42.0
    version, build = _lines(log)
    assert version.endswith("--version")
    assert build.startswith(f'{REAL} -DWITH="a b" -std=c99')


@pytest.mark.parametrize(
    ("refused", "used"),
    [
        ("-mprefer-vector-width=512", "-O3 -march=native"),
        ("-march=native", "-O2"),
        ("-O3", "-O2"),
    ],
)
def test_refused_flags_are_replaced(
    refused: str, used: str, folder: Path, fake: Fake, monkeypatch: pytest.MonkeyPatch
) -> None:
    log = fake(
        f'for a; do [ "$a" = {refused} ] && {{ echo unknown; exit 1; }}; done; exec {REAL} "$@"'
    )
    monkeypatch.setattr(c_build, "_processor", lambda: "flags: sse2 avx512f")
    assert [_twice(folder), _twice(folder)] == [42.0] * 2
    *before, last = _lines(log)
    assert before
    assert all(refused in line for line in before)
    assert used in last
    assert refused not in last


def test_given_flags_take_the_place_of_the_default(
    folder: Path, fake: Fake, monkeypatch: pytest.MonkeyPatch
) -> None:
    log = fake()
    monkeypatch.setenv("RODGEN_CFLAGS", "-O1 -DNAME='\"a b\"'")
    (folder / "rod.c").write_text(SOURCE + "const char *name = NAME;\n")
    assert _twice(folder) == 42.0
    (line,) = _lines(log)
    assert "-O1" in line
    assert not any(flag in line for flag in c_build.FLAGS)


def test_given_flags_that_are_refused_are_not_replaced(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("RODGEN_CFLAGS", "--no-such-flag")
    assert "--no-such-flag" in _fails(folder)


@pytest.mark.parametrize("variable", ["CC", "RODGEN_CFLAGS"])
def test_words_that_no_shell_reads(
    variable: str, folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv(variable, "cc 'open")
    assert f"{variable}=cc 'open" in _fails(folder)


@pytest.mark.parametrize("command", ["no-such-compiler -m64", "/no/such/cc", "''"])
def test_given_compiler_is_missing(
    command: str, folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    _twice(folder)
    monkeypatch.setenv("CC", command)
    assert f"CC={command}: no such program" in _fails(folder)


def test_no_compiler(folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PATH", str(tmp_path / "temporary"))
    assert "cc, gcc, clang" in _fails(folder)


def test_no_compiler_any_more(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert _twice(folder) == 42.0
    monkeypatch.setenv("PATH", str(tmp_path / "temporary"))
    assert _twice(folder) == 42.0
    (folder / "rod.c").write_text(SOURCE + "\n")
    assert "cc, gcc, clang" in _fails(folder)


def test_first_compiler_on_path_is_used(
    folder: Path, tmp_path: Path, fake: Fake, monkeypatch: pytest.MonkeyPatch
) -> None:
    log = fake()
    monkeypatch.delenv("CC")
    programs = tmp_path / "bin"
    programs.mkdir()
    (programs / "clang").symlink_to(log.parent / "fakecc")
    monkeypatch.setenv("PATH", str(programs))
    # The script calls the real compiler, which looks for its assembler.
    script = (log.parent / "fakecc").read_text().replace("exec", f"PATH={os.defpath} exec")
    (log.parent / "fakecc").write_text(script)
    assert _twice(folder) == 42.0
    assert len(_lines(log)) == 1


FAILING = {
    "an error": ("echo 'rod.c:3: so wrong' >&2; exit 1", "so wrong"),
    "a crash": ("kill -SEGV $$", "exit status -11"),
    "no file": ("exit 0", "it wrote no file"),
    "an empty file": (": > rod.so", "too short|cannot be built and loaded"),
    "garbage": ("echo garbage > rod.so", "cannot be built and loaded"),
    "half a file": (
        f'{REAL} "$@"; head -c 60 rod.so > half; mv half rod.so',
        "cannot be built and loaded",
    ),
    "a folder": ("mkdir -p rod.so", "it wrote no file"),
}


@pytest.mark.parametrize("what", FAILING)
def test_failing_compiler(what: str, folder: Path, cache: Path, tmp_path: Path, fake: Fake) -> None:
    script, expected = FAILING[what]
    fake(script)
    message = _fails(folder)
    assert any(part in message for part in expected.split("|"))
    assert not any(cache.iterdir())
    assert not any((tmp_path / "temporary").iterdir())


def test_last_lines_of_the_compiler_are_shown(folder: Path, fake: Fake) -> None:
    fake("seq 100; exit 1")
    lines = _fails(folder).splitlines()
    assert [line.strip() for line in lines[1:-1]] == [str(i) for i in range(89, 101)]


def test_source_with_an_error(folder: Path) -> None:
    (folder / "rod.c").write_text("no C at all\n")
    assert "error" in _fails(folder)


def test_function_that_is_nowhere(folder: Path) -> None:
    (folder / "rod.c").write_text(SOURCE + "void no_such(void); void f(void) { no_such(); }\n")
    assert "no_such" in _fails(folder)


def test_compiler_without_a_version(folder: Path, fake: Fake) -> None:
    """As tcc is."""
    log = fake(answers='[ "$1" = --version ] && { echo no input files; exit 1; }\n')
    assert [_twice(folder), _twice(folder)] == [42.0] * 2
    assert len(_lines(log)) == 1


def test_compiler_that_only_crashes(folder: Path, fake: Fake) -> None:
    fake(answers="kill -SEGV $$\n")
    assert "exit status -11" in _fails(folder)


@pytest.mark.parametrize("content", ["#!/no/such/shell\n", "\0\0not a program"])
def test_compiler_that_cannot_be_started(content: str, folder: Path, fake: Fake) -> None:
    (fake().parent / "fakecc").write_text(content)
    assert "fakecc --version: " in _fails(folder)


@pytest.mark.parametrize("limit", ["_BUILD_LIMIT", "_VERSION_LIMIT"])
def test_compiler_that_hangs_is_killed_with_its_children(
    limit: str,
    folder: Path,
    cache: Path,
    tmp_path: Path,
    fake: Fake,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    hang = f'sleep 1000 & echo $! > "{tmp_path}/child"; wait\n'
    fake(hang, answers=hang if limit == "_VERSION_LIMIT" else ANSWERS)
    monkeypatch.setattr(c_build, limit, 1.0)
    assert "killed after 1 s" in _fails(folder)
    child = int((tmp_path / "child").read_text())
    _until(lambda: not _alive(child))
    assert not cache.exists() or not any(cache.iterdir())


# Files and cffi


@pytest.mark.parametrize("suffix", [".c", ".h"])
def test_missing_file(suffix: str, folder: Path) -> None:
    (folder / f"rod{suffix}").unlink()
    message = _fails(folder)
    assert f"{folder}/rod{suffix}: No such file" in message
    assert "generate both again" in message


def test_missing_cffi(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "cffi", None)
    assert "pip install cffi" in _fails(folder)


def test_cffi_of_two_versions(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    class Broken:
        def __init__(self) -> None:
            raise Exception("Version mismatch: this is the 'cffi' package version 0")

    monkeypatch.setattr("cffi.FFI", Broken)
    assert "Version mismatch" in _fails(folder)


def test_declarations_that_are_none(folder: Path) -> None:
    assert "cffi refuses the declarations" in _fails(folder, declarations="double twice(")


# Several processes


@pytest.fixture
def slow(tmp_path: Path, fake: Fake) -> Iterator[Path]:
    """A compiler that never ends; its process id is written to the file that is yielded."""
    pid = tmp_path / "pid"
    fake(f'echo $$ > "{pid}.part"; mv "{pid}.part" "{pid}"; exec sleep 1000')
    yield pid
    if pid.exists() and _alive(int(pid.read_text())):
        os.kill(int(pid.read_text()), signal.SIGKILL)


@pytest.mark.parametrize("damaged", [False, True], ids=["empty", "damaged"])
def test_ten_processes_at_once(damaged: bool, folder: Path, cache: Path, fake: Fake) -> None:
    log = fake(f'sleep 0.3; exec {REAL} "$@"')
    if damaged:
        _twice(folder)
        (library,) = cache.glob("*/rod.so")
        library.unlink()
        library.write_bytes(b"garbage")
    processes = [_start(folder) for _ in range(10)]
    for process in processes:
        output, errors = process.communicate(timeout=120)
        assert (process.returncode, output, errors) == (0, "42.0\n", "")
    assert _names(cache) == ["rod.sha256", "rod.so"]
    before = len(_lines(log))
    assert _twice(folder) == 42.0
    assert len(_lines(log)) == before


def test_build_killed_half_way(
    folder: Path, cache: Path, slow: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    process = _start(folder)
    _until(slow.exists)
    process.kill()
    process.communicate(timeout=60)
    (left,) = cache.iterdir()
    monkeypatch.delenv("CC")
    assert _twice(folder) == 42.0
    assert left.exists(), "another process may still be at work there"
    old = time.time() - 2 * 86400
    os.utime(left, (old, old))
    (folder / "rod.c").write_text(SOURCE + "\n")
    assert _twice(folder) == 42.0
    assert not left.exists()


def test_ctrl_c_ends_the_compiler_too(folder: Path, cache: Path, slow: Path) -> None:
    process = _start(folder)
    _until(slow.exists)
    process.send_signal(signal.SIGINT)
    _, errors = process.communicate(timeout=60)
    assert "KeyboardInterrupt" in errors
    _until(lambda: not _alive(int(slow.read_text())))
    assert not any(cache.iterdir())


def test_source_changes_while_it_is_built(folder: Path, fake: Fake) -> None:
    """What is stored under the hash of a text is built from that text."""
    other = SOURCE.replace("2.0*x", "3.0*x")
    script = f"cat > '{folder}/rod.c' <<'END'\n{other}\nEND\n"
    fake(f'{script}exec {REAL} "$@"')
    assert _twice(folder) == 42.0
    fake()
    assert _twice(folder) == 63.0
    (folder / "rod.c").write_text(SOURCE)
    assert _twice(folder) == 42.0
