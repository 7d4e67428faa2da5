"""Builder of the module of a scene: emitted if it is not in the cache yet, then loaded."""

from __future__ import annotations

import copyreg
import json
import time
from collections.abc import Iterable, Mapping
from concurrent.futures import Future, ThreadPoolExecutor
from functools import lru_cache
from importlib.resources import files
from itertools import chain
from types import ModuleType
from typing import Any, Protocol

from rodgen.emit.targets import available_parts, check_output, required_parts, target_of
from rodgen.errors import InputError
from rodgen.loading import cache
from rodgen.loading.generated_module import Model, load_files, structure_of
from rodgen.native import native_batch, native_run
from rodgen.native.library import (
    BuildError,
    DeferredInterrupt,
    end_compilers,
    library_environment,
)
from rodgen.progress import COMPILING, DERIVING, report_stage, show_work
from rodgen.scene import Structure

# The dense form holds a few matrices of this many links squared.
MOST_DENSE_LINKS = 5000


class HasStructure(Protocol):
    """A scene, or what is made of one, such as a System."""

    @property
    def structure(self) -> Structure:
        """Structure of its module."""


def build(
    scene: HasStructure | Structure,
    target: str = "numpy",
    form: str = "chain",
    parts: Iterable[str] = ("rhs",),
) -> ModuleType:
    """Return the generated module of a scene.

    The module has `rhs(t, y, p)` and, when they are asked for, `jac`, `energy`, `joints` and what
    else stands in its docstrings. Terminals and notebooks show a bar of what takes more than a
    second.

    Parameters
    ----------
    scene
        A scene, a System, or the structure of one.
    target
        "numpy" or "c".
    form
        "chain", O(n), or for NumPy "dense", which has the mass matrix.
    parts
        What of the module is made at once, by the names of `rodgen derive --parts`. Everything else
        is made when it is asked for.

    Returns
    -------
    module
        Functions of the time t [s], states y (states,) and parameters p, in SI units.

    Raises
    ------
    InputError
        For what is not offered, and for more links than the dense form can hold.
    BuildError
        Where a C module cannot be compiled or loaded.

    Examples
    --------
    >>> import rodgen
    >>> rod = rodgen.build(rodgen.Structure(2, "pinned", terms=("gravity",)))
    >>> rod.STATE
    ('phi_0', 'phi_1', 'omega_0', 'omega_1')
    >>> p = rod.parameters(mass=1.0, length=1.0, bending_stiffness=0.0, gravity=9.81)
    >>> rod.rhs(0.0, [0.0, 0.0, 0.0, 0.0], p).round(3)
    array([  0.   ,   0.   , -25.226,   8.409])
    """
    structure, parts = _structure(scene), tuple(parts)
    check_output(target, form)
    required_parts(target, parts)
    if form == "dense" and structure.n_links > MOST_DENSE_LINKS:
        allowed = f"at most {MOST_DENSE_LINKS} in the dense form: it holds links^2 numbers"
        raise InputError("rod.links", structure.n_links, allowed)
    # What a C module is compiled by belongs to it, and so does where it would be kept.
    model = _cached_model(structure, target, form, library_environment())
    model.make(parts)
    return model


def _reduce(module: Model) -> tuple[Any, ...]:
    """Reduce a module for pickling to the call that builds it again."""
    return build, (structure_of(module), module.PROVENANCE["target"], module.PROVENANCE["form"])


copyreg.pickle(Model, _reduce)


@lru_cache(maxsize=16)
def _cached_model(
    structure: Structure, target: str, form: str, around: tuple[str | None, ...]
) -> Model:
    """Module that is loaded once in a process, without parts at first."""

    def make_parts(parts: Iterable[str]) -> dict[str, Mapping[str, Any]]:
        with show_work("generating"):
            return _load(structure, target, form, tuple(parts))

    return Model(structure.module_stem(target, form), make_parts)


def _load(
    structure: Structure, target: str, form: str, parts: tuple[str, ...]
) -> dict[str, Mapping[str, Any]]:
    """Load namespaces of parts: while one is compiled, the next is derived."""
    making: dict[str, Future[ModuleType]] = {}
    steps: Future[Any] | None = None
    with ThreadPoolExecutor() as pool:
        try:
            with DeferredInterrupt():  # what was begun is known, so that it can be ended
                steps = pool.submit(native_run.step_library) if "flow" in parts else None
            for part in parts:
                texts = _texts(structure, target, form, (part,))
                with DeferredInterrupt():
                    making[part] = pool.submit(load_files, texts, whole=False)
            if target_of(target).compiled:
                report_stage(COMPILING)
            made: dict[str, Mapping[str, Any]] = {
                part: vars(module.result()) for part, module in making.items()
            }
            if steps is not None:
                steps.result()
            return made
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            begun = [*making.values(), *([steps] if steps else [])]
            with DeferredInterrupt():
                while not all(work.done() for work in begun):  # one may be about to begin
                    end_compilers()
                    time.sleep(0.01)
            raise


