"""Builder and loader of C libraries.

Generated C modules are built by it: here, and beside modules where rodgen is not installed, so
that it needs Python's own library and cffi, and nothing of rodgen. A library is built in a
directory of its own, loaded from there, then moved into the user's cache whole. Whatever in the
cache is not what was stored is built again, and a cache that cannot be used only costs time.
"""

import hashlib
import os
import platform
import shlex
import shutil
import signal
import stat
import subprocess
import sysconfig
import tempfile
import threading
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from importlib import import_module
from itertools import takewhile
from pathlib import Path
from types import FrameType
from typing import Any

# Not -ffast-math: NaN, infinity, signed zeros and the order of a sum keep their meaning.
# Products of complex numbers are not looked at for infinities again: their parts show them.
_PLAIN = ("-O3", "-march=native", "-ffp-contract=fast", "-fno-math-errno", "-fno-trapping-math")
FLAGS = (*_PLAIN, "-fcx-limited-range")
_WIDE = "-mprefer-vector-width=512"  # Else compilers use half of AVX-512's width.
_PORTABLE = ("-O2",)  # For compilers that refuse FLAGS.
_SHARED = ("-std=c99", "-fPIC", "-shared")
# Seconds. A long chain at -O3 on a busy machine takes minutes; what takes longer hangs.
_BUILD_LIMIT, _VERSION_LIMIT, _STALE = 600.0, 60.0, 86400.0
_WORK = ".build-"
# What others may not do to the root of the cache: a group may write into it, but not where texts
# and libraries lie.
ROOT_OTHERS = 0o002
_FORMAT = "rodgen C cache 1"


class BuildError(RuntimeError):
    """A C module that cannot be compiled or loaded: why, and what there is instead.

    Examples
    --------
    >>> import rodgen
    >>> scene = rodgen.Scene.example("missile")
    >>> try:
    ...     model = rodgen.build(scene, target="c")
    ... except rodgen.BuildError:
    ...     model = rodgen.build(scene, target="numpy")
    """


def library_environment() -> tuple[str | None, ...]:
    """Environment variables by which a library is built, and by which its place is found."""
    names = ("CC", "RODGEN_CFLAGS", "RODGEN_CACHE", "XDG_CACHE_HOME", "PATH")
    return tuple(map(os.environ.get, names))


def _build_error(problem: str, output: str = "") -> BuildError:
    last = [f"    {line[:200]}" for line in output.strip().splitlines()[-12:]]
    advice = (
        "The NumPy target needs no compiler: --target numpy in rodgen derive and rodgen run, "
        'rodgen.build(scene, target="numpy") in Python'
    )
    return BuildError("\n".join([problem, *last, advice]))


def load_library(
    stem: str, folder: Path, declarations: str, files: Sequence[str] = ()
) -> tuple[Any, Any]:
    """Build <folder>/<stem>.c (with <stem>.h beside it) unless the cache has it, and load it.

    declarations: what cffi is told of the library; files: names of all files of a library that is
    made of others. Returns cffi's FFI object and the library; raises BuildError, and nothing else,
    where there is none to be had.

    The environment: CC (a command, with arguments if need be), RODGEN_CFLAGS (in place of FLAGS),
    RODGEN_CACHE or XDG_CACHE_HOME.
    """
    ffi = _declare(declarations)
    sources = _read(stem, Path(folder), files or (f"{stem}.c", f"{stem}.h"))
    processor = processor_features()
    flag_sets = flag_choices(processor)
    wanted = _digest(
        *(_FORMAT, sysconfig.get_config_var("SOABI"), processor, _SHARED, flag_sets, sources)
    )
    compiler = compiler_command()
    # Whatever it answers, with whatever status: whether it compiles is seen when it does.
    version = _run_command([*compiler, "--version"], _VERSION_LIMIT) if compiler else None
    built_by = _digest(compiler, version) if compiler else "*"
    cache = _cache()
    # Without a compiler, what any compiler made of the same source with the same flags will do.
    for entry in sorted(cache.glob(f"{wanted}-{built_by}")) if cache else ():
        library = _load_from_cache(ffi, entry / f"{stem}.so")
        if library is not None:
            return ffi, library
    if not compiler:
        raise _build_error(
            "no C compiler: none of cc, gcc, clang is on PATH; install one or set CC"
        )
    # A cache that takes no files, or from which nothing may be run: a temporary directory does.
    for place in (cache, None) if cache else (None,):
        try:
            with tempfile.TemporaryDirectory(
                prefix=_WORK, dir=place, ignore_cleanup_errors=True
            ) as work:
                file = _compile(stem, sources, Path(work), compiler, flag_sets)
                library = ffi.dlopen(str(file))
                if place:
                    _store(file, place / f"{wanted}-{built_by}")
                return ffi, library
        except (OSError, UnicodeError) as error:
            problem = f"{stem}.c cannot be built and loaded by {shlex.join(compiler)}: {error}"
    raise _build_error(f"{problem}; RODGEN_CACHE and TMPDIR say where it is tried")


