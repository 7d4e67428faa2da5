"""Surroundings on which measurements depend: versions, sources, processor, compiler."""

from __future__ import annotations

import hashlib
import os
import platform
import subprocess
from functools import lru_cache
from importlib.metadata import PackageNotFoundError, version
from importlib.util import find_spec
from pathlib import Path

from rodgen.loading import cache
from rodgen.native import library as c_library

PACKAGES = ("sympy", "mpmath", "numpy", "scipy", "jinja2", "xarray", "threadpoolctl", "cffi")
PEERS = ("scikit-sundae", "heyoka", "mujoco", "exudyn", "casadi", "pin", "numba", "pydy")
RUNTIME = ("rodgen.loading", "rodgen.integrate", "rodgen.analyse")
ABSENT = "not installed"


def versions() -> dict[str, str]:
    """Versions of rodgen, of what it needs and of peers, by name of distribution."""
    return {name: _version(name) for name in ("rodgen", *PACKAGES, *PEERS)}


def _version(name: str) -> str:
    try:
        return version(name)
    except PackageNotFoundError:
        return ABSENT


def machine() -> dict[str, str]:
    """Python, system, processor and compiler, in words."""
    return {
        "Python": platform.python_version(),
        "system": f"{platform.system()} {platform.machine()}",
        "processor": processor(),
        "cores": str(_cores()),
        "C compiler": compiler(),
        "C flags": flags(),
    }


def flags() -> str:
    """Flags of the C target, as far as the compiler takes them."""
    return " ".join(c_library.flag_choices(c_library.processor_features())[0])


def _cores() -> int:
    """Cores that this process may use."""
    can = getattr(os, "sched_getaffinity", None)
    return len(can(0)) if can else os.cpu_count() or 1


@lru_cache(maxsize=1)
def compiler() -> str:
    """Version that the compiler of the C target prints."""
    try:
        command = c_library.compiler_command()
        said = subprocess.run(
            [*command, "--version"], capture_output=True, text=True, timeout=10, check=False
        )
        return said.stdout.splitlines()[0]
    except (OSError, subprocess.SubprocessError, RuntimeError, IndexError):
        return ABSENT


def processor() -> str:
    """Name of the processor, as far as the system tells it."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        lines = []
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.processor() or platform.machine()


@lru_cache(maxsize=32)
def sources(*packages: str) -> str:
    """Content hash of the sources of packages, with those inside them."""
    digest = hashlib.sha256()
    for package in packages:
        spec = find_spec(package)
        for folder in spec.submodule_search_locations or [] if spec else []:
            for file in sorted(Path(folder).rglob("*")):
                if file.suffix in (".py", ".c"):
                    digest.update(file.name.encode() + b"\0" + file.read_bytes() + b"\0")
    return digest.hexdigest()


def fingerprint() -> list[str]:
    """List what every measurement depends on: what is measured, and on what."""
    known = {**versions(), **machine()}
    return [
        *(f"{name} {value}" for name, value in sorted(known.items())),
        cache.source_hash(*cache.PACKAGES, "rodgen.check"),
        sources(*RUNTIME),
    ]