def build_fastest(scene: HasStructure | Structure, parts: Iterable[str] = ("rhs",)) -> ModuleType:
    """The C module of a scene where it can be built, else its NumPy module."""
    return build_or_explain(scene, parts)[0]


def build_or_explain(
    scene: HasStructure | Structure, parts: Iterable[str] = ("rhs",)
) -> tuple[ModuleType, str]:
    """C module of a scene and "", or where it cannot be built its NumPy module and the reason."""
    parts = tuple(parts)
    try:
        return build(scene, "c", parts=parts), ""
    except BuildError as error:
        kept = [part for part in parts if part in available_parts("numpy")] or ["rhs"]
        return build(scene, "numpy", parts=kept), str(error).partition("\n")[0]


def sources(
    scene: HasStructure | Structure,
    target: str = "numpy",
    form: str = "chain",
    parts: Iterable[str] | None = None,
    steps: bool = False,
) -> dict[str, str]:
    """Texts of the generated module of a scene by file name, the Python module first; from the
    cache where they are there.

    parts, steps: as `rodgen.emit.module_files` has them.
    """
    structure = _structure(scene)
    check_output(target, form)
    return _texts(structure, target, form, required_parts(target, parts, steps), steps)


# Step loops that parts of a compiled module call, and what calls them in Python.
LOOPS = {
    "flow": ("native_run.py", *native_run.FILES),
    "newton": ("native_run.py", *native_run.FILES),
    "tangents": ("native_run.py", *native_run.FILES),
    "lanes": ("native_run.py", "native_batch.py", *native_batch.FILES),
}


def companions(
    target: str, parts: Iterable[str] | None = None, steps: bool = False
) -> dict[str, str]:
    """Texts of the files that generated modules of a target need beside them where rodgen is not
    installed, by file name: what builds C, and the step loops that some parts call.

    parts, steps: as `rodgen.emit.module_files` has them.
    """
    if not target_of(target).compiled:
        return {}
    loops = (LOOPS.get(part, ()) for part in required_parts(target, parts, steps))
    names = dict.fromkeys(
        ("__init__.py", "library.py", "function_pointers.py", *chain.from_iterable(loops))
    )
    folder = files("rodgen.native")
    return {f"rodgen_native/{name}": folder.joinpath(name).read_text("utf-8") for name in names}


def _texts(
    structure: Structure, target: str, form: str, parts: tuple[str, ...], steps: bool = False
) -> dict[str, str]:
    entry = _entry(structure, target, form, parts, steps)
    texts = _recall(cache.read_text(*entry))
    if texts is None:
        report_stage(DERIVING)
        from rodgen.emit import module_files  # SymPy is imported only where it is needed

        texts = module_files(structure, target, form, parts, steps)
        cache.store_text(json.dumps(texts), *entry)
    return texts


def _entry(
    structure: Structure, target: str, form: str, parts: tuple[str, ...], steps: bool = False
) -> tuple[str, ...]:
    """Entry of the cache that the texts of parts are kept in."""
    made_of = cache.key(target, form, structure.hash, *parts, steps)
    return "modules", made_of, f"{structure.module_stem(target, form)}.json"


def is_derived(structure: Structure, parts: Iterable[str], target: str = "c") -> bool:
    """Whether parts of the module of a structure, in chain form, need no derivation any more."""
    entries = (_entry(structure, target, "chain", (part,)) for part in parts)
    return all(cache.read_text(*entry) is not None for entry in entries)


def _structure(given: HasStructure | Structure) -> Structure:
    """Structure that the module of a scene is specialised to. Raises TypeError for others."""
    structure: object = getattr(given, "structure", given)
    if isinstance(structure, Structure):
        return structure
    raise TypeError(
        "scene must be a Scene, a System or a Structure (see Scene.from_toml), "
        f"not {type(given).__name__}"
    )


def _recall(text: str | None) -> dict[str, str] | None:
    """Texts as they were stored, or None where there are none."""
    try:
        found = json.loads(text or "")
        return {str(name): str(value) for name, value in found.items()}
    except (ValueError, AttributeError, RecursionError):
        return None