def _declare(declarations: str) -> Any:
    try:
        ffi = import_module("cffi").FFI()
        ffi.cdef(declarations)
    except ImportError as error:
        raise _build_error(f"cffi is missing ({error}): pip install cffi") from error
    except Exception as error:  # A backend of another version is a bare Exception to cffi.
        raise _build_error(f"cffi refuses the declarations: {error}") from error
    return ffi


def _read(stem: str, folder: Path, files: Sequence[str]) -> dict[str, bytes]:
    try:
        return {name: (folder / name).read_bytes() for name in files}
    except OSError as error:
        raise _build_error(
            f"{error.filename}: {error.strerror}; it belongs beside {stem}.py: generate both again"
        ) from error


def _digest(*parts: object) -> str:
    return hashlib.sha256(repr(parts).encode()).hexdigest()[:32]


def processor_features() -> str:
    """Features of the processor, for -march=native; the first processor speaks for all."""
    try:
        with open("/proc/cpuinfo", encoding="utf-8", errors="replace") as file:
            lines = list(takewhile(str.strip, file))
    except OSError:
        lines = [platform.processor()]
    names = ("flags", "Features", "model name")
    kept = [line for line in lines if line.partition(":")[0].strip() in names]
    return "".join([platform.machine(), "\n", *(kept or lines)])


def _environment_words(variable: str) -> list[str]:
    """Words of an environment variable; none if it is not set."""
    given = os.environ.get(variable, "")
    try:
        return shlex.split(given)
    except ValueError as error:
        raise _build_error(
            f"{variable}={given}: not words as a shell has them ({error})"
        ) from error


def flag_choices(processor: str) -> list[tuple[str, ...]]:
    """Flags to try, the first that the compiler takes being used."""
    given = _environment_words("RODGEN_CFLAGS")
    if given:
        return [tuple(given)]
    wide = [(*FLAGS, _WIDE)] if "avx512f" in processor.split() else []
    return [*wide, FLAGS, _PLAIN, _PORTABLE]


def compiler_command() -> list[str]:
    """Command of the compiler: CC, else cc, gcc or clang; empty if there is none."""
    given = _environment_words("CC")
    for command in [given] if given else [["cc"], ["gcc"], ["clang"]]:
        program = shutil.which(command[0])
        if program and Path(program).stem.lower() == "cl":
            raise _build_error("CC=cl: MSVC does not compile this C99; set CC to gcc or clang")
        if program:
            return [os.path.abspath(program), *command[1:]]
    if given:
        raise _build_error(f"CC={shlex.join(given)}: no such program; set CC to a C compiler")
    return []


def _cache() -> Path | None:
    """The cache's folder of C libraries; None where it cannot be used or trusted."""
    try:
        root = cache_root().absolute()
        root.mkdir(mode=0o700, parents=True, exist_ok=True)
        if not is_ours(root.stat(), ROOT_OTHERS):
            return None
        (root / "c").mkdir(mode=0o700, exist_ok=True)
        return root / "c" if is_ours((root / "c").stat()) else None
    except (OSError, RuntimeError):  # RuntimeError: a user without a home.
        return None


def cache_root() -> Path:
    """Root of the cache: RODGEN_CACHE, else rodgen in XDG_CACHE_HOME, else ~/.cache/rodgen."""
    override = os.environ.get("RODGEN_CACHE")
    if override:
        return Path(override)
    base = os.environ.get("XDG_CACHE_HOME")
    return (Path(base) if base and Path(base).is_absolute() else Path.home() / ".cache") / "rodgen"


def is_ours(status: os.stat_result, others: int = 0o022) -> bool:
    """Whether a file or folder is this user's, and others cannot write it."""
    if not hasattr(os, "getuid"):
        return True
    return status.st_uid == os.getuid() and not status.st_mode & others


def read_own(path: Path) -> bytes:
    """Content of a file that is this user's, and that others cannot write. Raises OSError for any
    other, and for what is no plain file: a pipe is not waited for, nor a link followed."""
    how = sum(getattr(os, flag, 0) for flag in ("O_NOFOLLOW", "O_NONBLOCK", "O_BINARY"))
    with open(os.open(path, os.O_RDONLY | how), "rb") as file:
        status = os.fstat(file.fileno())
        if not (stat.S_ISREG(status.st_mode) and is_ours(status)):
            raise PermissionError(path)
        return file.read()


def _load_from_cache(ffi: Any, library: Path) -> Any | None:
    """Load a library of the cache, or None: to load half a file can end the process."""
    try:
        return ffi.dlopen(str(library)) if _is_whole(library) else None
    except (OSError, UnicodeError):
        with suppress(OSError):  # Of another system, say: one that can be loaded takes its place.
            library.with_suffix(".sha256").unlink()
        return None


def _is_whole(library: Path) -> bool:
    try:
        kept = read_own(library.with_suffix(".sha256"))
        return is_ours(library.parent.stat()) and kept == _checksum(library).encode()
    except OSError:
        return False


def _checksum(library: Path) -> str:
    """Checksum of a library, as sha256sum writes it."""
    return f"{hashlib.sha256(read_own(library)).hexdigest()}  {library.name}\n"


def _store(library: Path, entry: Path) -> None:
    """Move a library into the cache; half of it, or of another, is seen to be that and rebuilt."""
    target, sums = entry / library.name, library.with_suffix(".sha256")
    with suppress(OSError):
        for left in entry.parent.glob(f"{_WORK}*"):
            if time.time() - left.stat().st_mtime > _STALE:
                shutil.rmtree(left, ignore_errors=True)
    with suppress(OSError):
        entry.mkdir(mode=0o700, exist_ok=True)
        if _is_whole(target):  # Another process was first, and others use its file.
            return
        library.chmod(0o700)  # Whatever the user's mask lets others do.
        sums.write_text(_checksum(library), encoding="utf-8")
        sums.chmod(0o600)
        os.replace(library, target)
        os.replace(sums, target.with_suffix(".sha256"))


def _compile(
    stem: str,
    sources: dict[str, bytes],
    work: Path,
    compiler: list[str],
    flag_sets: list[tuple[str, ...]],
) -> Path:
    """Compile a copy of the sources: the very bytes that the cache's key was made of."""
    for name, content in sources.items():
        (work / name).parent.mkdir(exist_ok=True)
        (work / name).write_bytes(content)
    texts = [name for name in sources if name.endswith(".c")]
    library = work / f"{stem}.so"
    for flags in flag_sets:
        command = [*compiler, *_SHARED, *flags, *texts, "-o", library.name, "-lm"]
        status, output = _run_command(command, _BUILD_LIMIT, work)
        if status == 0 and library.is_file():
            return library
    problem = f"exit status {status}" if status else "it wrote no file"
    raise _build_error(f"{shlex.join(command)}: {problem}", output)


def _run_command(command: list[str], limit: float, folder: Path | None = None) -> tuple[int, str]:
    """Exit status and output of a command, killed with all that it started after limit [s]."""
    try:
        with _command_process(command, folder) as process:
            output, _ = process.communicate(timeout=limit)
    except subprocess.TimeoutExpired as error:
        raise _build_error(f"{shlex.join(command)}: killed after {limit:.0f} s") from error
    except OSError as error:
        raise _build_error(f"{shlex.join(command)}: {error.strerror}") from error
    return process.returncode, output.decode(errors="replace")


@contextmanager
def _command_process(
    command: list[str], folder: Path | None
) -> Iterator["subprocess.Popen[bytes]"]:
    """Run a command inside the context; it is killed where nobody can wait for it."""
    process = None
    try:
        with DeferredInterrupt():  # One that is raised within Popen leaves what it has started.
            process = subprocess.Popen(
                command,
                cwd=folder,
                env={**os.environ, "LC_ALL": "C"},  # One key and one message in every language.
                stdin=subprocess.DEVNULL,
                stdout=subprocess.PIPE,
                stderr=subprocess.STDOUT,
                start_new_session=True,
            )
            _running.add(process.pid)
        yield process
    except BaseException:
        if process is not None:
            _kill(process.pid)
        raise
    finally:
        if process is not None:
            with process:  # Its pipe is closed, and it is waited for.
                _running.discard(process.pid)


# Compilers that run now, each the leader of a session of its own.
_running: set[int] = set()


def end_compilers() -> None:
    """Kill all compilers that run for this process: whoever waits for one, in another thread, is
    told that it failed."""
    for pid in tuple(_running):
        _kill(pid)


def _kill(pid: int) -> None:
    with suppress(ProcessLookupError):
        if hasattr(os, "killpg"):
            os.killpg(pid, signal.SIGKILL)
        else:  # Windows, where any signal ends a process at once.
            os.kill(pid, signal.SIGTERM)


ENDS = "ends_as_by_default"  # attribute of a handler of Ctrl-C that raises KeyboardInterrupt


class DeferredInterrupt:
    """Context in which Ctrl-C leaves a note, which `raise_pending` turns into KeyboardInterrupt.

    Where Python would raise it at once, a step might be taken and its samples not. One still
    pending is raised at the end. In threads, and where the program has a handler of its own,
    nothing is changed.
    """

    def __init__(self) -> None:
        self._noted = False
        self._before: Any = None

    def __enter__(self) -> "DeferredInterrupt":
        main = threading.current_thread() is threading.main_thread()
        there = signal.getsignal(signal.SIGINT)
        if main and (there is signal.default_int_handler or getattr(there, ENDS, False)):
            self._before = signal.signal(signal.SIGINT, self._note)
        return self

    def _note(self, number: int, frame: FrameType | None) -> None:
        self._noted = True

    def raise_pending(self) -> None:
        """Raise KeyboardInterrupt if there was one."""
        if self._noted:
            self._noted = False
            raise KeyboardInterrupt

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        if self._before is not None:
            signal.signal(signal.SIGINT, self._before)
        if kind is None:
            self.raise_pending()
